#!/usr/bin/env bash
# Builds the program and its tests with a sanitizer in build/asan or build/tsan, and runs the tests.
#
#   tests/sanitizers.sh address                       addresses, leaks, undefined behaviour
#   tests/sanitizers.sh thread                        data races
#   tests/sanitizers.sh address -R 'KeyframeVo'       what follows is for ctest
#
# The build takes 80 minutes of one core, and 4 GB for the longest source.
# Exit code: 0 nothing was found, 2 wrong usage, 4 it cannot be built, else ctest's.
set -uo pipefail
cd "$(dirname "$0")/.."
case ${1:-} in
  address) preset=asan ;;
  thread) preset=tsan ;;
  *)
    sed -n '2,/^set/s/^# \{0,1\}//p' "$0" >&2
    exit 2
    ;;
esac
shift
if [ ! -e build/$preset/build.ninja ]; then cmake --preset $preset >&2 || exit 4; fi
cmake --build --preset $preset >&2 || exit 4
export LSAN_OPTIONS=print_suppressions=0 TSAN_OPTIONS=print_suppressions=0
# Programs under test preload libraries of their own before the sanitizer's, and ask for more memory than there is.
export ASAN_OPTIONS=verify_asan_link_order=0:allocator_may_return_null=1:detect_stack_use_after_return=1
export UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1
# The thread sanitizer maps a temporary file in this folder, if there is one. A test that limits the size of files would
# cut that file, and end the program.
if [ $preset = tsan ]; then export TEST_TMPDIR=/nowhere; fi
exec ctest --preset $preset --timeout 3000 "$@"
