#!/usr/bin/env bash
# Fuzzes scenes and their queries, the C interface and the readers of meshes.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: tests/fuzz/run.sh [SECONDS [TARGET...]]

Builds libFuzzer's programs with clang++ (build/fuzz) and runs each for SECONDS (default: 60; 3600 for an hour).
TARGETs: scenes, c_interface, meshes (default: all). Interesting inputs are kept in build/fuzz/corpus, where the next
run begins. An input that breaks a guarantee ends the run and is written to build/fuzz/found:
`build/fuzz/tests/fuzz/softcd_fuzz_TARGET FILE` repeats it.

Environment: SOFTCD_SETUP=off installs nothing.
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac

cd "$(dirname "${BASH_SOURCE[0]}")/../.."
seconds=${1:-60}
targets=("${@:2}")
[ ${#targets[@]} -gt 0 ] || targets=(scenes c_interface meshes)
cmake/setup.sh clang
version=$(clang++ -dumpversion)
cmake/setup.sh "libclang-rt-${version%%.*}-dev"
cmake --preset fuzz >/dev/null
cmake --build --preset fuzz --parallel "$(nproc)" >&2

mkdir -p build/fuzz/found
failed=()
for target in "${targets[@]}"; do
  mkdir -p "build/fuzz/corpus/$target"
  log=build/fuzz/found/$target.log
  echo "== $target, $seconds s: $log"
  options=(-max_total_time="$seconds" -max_len=4096 -len_control=0 -timeout=60 -rss_limit_mb=4096)
  options+=(-print_final_stats=1)
  if [ -f "tests/fuzz/$target.dict" ]; then options+=(-dict="tests/fuzz/$target.dict"); fi
  "build/fuzz/tests/fuzz/softcd_fuzz_$target" "${options[@]}" -artifact_prefix="build/fuzz/found/$target-" \
    "build/fuzz/corpus/$target" >"$log" 2>&1 || failed+=("$target")
  grep -E '^broken:|^SUMMARY|Test unit written|number_of_executed_units' "$log" || true
done
[ ${#failed[@]} -eq 0 ] || { echo "found something: ${failed[*]}" >&2 && exit 1; }
