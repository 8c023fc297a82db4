#!/usr/bin/env bash
# Fetches the distribution's sources of an installed package.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: cmake/fetch_source.sh PACKAGE FOLDER

Unpacks the sources that the installed Debian or Ubuntu PACKAGE was built from into FOLDER/sources, with the
distribution's patches. FOLDER is emptied first. apt's own lists of packages stay as they are. Needs dpkg-dev.
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac
if [ $# -ne 2 ]; then usage >&2 && exit 2; fi
folder=$2

lists=$folder/apt
rm -rf "$folder"
mkdir -p "$lists/sources" "$lists/lists/partial" "$lists/cache/archives/partial"
folder=$(cd "$folder" && pwd)
lists=$folder/apt
sed 's/^deb /deb-src /' /etc/apt/sources.list >"$lists/sources.list" 2>/dev/null || true
find /etc/apt/sources.list.d -name '*.sources' -exec cp -t "$lists/sources" {} +
find /etc/apt/sources.list.d -name '*.list' -exec cp -t "$lists/sources" {} +
find "$lists/sources" -type f -exec sed -i 's/^Types: deb$/Types: deb-src/; s/^deb /deb-src /' {} +
apt=(apt-get -qq -o "Dir::Etc::sourcelist=$lists/sources.list" -o "Dir::Etc::sourceparts=$lists/sources"
  -o "Dir::State::lists=$lists/lists" -o "Dir::Cache=$lists/cache")
package=$(dpkg-query -W -f '${source:Package}' "$1")
"${apt[@]}" update
# Mirrors may lack what the list of security updates names: then the release's own sources are taken.
release=$(sed -n 's/^VERSION_CODENAME=//p' /etc/os-release)
(cd "$folder" && { "${apt[@]}" source "$package" || "${apt[@]}" source "$package/$release"; } >/dev/null)
mv "$folder/$package"-*/ "$folder/sources"
