#!/usr/bin/env bash
# Makes a site of the pages and of the public headers' comments.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: docs/site.sh [FOLDER]

Makes the documentation's site in FOLDER (default: build/site) from README.md, the pages below docs/ and the public
headers. The first page is FOLDER/html/index.html. Fails if a public name has no description, or if a link leads nowhere.
Installs Doxygen if it is missing.
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac
folder=$(realpath -m "${1:-$(dirname "${BASH_SOURCE[0]}")/../build/site}")
cd "$(dirname "${BASH_SOURCE[0]}")/.."
cmake/setup.sh --only doxygen python3

rm -rf "$folder/html"
mkdir -p "$folder"
version=$(sed -n 's/#define SOFTCD_VERSION_STRING "\(.*\)"/\1/p' kernels/include/softcd/version.hpp)
# The kernels' headers that are installed.
installed=$(sed -n 's/^set(SOFTCD_PUBLIC_KERNEL_HEADERS "\(.*\)" PARENT_SCOPE)$/\1/p' kernels/CMakeLists.txt)
kernel_headers=$(find kernels/include -name '*.hpp' | grep -E "${installed//\\\\/\\}")
doxygen - <<TEXT
@INCLUDE = docs/site/Doxyfile
INPUT += ${kernel_headers//$'\n'/ }
OUTPUT_DIRECTORY = $folder
PROJECT_NUMBER = $version
TEXT

# Files of the repository that pages link to or show.
grep -rhoE '(href|src)="files/[^"#]+' "$folder/html" --include='*.html' | sed 's/.*"files\///' | sort -u |
  while read -r file; do
    mkdir -p "$(dirname "$folder/html/files/$file")"
    cp "$file" "$folder/html/files/$file"
  done
# The scenes in a browser, where packaging/web.sh has built them.
if [ -e build/web/page/index.html ]; then
  cp build/web/page/index.html "$folder/html/in-the-browser.html"
  sed -i 's|<div class="contents">|&<p><a href="in-the-browser.html">Try the scenes in your browser</a></p>|' \
    "$folder/html/index.html"
fi
echo "$folder/html/index.html"
