#!/usr/bin/env bash
# Measures how many of the faults that are planted in softcd its tests catch.
set -euo pipefail

usage() {
  cat <<'TEXT'
usage: tests/planted_faults.sh [--proofs] [--jobs N] [--only PATTERN] [--programs PATTERN] [--list]

Plants the faults of tests/planted_faults/faults.txt in a copy of the sources (build/planted_faults/source), compiles it
once, and runs the tests of a change once for each fault, which the environment variable SOFTCD_FAULT chooses. Prints
each fault with the test that caught it, the share of caught faults, and the faults that survived. The exit code is 1 if
any survived. build/planted_faults/results.json keeps the results: the next run first tries the programs that caught a fault.

  --proofs            plants the faults of tests/proofs/faults.txt, and runs the proofs instead of the tests
  --jobs N            how many faults at once, each on an equal share of the cores; default: 1
  --only PATTERN      only faults whose number, file or description matches this regular expression
  --programs PATTERN  only test programs whose name matches this one
  --list              prints the faults, builds and runs nothing

A fault is caught if a program fails, crashes, or runs for much longer than without it. The programs are compiled for
the CPU alone, with -O1 and one kind of vectors.

Environment: SOFTCD_SETUP=off; see cmake/build.sh --help. CMAKE_BUILD_PARALLEL_LEVEL says how many compilers run at once.
TEXT
}

case "${1:-}" in
  -h | --help) usage && exit 0 ;;
esac
cd "$(dirname "${BASH_SOURCE[0]}")/.."
cmake/setup.sh python3
exec python3 tests/planted_faults/run.py "$@"
