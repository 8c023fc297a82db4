#!/usr/bin/env bash
# Fetches the recorded steps and queries that some tests compare with.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: tests/fetch_data.sh [FOLDER]

Downloads, with curl, 18 MB of recorded steps and queries with their exact verdicts into FOLDER (build/data), and
compares their checksums. Tests that need the data are skipped where it is missing. Existing files are kept. With
another FOLDER configure with -DSOFTCD_DATA_DIR=FOLDER. The files are sample data of other authors, from
github.com/Continuous-Collision-Detection; their licences come with them.
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac
sums=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)/recorded_data.sha256
folder=${1:-$(dirname "$sums")/../build/data}
mkdir -p "$folder"
cd "$folder"

# Prints the address of a file of recorded_data.sha256, at the version whose checksum was taken.
address_of() {
  local host=https://raw.githubusercontent.com/Continuous-Collision-Detection
  case $1 in
    ccd-steps/*) echo "$host/Sample-Scalable-CCD-Data/d1de594b017d98b37be67f02f74e541e74804109/${1#*/}" ;;
    ccd-queries/*) echo "$host/Sample-Queries/a744562c7a842e9eee033fcea290e75a4a8e7b4e/${1#*/}" ;;
  esac
}

while read -r sum file; do
  if [ -f "$file" ] && sha256sum --status --check <<<"$sum  $file"; then continue; fi
  mkdir -p "$(dirname "$file")"
  curl --fail --silent --show-error --location --retry 3 --output "$file.part" "$(address_of "$file")"
  sha256sum --quiet --check <<<"$sum  $file.part"
  mv "$file.part" "$file"
done <"$sums"
echo "$PWD has ccd-steps and ccd-queries"
