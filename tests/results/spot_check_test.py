"""Tests of results/spot_check.py, with a study of two exposures and two seeds that the program in $GAITCAM_PROGRAM runs."""
import csv
import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
STUDY = f"""description: two exposures
base: {ROOT}/scenarios/quickstart.yaml
set: {{duration_s: 0.6, camera.width_px: 160, camera.height_px: 120, system: floor_slam, variation: repeat}}
axes:
  camera.exposure_ms: [2, 20]
seeds: [3, 5]
metrics: [coverage_ratio, ate_rmse_m]
"""


class SpotCheckTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.of = Path(cls.folder.name)
        (cls.of / "pair.yaml").write_text(STUDY)
        cls.program = os.environ["GAITCAM_PROGRAM"]
        subprocess.run([cls.program, "study", cls.of / "pair.yaml", "--out", cls.of / "pair", "--cache", cls.of / "cache"],
                       check=True, capture_output=True)
        with open(cls.of / "pair" / "runs.csv") as file:
            cls.rows = list(csv.DictReader(file))

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def spot_check(self, rows, *options):
        """Compares with `rows`; returns the exit code and what was said."""
        with open(self.of / "pair" / "runs.csv", "w") as file:
            table = csv.DictWriter(file, rows[0], lineterminator="\n")
            table.writeheader()
            table.writerows(rows)
        command = [sys.executable, ROOT / "results" / "spot_check.py", "pair", "--program", self.program, "--files", self.of,
                   "--rows", self.of, "--cache", self.of / "cache", *options]
        done = subprocess.run(command, capture_output=True, text=True)
        return done.returncode, done.stdout + done.stderr

    def test_runs_made_by_this_program_are_the_same(self):
        self.assertEqual(len({row["blur_median_px"] for row in self.rows}), 4)  # else a wrong row would pass as well
        same = "".join(f"pair, row {row} of 4, seed {seed}: the same\n" for row, seed in ((1, 3), (2, 5), (3, 3), (4, 5)))
        self.assertEqual(self.spot_check(self.rows, "--runs", "4"), (0, same))

    def test_a_digit_that_differs_is_named_with_its_row(self):
        rows = [dict(row) for row in self.rows]
        rows[2]["blur_median_px"] += "1"
        code, said = self.spot_check(rows, "--runs", "9")
        blur = self.rows[2]["blur_median_px"]
        self.assertEqual(code, 1)
        self.assertEqual(said.splitlines()[2], f"pair, row 3 of 4, seed 3: blur_median_px: {blur}1, now {blur}")
        self.assertEqual(said.count("the same"), 3)

    def test_rows_that_are_not_those_of_the_study_are_refused(self):
        code, said = self.spot_check(self.rows[:3])
        self.assertEqual((code, said.count("\n")), (2, 1))
        self.assertIn("has 3 rows, the study 4 runs", said)


if __name__ == "__main__":
    unittest.main()
