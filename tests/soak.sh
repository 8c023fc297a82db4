#!/usr/bin/env bash
# Lets worlds of soft bodies live long, while everything in them changes.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: tests/soak.sh [--asan] [STEPS [RUN...]]

Builds the soak test and runs it in each kind of world for STEPS steps, 200000 where none are named, once for each RUN, a
number that its random choices follow from (1 where none is named); as many at once as there are processors. With --asan
under the sanitizers of the preset cpu-asan, and 20000 steps where none are named. Prints what has been going on in each,
and fails where a position is not finite, something is through something else, a detector has failed, memory has grown,
or hardly anything has touched, as in fewer than 200 steps; the logs are in build/soak. 24 hours on 16 processors: 1000000
steps and 32 runs.

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
  # What is freed is kept for a while to find who still uses it: little, as memory must not grow.
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
