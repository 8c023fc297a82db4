#!/usr/bin/env bash
# Builds softcd's scenes as a page that a browser opens, with WebAssembly.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: packaging/web.sh [--try]

Compiles softcd, Bullet and the page of demos/web with Debian's Emscripten (one thread, SIMD128, Release) into
build/web/page/index.html. The page is one file, which needs no server.

Libraries are compiled once, from the distribution's sources, into build/web/prefix. Needs 2 GB. As root, on Debian 12.

  --try   also compiles the tests of kernels and of golden contacts, whose hashes must be the native build's, and runs them
          with node. Runs the page in headless Chromium for 60 steps of each scene, and writes build/web/page.png and the
          table of step times, build/web/times.txt.
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."
cmake/setup.sh emscripten dpkg-dev m4

# For a node that is not Debian's own.
export NODE_PATH=/usr/share/nodejs
# shellcheck source=packaging/cross.sh
. packaging/cross.sh web
libraries emconfigure ../sources/configure --host=none --disable-assembly
programs=()
if [ "${1:-}" = --try ]; then
  cmake/setup.sh chromium
  programs=(softcd_kernel_tests softcd_golden_tests)
fi
build_softcd -DSOFTCD_THREADS=OFF -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON -DSOFTCD_DEMOS=OFF -DSOFTCD_INSTALL=OFF -- \
  softcd_web "${programs[@]}"
mkdir -p "$work/page"
cp "$work/softcd/demos/web/index.html" "$work/page/"
printf '%s: %d bytes, %d compressed\n' "$work/page/index.html" "$(wc -c <"$work/page/index.html")" \
  "$(gzip -9c "$work/page/index.html" | wc -c)"
[ ${#programs[@]} -gt 0 ] || exit 0

try_programs "${programs[@]}"
node demos/web/try.js "$work/page/index.html" "$work/page.png" | tee "$work/times.txt"
