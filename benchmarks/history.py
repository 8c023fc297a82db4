#!/usr/bin/env python3
"""Keeps a release's measured times by machine, and makes the page about all releases.

    benchmarks/history.py [--version VERSION] [RESULT...]

A maintainer runs it for a release, with the files that benchmarks/baseline.sh has written for each machine. Writes the
medians of each RESULT to benchmarks/history/VERSION-MACHINE.json, in place of an earlier one of that release and machine.
Then makes docs/measured/history.md from all files there. Without a RESULT, makes the page alone.

VERSION is the result's own if it is not given. `benchmarks/report.py benchmarks/history/*.json --figure history --out
docs/figures` draws them.
"""

import argparse
import json
import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
HISTORY = ROOT / "benchmarks/history"
PAGE = ROOT / "docs/measured/history.md"

HEAD = """# Times of releases

The median time of one detection in ms, by machine and release. `benchmarks/history/` has the figures with their quartiles.
`benchmarks/baseline.sh` measures them, and `benchmarks/history.py` makes this page. Compare releases on one machine only. A pull request is not
judged by times: its [instructions are counted](../../CONTRIBUTING.md#speed).

![Times of each scene by release](../figures/history.svg)
"""


def add(path, version):
    result = json.loads(path.read_text())
    version = version or result["softcd"]
    machine = re.sub(r"[^a-z0-9]+", "-", re.sub(r"\([^)]*\)", "", result["machine"]).lower()).strip("-")
    rows = [
        {
            "version": version,
            "machine": result["machine"],
            "date": result["date"],
            "scene": row["scene"],
            "mode": f"{row['detection']} {row['accuracy']}",
            "backend": row["backend"],
            "ms": round(row["ms"]["total"], 4),
            "ms_first_quartile": round(row["total_ms_quartiles"]["first"], 4),
            "ms_third_quartile": round(row["total_ms_quartiles"]["third"], 4),
            "contacts_checksum": row["contacts_checksum"],
        }
        for row in result["rows"]
        if row["sweep"] == "stages"
    ]
    HISTORY.mkdir(exist_ok=True)
    kept = {"compiler": result["compiler"], "history": rows}
    (HISTORY / f"{version}-{machine}.json").write_text(json.dumps(kept, indent=1) + "\n")


def by_version(version):
    """Orders 0.9.0 before 0.10.0, and a version without a suffix after those with one."""
    numbers = [int(number) for number in re.findall(r"\d+", version.split("-")[0])]
    return numbers, "-" not in version, version


def page():
    rows = [row for path in sorted(HISTORY.glob("*.json")) for row in json.loads(path.read_text())["history"]]
    text = HEAD
    for machine in sorted({row["machine"] for row in rows}):
        its = [row for row in rows if row["machine"] == machine]
        dates = {row["version"]: row["date"] for row in its}
        versions = sorted(dates, key=by_version)
        text += f"\n## {machine}\n\n| scene | detection | "
        text += " | ".join(f"{version}, {dates[version]}" for version in versions) + " |\n|---|---|" + "--:|" * len(versions) + "\n"
        times = {(row["scene"], row["mode"], row["version"]): row["ms"] for row in its}
        for scene, mode in dict.fromkeys((row["scene"], row["mode"]) for row in its):
            cells = [times.get((scene, mode, version)) for version in versions]
            text += f"| {scene} | {mode} | " + " | ".join("" if ms is None else f"{ms:.3g}" for ms in cells) + " |\n"
    PAGE.write_text(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("results", nargs="*", type=Path)
    parser.add_argument("--version")
    arguments = parser.parse_args()
    for path in arguments.results:
        add(path, arguments.version)
    page()


if __name__ == "__main__":
    main()
