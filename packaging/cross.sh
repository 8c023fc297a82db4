# shellcheck shell=bash
# What packaging/windows.sh and packaging/web.sh share. They read this file from the root, with an argument: the name of the
# toolchain file in packaging and of the folder in build.

system=$1
work=$PWD/build/$system
prefix=$work/prefix
mkdir -p "$prefix"/{bin,include,share/cmake}
# The machine has libraries of the same names.
export PKG_CONFIG_LIBDIR=$prefix/lib/pkgconfig

# configure SOURCES BUILD OPTION...
configure() {
  cmake -S "$1" -B "$2" -G Ninja --toolchain "$PWD/packaging/$system.cmake" -DSOFTCD_CROSS_PREFIX="$prefix" \
    -DCMAKE_INSTALL_PREFIX="$prefix" -DCMAKE_BUILD_TYPE=Release "${@:3}"
}

# library PACKAGE OPTION...: compiles the sources of the installed Debian package. Its log is beside them. Where CMake does
# not configure these, the options are preceded by the script that does, seen from a folder beside theirs.
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
        (cd "$folder/build" && "${@:2}" --prefix="$prefix") &&
        make -C "$folder/build" -j "$(nproc)" install
    fi
  } >"$folder/log" 2>&1 || { tail -n 40 "$folder/log" >&2 && exit 1; }
  touch "$folder/installed"
}

# libraries OPTION...: compiles those that both need; the options are for GMP. Those without code are the machine's own; its
# other headers must not be seen.
libraries() {
  library libfmt-dev -DFMT_TEST=OFF -DFMT_DOC=OFF
  library libhwy-dev -DBUILD_TESTING=OFF -DHWY_ENABLE_CONTRIB=OFF -DHWY_ENABLE_EXAMPLES=OFF
  library libgtest-dev
  library libgmp-dev "$@" --disable-shared --enable-static
  library libbullet-dev -DINSTALL_LIBS=ON -DBUILD_EXTRAS=OFF -DBUILD_UNIT_TESTS=OFF -DBUILD_BULLET2_DEMOS=OFF \
    -DBUILD_CPU_DEMOS=OFF -DBUILD_OPENGL3_DEMOS=OFF -DBUILD_PYBULLET=OFF -DBUILD_BULLET3=OFF -DBUILD_ENET=OFF \
    -DBUILD_CLSOCKET=OFF -DUSE_GLUT=OFF -DUSE_GRAPHICAL_BENCHMARK=OFF -DCMAKE_DISABLE_FIND_PACKAGE_OpenGL=ON
  local headers
  for headers in boost CLI nlohmann; do ln -sfn "/usr/include/$headers" "$prefix/include/$headers"; done
  cp -r /usr/share/cmake/{CLI11,nlohmann_json} "$prefix/share/cmake/"
}

# build_softcd OPTION... -- TARGET...
build_softcd() {
  local options=()
  while [ "$1" != -- ]; do options+=("$1") && shift; done
  shift
  configure . "$work/softcd" -DCMAKE_UNITY_BUILD=ON -DSOFTCD_CUDA=OFF -DSOFTCD_BULLET_FLOAT64=OFF \
    -DSOFTCD_BENCHMARKS=OFF "${options[@]}" >&2
  cmake --build "$work/softcd" --parallel "$(nproc)" --target "$@" >&2
}

# Runs test programs, and prints for each how many of its tests passed and were skipped.
try_programs() {
  local log=$work/softcd/Testing/Temporary/LastTest.log
  ctest --test-dir "$work/softcd" -C programs -L program -R "^($(IFS='|' && echo "$*"))\$" --output-on-failure --no-tests=error
  # Wine may report success for a program that has crashed, which then prints no sum.
  awk '/^[0-9]+\/[0-9]+ Test: / {program = $3; passed[program] = -1}
    /\[  PASSED  \]/ {passed[program] = $4}
    /\[  SKIPPED \] [0-9]+ test/ {skipped[program] = $4}
    END {
      for (program in passed) {
        if (passed[program] < 0) {
          printf "%s: crashed\n", program
          failed = 1
        } else {
          printf "%s: %d passed, %d skipped\n", program, passed[program], skipped[program]
        }
      }
      exit failed
    }' "$log"
}
