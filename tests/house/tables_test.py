"""Tests of results/tables.py, and that the pages of results/studies say what the rows beside them say."""
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

TABLES = Path(__file__).resolve().parents[2] / "results" / "tables.py"
sys.path.insert(0, str(TABLES.parent))
sys.dont_write_bytecode = True
import tables  # noqa: E402

ROWS = """exposure,system,seed,error_m,jumps
10,ours,1,0.0010,3
10,ours,2,0.0030,4
10,ours,3,0.0200,5
10,theirs,1,0.0020,0
10,theirs,2,0.0020,0
10,theirs,3,,0
20,ours,1,0.0100,1
20,ours,2,0.0100,2
20,ours,3,0.0100,3
20,theirs,1,0.0200,0
20,theirs,2,0.0050,0
20,theirs,3,0.0300,0
"""
BY_EXPOSURE = """<!-- table {show: error_m*1000, rows: system, columns: exposure} -->
| | 10 ms | 20 ms |
|---|---|---|
| ours | 3 (1 to 20) | 10 |
| theirs | 2 [2] | 20 (5 to 30) |
"""


class TablesTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.page = Path(self.folder.name) / "README.md"
        (self.page.parent / "runs.csv").write_text(ROWS)

    def tearDown(self):
        self.folder.cleanup()

    def run_on(self, text, *options):
        """Runs the program on a page; returns its exit code, what it said, and the page afterwards."""
        self.page.write_text(text)
        done = subprocess.run([sys.executable, TABLES, *options, self.page], capture_output=True, text=True)
        return done.returncode, done.stdout + done.stderr, self.page.read_text()

    def test_a_page_that_says_what_its_rows_say_is_left_as_it_is(self):
        self.assertEqual(self.run_on(BY_EXPOSURE, "--check"), (0, "", BY_EXPOSURE))

    def test_a_wrong_digit_is_found_and_mended(self):
        wrong = BY_EXPOSURE.replace("1 to 20", "1 to 21")
        code, said, page = self.run_on(wrong, "--check")
        self.assertEqual((code, page), (1, wrong))
        self.assertIn("README.md:4: its rows say | ours | 3 (1 to 20) | 10 |", said)
        self.assertEqual(self.run_on(wrong)[2], BY_EXPOSURE)

    def test_text_and_tables_without_a_mark_are_left_alone(self):
        text = "Some text.\n\n| a | b |\n|---|---|\n| 1 | 2 |\n\n" + BY_EXPOSURE + "\nMore text.\n"
        self.assertEqual(self.run_on(text)[2], text)

    def test_several_metrics_of_some_runs_are_columns(self):
        text = """<!-- table {show: [error_m*1000, jumps], rows: system, where: {exposure: 10}, decimals: {error_m: 2}} -->
| system | by | error, mm | jumps |
|---|---|---|---|
| ours | us | 3.00 (1.00 to 20.00) | 4 (3 to 5) |
| theirs | them | 2.00 [2] | 0 |
"""
        self.assertEqual(self.run_on(text), (0, "", text))

    def test_where_takes_several_values_of_an_axis_and_refuses_one_that_no_run_has(self):
        whole = BY_EXPOSURE.replace("columns: exposure", "columns: exposure, where: {exposure: [20, 10]}")
        self.assertEqual(self.run_on(whole), (0, "", whole))
        more = BY_EXPOSURE.replace("columns: exposure", "columns: exposure, where: {exposure: [10, 20, 30]}")
        self.assertEqual(self.run_on(more)[0], 2)

    def test_metrics_can_be_rows(self):
        text = """<!-- table {show: [error_m*1000, jumps], columns: system, where: {exposure: 20}} -->
| | ours | theirs |
|---|---|---|
| error, mm | 10 | 20 (5 to 30) |
| jumps | 2 (1 to 3) | 0 |
"""
        self.assertEqual(self.run_on(text), (0, "", text))

    def test_a_metric_can_be_divided_by_another_and_has_no_value_where_that_is_none(self):
        text = """<!-- table {show: error_m/jumps*1000, rows: system, columns: exposure, decimals: 2} -->
| | 10 ms | 20 ms |
|---|---|---|
| ours | 0.75 (0.33 to 4.00) | 5.00 (3.33 to 10.00) |
| theirs | - | - |
"""
        self.assertEqual(self.run_on(text), (0, "", text))

    def test_than_counts_the_seeds_on_which_a_row_is_the_smaller_one(self):
        text = """<!-- table {show: error_m, rows: system, columns: exposure, than: theirs} -->
| | 10 ms | 20 ms |
|---|---|---|
| ours | 1 of 2 | 2 of 3 |
"""
        self.assertEqual(self.run_on(text), (0, "", text))

    def test_what_does_not_fit_together_is_one_line_with_file_and_line_and_changes_nothing(self):
        for mistake, said in (
            ("rows: sytem", "no column sytem"),
            ("show: eror_m", "no column eror_m"),
            ("show: error_m/jump", "no column jump"),
            ("show: error_m/error_m/error_m", "is no ratio of two metrics"),
            ("rows: system, columns: exposure, where: {exposure: 30}", "has exposure 30"),
            ("rows: [system, exposure]", "the table has 2 rows, and the runs make 4"),
            ("rows: system, colums: exposure", "no such key: colums"),
            ("rows: system, columns: [exposure", "needs a mapping"),
        ):
            spec = mistake if "show" in mistake else "show: error_m, " + mistake
            spec = spec if "rows" in spec else spec + ", rows: system, columns: exposure"
            text = BY_EXPOSURE.replace("show: error_m*1000, rows: system, columns: exposure", spec)
            code, message, page = self.run_on(text)
            self.assertEqual((code, page), (2, text), mistake)
            self.assertRegex(message, r"^tables\.py: .*README\.md:1: .*" + said)
            self.assertEqual(message.count("\n"), 1)

    def test_a_row_that_stands_where_the_runs_have_another_is_refused(self):
        exchanged = BY_EXPOSURE.replace("ours", "their").replace("theirs", "ours").replace("their ", "theirs ")
        code, said, page = self.run_on(exchanged)
        self.assertEqual((code, page), (2, exchanged))
        self.assertIn("the row of theirs stands where the runs have ours", said)

    def test_figures_have_two_digits_that_count_and_no_minus_before_nothing(self):
        shown = {123.4: "123", 9.96: "10", 9.94: "9.9", 0.0456: "0.046", 0.998: "1.0", -1.26: "-1.3", 3.0: "3", 0.5: "0.5", 0.0: "0"}
        self.assertEqual({value: tables.figure(value, None) for value in shown}, shown)
        self.assertEqual(tables.figure(-0.04, 1), "0.0")

    def test_the_parts_of_a_condition_are_axes(self):
        (self.page.parent / "runs.csv").write_text(
            'condition,seed,jumps\n"width=320, system={name: ours, fast: true}",1,5\n"width=640, system=theirs",1,7\n'
        )
        rows = tables.Rows(self.page.parent / "runs.csv")
        self.assertEqual(rows.keys(rows.runs, ["system"]), [("{name: ours, fast: true}",), ("theirs",)])
        self.assertEqual(rows.keys(rows.of({"width": ["640"]}), ["system"]), [("theirs",)])


class PagesTest(unittest.TestCase):
    def test_each_page_says_what_its_rows_say(self):
        done = subprocess.run([sys.executable, TABLES, "--check"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


if __name__ == "__main__":
    unittest.main()
