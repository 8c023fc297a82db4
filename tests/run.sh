#!/usr/bin/env bash
# Installs, builds and runs every test.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: tests/run.sh [ARGUMENT...]

Installs missing tools, builds softcd (Release, build/release) and runs every test with ctest. ARGUMENTs go to ctest,
e.g. -R program (tests whose names match), -LE slow (without the long ones), -N (only list them).

Environment: SOFTCD_CUDA=auto|on|off, SOFTCD_SETUP=off; see cmake/build.sh --help.
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
"$root/cmake/build.sh"
exec ctest --test-dir "$root/build/release" --output-on-failure --no-tests=error -j "$(nproc)" "$@"
