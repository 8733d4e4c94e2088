#!/usr/bin/env python3
"""Dead reckoning as a command on a recorded folder (TUM layout): the same as gyro_process.py, after the walk.

    system: {command: [python3, scenarios/examples/gyro_command.py, "{dataset}", "{output}"],
             depends: [scenarios/examples/gyro_process.py]}

Such a system sees the folder, its own file and what `depends` names, and nothing else of the user's files."""
import csv
import os
import re
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from gyro_process import answer  # noqa: E402


def rotation_of_imu(file):
    """Quaternion x, y, z, w that turns the IMU's axes into the camera's."""
    with open(file) as text:
        numbers = re.search(r"X_CI:.*?rotation_xyzw: \[(.*?)\]", text.read(), re.S).group(1)
    return [float(number) for number in numbers.split(",")]


def rows(file, separator):
    with open(file) as text:
        return list(csv.reader((line for line in text if not line.startswith("#")), delimiter=separator))


def main(dataset, output):
    imu = [[int(row[0])] + [float(field) for field in row[1:]] for row in rows(dataset + "/imu.csv", ",")]
    counts = [int(row[2]) for row in rows(dataset + "/exposure.csv", ",")]
    state = {}
    answer({"event": "start", "calibration": {"imu": {"X_CI": [0, 0, 0] + rotation_of_imu(dataset + "/calibration.yaml")}},
            "settings": {}}, state)
    with open(output, "w") as trajectory:
        for (stamp, _), count in zip(rows(dataset + "/rgb.txt", " "), counts):
            samples, imu = imu[:count], imu[count:]
            pose = answer({"event": "frame", "imu": samples}, state)["pose"]
            print(stamp, *pose, file=trajectory)


if __name__ == "__main__":
    main(*sys.argv[1:])
