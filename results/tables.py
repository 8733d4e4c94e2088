#!/usr/bin/env python3
"""Fills the tables of the pages in results from the rows of the studies.

    results/tables.py                                  every page
    results/tables.py results/studies/scale/README.md  one of them
    results/tables.py --check                          changes nothing; exit code 1 if a page says other than its rows

A table is filled if a comment stands before it, a mapping in YAML:

    <!-- table {show: ate_sim3_rmse_m*1000, rows: system, columns: [gait.preset, camera.exposure_ms]} -->

show     a metric of runs.csv, or several of them; *1000 multiplies it, /other_metric divides it by another
rows     axes of runs.csv whose values make a row; the values of each in the order in which runs.csv has them
columns  axes whose values make a column. Several metrics take the place of one of the two: each has a row or a column
where    {axis: value}, or {axis: [values]}: of the runs with these values alone
than     a value of the axis of rows: the cell is on how many seeds the metric is smaller than there
decimals of each figure, or {metric: decimals}; without it two digits that count, and counts as they are
from     the file of rows, as seen from the page; without it runs.csv

What a condition consists of, as in "exposure_ms=33, system=sift_vo", are axes, too. The head of a table and the first cell of each row stay as they are; the others are medians over the seeds (smallest to
largest), and [n] where only n of the runs have the metric. Exit code: 2 if a comment and its rows do not fit together.
"""
import csv
import math
import re
import statistics
import sys
from pathlib import Path

import yaml

MARK = re.compile(r"^<!-- *table\b(.*)-->$")
PART = re.compile(r"([\w.]+)=(\{.*?\}+|[^,]*)(?:, |$)")
KEYS = {"show", "rows", "columns", "where", "than", "decimals", "from"}


class DoesNotFit(Exception):
    """A comment asks for what its rows or its table do not have."""


def as_list(value):
    return [] if value is None else value if isinstance(value, list) else [value]


def figure(value, decimals):
    """A figure with so many decimals; if None with two digits that count, whole from ten on, counts as they are."""
    if decimals is None:
        if abs(value) < 9.95 and 2 * value == round(2 * value):  # a count, or the median of two
            return f"{value:g}"
        decimals = 0 if abs(value) >= 9.95 else 1 - math.floor(math.log10(float(f"{abs(value):.1e}")))
    text = f"{value:.{decimals}f}"
    return text.lstrip("-") if float(text) == 0 else text


def spread(values, decimals):
    """Median (smallest to largest) of the seeds that have a value; `values` holds a float or None for each seed."""
    there = [value for value in values if value is not None]
    if not there:
        return "-"
    median, low, high = (figure(value, decimals) for value in (statistics.median(there), min(there), max(there)))
    text = median if low == high else f"{median} ({low} to {high})"
    return text if len(there) == len(values) else f"{text} [{len(there)}]"


def smaller(values, others):
    """On how many seeds, of those that both have, the first is the smaller one; both are {seed: float or None}."""
    pairs = [(values[seed], others[seed]) for seed in values if seed in others]
    pairs = [(one, other) for one, other in pairs if one is not None and other is not None]
    return f"{sum(one < other for one, other in pairs)} of {len(pairs)}" if pairs else "-"


class Rows:
    """The runs of one study, as results/repeat.sh keeps them."""

    def __init__(self, path):
        with open(path) as file:
            self.runs = list(csv.DictReader(file))
        for run in self.runs:
            run.update(PART.findall(run.get("condition", "")))
        self.names = set().union(*self.runs)
        self.path = path

    def column(self, name):
        if name not in self.names:
            raise DoesNotFit(f"{self.path} has no column {name}")
        return name

    def of(self, where):
        """The runs with these values; of each axis there is a list."""
        for axis, values in where.items():
            there = {run[self.column(axis)] for run in self.runs}
            for value in values:
                if value not in there:
                    raise DoesNotFit(f"no run of {self.path} has {axis} {value}")
        return [run for run in self.runs if all(run[axis] in values for axis, values in where.items())]

    def keys(self, runs, axes):
        """What values of the axes there are together, in the order of each axis by itself."""
        orders = [list(dict.fromkeys(run[self.column(axis)] for run in runs)) for axis in axes]
        there = {tuple(run[axis] for axis in axes) for run in runs}
        return sorted(there, key=lambda key: [order.index(value) for order, value in zip(orders, key)])

    def by_seed(self, runs, axes, key, metric, factor):
        """{seed: value, None where it has none} of the runs whose axes have the values of the key.

        metric: a column, or "one/other" for the ratio of two
        """
        runs = [run for run in runs if tuple(run[axis] for axis in axes) == key]
        one, _, other = metric.partition("/")

        def value(run):
            if not run[one] or (other and not float(run[other] or 0)):
                return None
            return float(run[one]) / (float(run[other]) if other else 1) * factor

        return {run["seed"]: value(run) for run in runs}


