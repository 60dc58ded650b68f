#!/usr/bin/env bash
# The files that are compiled for newer processors give the linker no function that others might call, and round after
# every operation: no fused multiply-add. Usage: scan_kernels_stay_apart.sh libuwsim_mapping.a
set -euo pipefail

folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
archive=$(realpath "$1")
cd "$folder"
for set in portable avx2 avx512 slabs_avx512; do
  object=scan_kernels_$set.cpp.o
  ar x "$archive" "$object"
  if nm "$object" | grep -E '^[0-9a-f]+ [TWVu] '; then
    echo "$object: gives these to the linker" >&2
    exit 1
  fi
  if objdump -d "$object" | grep -E 'vfn?m(add|sub)'; then
    echo "$object: fuses multiplications and additions" >&2
    exit 1
  fi
done
