#!/usr/bin/env bash
# clang-tidy's small set (.clang-tidy) over the product's sources, by the build's own compile commands.
set -euo pipefail
source_folder=$1 build_folder=$2
cd "$source_folder"
mapfile -t files < <(find algorithms models sim results scenarios -name '*.cpp' | sort)
[ ${#files[@]} -gt 20 ] || { echo "found only ${#files[@]} sources"; exit 1; }
printf '%s\0' "${files[@]}" | xargs -0 -n 4 -P "$(nproc)" clang-tidy -p "$build_folder" --quiet 2>/dev/null
