#!/usr/bin/env bash
# The first look at softcd: installs, builds and runs the main demo.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: demos/run.sh [ARGUMENT...]

Installs missing tools, builds softcd (Release, build/release) and runs `softcd-demo cloth-on-ball`: a cloth drapes
over a ball that turns. Prints a table, one row per second of simulation, and writes pictures into build/demo.

ARGUMENTs go to softcd-demo, e.g. --size 150 --world deformable --collision bullet. A first ARGUMENT that is no option
is the scene to run instead; `demos/run.sh --list` names them.

Environment: SOFTCD_CUDA=auto|on|off, SOFTCD_SETUP=off; see cmake/build.sh --help.
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
"$root/cmake/build.sh" demos/all

case "${1:--}" in
  -*) scene=cloth-on-ball ;;
  *) scene=$1 && shift ;;
esac

# The scene's pictures, unless the arguments say where to.
outputs=()
case " $* " in
  *" --list "*) ;;
  *)
    mkdir -p "$root/build/demo"
    case " $* " in *" --picture"[\ =]*) ;; *) outputs+=(--picture "$root/build/demo/$scene.png") ;; esac
    case " $* " in *" --record"[\ =]*) ;; *) outputs+=(--record "$root/build/demo/$scene") ;; esac
    ;;
esac
exec "$root/build/release/demos/demo/softcd-demo" "$scene" "${outputs[@]}" "$@"
