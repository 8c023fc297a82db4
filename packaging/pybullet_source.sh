#!/usr/bin/env bash
# Fetches the sources of the PyBullet that the plugin is built for.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: packaging/pybullet_source.sh FOLDER

Fetches the sources of the PyBullet that python/pybullet/pyproject.toml names from PyPI, and unpacks them into FOLDER,
unless they are there. Prints their folder. Needs a python3 with pip and venv.
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac
if [ $# -ne 1 ]; then usage >&2 && exit 2; fi
mkdir -p "$1"
folder=$(cd "$1" && pwd)
version=$(sed -n 's/^dependencies = .*"pybullet==\([0-9.]*\)".*/\1/p' "$(dirname "${BASH_SOURCE[0]}")/../python/pybullet/pyproject.toml")
sources=$folder/pybullet-$version
if [ ! -d "$sources" ]; then
  [ -x "$folder/venv/bin/python" ] || python3 -m venv "$folder/venv"
  "$folder/venv/bin/python" -m pip --quiet --disable-pip-version-check download --no-deps --no-binary :all: \
    --dest "$folder" "pybullet==$version" >&2
  rm -rf "$folder/part"
  mkdir "$folder/part"
  tar -xzf "$folder/pybullet-$version.tar.gz" -C "$folder/part"
  mv "$folder/part/pybullet-$version" "$sources"
fi
echo "$sources"