def cells(rows, spec):
    """What values of the axes of rows make each row (none, if rows are metrics), and its cells."""
    runs = rows.of({axis: [str(value) for value in as_list(values)] for axis, values in spec.get("where", {}).items()})
    down, across = as_list(spec.get("rows")), as_list(spec.get("columns"))
    shown = [(name, float(factor or 1)) for name, _, factor in (text.partition("*") for text in as_list(spec["show"]))]
    if len(shown) > 1 and down and across:
        raise DoesNotFit("several metrics take the place of rows or columns")
    for name, _ in shown:
        if name.count("/") > 1:
            raise DoesNotFit(f"{name} is no ratio of two metrics")
        for part in name.split("/"):
            rows.column(part)
    decimals = spec.get("decimals")
    decimals = decimals if isinstance(decimals, dict) else dict.fromkeys((name for name, _ in shown), decimals)

    def cell(row, column, metric, factor):
        values = rows.by_seed(runs, down + across, row + column, metric, factor)
        if "than" not in spec:
            return spread(list(values.values()), decimals.get(metric))
        return smaller(values, rows.by_seed(runs, down + across, (str(spec["than"]),) + column, metric, factor))

    rows_shown = [key for key in rows.keys(runs, down) if key != (str(spec.get("than")),)]
    columns_shown = rows.keys(runs, across)
    if not down:
        return [((), [cell((), column, *metric) for column in columns_shown]) for metric in shown]
    return [(row, [cell(row, column, *metric) for metric in shown for column in columns_shown]) for row in rows_shown]


def read_mark(text):
    """The mapping of a comment before a table."""
    try:
        spec = yaml.safe_load(text)
    except yaml.YAMLError:
        spec = None
    if not isinstance(spec, dict) or "show" not in spec:
        raise DoesNotFit("a table needs a mapping with the key show, as {show: coverage_ratio, rows: system}")
    if unknown := set(spec) - KEYS:
        raise DoesNotFit(f"no such key: {', '.join(sorted(unknown))}; there are {', '.join(sorted(KEYS))}")
    return spec


def filled(table, spec, folder):
    """A table's lines with its cells filled."""
    head, body = table[:2], table[2:]
    new = cells(Rows(folder / spec.get("from", "runs.csv")), spec)
    if len(new) != len(body):
        raise DoesNotFit(f"the table has {len(body)} rows, and the runs make {len(new)}")
    labels = head[0].count("|") - 1 - (len(new[0][1]) if new else 0)
    if labels < 1:
        raise DoesNotFit(f"the table has {head[0].count('|') - 2} columns of figures, and the runs make {len(new[0][1])}")
    values = {value for key, _ in new for value in key}
    for line, (key, _) in zip(body, new):
        for label in (cell.strip(" `") for cell in line.split("|")[1 : labels + 1]):
            if label in values and label not in key:
                raise DoesNotFit(f"the row of {label} stands where the runs have {', '.join(key)}")
    start = ["|".join(line.split("|")[: labels + 1]) for line in body]
    return head + [f"{labels}| {' | '.join(row)} |" for labels, (_, row) in zip(start, new)]


def fill(page):
    """The page's text with all its tables filled."""
    lines, at = page.read_text().split("\n"), 0
    while at < len(lines):
        if found := MARK.match(lines[at]):
            begin = at + 1 + (lines[at + 1 : at + 2] == [""])
            end = begin
            while end < len(lines) and lines[end].startswith("|"):
                end += 1
            try:
                lines[begin:end] = filled(lines[begin:end], read_mark(found[1]), page.parent)
            except (DoesNotFit, OSError) as error:
                raise DoesNotFit(f"{page}:{at + 1}: {error}") from error
        at += 1
    return "\n".join(lines)


def main(arguments):
    if "-h" in arguments or "--help" in arguments:
        print(__doc__)
        return 0
    check = "--check" in arguments
    pages = [Path(name) for name in arguments if name != "--check"]
    wrong = 0
    try:
        for page in pages or sorted(Path(__file__).parent.rglob("*.md")):
            text, now = fill(page), page.read_text()
            if text == now:
                continue
            if not check:
                page.write_text(text)
            for number, (old, new) in enumerate(zip(now.split("\n"), text.split("\n")), 1):
                if old != new:
                    wrong += 1
                    print(f"{page}:{number}: {'its rows say' if check else 'now'} {new}")
    except (DoesNotFit, OSError) as error:  # what was filled until then stays
        print(f"tables.py: {error}", file=sys.stderr)
        return 2
    return 1 if check and wrong else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
