"""Runs the examples for PyBullet, and tests what they print."""

import pathlib
import re
import subprocess
import sys

import numpy as np
import pytest

import bullet_worlds  # noqa: F401: skips these tests where there is no plugin

EXAMPLES = pathlib.Path(__file__).resolve().parents[1] / "examples"


def run(name, *arguments):
    """Returns the lines that an example prints."""
    script = EXAMPLES / name
    assert len(script.read_text().splitlines()) <= 80
    command = [sys.executable, script, *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines()


def numbers_in(lines):
    """Returns the numbers of each line that begins with one."""
    rows = [re.findall(r"-?\d+\.\d+", line) for line in lines if re.match(r"\d", line)]
    return np.array(rows, float)


def test_a_gripper_feels_what_newtons_law_says():
    rows = numbers_in(run("pybullet_gripper.py"))
    time, on_cloth, of_cloth, by_fingers, on_finger, of_finger = rows.T
    assert time[-1] == 3 and len(rows) == 12
    np.testing.assert_allclose(on_cloth, of_cloth, atol=0.002)
    np.testing.assert_allclose(on_finger, of_finger, atol=0.01)
    np.testing.assert_allclose(on_cloth.mean(), 2, atol=0.05)
    assert on_finger[-1] < -4 and by_fingers[-1] > 1.9, "the fingers hold all of the cloth"
    assert abs(by_fingers[0]) < 0.5, "the table holds it"


def test_only_faces_and_edges_hold_balls_in_a_bag():
    alone, balanced, safe = (line for line in run("pybullet_bag.py") if "balls" in line)
    assert "0 of 8 balls" in alone and "0 of 8 balls" in balanced and "8 of 8 balls" in safe
    force, weight = (float(number) for number in re.findall(r"(\d+\.\d+) N", safe))
    assert weight == 8 and abs(force - weight) < 0.01 * weight


def test_a_folded_cloth_does_not_cross_itself(tmp_path):
    pytest.importorskip("PIL")
    video = tmp_path / "fold.gif"
    alone, safe, *_ = run("pybullet_fold.py", "--video", str(video))
    assert video.stat().st_size > 10000
    counts = [[int(number) for number in re.findall(r"(\d+) (?:pairs|at the end)", line)] for line in (alone, safe)]
    assert counts[1] == [0, 0] and counts[0][0] > 0, "PyBullet alone lets the cloth through itself"
    held, later = zip(*(map(int, re.findall(r"(\d+) mm", line)) for line in (alone, safe)))
    assert held[1] < 60
    assert later[1] < later[0], "springs that are bent open the fold again"
    force, weight = (float(number) for number in re.findall(r"(\d+\.\d+) N", safe))
    assert abs(force - weight) < 0.01 * weight


def test_a_gripper_carries_a_rope_and_knows_its_weight():
    time, on_rope, of_rope, by_fingers, lowest = numbers_in(run("pybullet_rope.py")).T
    np.testing.assert_allclose(on_rope, of_rope, atol=0.01 * 1)
    assert lowest[-1] > 0.05 and abs(by_fingers[-1] - on_rope[-1]) < 0.01, "the rope hangs from the fingers"


def test_a_rope_around_a_post_holds_itself():
    alone, safe = (line for line in run("pybullet_post.py") if "turns" in line)
    assert float(re.search(r"(\d+\.\d+) turns", alone)[1]) < 0.5, "with PyBullet alone it falls through the post"
    assert safe.startswith("safe: 0 pairs") and float(re.search(r"(\d+\.\d+) turns", safe)[1]) > 1.2
    assert abs(int(re.search(r"sinks by (-?\d+) mm", safe)[1])) < 50
    force, weight = (float(number) for number in re.findall(r"(\d+\.\d+) N", safe))
    assert abs(force - weight) < 0.01 * weight


def test_the_notebook_runs():
    nbclient, nbformat = pytest.importorskip("nbclient"), pytest.importorskip("nbformat")
    for package in ("ipykernel", "matplotlib"):
        pytest.importorskip(package)
    notebook = nbformat.read(EXAMPLES / "pybullet.ipynb", as_version=4)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert len(code) >= 8 and not any(cell.outputs for cell in code), "outputs are stripped"
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(EXAMPLES)}}).execute()
    text = "".join(output.get("text", "") for cell in code for output in cell.outputs)
    carried, weight = re.search(r"carry (\S+) N; the cloth weighs (\S+) N", text).groups()
    assert abs(float(carried) - float(weight)) < 0.01 * float(weight), "forces are those that Newton's law gives"
    assert "0 failed steps" in text


def test_softcd_stops_the_crossings_that_an_audit_of_pybullet_finds():
    for line in run("audit_pybullet.py"):
        crossings = [int(number) for number in re.findall(r"(\d+) (?:vertices|edges)", line)]
        assert sum(crossings) == 0 if "safe" in line else min(crossings) > 0, line
