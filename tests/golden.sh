#!/usr/bin/env bash
# Compares the contacts of the golden scenes between compilers and their options.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: tests/golden.sh [VARIANT...]

Builds only the test of golden contacts, once for each VARIANT (build/golden/VARIANT), and runs it. On the CPU it uses
1 to 16 threads, float and double positions, and each kind of registers that this processor has. It also runs on the
GPU, where a GPU and an nvcc exist. A VARIANT is a compiler and its options, with commas: g++,-O2 or
clang++,-O3,-march=native. Default: g++ and clang++, each with -O0, -O1, -O2, -O3 and -O3,-march=native. All variants
are run, even if some fail.

Environment: SOFTCD_CUDA=auto|on|off, SOFTCD_SETUP=off; see cmake/build.sh --help.
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac

cd "$(dirname "${BASH_SOURCE[0]}")/.."
cmake/setup.sh clang
variants=("$@")
if [ $# -eq 0 ]; then
  for compiler in g++ clang++; do
    for options in -O0 -O1 -O2 -O3 -O3,-march=native; do variants+=("$compiler,$options"); done
  done
fi
cuda=${SOFTCD_CUDA:-auto}

# Not Release, which adds options to the tests' sources.
try() {
  local variant=$1 folder="build/golden/$1" compiler=${1%%,*} options=${1#*,}
  cmake -S . -B "$folder" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DCMAKE_CXX_COMPILER="$compiler" \
    -DCMAKE_CXX_FLAGS_RELWITHDEBINFO="${options//,/ } -DNDEBUG" -DCMAKE_UNITY_BUILD=ON -DSOFTCD_BULLET=OFF \
    -DSOFTCD_BENCHMARKS=OFF -DSOFTCD_INSTALL=OFF -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON -DSOFTCD_CUDA="${cuda^^}" >&2 &&
    cmake --build "$folder" --parallel "$(nproc)" --target softcd_golden_tests >&2 &&
    ctest --test-dir "$folder" -C programs -L program -R '(^|cuda\.)softcd_golden_tests$' --output-on-failure \
      --no-tests=error
}

failed=()
for variant in "${variants[@]}"; do
  printf '\n== %s\n' "$variant"
  try "$variant" || failed+=("$variant")
done
[ ${#failed[@]} -eq 0 ] || { printf '\ngolden contacts differ, or were not built: %s\n' "${failed[*]}" >&2 && exit 1; }
printf '\nthe same contacts: %s\n' "${variants[*]}"
