#!/usr/bin/env bash
# Fuzzes every reader of readers.cpp in turn, for SECONDS each (60), and prints a line for each: the inputs that were
# read, the longest time that one took, and what was found. What was learned stays in build/fuzz/grown/READER, so that the
# next campaign goes on from there; inputs that broke a reader are in build/fuzz/found/READER.
#
#   tests/fuzz/campaign.sh [SECONDS [READER...]]
#   GAITCAM_FUZZ_ALL=1 tests/fuzz/campaign.sh ...        also scenarios, suites, studies, matrices: a long build
#
# Exit code: 0 nothing was found, 1 something was, 4 it cannot be built.
set -uo pipefail
cd "$(dirname "$0")/../.."
seconds=${1:-60}
shift || true
if [ ! -e build/fuzz/build.ninja ]; then cmake --preset fuzz >&2 || exit 4; fi
fuzzer=gaitcam_fuzz${GAITCAM_FUZZ_ALL:+_all}
cmake --build --preset fuzz --target $fuzzer >&2 || exit 4
export GAITCAM_DATA=$PWD
readers=("$@")
[ ${#readers[@]} -gt 0 ] || readers=($(GAITCAM_FUZZ=list build/fuzz/tests/$fuzzer tests/fuzz/corpus 2>/dev/null | tail -n 1))
limit_s=5 memory_mb=2048 failed=0 total=0
export ASAN_OPTIONS=detect_leaks=1:allocator_may_return_null=1 UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1
printf '%-22s %12s %10s %8s\n' reader inputs slowest_s found
for reader in "${readers[@]}"; do
  grown=build/fuzz/grown/$reader found=build/fuzz/found/$reader log=build/fuzz/$reader.log
  mkdir -p "$grown" "$found"
  GAITCAM_FUZZ=$reader build/fuzz/tests/$fuzzer -max_total_time="$seconds" -timeout=$limit_s -rss_limit_mb=$memory_mb \
    -max_len=16384 -print_final_stats=1 -artifact_prefix="$found/" "$grown" "tests/fuzz/corpus/$reader" >"$log" 2>&1 || failed=1
  inputs=$(awk '/stat::number_of_executed_units/ {print $2}' "$log")
  slowest=$(awk '/stat::slowest_unit_time_sec/ {print $2}' "$log")
  total=$((total + ${inputs:-0}))
  printf '%-22s %12s %10s %8s\n' "$reader" "${inputs:-?}" "${slowest:-?}" "$(find "$found" -type f | wc -l)"
done
printf '%-22s %12s\n' all "$total"
exit $failed
