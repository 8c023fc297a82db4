#!/usr/bin/env bash
# Builds, tests and measures on a machine without a network.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: benchmarks/offline.sh [--prefix DIR] [--build DIR] [--arch ARCHS] [--backend BACKENDS] [--output FILE]

For machines without a network. Configures and builds softcd (Release, with the CUDA backend if there is an nvcc), runs
every test, and then benchmarks/performance.sh. Fetches nothing and writes only below --build and to --output.

  --prefix DIR        a folder with the dependencies (Bullet, oneTBB, Highway, Eigen, CLI11, fmt, nlohmann_json,
                      GoogleTest, Boost, GMP, libpng; for softcd-certify OpenSSL) in DIR/include and DIR/lib, or unpacked
                      from Debian packages: DIR/usr/include, DIR/usr/lib/x86_64-linux-gnu. Left out: the system's
  --build DIR         where to build; default build/offline
  --arch ARCHS        CUDA architectures, e.g. 90; default native, this machine's GPU, where there is one
  --backend BACKENDS  what to measure: cpu, cuda or cpu,cuda; default: cuda too where it is built and there is a GPU
  --output FILE       the tables; default performance.md in --build. They are appended

  SOFTCD_CUDA=off             no CUDA backend
  SOFTCD_REPEAT, SOFTCD_MOST  see benchmarks/performance.sh --help
  CMAKE_BUILD_PARALLEL_LEVEL, CTEST_PARALLEL_LEVEL  processes at a time; default: one per core
TEXT
}

fail() {
  echo "offline.sh: $*" >&2
  exit 2
}

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
prefix='' build=$root/build/offline arch='' backends='' output=''
while [ $# -gt 0 ]; do
  case "$1" in
    -h | --help) usage && exit 0 ;;
    --prefix | --build | --arch | --backend | --output)
      [ $# -ge 2 ] || fail "$1 needs a value"
      case "$1" in
        --prefix) prefix=$2 ;;
        --build) build=$2 ;;
        --arch) arch=$2 ;;
        --backend) backends=$2 ;;
        --output) output=$2 ;;
      esac
      shift 2
      ;;
    *) fail "unknown argument '$1'; see --help" ;;
  esac
done

# prepend VARIABLE FOLDER: puts an existing folder in front of a variable's list.
prepend() {
  [ -d "$2" ] || return 0
  export "$1=$2${!1:+:${!1}}"
}

if [ -n "$prefix" ]; then
  prefix=$(cd "$prefix" 2>/dev/null && pwd) || fail "--prefix: there is no such folder"
  # In rising order of preference.
  for base in "$prefix/usr" "$prefix"; do
    prepend CMAKE_PREFIX_PATH "$base"
    prepend CPATH "$base/include"
    prepend CPATH "$base/include/$(uname -m)-linux-gnu"
    for lib in "$base/lib" "$base/lib64" "$base/lib/$(uname -m)-linux-gnu"; do
      prepend LIBRARY_PATH "$lib"
      prepend LD_LIBRARY_PATH "$lib"
      prepend PKG_CONFIG_PATH "$lib/pkgconfig"
    done
    prepend PKG_CONFIG_PATH "$base/share/pkgconfig"
    prepend PATH "$base/bin"
  done
fi

has_gpu() { command -v nvidia-smi >/dev/null && nvidia-smi -L >/dev/null 2>&1; }
has_nvcc() { [ -n "${CUDACXX:-}" ] || command -v nvcc >/dev/null || [ -x /usr/local/cuda/bin/nvcc ]; }

configuration=(-DCMAKE_BUILD_TYPE=Release)
if [ "${SOFTCD_CUDA:-auto}" != off ] && has_nvcc; then
  configuration+=(-DSOFTCD_CUDA=ON)
  if [ -z "$arch" ] && has_gpu; then arch=native; fi
  if [ -n "$arch" ]; then configuration+=("-DCMAKE_CUDA_ARCHITECTURES=$arch"); fi
  if [ -z "$backends" ] && has_gpu; then backends=cpu,cuda; fi
else
  configuration+=(-DSOFTCD_CUDA=OFF)
fi
if command -v ninja >/dev/null; then configuration+=(-G Ninja); fi

export CMAKE_BUILD_PARALLEL_LEVEL=${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)}
export CTEST_PARALLEL_LEVEL=${CTEST_PARALLEL_LEVEL:-$(nproc)}
cmake -S "$root" -B "$build" "${configuration[@]}"
cmake --build "$build"
ctest --test-dir "$build" --output-on-failure --no-tests=error
"$root/benchmarks/performance.sh" "$build/benchmarks/softcd-bench" "${backends:-cpu}" "${output:-$build/performance.md}"
