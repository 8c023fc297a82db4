#!/usr/bin/env bash
# Compiles softcd for aarch64 and runs tests there, by an emulator.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: packaging/aarch64.sh [PROGRAM...]

Cross compiles test PROGRAMs and what they need (Release, without demo and benchmarks) into build/aarch64 and runs them
under qemu-user. Default: tests of the kernels that compare vectors (NEON) with plain code, and golden contacts and a
certificate, whose hashes must be those of x86-64.

Installs the compiler, the emulator and the libraries for arm64 beside this machine's own. To keep them off this machine
run packaging/bare.sh bookworm packaging/aarch64.sh. As root, on Debian 12.
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."
programs=("$@")
if [ $# -eq 0 ]; then
  programs=(softcd_kernel_tests softcd_golden_tests softcd_certify_test)
  export GTEST_FILTER='Twins.*:*InLanes*:*GoldenContacts*:CertificateBytes.*'
fi

dpkg --add-architecture arm64
cmake/setup.sh g++-aarch64-linux-gnu qemu-user \
  {libc6-dev,libstdc++-12-dev,libtbb-dev,libhwy-dev,libbullet-dev,libfmt-dev,libgtest-dev,libgmock-dev,libgmp-dev,libassimp-dev,libssl-dev}:arm64

cmake -S . -B build/aarch64 -G Ninja --toolchain "$PWD/packaging/aarch64.cmake" -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_UNITY_BUILD=ON -DSOFTCD_CUDA=OFF -DSOFTCD_DEMOS=OFF -DSOFTCD_BENCHMARKS=OFF >&2
cmake --build build/aarch64 --parallel "$(nproc)" --target softcd "${programs[@]}" >&2
ctest --test-dir build/aarch64 -C programs -L program -R "^($(IFS='|' && echo "${programs[*]}"))\$" \
  --output-on-failure --no-tests=error
