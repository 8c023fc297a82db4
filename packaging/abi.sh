#!/usr/bin/env bash
# Describes the binary interface of shared libraries, and compares it with that of an earlier release.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: packaging/abi.sh FOLDER [--against EARLIER] LIBRARY...

Writes a description of each shared LIBRARY's functions and their types to FOLDER/NAME.abi.xz (abidw of
libabigail). The libraries need debug information (-g). Types that no public header has are left out.

  --against EARLIER   compares each with EARLIER/NAME.abi.xz. Fails if a function is missing or a type has changed; new
                      ones may be there. NAME contains the version of the interface, as in libsoftcd.so.0.1, so that
                      libraries of incompatible versions are not compared.
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac
folder=${1:-}
earlier=""
if [ "${2:-}" = --against ]; then
  earlier=${3:?a folder}
  set -- "$1" "${@:4}"
fi
if [ $# -lt 2 ]; then usage >&2 && exit 2; fi
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
"$root/cmake/setup.sh" --only abigail-tools binutils xz-utils
mkdir -p "$folder"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

headers=()
for layer in kernels plugin bullet_integration; do headers+=(--headers-dir "$root/$layer/include"); done
failed=0
for library in "${@:2}"; do
  grep -q '\.debug_info' <<<"$(readelf -S "$library")" || { echo "softcd: $library has no debug information; compile it with -g" >&2 && exit 1; }
  name=$(readelf -d "$library" | grep -oP 'SONAME.*\[\K[^]]*').abi
  abidw "${headers[@]}" --drop-private-types --no-corpus-path --no-comp-dir-path --no-show-locs --out-file "$work/$name" "$library"
  xz --stdout "$work/$name" >"$folder/$name.xz"
  if [ -z "$earlier" ]; then continue; fi
  if [ ! -e "$earlier/$name.xz" ]; then
    echo "softcd: $earlier has no $name.xz, which is a new interface" && continue
  fi
  xz --decompress --stdout "$earlier/$name.xz" >"$work/earlier.abi"
  if abidiff --no-added-syms "$work/earlier.abi" "$work/$name"; then
    echo "softcd: $name is compatible with $earlier"
  else
    echo "softcd: $name is not compatible with $earlier: undo what is listed above, or raise the minor version" >&2
    failed=1
  fi
done
exit "$failed"
