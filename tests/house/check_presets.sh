#!/usr/bin/env bash
# Configures each preset that the tests are not built with, in a folder of its own, and looks whether its build has all
# that it needs; nothing is compiled. Usage: check_presets.sh SOURCE
set -euo pipefail
cd "$1"
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# One line for the preset $1 that cannot be configured or built.
check() {
  local log=$folder/$1.log
  cmake --preset "$1" -B "$folder/$1" >"$log" 2>&1 && ninja -C "$folder/$1" -n >>"$log" 2>&1 && return
  tail -n 20 "$log"
  echo "preset $1: cannot be built as it stands in CMakePresets.json"
  return 1
}
export -f check
export folder
printf '%s\0' dev no-sim asan tsan fuzz | xargs -0 -n 1 -P "$(nproc)" bash -c 'check "$1"' bash
