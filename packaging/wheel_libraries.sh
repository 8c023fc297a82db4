#!/usr/bin/env bash
# Builds the libraries that a wheel holds, as static ones.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: packaging/wheel_libraries.sh FOLDER

Builds oneTBB, fmt and Highway as static libraries into FOLDER/prefix, and puts the licences of all libraries that a
wheel contains into its share/doc. On Debian and Ubuntu it uses the distribution's sources, elsewhere those that the
projects publish on GitHub, with the headers of Boost, CLI11 and nlohmann_json. Existing libraries are not built again.

  SOFTCD_JOBS   how many compilers run at a time; default: as many as there are processors
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac
if [ $# -ne 1 ]; then usage >&2 && exit 2; fi
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
mkdir -p "$1"
folder=$(cd "$1" && pwd)
prefix=$folder/prefix

# Prints the address of a package's published sources, for systems other than Debian.
published() {
  local github=https://github.com
  case $1 in
    libtbb-dev) echo "$github/uxlfoundation/oneTBB/archive/refs/tags/v2022.1.0.tar.gz" ;;
    libfmt-dev) echo "$github/fmtlib/fmt/archive/refs/tags/10.1.1.tar.gz" ;;
    libhwy-dev) echo "$github/google/highway/archive/refs/tags/1.2.0.tar.gz" ;;
    libboost-dev) echo "$github/boostorg/boost/releases/download/boost-1.83.0/boost-1.83.0.tar.gz" ;;
    libcli11-dev) echo "$github/CLIUtils/CLI11/archive/refs/tags/v2.4.1.tar.gz" ;;
    nlohmann-json3-dev) echo "$github/nlohmann/json/archive/refs/tags/v3.11.3.tar.gz" ;;
  esac
}

is_debian() { command -v apt-get >/dev/null; }

fetch() {
  if is_debian; then
    "$root/cmake/fetch_source.sh" "$1" "$folder/$1"
  else
    rm -rf "${folder:?}/$1"
    mkdir -p "$folder/$1/sources"
    curl --fail --silent --show-error --location "$(published "$1")" | tar -xz --strip-components=1 -C "$folder/$1/sources"
  fi
}

# $1: the package; $2: what it is called; more arguments for cmake's configuration.
build() {
  local sources=$folder/$1/sources
  [ ! -e "$prefix/share/doc/$2" ] || return 0
  fetch "$1"
  {
    cmake -S "$sources" -B "$folder/$1/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DBUILD_SHARED_LIBS=OFF \
      -DCMAKE_POSITION_INDEPENDENT_CODE=ON -DCMAKE_CXX_VISIBILITY_PRESET=hidden -DCMAKE_VISIBILITY_INLINES_HIDDEN=ON \
      -DCMAKE_INSTALL_LIBDIR=lib -DCMAKE_INSTALL_PREFIX="$prefix" "${@:3}" &&
      cmake --build "$folder/$1/build" --parallel "${SOFTCD_JOBS:-$(nproc)}" --target install
  } >"$folder/$1/build.log" 2>&1 || {
    tail -n 40 "$folder/$1/build.log" >&2
    printf 'softcd: %s could not be built as a static library\n' "$2" >&2
    exit 1
  }
  rm -rf "$prefix/share/doc/TBB"
  mkdir -p "$prefix/share/doc/$2"
  cp "$sources"/LICENSE* "$prefix/share/doc/$2/"
  if [ -e "$sources/debian/copyright" ]; then cp "$sources/debian/copyright" "$prefix/share/doc/$2/"; fi
}

# Headers alone. $1: the package; $2: what it is called; $3: one of the headers; more arguments for cmake's configuration.
take_headers() {
  local owner
  if is_debian; then
    "$root/cmake/setup.sh" --only "$1"
    mkdir -p "$prefix/share/doc/$2"
    owner=$(dpkg-query --search "/usr/include/$3")
    cp "/usr/share/doc/${owner%%:*}/copyright" "$prefix/share/doc/$2/"
  else
    build "$1" "$2" "${@:4}"
  fi
}
build libtbb-dev onetbb -DTBB_TEST=OFF -DTBBMALLOC_BUILD=OFF -DTBB_STRICT=OFF
build libfmt-dev fmt -DFMT_DOC=OFF -DFMT_TEST=OFF
build libhwy-dev highway -DBUILD_TESTING=OFF -DHWY_ENABLE_CONTRIB=OFF -DHWY_ENABLE_EXAMPLES=OFF -DHWY_ENABLE_TESTS=OFF
take_headers libboost-dev boost boost/version.hpp -DBOOST_INCLUDE_LIBRARIES=multiprecision
take_headers libcli11-dev cli11 CLI/CLI.hpp -DCLI11_BUILD_TESTS=OFF -DCLI11_BUILD_EXAMPLES=OFF -DCLI11_BUILD_DOCS=OFF
take_headers nlohmann-json3-dev nlohmann_json nlohmann/json.hpp -DJSON_BuildTests=OFF
