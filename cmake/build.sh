#!/usr/bin/env bash
# Installs, configures and builds: what demos/run.sh, tests/run.sh and .ci/run have in common.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: cmake/build.sh [TARGET...]

Installs missing tools and libraries, and builds softcd (Release): all of it, or the named targets.

  SOFTCD_CUDA=auto|on|off   auto (default) builds the CUDA backend where there is an nvcc; on fetches one if need be
  CUDAARCHS                 CUDA architectures; default: this machine's GPU, 90 where there is none
  SOFTCD_CMAKE_ARGS         more arguments for cmake's configuration
  SOFTCD_BUILD_DIR          where; default: build/release
  SOFTCD_SETUP=off          installs nothing
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
"$root/cmake/setup.sh"

fetched_nvcc=$root/build/nvcc/nvidia/cu13/bin/nvcc
has_gpu() { command -v nvidia-smi >/dev/null && nvidia-smi -L >/dev/null 2>&1; }
has_toolkit() { [ -n "${CUDACXX:-}" ] || command -v nvcc >/dev/null || [ -x /usr/local/cuda/bin/nvcc ]; }

cuda=${SOFTCD_CUDA:-auto}
if [ "$cuda" != off ] && ! has_toolkit; then
  if [ -x "$fetched_nvcc" ]; then
    export CUDACXX=$fetched_nvcc
  elif has_gpu; then
    echo "softcd: there is a GPU here but no nvcc: the CPU backend only. SOFTCD_CUDA=on fetches the compiler." >&2
  fi
fi
if [ -z "${CUDAARCHS:-}" ]; then
  if has_gpu; then CUDAARCHS=native; else CUDAARCHS=90; fi
  export CUDAARCHS
fi

build=${SOFTCD_BUILD_DIR:-$root/build/release}
# Everything is built from nothing as a rule, hence the sources of each library as one.
# shellcheck disable=SC2086  # several arguments in one variable
cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DCMAKE_UNITY_BUILD=ON \
  -DSOFTCD_CUDA="${cuda^^}" ${SOFTCD_CMAKE_ARGS:-} >&2
targets=("$@")
cmake --build "$build" --parallel "$(nproc)" ${targets[@]+--target "${targets[@]}"} >&2
