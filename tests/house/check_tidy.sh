#!/usr/bin/env bash
# clang-tidy's small set (.clang-tidy) by the build's own compile commands, batch by batch where the build has batches.
# Usage: check_tidy.sh SOURCE BUILD [FOLDER ...]; without folders, all of the product's sources (some ten minutes).
set -euo pipefail
source_folder=$1 build_folder=$2
shift 2
cd "$source_folder"
[ $# -gt 0 ] || set -- algorithms models sim results scenarios
files=()
for folder in "$@"; do
  # The largest first: no core is idle at the end.
  mapfile -t sources < <(grep -oE "\"file\": \"($build_folder/CMakeFiles/gaitcam_$folder[^/]*\.dir/Unity|$source_folder/$folder)/[^\"]*" \
    "$build_folder/compile_commands.json" | cut -d '"' -f 4 | xargs -r ls -S)
  [ ${#sources[@]} -gt 0 ] || { echo "found no sources of $folder"; exit 1; }
  files+=("${sources[@]}")
done
printf '%s\0' "${files[@]}" |
  xargs -0 -n 1 -P "$(nproc)" clang-tidy -p "$build_folder" --quiet --extra-arg=-Wno-unknown-warning-option 2>/dev/null
