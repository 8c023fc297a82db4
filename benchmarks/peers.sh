#!/usr/bin/env bash
# Tests the sample queries of CCD-Wrapper with softcd, Tight-Inclusion and TDIB-CCD.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: benchmarks/peers.sh [ROUNDS]

Compares softcd's continuous test of two features with Tight-Inclusion and TDIB-CCD. Fetches their sources and the sample
queries from GitHub into build/peers, unless they are there. Compiles them, and prints a table for
docs/measured/accuracy.md: for each set of queries and each test, the false reports, the missed touches, and the least
processor time of a query in microseconds in ROUNDS (5).

To test the 60 million queries of CCD-Wrapper, run build/peers/peers FOLDER ROUNDS. FOLDER has the same layout.

Environment: CXX; SOFTCD_SETUP=off, see cmake/build.sh --help.
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."
cmake/setup.sh --only git g++ libeigen3-dev libspdlog-dev libboost-dev >&2
work=build/peers
mkdir -p "$work"

# $1: the repository on GitHub; $2: the commit.
fetch() {
  local folder=$work/${1##*/}
  [ -d "$folder" ] || git clone --quiet "https://github.com/$1.git" "$folder"
  git -C "$folder" checkout --quiet "$2"
}
fetch Continuous-Collision-Detection/Sample-Queries a744562c7a842e9eee033fcea290e75a4a8e7b4e
fetch Continuous-Collision-Detection/Tight-Inclusion ca9a8c24fe91de3376d77975c5e9978f88e05794
fetch xw-c/TDIB-CCD b88a33586d7e3b23a07da5026cd24ddd0610e733

tight=$work/Tight-Inclusion/src/tight_inclusion
sed -e 's/@PROJECT_[A-Z_]*@//' -e 's/#cmakedefine \(TIGHT_INCLUSION_WITH_DOUBLE_PRECISION\)/#define \1/' \
  -e '/#cmakedefine/d' "$tight/config.hpp.in" >"$tight/config.hpp"
# Debian's spdlog has no copy of fmt.
mkdir -p "$work/include/spdlog/fmt/bundled"
echo '#include <fmt/ranges.h>' >"$work/include/spdlog/fmt/bundled/ranges.h"
"${CXX:-g++}" -std=c++20 -O2 -DNDEBUG -ffp-contract=off -w -I kernels/include -I tests/support -I "$work/include" \
  -isystem "$work/Tight-Inclusion/src" -isystem "$work/TDIB-CCD/benchmark" -isystem /usr/include/eigen3 \
  benchmarks/peers/*.cpp tests/support/recorded_queries.cpp \
  "$tight"/{avx,ccd,interval,interval_root_finder,logger}.cpp -o "$work/peers" -lfmt -lspdlog
"$work/peers" "$work/Sample-Queries" "${1:-5}"
