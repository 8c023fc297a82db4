#!/usr/bin/env bash
# Runs tests with another C++ standard library than g++'s, which checks its callers.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: tests/libcxx.sh [PROGRAM...]

Builds softcd and test PROGRAMs with clang++ 16 and libc++ 16 (build/libcxx, Release) and runs them. Default: tests of the
kernels, of detections, of golden contacts, which must have the hashes of g++ and libstdc++, and of the readers of meshes.

_LIBCPP_ENABLE_ASSERTIONS=1 makes libc++ end a program at a misuse that it can see, such as an index that is too large.
libc++ 18 calls the same _LIBCPP_HARDENING_MODE. The script first checks that such an index ends a program.

oneTBB, fmt, Highway and GoogleTest pass types of the standard library to their callers. So the script builds these with
libc++ first, from Debian's sources. Bullet is left out.

Environment: SOFTCD_SETUP=off; see cmake/build.sh --help.
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac

cd "$(dirname "${BASH_SOURCE[0]}")/.."
cmake/setup.sh clang-16 libc++-16-dev libc++abi-16-dev dpkg-dev googletest
programs=("$@")
if [ $# -eq 0 ]; then programs=(softcd_kernel_tests softcd_golden_tests softcd_detection_tests softcd_mesh_io_test); fi
work=$PWD/build/libcxx
libraries=$work/libraries
mkdir -p "$work"
export CC=clang-16 CXX=clang++-16 LDFLAGS=-stdlib=libc++
# Boost 1.74 derives from std::unary_function, which C++20 lacks, unless it is told otherwise.
export CXXFLAGS="-stdlib=libc++ -D_LIBCPP_ENABLE_ASSERTIONS=1 -DBOOST_NO_CXX98_FUNCTION_BASE"

fail() {
  printf 'libcxx: %s\n' "$*" >&2
  exit 1
}

# Without this check the results below would mean less.
try_assertions() {
  # shellcheck disable=SC2086  # several options in each variable
  "$CXX" $CXXFLAGS -O2 -x c++ - $LDFLAGS -o "$work/index" <<'CPP'
#include <vector>

int main(int arguments, char**) {
  const std::vector<int> values{0, 0};
  return values[arguments];
}
CPP
  "$work/index" || fail "an index that is right ends a program"
  if (ulimit -c 0 && exec "$work/index" 2) 2>"$work/index.log"; then fail "libc++ accepts an index that is too large"; fi
  grep -q 'assertion.*out of bounds' "$work/index.log" || fail "libc++ does not say why a program ended: $work/index.log"
}

build_googletest() {
  [ ! -e "$libraries/googletest" ] || return 0
  cmake -S /usr/src/googletest -B "$work/googletest" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_INSTALL_LIBDIR=lib \
    -DCMAKE_INSTALL_PREFIX="$libraries/prefix" >/dev/null
  cmake --build "$work/googletest" --parallel "$(nproc)" --target install >/dev/null
  touch "$libraries/googletest"
}

try_assertions
packaging/wheel_libraries.sh "$libraries"
build_googletest
cmake -S . -B "$work/softcd" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_UNITY_BUILD=ON -DSOFTCD_CUDA=OFF \
  -DCMAKE_PREFIX_PATH="$libraries/prefix" -DSOFTCD_BULLET=OFF -DSOFTCD_BENCHMARKS=OFF -DSOFTCD_INSTALL=OFF >/dev/null
cmake --build "$work/softcd" --parallel "$(nproc)" --target "${programs[@]}"
ctest --test-dir "$work/softcd" -C programs -L program -R "^($(IFS='|' && echo "${programs[*]}"))\$" -j "$(nproc)" \
  --output-on-failure --no-tests=error
if ldd "$(find "$work/softcd/tests" -type f -name "${programs[0]}")" | grep -F libstdc++; then
  fail "a program uses both standard libraries"
fi
