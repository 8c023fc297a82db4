#!/usr/bin/env bash
# Compiles softcd for Windows and runs tests there, with Wine.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: packaging/windows.sh [PROGRAM...]

Cross compiles softcd, softcd::bullet, softcd-detect, softcd-demo and test PROGRAMs for 64-bit Windows (MinGW-w64,
Release) into build/windows/softcd. Runs softcd-demo and the test programs under Wine. Prints how many tests of each
passed. Where none is named: tests of the kernels, golden contacts, whose hashes are Linux's, detections, the C
interface, and Bullet's contacts, filters and worlds. Installs the libraries into build/windows/install, and builds and
runs the programs of tests/package with them.

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
  programs=(softcd_kernel_tests softcd_golden_tests softcd_detection_tests softcd_c_interface_tests bullet_contacts_test
    bullet_filter_test bullet_worlds_test)
fi
cmake/setup.sh g++-mingw-w64-x86-64-posix libz-mingw-w64-dev wine wine64 dpkg-dev m4

# shellcheck source=packaging/cross.sh
. packaging/cross.sh windows
libraries ../sources/configure --host=x86_64-w64-mingw32 CC=x86_64-w64-mingw32-gcc-posix
library libtbb-dev -DTBB_TEST=OFF -DTBBMALLOC_BUILD=OFF -DTBB_STRICT=OFF -DBUILD_SHARED_LIBS=ON
# Debian's sources of zlib lack what CMake needs for a DLL.
ln -sfn /usr/x86_64-w64-mingw32/include/{zlib,zconf}.h "$prefix/include/"
ln -sfn /usr/x86_64-w64-mingw32/lib/libz.a "$prefix/lib/"
library libpng-dev -DPNG_TESTS=OFF -DPNG_SHARED=OFF
# Programs need these beside them, or in the PATH.
cp "$(x86_64-w64-mingw32-g++-posix -print-file-name=libstdc++-6.dll)" \
  "$(x86_64-w64-mingw32-g++-posix -print-file-name=libgcc_s_seh-1.dll)" \
  "$(x86_64-w64-mingw32-g++-posix -print-file-name=libwinpthread-1.dll)" "$prefix/bin/"

export WINEPREFIX=$work/wine WINEARCH=win64 WINEDEBUG=-all
WINEPATH="Z:$prefix/bin"
export WINEPATH=${WINEPATH//\//\\}
wineboot --init >/dev/null 2>&1 || true

build_softcd -DCMAKE_COMPILE_WARNING_AS_ERROR=ON -- softcd softcd_bullet softcd_detect softcd_demo "${programs[@]}"
wine "$work/softcd/demos/demo/softcd-demo.exe" two-cloths --size 12 --steps 12
try_programs "${programs[@]}"

# A project of a user, which sets no compiler options for softcd.
cmake --install "$work/softcd" --component development --prefix "$work/install" >/dev/null
configure tests/package "$work/package" -Dsoftcd_DIR="$work/install/lib/cmake/softcd" -DCMAKE_CXX_FLAGS= \
  -DCMAKE_EXPORT_COMPILE_COMMANDS=ON >&2
cmake --build "$work/package" --parallel "$(nproc)" >&2
for source in detector one_line_app; do
  grep -q -- "-fno-ipa-ra .*/$source\.cpp" "$work/package/compile_commands.json" ||
    { printf '%s.cpp was compiled without what g++ for Windows needs\n' "$source" >&2 && exit 1; }
done
ctest --test-dir "$work/package" --output-on-failure --no-tests=error
export PKG_CONFIG_LIBDIR=$work/install/lib/pkgconfig:$prefix/lib/pkgconfig
read -ra flags <<<"$(pkg-config --static --cflags --libs softcd)"
x86_64-w64-mingw32-g++-posix -std=c++17 tests/package/detector.cpp -o "$work/package/pkg_config.exe" "${flags[@]}"
wine "$work/package/pkg_config.exe" "$(pkg-config --modversion softcd)"
case " ${flags[*]} " in
  *" -fno-ipa-ra "*) ;;
  *) printf 'softcd.pc lacks what g++ for Windows needs\n' >&2 && exit 1 ;;
esac
