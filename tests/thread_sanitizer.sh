#!/usr/bin/env bash
# Runs tests whose loops are parallel under the thread sanitizer, with a oneTBB that is compiled with it.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: tests/thread_sanitizer.sh [PROGRAM...]

Builds the named test programs with the thread sanitizer (build/thread-sanitizer) and runs them. Default: the tests of
threads, softcd_determinism_tests and softcd_rank_tests.

Distributions build oneTBB without the sanitizer. It then cannot see that a task runs after the code that spawned it,
and reports every loop. So this first builds the distribution's sources of oneTBB with the sanitizer
(build/thread-sanitizer/tbb). It checks that a correct loop is not reported, and that a loop with a race is. It uses
vectors of this processor's widest kind only.

Environment: SOFTCD_SETUP=off; see cmake/build.sh --help.
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac

cd "$(dirname "${BASH_SOURCE[0]}")/.."
cmake/setup.sh dpkg-dev
programs=("$@")
if [ $# -eq 0 ]; then programs=(softcd_determinism_tests softcd_rank_tests); fi
build=$PWD/build/thread-sanitizer
tbb=$build/tbb

fail() {
  printf 'thread_sanitizer: %s\n' "$*" >&2
  exit 1
}

# g++ warns that the sanitizer knows nothing of fences, of which oneTBB has some: hence TBB_STRICT=OFF.
build_tbb() {
  cmake -S "$tbb/sources" -B "$tbb/build" -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo \
    -DCMAKE_CXX_FLAGS_RELWITHDEBINFO="-O1 -g1" -DTBB_SANITIZE=thread -DTBB_STRICT=OFF -DTBB_TEST=OFF -DTBBMALLOC_BUILD=OFF \
    -DCMAKE_INSTALL_LIBDIR=lib -DCMAKE_INSTALL_PREFIX="$tbb/prefix" >/dev/null
  cmake --build "$tbb/build" --parallel "$(nproc)" --target install >"$tbb/build.log" 2>&1 || {
    tail -n 40 "$tbb/build.log" >&2
    fail "oneTBB could not be built with the sanitizer"
  }
}

# Without this check the results below would mean nothing.
try_sanitizer() {
  c++ -x c++ -std=c++17 -O1 -g1 -fsanitize=thread "-I$tbb/prefix/include" -o "$tbb/loops" - \
    "-L$tbb/prefix/lib" "-Wl,-rpath,$tbb/prefix/lib" -ltbb <<'CPP'
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/global_control.h>

#include <vector>

int main(int arguments, char**) {
  const tbb::global_control four(tbb::global_control::max_allowed_parallelism, 4);
  std::vector<int> values(1'000'000);
  int sum = 0;
  for (int round = 0; round < 20; ++round) {
    tbb::parallel_for(0, 1'000'000, [&](int i) {
      values[i] += i;
      if (arguments > 1) sum += values[i];
    });
    for (const int value : values) sum ^= value;
  }
  return sum == 1 ? 1 : 0;
}
CPP
  "$tbb/loops" 2>"$tbb/right.log" || fail "a loop that is right is reported: $tbb/right.log"
  if "$tbb/loops" that races 2>"$tbb/race.log"; then fail "a loop that races is not reported"; fi
}

if [ ! -e "$tbb/prefix/lib/cmake/TBB/TBBConfig.cmake" ]; then
  cmake/fetch_source.sh libtbb-dev "$tbb"
  build_tbb
fi
try_sanitizer
cmake --preset cpu-tsan -B "$build" -DSOFTCD_DEMOS=OFF -DSOFTCD_INSTALL=OFF -DTBB_DIR="$tbb/prefix/lib/cmake/TBB" \
  -DCMAKE_CXX_FLAGS_RELWITHDEBINFO="-O1 -g1 -march=native -DHWY_COMPILE_ONLY_STATIC" >/dev/null
cmake --build "$build" --parallel "$(nproc)" --target "${programs[@]}"
for program in "${programs[@]}"; do
  found=$(find "$build/tests" -type f -name "$program")
  ldd "$found" | grep -qF "$tbb/prefix" || fail "$program does not use the oneTBB that was built for it"
  "$found" --gtest_brief=1
done
