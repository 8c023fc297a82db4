#!/usr/bin/env bash
# Builds all files of a release.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: packaging/release.sh [--check | --against FOLDER]

Builds from a clean clone into build/release:
- the sources, softcd-VERSION-source.tar.gz, with the tests, and those of the Python package;
- Debian packages for this system, CPU only (packaging/debian.sh);
- wheels of softcd and softcd-pybullet (packaging/wheels.sh);
- the binary interface of the shared libraries (packaging/abi.sh);
- softcd-VERSION.cdx.json, which lists the libraries that each file contains; SHA256SUMS.

Fails if:
- the clone has changes that are not committed;
- files name different versions, or CHANGELOG.md and CITATION.cff different dates;
- the commit has a tag of another version, or CHANGELOG.md has no date for the tagged version. Without a tag the files
  are a trial, not to be published.

  --check            compares versions and dates, and builds nothing
  --against FOLDER   compares the binary interface with that of the last release, whose files are in FOLDER

  SOFTCD_CUDA, CUDAARCHS, PYTHONS, SOFTCD_JOBS   see packaging/wheels.sh --help
TEXT
}

fail() {
  printf 'softcd: %s\n' "$*" >&2
  exit 1
}

against=()
check=off
case "${1:-}" in
  -h | --help) usage && exit 0 ;;
  --check) check=on ;;
  --against) against=(--against "$(realpath "${2:?a folder}")") ;;
  '') ;;
  *) usage >&2 && exit 2 ;;
esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."
release=$PWD/build/release
packages=$PWD/build/packages
wheels=$PWD/build/wheels
version=$(sed -n 's/#define SOFTCD_VERSION_STRING "\(.*\)"/\1/p' kernels/include/softcd/version.hpp)

# Fails where the file $1 does not have a line that matches $2.
names_version() { grep -qE "$2" "$1" || fail "$1 does not name version $version, as version.hpp does"; }

# Prints the version's date in CHANGELOG.md, which CITATION.cff has to have, too. Prints nothing if there is none.
release_date() {
  local date
  date=$(sed -nE "s/^## ${version//./\\.}, ([0-9]{4}-[0-9]{2}-[0-9]{2})\$/\1/p" CHANGELOG.md)
  if [ -n "$date" ]; then
    grep -qx "date-released: $date" CITATION.cff || fail "CITATION.cff lacks the line 'date-released: $date', CHANGELOG.md's date"
  fi
  printf '%s' "$date"
}

# PyPI takes a version once, and .github/workflows/wheels.yml publishes what is tagged.
check_tag() {
  local date tags
  date=$(release_date)
  tags=$(git tag --points-at HEAD 'v*')
  if [ -z "$tags" ]; then
    if [ "$check" = off ]; then echo "softcd: this commit has no tag v$version, so its files are a rehearsal" >&2; fi
  elif [ "$tags" != "v$version" ]; then
    fail "the tag of this commit is ${tags//$'\n'/ }, and its version $version"
  elif [ -z "$date" ]; then
    fail "v$version has no date: write '## $version, $(date +%F)' into CHANGELOG.md, commit, and tag that commit instead"
  fi
}

check_sources() {
  local escaped=${version//./\\.}
  names_version CHANGELOG.md "^## $escaped\b"
  names_version CITATION.cff "^version: $escaped\$"
  names_version packaging/conda/recipe.yaml "^  version: $escaped\$"
  names_version packaging/vcpkg/softcd/vcpkg.json "\"version\": \"$escaped\""
  names_version python/pybullet/pyproject.toml "\"softcd==$escaped\""
}

# Prints the version of the CUDA compiler that the wheels were built with, or none.
cuda_of_wheels() {
  local found
  found=$(find "$wheels"/cmake-source-* -name CMakeCUDACompiler.cmake -print -quit)
  if [ -z "$found" ]; then echo none && return; fi
  sed -n 's/^set(CMAKE_CUDA_COMPILER_VERSION "\(.*\)")$/\1/p' "$found"
}

# Prints the version of nanobind that the wheels were built with.
nanobind_of_wheels() {
  local python
  python=$(find "$wheels" -path "$wheels/python3*/bin/python" -print -quit)
  "$python" -c 'import importlib.metadata; print(importlib.metadata.version("nanobind"))'
}

check_sources
check_tag
if [ "$check" = on ]; then exit; fi
[ -z "$(git status --porcelain)" ] || fail "there are changes that are not committed: git status names them"
rm -rf "$release"
mkdir -p "$release"
git archive --format=tar --prefix="softcd-$version/" HEAD | gzip -9n >"$release/softcd-$version-source.tar.gz"

# Packages are stripped; the descriptions of the binary interface are made of what is not.
CXXFLAGS="${CXXFLAGS:-} -g" packaging/debian.sh >&2
cp "$packages"/*.deb "$release/"
packaging/abi.sh "$release" ${against[@]+"${against[@]}"} "$packages"/plugin/libsoftcd.so "$packages"/bullet_integration/libsoftcd_bullet*.so

packaging/wheels.sh
cp "$wheels"/dist/* "$release/"

pybullet=$(packaging/pybullet_source.sh "$wheels/pybullet")
bill=$(python3 packaging/sbom.py "$release" --cuda "$(cuda_of_wheels)" --nanobind "$(nanobind_of_wheels)" \
  --pybullet "${pybullet##*-}")
printf '%s\n' "$bill" >"$release/softcd-$version.cdx.json"
(cd "$release" && sha256sum -- * >SHA256SUMS.part && mv SHA256SUMS.part SHA256SUMS && sha256sum --quiet --check SHA256SUMS)
ls -l "$release"
check_tag
