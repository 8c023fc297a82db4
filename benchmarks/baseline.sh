#!/usr/bin/env bash
# Measures the results of a machine for benchmarks/baseline/.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: benchmarks/baseline.sh BENCH BACKEND FILE [STEPS [MACHINE]]

Measures the generated scenes, and the recorded steps where they are given, in every mode, and writes the result of
`softcd-bench detector --json` to FILE, for `softcd-bench compare`. Under a minute on a GPU, about two minutes on two cores.

  BENCH    the program softcd-bench, e.g. build/release/benchmarks/softcd-bench
  BACKEND  cpu or cuda
  FILE     e.g. benchmarks/baseline/intel-xeon-2-cores.json
  STEPS    a folder of the recorded steps of Scalable CCD's sample data: armadillo-rollers, cloth-ball, cloth-funnel,
           n-body-simulation and rod-twist, each with its two meshes in frames/. Missing ones are skipped
  MACHINE  the machine's name in the result; default: its processor. A GPU has to be named

  SOFTCD_REPEAT=N  measured detections; default 30
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac
if [ $# -lt 3 ] || [ $# -gt 5 ]; then
  usage >&2
  exit 2
fi

bench=$1 backend=$2 output=$3 steps=${4:-} machine=${5:-}
arguments=(--backend "$backend" --repeat "${SOFTCD_REPEAT:-30}" --mode dcd-fast ccd-precise ccd-conservative --json "$output")
if [ -n "$machine" ]; then arguments+=(--machine "$machine"); fi
for step in armadillo-rollers cloth-ball cloth-funnel n-body-simulation rod-twist; do
  if [ -n "$steps" ] && [ -d "$steps/$step" ]; then arguments+=(--step "$steps/$step"); fi
done
exec "$bench" detector "${arguments[@]}"
