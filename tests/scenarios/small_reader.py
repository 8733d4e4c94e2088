"""Reads a recording as small programs do: sorts names, skips lines by their number, believes what it finds.

usage: small_reader.py FOLDER   prints "N frames, S s"; exit 1 where frames are missing or out of order
"""
import os
import sys
from decimal import Decimal


def rows_of(table, skipped, separator):
    with open(table) as lines:
        return [line.rstrip("\n").split(separator) for line in list(lines)[skipped:]]


def listing_of(folder):
    """The folder of the images, and for each row of their table its time in seconds and its file's name."""
    if os.path.exists(folder + "/rgb.txt"):  # three lines before the first row, whatever they hold
        rows = rows_of(folder + "/rgb.txt", 3, " ")
        return folder + "/rgb", [(Decimal(t), os.path.basename(name)) for t, name in rows]
    if os.path.exists(folder + "/rgb.csv"):  # one line that names the columns
        rows = rows_of(folder + "/rgb.csv", 1, ",")
        return folder + "/rgb_0", [(Decimal(row[0]) / 10**9, os.path.basename(row[1])) for row in rows]
    rows = rows_of(folder + "/mav0/cam0/data.csv", 1, ",")
    return folder + "/mav0/cam0/data", [(Decimal(t) / 10**9, name) for t, name in rows]


def main(folder):
    images, listed = listing_of(folder)
    names = sorted(os.listdir(images))  # the order of the film
    if names != [name for _, name in listed]:
        print("sorted names are not the table's order")
        return 1
    times = [t for t, _ in listed]
    if any(after <= before for before, after in zip(times, times[1:])):
        print("times do not increase")
        return 1
    stamps = [Decimal(name[:-4]) for name in names]  # of the names, in seconds or in nanoseconds
    if [t if t < 10**10 else t / 10**9 for t in stamps] != times:
        print("names are not the times of their frames")
        return 1
    beside = rows_of(os.path.dirname(images) + "/times.txt", 0, " ")  # where direct odometry looks for it
    if [Decimal(row[1]) for row in beside] != times or any(float(row[2]) <= 0 for row in beside):
        print("times.txt has other times, or no exposures")
        return 1
    print(f"{len(names)} frames, {times[-1] - times[0]} s")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
