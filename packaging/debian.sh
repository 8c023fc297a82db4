#!/usr/bin/env bash
# Debian packages of softcd, and a trial of them.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: packaging/debian.sh [--try]

Builds Debian packages with the compiler and libraries of this system into build/packages: libsoftcd0.1 (shared libraries, named by their
binary interface), libsoftcd-dev (headers, CMake, pkg-config) and softcd-tools (softcd-detect, softcd-certify and
softcd-demo).

  --try    then installs them, builds and runs the programs of tests/package against them, runs the tools, removes the
           packages and checks that no file is left. As root, on a system without softcd

  SOFTCD_CMAKE_ARGS   more arguments for cmake's configuration; -DSOFTCD_CUDA=ON adds the CUDA backend
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
  '' | --try) ;;
  *) usage >&2 && exit 2 ;;
esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."
build=$PWD/build/packages

build_packages() {
  cmake/setup.sh dpkg-dev fakeroot file
  # shellcheck disable=SC2086  # several arguments in one variable
  cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_UNITY_BUILD=ON -DBUILD_SHARED_LIBS=ON \
    -DCMAKE_INSTALL_PREFIX=/usr -DSOFTCD_TESTS=OFF -DSOFTCD_BENCHMARKS=OFF -DSOFTCD_CUDA=OFF ${SOFTCD_CMAKE_ARGS:-} >&2
  # Builds only the installed targets: demos/all would also build the scenes in both precisions.
  cmake --build "$build" --parallel "$(nproc)" --target plugin/all bullet_integration/all softcd_detect \
    softcd_certify softcd_demo >&2
  rm -f "$build"/*.deb
  (cd "$build" && cpack >&2)
  ls -l "$build"/*.deb
}

packages=()
remove_packages() { apt-get -qq purge -y "${packages[@]}" >/dev/null; }

try_packages() {
  local deb files file flags work=$build/trial
  for deb in "$build"/*.deb; do packages+=("$(dpkg-deb --field "$deb" Package)"); done
  trap remove_packages EXIT
  apt-get -qq install -y --no-install-recommends "$build"/*.deb >/dev/null
  mapfile -t files < <(dpkg-query --listfiles "${packages[@]}" | grep softcd | sort -u)

  rm -rf "$work"
  cmake -S tests/package -B "$work" -G Ninja -DCMAKE_BUILD_TYPE=Release >&2
  cmake --build "$work" >&2
  ctest --test-dir "$work" --output-on-failure --no-tests=error
  read -ra flags < <(pkg-config --cflags --libs softcd-bullet)
  g++ -std=c++17 tests/package/one_line_app.cpp -o "$work/one_line_app" "${flags[@]}"
  "$work/one_line_app"
  softcd-demo two-cloths --size 8 --steps 2 --picture "$work/picture.png" --export-step 2 "$work/step"
  softcd-detect "$work/step/t0.ply" "$work/step/t1.ply"
  softcd-certify "$work/step" --json "$work/certificate.json"
  softcd-certify --check "$work/certificate.json" "$work/step"

  trap - EXIT
  remove_packages
  for file in "${files[@]}"; do
    if [ -e "$file" ]; then echo "left behind: $file" >&2 && return 1; fi
  done
}

build_packages
if [ "${1:-}" = --try ]; then try_packages; fi
