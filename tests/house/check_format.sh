#!/usr/bin/env bash
# Every source is as clang-format leaves it.
set -euo pipefail
cd "$1"
mapfile -t files < <(find algorithms models sim results scenarios tests -name '*.h' -o -name '*.cpp' | sort)
[ ${#files[@]} -gt 50 ] || { echo "found only ${#files[@]} sources"; exit 1; }
clang-format --dry-run -Werror "${files[@]}"
