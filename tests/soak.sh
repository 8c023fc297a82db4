#!/usr/bin/env bash
# Runs worlds of soft bodies for a long time, while everything in them changes.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: tests/soak.sh [--asan] [STEPS [RUN...]]

Builds the soak test and runs it in each kind of world for STEPS steps (default: 200000), once for each RUN. A RUN is
the number that determines its random choices (default: 1). As many runs as there are processors run at a time. With
--asan it runs under the sanitizers of the preset cpu-asan, by default for 20000 steps.

Prints the events of each run. Fails if a position is not finite, bodies intersect, a detector has failed, memory has
grown, or hardly anything has touched, as in runs of fewer than 200 steps. The logs are in build/soak. 24 hours on 16
processors: 1000000 steps and 32 runs.

Environment: SOFTCD_TEST_BACKEND=cuda for the GPU, SOFTCD_CUDA=auto|on|off, SOFTCD_SETUP=off; see cmake/build.sh --help.
TEXT
}

asan=
case "${1:-}" in
  -h | --help) usage && exit 0 ;;
  --asan) asan=yes && shift ;;
esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."
if [ -n "$asan" ]; then
  cmake/setup.sh
  cmake --preset cpu-asan -DSOFTCD_DEMOS=OFF >/dev/null
  cmake --build --preset cpu-asan --parallel "$(nproc)" --target bullet_soak_test >&2
  program=build/cpu-asan/tests/bullet_integration/bullet_soak_test
  # Freed memory is kept for a while to find later uses: only little, because memory must not grow.
  export ASAN_OPTIONS=${ASAN_OPTIONS:-quarantine_size_mb=16}
  steps=${1:-20000}
else
  cmake/build.sh bullet_soak_test
  program=build/release/tests/bullet_integration/bullet_soak_test
  steps=${1:-200000}
fi
runs=("${@:2}")
[ ${#runs[@]} -gt 0 ] || runs=(1)

mkdir -p build/soak
export SOFTCD_SOAK_STEPS=$steps
soak() {
  SOFTCD_SOAK_RUN=$3 "$1" --gtest_filter="*/$2" >"build/soak/$2-$3.log" 2>&1 || { cat "build/soak/$2-$3.log" && return 1; }
  echo "$2, run $3: $(grep watched "build/soak/$2-$3.log")"
}
export -f soak
worlds=(one_line multi_body dispatcher deformable attached attached_deformable)
for run in "${runs[@]}"; do
  for world in "${worlds[@]}"; do printf '%s %s %s\0' "$program" "$world" "$run"; done
done | xargs -0 -P "$(nproc)" -I{} bash -c 'soak {}'
