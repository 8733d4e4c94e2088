#!/usr/bin/env python3
"""Does the program of today still make the rows of a study? Repeats a few runs of it and compares them with results/studies/NAME/runs.csv.

    results/spot_check.py                            one run of each study that has rows
    results/spot_check.py exposure floor_loop        of these
    results/spot_check.py exposure --runs 5 --pick 7 five runs, drawn by another number

Drawn by --pick, so that the same number repeats the same runs. Compared are all columns that both have, to the digit; times and memory are in neither.
Says for each run that it is the same, or what differs. Rows whose frames a graphics card rendered differ where this machine has none.
Studies of robots that go by a map need that map first; their files say which.
Exit code: 1 if a run differs, 2 if a study, its rows or its run could not be read or made.
"""
import argparse
import csv
import itertools
import random
import subprocess
import sys
import tempfile
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[1]


class CannotCompare(Exception):
    """A study and its rows do not fit together, or its run was not made."""


def conditions(study):
    """The conditions of a study in the order of its rows, each as the part of a study file that names it alone."""
    if "list" in study:
        return [{"list": [condition]} for condition in study["list"]]
    axes = study["axes"]
    return [{"axes": {axis: [value] for axis, value in zip(axes, values)}} for values in itertools.product(*axes.values())]


def seeds_of(study):
    seeds = study["seeds"]
    return list(range(1, seeds + 1)) if isinstance(seeds, int) else seeds


def rows_of(path):
    with open(path) as file:
        return list(csv.DictReader(file))


def repeat(study, condition, seed, path, program, cache):
    """The row of one run of `study`, which is the file `path`, made anew."""
    with tempfile.TemporaryDirectory() as folder:
        alone = {key: value for key, value in study.items() if key not in ("axes", "list", "reference")}
        alone |= condition | {"seeds": [seed], "base": str((path.parent / study["base"]).resolve())}
        file = Path(folder) / path.name
        file.write_text(yaml.safe_dump(alone, sort_keys=False))
        command = [*program, "study", str(file), "--out", str(Path(folder) / "out"), *(["--cache", cache] if cache else [])]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            raise CannotCompare((done.stderr.strip().splitlines() or ["no word of why"])[-1])
        return rows_of(Path(folder) / "out" / "runs.csv")[0]


def differences(committed, again, axes):
    """Columns of which the two rows have other text, as "column: committed, now again". A value of an axis alone may have another name."""
    both = [name for name in committed if name in again and name not in [*axes, "seed", "hash"]]
    if not both:
        raise CannotCompare("the committed rows and today's have no column in common")
    return [f"{name}: {committed[name] or 'none'}, now {again[name] or 'none'}" for name in both if committed[name] != again[name]]


def check(path, rows_path, options):
    """Repeats some runs of one study. Returns how many differ."""
    study = yaml.safe_load(path.read_text())
    rows = rows_of(rows_path)
    runs = list(itertools.product(conditions(study), seeds_of(study)))
    if len(rows) != len(runs):
        raise CannotCompare(f"{rows_path} has {len(rows)} rows, the study {len(runs)} runs")
    differ = 0
    axes = ["condition", *study.get("axes", [])]
    for index in sorted(random.Random(f"{options.pick} {path.stem}").sample(range(len(runs)), min(options.runs, len(runs)))):
        condition, seed = runs[index]
        found = differences(rows[index], repeat(study, condition, seed, path, options.program.split(), options.cache), axes)
        differ += bool(found)
        print(f"{path.stem}, row {index + 1} of {len(rows)}, seed {seed}: {'; '.join(found) or 'the same'}", flush=True)
    return differ


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("studies", nargs="*", metavar="NAME", help="default: each that has rows")
    parser.add_argument("--runs", type=int, default=1, help="of each study")
    parser.add_argument("--pick", type=int, default=1, help="which runs are drawn")
    parser.add_argument("--program", default=str(ROOT / "gaitcam"), help="what makes them")
    parser.add_argument("--cache", default="", help="folder of recorded walks, as of `gaitcam study`")
    parser.add_argument("--files", type=Path, default=ROOT / "scenarios" / "studies", help="folder of the study files")
    parser.add_argument("--rows", type=Path, default=ROOT / "results" / "studies", help="folder of their rows")
    options = parser.parse_args()
    names = options.studies or sorted(path.parent.name for path in options.rows.glob("*/runs.csv"))
    differ = failed = 0
    for name in names:
        try:
            differ += check(options.files / f"{name}.yaml", options.rows / name / "runs.csv", options)
        except (CannotCompare, OSError) as error:
            failed += 1
            print(f"{name}: {error}", file=sys.stderr, flush=True)
    return 2 if failed else 1 if differ else 0


if __name__ == "__main__":
    sys.exit(main())
