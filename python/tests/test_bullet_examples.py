"""Runs the examples for PyBullet, and tests what they print."""

import pathlib
import re
import subprocess
import sys

import numpy as np

import bullet_worlds  # noqa: F401: skips these tests where there is no plugin

EXAMPLES = pathlib.Path(__file__).resolve().parents[1] / "examples"


def run(name):
    """Returns the lines that an example prints."""
    script = EXAMPLES / name
    assert len(script.read_text().splitlines()) <= 80
    return subprocess.run([sys.executable, script], check=True, capture_output=True, text=True).stdout.splitlines()


def test_a_gripper_feels_what_newtons_law_says():
    lines = [line for line in run("pybullet_gripper.py") if re.match(r"\d", line)]
    rows = np.array([[float(number) for number in re.findall(r"-?\d+\.\d+", line)] for line in lines])
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
