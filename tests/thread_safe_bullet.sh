#!/usr/bin/env bash
# Tests Bullet's worlds with a Bullet that was built for several threads, which Debian's was not.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: tests/thread_safe_bullet.sh [FILTER]

Builds Bullet with BT_THREADSAFE and installs it into build/thread-safe/bullet. Builds softcd and the tests of Bullet's
worlds against it (build/thread-safe/softcd), and runs the tests that FILTER selects, as --gtest_filter does (default:
all). btCollisionDispatcherMt then uses several threads.

  BULLET_SOURCE=DIR   Bullet's sources; default: 3.24, fetched with git
  SOFTCD_SETUP=off    installs nothing
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac

cd "$(dirname "${BASH_SOURCE[0]}")/.."
cmake/setup.sh git
folder=$PWD/build/thread-safe
source=${BULLET_SOURCE:-$folder/source}
if [ ! -f "$source/CMakeLists.txt" ]; then
  git clone --quiet --depth 1 --branch 3.24 https://github.com/bulletphysics/bullet3 "$source"
fi

options=(-DBULLET2_MULTITHREADING=ON -DBUILD_SHARED_LIBS=ON -DINSTALL_LIBS=ON -DBUILD_BULLET3=OFF -DBUILD_PYBULLET=OFF)
for part in EXTRAS BULLET2_DEMOS CPU_DEMOS OPENGL3_DEMOS UNIT_TESTS ENET CLSOCKET; do options+=("-DBUILD_$part=OFF"); done
cmake -S "$source" -B "$folder/bullet-build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_CXX_FLAGS=-w \
  -DCMAKE_INSTALL_PREFIX="$folder/bullet" -DCMAKE_INSTALL_RPATH="$folder/bullet/lib" "${options[@]}" >/dev/null
cmake --build "$folder/bullet-build" --parallel "$(nproc)" --target install >&2

# Bullet's headers need the same definition as its sources.
cmake -S . -B "$folder/softcd" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_UNITY_BUILD=ON -DSOFTCD_CUDA=OFF \
  -DSOFTCD_BULLET_FLOAT64=OFF -DBULLET_ROOT="$folder/bullet" -DCMAKE_CXX_FLAGS=-DBT_THREADSAFE=1 >/dev/null
programs=(bullet_behaviour_test bullet_throwing_test)
cmake --build "$folder/softcd" --parallel "$(nproc)" --target "${programs[@]}" >&2
for program in "${programs[@]}"; do
  "$folder/softcd/tests/bullet_integration/$program" ${1:+"--gtest_filter=$1"}
done
