#!/usr/bin/env bash
# Builds softcd's scenes as a page that a browser opens, with WebAssembly.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: packaging/web.sh [--try]

Compiles softcd, Bullet and the page of demos/web with Debian's Emscripten (one thread, SIMD128, Release) into
build/web/page/index.html. The page is one file, which needs no server.

Libraries are compiled once, from the distribution's sources, into build/web/prefix. Needs 2 GB. As root, on Debian 12.

  --try   also compiles the tests of kernels that compare vectors with plain code, and of golden contacts, whose hashes
          are the native build's, and runs them with node. Runs the page in headless Chromium for 60 steps of each
          scene, and writes build/web/page.png and the table of step times, build/web/times.txt.
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."
cmake/setup.sh emscripten dpkg-dev m4

work=$PWD/build/web
prefix=$work/prefix
mkdir -p "$prefix"/{include,share/cmake}
# For a node that is not Debian's own.
export NODE_PATH=/usr/share/nodejs

configure() {
  cmake -S "$1" -B "$2" -G Ninja --toolchain "$PWD/packaging/web.cmake" -DSOFTCD_WEB_PREFIX="$prefix" \
    -DCMAKE_INSTALL_PREFIX="$prefix" -DCMAKE_BUILD_TYPE=Release "${@:3}"
}

# library PACKAGE OPTION...: from the sources of the installed Debian package. Its log is beside them.
library() {
  local folder=$work/$1
  [ ! -e "$folder/installed" ] || return 0
  printf 'compiling what %s has\n' "$1"
  cmake/fetch_source.sh "$1" "$folder"
  {
    if [ -e "$folder/sources/CMakeLists.txt" ]; then
      configure "$folder/sources" "$folder/build" "${@:2}" && cmake --build "$folder/build" --parallel "$(nproc)" &&
        cmake --install "$folder/build"
    else
      # Debian leaves the documentation of GMP out, which its makefiles look for.
      mkdir -p "$folder/build" "$folder/sources/doc" && printf 'all install:\n' >"$folder/sources/doc/Makefile.in" &&
        (cd "$folder/build" && emconfigure ../sources/configure --host=none --prefix="$prefix" "${@:2}") &&
        make -C "$folder/build" -j "$(nproc)" install
    fi
  } >"$folder/log" 2>&1 || { tail -n 40 "$folder/log" >&2 && exit 1; }
  touch "$folder/installed"
}

library libfmt-dev -DFMT_TEST=OFF -DFMT_DOC=OFF
library libhwy-dev -DBUILD_TESTING=OFF -DHWY_ENABLE_CONTRIB=OFF -DHWY_ENABLE_EXAMPLES=OFF
library libgtest-dev
library libgmp-dev --disable-shared --enable-static --disable-assembly
library libbullet-dev -DINSTALL_LIBS=ON -DBUILD_EXTRAS=OFF -DBUILD_UNIT_TESTS=OFF -DBUILD_BULLET2_DEMOS=OFF \
  -DBUILD_CPU_DEMOS=OFF -DBUILD_OPENGL3_DEMOS=OFF -DBUILD_PYBULLET=OFF -DBUILD_BULLET3=OFF -DBUILD_ENET=OFF \
  -DBUILD_CLSOCKET=OFF -DUSE_GLUT=OFF -DUSE_GRAPHICAL_BENCHMARK=OFF -DCMAKE_DISABLE_FIND_PACKAGE_OpenGL=ON
# Libraries without code are the machine's own; its other headers must not be seen.
for headers in boost CLI nlohmann; do ln -sfn "/usr/include/$headers" "$prefix/include/$headers"; done
cp -r /usr/share/cmake/{CLI11,nlohmann_json} "$prefix/share/cmake/"

programs=()
if [ "${1:-}" = --try ]; then
  cmake/setup.sh chromium
  programs=(softcd_kernel_tests softcd_golden_tests)
fi
configure . "$work/softcd" -DSOFTCD_THREADS=OFF -DCMAKE_UNITY_BUILD=ON -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON \
  -DSOFTCD_CUDA=OFF -DSOFTCD_BULLET_FLOAT64=OFF -DSOFTCD_BENCHMARKS=OFF -DSOFTCD_DEMOS=OFF -DSOFTCD_INSTALL=OFF >&2
cmake --build "$work/softcd" --parallel "$(nproc)" --target softcd_web "${programs[@]}" >&2
mkdir -p "$work/page"
cp "$work/softcd/demos/web/index.html" "$work/page/"
printf '%s: %d bytes, %d compressed\n' "$work/page/index.html" "$(wc -c <"$work/page/index.html")" \
  "$(gzip -9c "$work/page/index.html" | wc -c)"
[ ${#programs[@]} -gt 0 ] || exit 0

export GTEST_FILTER='Twins.*:*InLanes*:*GoldenContacts*'
ctest --test-dir "$work/softcd" -C programs -L program -R "^($(IFS='|' && echo "${programs[*]}"))\$" \
  --output-on-failure --no-tests=error
node demos/web/try.js "$work/page/index.html" "$work/page.png" | tee "$work/times.txt"
