#!/usr/bin/env bash
# Runs the tests on a GPU under NVIDIA's compute-sanitizer.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: tests/compute_sanitizer.sh [TOOL...]

Builds softcd with CUDA and runs the test programs for every backend on the GPU, under compute-sanitizer with each TOOL
(default: memcheck, initcheck, racecheck and synccheck). Takes a hundred times as long as the tests alone; GTEST_FILTER
selects tests. Fetches compute-sanitizer (14 MB) into build/compute-sanitizer where it is missing. Fails without a GPU.
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."
tools=("$@")
[ $# -gt 0 ] || tools=(memcheck initcheck racecheck synccheck)

if ! { command -v nvidia-smi && nvidia-smi -L; } >/dev/null 2>&1; then
  echo "compute_sanitizer.sh: there is no GPU here" >&2
  exit 1
fi

fetched=$PWD/build/compute-sanitizer
sanitizer=$(PATH="$PATH:/usr/local/cuda/bin:$fetched/nvidia/cu13/bin" command -v compute-sanitizer || true)
cmake/setup.sh python3 python3-pip
if [ -z "$sanitizer" ]; then
  python3 -m pip install --quiet --disable-pip-version-check --root-user-action=ignore --target "$fetched" \
    nvidia-cuda-sanitizer-api==13.0.85
  sanitizer=$fetched/nvidia/cu13/bin/compute-sanitizer
  chmod +x "$sanitizer"
fi

SOFTCD_CUDA=on cmake/build.sh softcd_tests_once
programs=$(ctest --test-dir build/release -C programs -L program -LE repetition -R '^cuda[.]' --show-only=json-v1 |
  python3 -c 'import json, sys; print(*[test["command"][0] for test in json.load(sys.stdin)["tests"]])')
[ -n "$programs" ] || { echo "no test runs on a GPU in build/release: is the CUDA backend built?" >&2 && exit 1; }
for tool in "${tools[@]}"; do
  for program in $programs; do
    echo "== $tool: $(basename "$program")"
    SOFTCD_TEST_BACKEND=cuda "$sanitizer" --tool "$tool" --error-exitcode 3 --print-limit 5 "$program" --gtest_brief=1
  done
done
