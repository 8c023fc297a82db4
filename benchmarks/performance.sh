#!/usr/bin/env bash
# Measures the tables of docs/measured/performance-tables.md.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: benchmarks/performance.sh BENCH BACKENDS FILE

Runs the benchmarks `detector` and `bullet` and appends one section of tables, headed by this machine, to FILE. 20 to 30 minutes on two cores.

  BENCH     the program softcd-bench, e.g. build/release/benchmarks/softcd-bench
  BACKENDS  cpu, cuda, or both: cpu,cuda
  FILE      docs/measured/performance-tables.md, or a file that does not exist yet

  SOFTCD_REPEAT=N  measured detections; default 50
  SOFTCD_MOST=N    triangles of the largest scene; default 1000000
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac
if [ $# -ne 3 ]; then
  usage >&2
  exit 2
fi

bench=$1 backends=$2 output=$3
if [ ! -x "$bench" ]; then
  echo "performance.sh: $bench is not a program; build softcd_bench first" >&2
  exit 2
fi
results=$(mktemp -d)
trap 'rm -rf "$results"' EXIT

machine() {
  printf '%s, %s cores' "$(sed -n 's/^model name[[:space:]]*: //p' /proc/cpuinfo | head -n 1)" "$(nproc)"
  if [[ $backends == *cuda* ]] && command -v nvidia-smi >/dev/null; then
    printf '; %s' "$(nvidia-smi --query-gpu=name --format=csv,noheader | head -n 1)"
  fi
}

# One table or several; progress goes to the terminal.
number=10
measure() {
  number=$((number + 1))
  echo "softcd-bench $*" >&2
  "$bench" "$@" --markdown "$results/$number.md" >/dev/null
}

repeat=(--repeat "${SOFTCD_REPEAT:-50}")
measure detector --backend "$backends" "${repeat[@]}" --sweep stages,subdivision
measure detector --backend "$backends" "${repeat[@]}" --sweep cell_size_factor --scene cloth-on-ball,n-body
measure detector --backend "$backends" "${repeat[@]}" --sweep scaling --most "${SOFTCD_MOST:-1000000}"
if "$bench" bullet --help >/dev/null 2>&1; then
  for world in soft deformable; do
    for scene in two-cloths balls "draped --size 101" "draped --size 213" "crumpling --size 101"; do
      # shellcheck disable=SC2086  # a scene may have a size
      measure bullet --backend "$backends" --world "$world" --scene $scene
    done
  done
fi

{
  printf '\n## %s\n\n%s, %s; medians of %s detections, of 60 steps of Bullet.\n\n' \
    "$(machine)" "$(LC_ALL=C date '+%-d %B %Y')" "$("$bench" --version)" "${SOFTCD_REPEAT:-50}"
  cat "$results"/*.md
} >>"$output"
