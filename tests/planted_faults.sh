#!/usr/bin/env bash
# Measures how many of the faults that are planted in softcd its tests catch.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: tests/planted_faults.sh [--proofs] [--jobs N] [--only PATTERN] [--programs PATTERN] [--list]

Plants the faults of tests/planted_faults/faults.txt in a copy of the sources (build/planted_faults/source), compiles it
once, and runs the tests of a change once for each fault, which the environment variable SOFTCD_FAULT chooses. Prints
each fault with the test that caught it, the share that was caught, and the faults that survived; exit code 1 where there
are any. Results are kept in build/planted_faults/results.json, and programs that caught a fault last time are tried first.

  --proofs            plants those of tests/proofs/faults.txt, and runs the proofs instead of the tests
  --jobs N            how many faults at once, each on an equal share of the cores; 1 where none is named
  --only PATTERN      only faults whose number, file or description matches this regular expression
  --programs PATTERN  only test programs whose name matches this one
  --list              prints the faults, builds and runs nothing

A fault is caught where a program fails, crashes, or runs for much longer than without it. CPU only, -O1 and vectors
of one kind.

Environment: SOFTCD_SETUP=off; see cmake/build.sh --help. CMAKE_BUILD_PARALLEL_LEVEL says how many compilers run at once.
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."
cmake/setup.sh python3
exec python3 tests/planted_faults/run.py "$@"
