#!/usr/bin/env bash
# Compiles softcd for Windows and runs tests there, with Wine.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: packaging/windows.sh [PROGRAM...]

Cross compiles softcd, softcd::bullet, softcd-detect and test PROGRAMs for 64-bit Windows (MinGW-w64, Release) into
build/windows/softcd, and runs the programs under Wine. Where none is named: tests of the kernels that compare vectors
with plain code, golden contacts, whose hashes are Linux's, the C interface, and Bullet's contacts.

Libraries are compiled once, from the distribution's sources, into build/windows/prefix. Needs 2 GB. As root, on Debian
12.
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."
programs=("$@")
if [ $# -eq 0 ]; then
  programs=(softcd_kernel_tests softcd_golden_tests softcd_c_interface_tests bullet_contacts_test)
fi
cmake/setup.sh g++-mingw-w64-x86-64-posix wine wine64 dpkg-dev m4

work=$PWD/build/windows
prefix=$work/prefix
mkdir -p "$prefix"/{bin,include,share/cmake}

configure() {
  cmake -S "$1" -B "$2" -G Ninja --toolchain "$PWD/packaging/windows.cmake" -DSOFTCD_WINDOWS_PREFIX="$prefix" \
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
        (cd "$folder/build" && ../sources/configure --host=x86_64-w64-mingw32 CC=x86_64-w64-mingw32-gcc-posix \
          --prefix="$prefix" "${@:2}") && make -C "$folder/build" -j "$(nproc)" install
    fi
  } >"$folder/log" 2>&1 || { tail -n 40 "$folder/log" >&2 && exit 1; }
  touch "$folder/installed"
}

library libfmt-dev -DFMT_TEST=OFF -DFMT_DOC=OFF
library libhwy-dev -DBUILD_TESTING=OFF -DHWY_ENABLE_CONTRIB=OFF -DHWY_ENABLE_EXAMPLES=OFF
library libtbb-dev -DTBB_TEST=OFF -DTBBMALLOC_BUILD=OFF -DTBB_STRICT=OFF -DBUILD_SHARED_LIBS=ON
library libgtest-dev
library libgmp-dev --disable-shared --enable-static
library libbullet-dev -DINSTALL_LIBS=ON -DBUILD_EXTRAS=OFF -DBUILD_UNIT_TESTS=OFF -DBUILD_BULLET2_DEMOS=OFF \
  -DBUILD_CPU_DEMOS=OFF -DBUILD_OPENGL3_DEMOS=OFF -DBUILD_PYBULLET=OFF -DBUILD_BULLET3=OFF -DBUILD_ENET=OFF \
  -DBUILD_CLSOCKET=OFF -DUSE_GLUT=OFF -DUSE_GRAPHICAL_BENCHMARK=OFF -DCMAKE_DISABLE_FIND_PACKAGE_OpenGL=ON

# Libraries without code are the machine's own; its other headers must not be seen.
for headers in boost CLI nlohmann; do ln -sfn "/usr/include/$headers" "$prefix/include/$headers"; done
cp -r /usr/share/cmake/{CLI11,nlohmann_json} "$prefix/share/cmake/"
# Programs need these beside them, or in the PATH.
cp "$(x86_64-w64-mingw32-g++-posix -print-file-name=libstdc++-6.dll)" \
  "$(x86_64-w64-mingw32-g++-posix -print-file-name=libgcc_s_seh-1.dll)" \
  "$(x86_64-w64-mingw32-g++-posix -print-file-name=libwinpthread-1.dll)" "$prefix/bin/"

export WINEPREFIX=$work/wine WINEARCH=win64 WINEDEBUG=-all
WINEPATH="Z:$prefix/bin"
export WINEPATH=${WINEPATH//\//\\}
wineboot --init >/dev/null 2>&1 || true

configure . "$work/softcd" -DCMAKE_UNITY_BUILD=ON -DSOFTCD_CUDA=OFF -DSOFTCD_BULLET_FLOAT64=OFF -DSOFTCD_BENCHMARKS=OFF \
  -DSOFTCD_DEMOS=OFF -DCMAKE_COMPILE_WARNING_AS_ERROR=ON >&2
cmake --build "$work/softcd" --parallel "$(nproc)" --target softcd softcd_bullet softcd_detect "${programs[@]}" >&2
ctest --test-dir "$work/softcd" -C programs -L program -R "^($(IFS='|' && echo "${programs[*]}"))\$" \
  --output-on-failure --no-tests=error
