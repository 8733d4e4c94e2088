#!/usr/bin/env bash
# clang-tidy's small set (.clang-tidy) by the build's own compile commands.
# Usage: check_tidy.sh SOURCE BUILD [FOLDER ...]; without folders, all of the product's sources (some ten minutes).
set -euo pipefail
source_folder=$1 build_folder=$2
shift 2
cd "$source_folder"
[ $# -gt 0 ] || set -- algorithms models sim results scenarios
mapfile -t files < <(find "$@" -name '*.cpp' | sort)
[ ${#files[@]} -gt 20 ] || { echo "found only ${#files[@]} sources"; exit 1; }
printf '%s\0' "${files[@]}" | xargs -0 -n 4 -P "$(nproc)" clang-tidy -p "$build_folder" --quiet 2>/dev/null
