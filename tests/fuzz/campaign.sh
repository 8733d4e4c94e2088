#!/usr/bin/env bash
# Fuzzes every reader of readers.cpp for SECONDS each (60), one on each processor at a time, and prints a line for each:
# the inputs that were read, the longest time that one took, and what was found. What was learned stays in
# build/fuzz/grown/READER, so that the next campaign goes on from there; inputs that broke a reader are in
# build/fuzz/found/READER.
#
#   tests/fuzz/campaign.sh [SECONDS [READER...]]
#   GAITCAM_FUZZ_ALL=1 tests/fuzz/campaign.sh ...        also scenarios, suites, studies, matrices: a long build
#   GAITCAM_FUZZ_JOBS=1 tests/fuzz/campaign.sh ...       so many at a time
#
# Exit code: 0 nothing was found, 1 something was, 4 it cannot be built.
set -uo pipefail
cd "$(dirname "$0")/../.."
seconds=${1:-60}
shift || true
if [ ! -e build/fuzz/build.ninja ]; then cmake --preset fuzz >&2 || exit 4; fi
export fuzzer=build/fuzz/tests/gaitcam_fuzz${GAITCAM_FUZZ_ALL:+_all} seconds GAITCAM_DATA=$PWD
cmake --build --preset fuzz --target "${fuzzer##*/}" >&2 || exit 4
readers=("$@")
[ ${#readers[@]} -gt 0 ] || readers=($(GAITCAM_FUZZ=list "$fuzzer" tests/fuzz/corpus 2>/dev/null | tail -n 1))
# One frame of each allocation's stack is kept and eight megabytes of freed memory, and inputs to change are drawn
# without regard to how rare their paths are: up to three times as many inputs a second. Of what is found,
# GAITCAM_FUZZ=READER build/fuzz/tests/gaitcam_fuzz FILE tells the whole stack.
export ASAN_OPTIONS=detect_leaks=1:allocator_may_return_null=1:malloc_context_size=1:quarantine_size_mb=8
export UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1

# Fuzzes the reader $1, and prints its line.
fuzz() {
  local grown=build/fuzz/grown/$1 found=build/fuzz/found/$1 log=build/fuzz/$1.log limit_s=5 memory_mb=2048 failed=0
  mkdir -p "$grown" "$found"
  GAITCAM_FUZZ=$1 "$fuzzer" -max_total_time="$seconds" -timeout=$limit_s -rss_limit_mb=$memory_mb -max_len=16384 \
    -entropic=0 -print_final_stats=1 -artifact_prefix="$found/" "$grown" "tests/fuzz/corpus/$1" >"$log" 2>&1 || failed=1
  awk -v reader="$1" -v found="$(find "$found" -type f | wc -l)" '
    /stat::number_of_executed_units/ {inputs = $2}
    /stat::slowest_unit_time_sec/ {slowest = $2}
    END {printf "%-22s %12s %10s %8s\n", reader, inputs == "" ? "?" : inputs, slowest == "" ? "?" : slowest, found}' "$log"
  return $failed
}
export -f fuzz

printf '%-22s %12s %10s %8s\n' reader inputs slowest_s found
failed=0
printf '%s\n' "${readers[@]}" | xargs -P "${GAITCAM_FUZZ_JOBS:-$(nproc)}" -I {} bash -c 'fuzz {}' |
  tee build/fuzz/campaign.txt || failed=1
awk '{inputs += $2} END {printf "%-22s %12s\n", "all", inputs}' build/fuzz/campaign.txt
exit $failed
