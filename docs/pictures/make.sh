#!/usr/bin/env bash
# Makes the pictures of README and docs/use/scenes.md, and videos of the scenes.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: docs/pictures/make.sh pictures [SCENE...]      docs/pictures/SCENE.png, as the scene ends; untangling with Bullet's own
                                                      detection on the left, softcd on the right
       docs/pictures/make.sh videos [SCENE...]        build/videos/SCENE.mp4, 1280 x 720, 30 frames a second
       docs/pictures/make.sh comparisons [SCENE...]   build/videos/SCENE-comparison.mp4: Bullet's own detection on the
                                                      left, softcd on the right, the same scene
       docs/pictures/make.sh window                   docs/pictures/viewer.png, the window of --view, on a display of Xvfb's
       docs/pictures/make.sh animation                docs/pictures/comparison.webp, README's: the comparison of reef-knot

Without SCENE: all of them. Builds softcd-demo, and installs ffmpeg where it is missing. Minutes for a scene on two cores.

  SOFTCD_DEMO_ARGS   more arguments for softcd-demo, such as "--size paper"
TEXT
}

cd "$(dirname "${BASH_SOURCE[0]}")/../.."
demo=build/release/demos/demo/softcd-demo
videos=build/videos

# Steps of 1/120 s until the scene shows most.
steps_of() {
  case $1 in
    flamenco) echo 360 ;;
    two-cloths | stack | mixed-sizes-cloth) echo 400 ;;
    untangling) echo 240 ;;
    funnel | n-body | folding-cloth | mixed-sizes-balls) echo 480 ;;
    *) echo 600 ;;
  esac
}

simulate() {
  local scene=$1
  shift
  # shellcheck disable=SC2086  # several arguments in one variable
  "$demo" "$scene" --steps "$(steps_of "$scene")" ${SOFTCD_DEMO_ARGS:-} "$@"
}

# Bullet's own detection never ends in the scene tearing.
list_scenes() { "$demo" --list | grep -v '^ ' | if [ "$kind" = comparison ]; then grep -vx tearing; else cat; fi; }

run_ffmpeg() { ffmpeg -y -loglevel error "$@"; }

# With a palette of 128 colours the file is a sixth, and smooth shading still has no visible dots.
shrink() {
  run_ffmpeg -i "$videos/$1.png" -update 1 -frames:v 1 \
    -vf "scale=960:-1:flags=lanczos,split[a][b];[a]palettegen=max_colors=128[p];[b][p]paletteuse=dither=none" \
    "docs/pictures/$1.png"
}

make_picture() {
  if [ "$1" = untangling ]; then
    make_pair_of_pictures "$1"
  else
    simulate "$1" --picture "$videos/$1.png"
  fi
  shrink "$1"
}

make_window() {
  cmake/setup.sh xvfb xauth
  xvfb-run -a -s "-screen 0 1280x800x24" "$demo" cloth-on-ball --size 40 --backend cpu --view --overlays contacts,cells \
    --view-frames 90 --screenshot "$videos/viewer.png"
  shrink viewer
}

make_video() { simulate "$1" --picture "$videos/$1.png" --record "$videos/$1.mp4"; }

# Puts two pictures or videos, with the endings -bullet and -softcd, side by side. The words are legible on a phone.
put_side_by_side() {
  local ending=$2
  local text="fontsize=34:fontcolor=black:box=1:boxcolor=white@0.75:boxborderw=10:x=16:y=16"
  run_ffmpeg -i "$videos/$1-bullet.$ending" -i "$videos/$1-softcd.$ending" -filter_complex \
    "[0]drawtext=text=Bullet:${text}[a];[1]drawtext=text=Bullet with softcd:${text}[b];[a][b]hstack" "$3"
}

make_pair_of_pictures() {
  local collision
  for collision in bullet softcd; do
    simulate "$1" --collision "$collision" --picture-size 640x480 --picture "$videos/$1-$collision.png"
  done
  put_side_by_side "$1" png "$videos/$1.png"
}

make_comparison() {
  local collision
  for collision in bullet softcd; do
    simulate "$1" --collision "$collision" --picture-size 640x480 --picture "$videos/$1-$collision.png" \
      --record "$videos/$1-$collision.mp4"
  done
  put_side_by_side "$1" mp4 "$videos/$1-comparison.mp4"
}

make_animation() {
  make_comparison reef-knot
  run_ffmpeg -i "$videos/reef-knot-comparison.mp4" -vf "fps=15,scale=960:-1:flags=lanczos" -loop 0 -quality 60 \
    docs/pictures/comparison.webp
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
  pictures | videos | comparisons | window | animation) kind=${1%s} && shift ;;
  *) usage >&2 && exit 2 ;;
esac

cmake/setup.sh ffmpeg fonts-dejavu-core
cmake/build.sh softcd_demo
mkdir -p "$videos"
case $kind in
  window | animation)
    "make_$kind"
    exit
    ;;
esac
scenes=("$@")
if [ $# = 0 ]; then mapfile -t scenes < <(list_scenes); fi
for scene in "${scenes[@]}"; do "make_$kind" "$scene"; done
