#!/usr/bin/env python3
"""Counts the instructions of detections, which do not depend on how fast or busy a machine is.

    benchmarks/instructions.py BASE [HEAD] [--limit PERCENT] [--json FILE]

BASE and HEAD are builds of softcd-detect. Runs each on recorded steps of tests/recorded_steps, on one thread, under
valgrind's callgrind (apt-get install valgrind). Counts instructions of softcd's own functions, without those of the
program around them: reading files and printing vary by a thousandth from run to run. Prints both counts. Exits with 1 if
HEAD needs more instructions than BASE by over PERCENT (default 2) in some scene. Says where contacts differ, which the
golden contacts of the tests judge.

valgrind shows programs the same processor everywhere, with AVX2. So counts of one build do not depend on the machine.
Counts of two compilers differ.
"""

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

STEPS = Path(__file__).resolve().parents[1] / "tests" / "recorded_steps"
SCENES = {
    "folding-cloth, ccd conservative": ("folding-cloth", "--detection", "ccd", "--margin", "0.01"),
    "reef-knot, ccd precise": ("reef-knot", "--detection", "ccd", "--accuracy", "precise", "--margin", "0.01"),
    "n-body, ccd fast": ("n-body", "--detection", "ccd", "--accuracy", "fast"),
    "tube, dcd fast": ("tube", "--detection", "dcd", "--accuracy", "fast", "--margin", "0.05"),
}
REPEAT = "5"  # detections after a warm-up: the first one builds lists that the others use
OWN = re.compile(r"softcd::|6softcd")
OF_THE_PROGRAM = re.compile(r"softcd::demo::|6softcd4demo")


def count(program, scene):
    """Returns the instructions of softcd's functions, and a line about the contacts."""
    step, *options = SCENES[scene]
    frames = [STEPS / step / "t0.ply", STEPS / step / "t1.ply"]
    with tempfile.NamedTemporaryFile(suffix=".callgrind") as profile:
        command = ["valgrind", "--tool=callgrind", f"--callgrind-out-file={profile.name}", program, *frames, "--backend", "cpu",
                   "--repeat", REPEAT, *options]
        # One processor is one thread, which takes the same steps every time.
        processor = min(os.sched_getaffinity(0))
        run = subprocess.run(command, capture_output=True, text=True, preexec_fn=lambda: os.sched_setaffinity(0, {processor}))
        if run.returncode != 0:
            raise SystemExit(f"{program} failed in '{scene}':\n{run.stdout}{run.stderr}")
        table = subprocess.run(["callgrind_annotate", "--threshold=100", profile.name], check=True, capture_output=True,
                               text=True).stdout
    instructions = 0
    for line in table.splitlines():
        row = re.match(r" *([\d,]+) \( *[\d.]+%\) +(\S.*)", line)
        if row and OWN.search(row[2]) and not OF_THE_PROGRAM.search(row[2]):
            instructions += int(row[1].replace(",", ""))
    contacts = re.search(r"^contacts +(.*)$", run.stdout, re.MULTILINE)
    if instructions == 0 or not contacts:
        raise SystemExit(f"{program} has no functions of softcd by name, or reports no contacts, in '{scene}'")
    return instructions, contacts[1]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("base", type=Path)
    parser.add_argument("head", type=Path, nargs="?")
    parser.add_argument("--limit", type=float, default=2.0, help="per cent; default 2")
    parser.add_argument("--json", type=Path, help="write the counts of HEAD, or of BASE alone, to this file")
    arguments = parser.parse_args()
    counts, failures = {}, []
    for scene in SCENES:
        before, contacts_before = count(arguments.base.resolve(), scene)
        counts[scene] = before
        if not arguments.head:
            print(f"{scene:34} {before:14,}   {contacts_before}", flush=True)
            continue
        after, contacts_after = count(arguments.head.resolve(), scene)
        counts[scene] = after
        change = 100.0 * (after / before - 1.0)
        print(f"{scene:34} {before:14,} {after:14,} {change:+8.3f} %   {contacts_after}", flush=True)
        if change > arguments.limit:
            failures.append(f"{scene}: {change:.2f} % more instructions, over {arguments.limit} %")
        if contacts_after != contacts_before:
            print(f"{scene}: contacts were '{contacts_before}'")
    if arguments.json:
        arguments.json.write_text(json.dumps(counts, indent=2) + "\n")
    for failure in failures:
        print(f"instructions.py: {failure}", file=sys.stderr)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
