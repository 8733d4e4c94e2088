#!/usr/bin/env bash
# Repeats studies, and puts what they end with beside what is concluded from them, in results/studies/NAME: tables.md,
# summary.csv, effects.csv, and of runs.csv the columns that the study's tables are about. Then fills the tables of the
# page there from these rows (results/tables.py); what the page concludes from them is for people to write.
#
#   results/repeat.sh quickstart                       some minutes; each README there says what it was made with
#   results/repeat.sh odometry_lab_loop step_length    hours; a study that was interrupted goes on where it was
#
# Exit code: of the first study that fails.
set -euo pipefail
cd "$(dirname "$0")/.."
[ $# -gt 0 ] || { sed -n '2,/^$/s/^# \{0,1\}//p' "$0" >&2 && exit 2; }
export PATH=$PWD/build/release/tests:$PATH # step_length's dense odometry is built with the tests
for name in "$@"; do
  ./gaitcam study "scenarios/studies/$name.yaml" --out "studies/$name"
  to=results/studies/$name
  mkdir -p "$to"
  cp "studies/$name/"{tables.md,summary.csv,effects.csv} "$to/"
  python3 - "studies/$name" "$to" <<'PYTHON'
import csv, sys
came, goes = sys.argv[1:]
with open(came + "/summary.csv") as file:
    metrics = {row["metric"] for row in csv.DictReader(file)}
with open(came + "/runs.csv") as file:
    rows = csv.DictReader(file)
    before = rows.fieldnames[: rows.fieldnames.index("frames") + 1]
    names = [name for name in rows.fieldnames if name in metrics or (name in before and name != "hash")]
    with open(goes + "/runs.csv", "w") as out:
        table = csv.DictWriter(out, names, extrasaction="ignore", lineterminator="\n")
        table.writeheader()
        table.writerows(rows)
PYTHON
  [ ! -e "$to/README.md" ] || results/tables.py "$to/README.md"
done
