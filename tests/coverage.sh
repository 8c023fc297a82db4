#!/usr/bin/env bash
# Measures which lines of the products the tests run.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: tests/coverage.sh [PROGRAM...]

Builds softcd for gcov (build/coverage, CPU only) and runs the test PROGRAMs; default: all but those labelled
`repetition`. Prints the share of the lines of kernels, plugin, bullet_integration and demos that they have run, by file
and in total. Writes the lines themselves to build/coverage/html. Leaves out files that are not linked into
any of the programs. Installs missing tools.
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."
cmake/setup.sh gcovr
targets=("$@")
[ $# -gt 0 ] || targets=(softcd_tests_once)
selection=(-LE repetition -E '^softcd_package$')  # its programs are linked without gcov
[ $# -eq 0 ] || selection=(-R "^($(IFS='|' && echo "$*"))\$")

# At -O1 lines keep their counts, and tests take little longer.
cmake -S . -B build/coverage -G Ninja -DCMAKE_BUILD_TYPE=Release "-DCMAKE_CXX_FLAGS=--coverage -fprofile-update=atomic" \
  -DCMAKE_CXX_FLAGS_RELEASE=-O1 -DCMAKE_UNITY_BUILD=ON -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON -DSOFTCD_CUDA=OFF \
  -DSOFTCD_BENCHMARKS=OFF >/dev/null
cmake --build build/coverage --parallel "$(nproc)" --target "${targets[@]}"
find build/coverage -name '*.gcda' -delete
ctest --test-dir build/coverage -C programs -L program "${selection[@]}" -j "$(nproc)" --output-on-failure --no-tests=error
mkdir -p build/coverage/html
gcovr --root . --object-directory build/coverage --exclude-throw-branches --exclude-unreachable-branches \
  --filter kernels/ --filter plugin/ --filter bullet_integration/ --filter demos/ \
  --html-details build/coverage/html/index.html --txt -
