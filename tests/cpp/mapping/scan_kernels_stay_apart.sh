#!/usr/bin/env bash
# Checks that the files compiled for newer processors export no function, which the linker might use in other files, and
# that they round after every operation: no fused multiply-add. Usage: scan_kernels_stay_apart.sh libuwsim_mapping.a
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
archive=$(realpath "$1")
cd "$folder"
objects=$(ar t "$archive" | grep '^scan_kernels_.*\.cpp\.o$')
for object in $objects; do
  ar x "$archive" "$object"
  if nm "$object" | grep -E '^[0-9a-f]+ [TWVu] '; then
    echo "$object: exports these functions" >&2
    exit 1
  fi
  if objdump -d "$object" | grep -E 'vfn?m(add|sub)'; then
    echo "$object: fuses multiplications and additions" >&2
    exit 1
  fi
done
