"""Tests softcd.plot: the points that it shows, and its pictures where pyvista or polyscope is installed."""

import importlib.util
import os
import pathlib
import subprocess
import sys

import numpy as np
import pytest

import softcd
from meshes import PIERCING_T0, PIERCING_T1, PIERCING_TRIANGLES, soup
from softcd._plot import contact_points


def test_points_of_both_sides_meet_at_the_time_of_impact():
    x_t0, triangles = soup(1, 40)
    x_t1 = soup(2, 40)[0]
    contacts = softcd.detect(x_t0, triangles, x_t1)
    assert {0, 1} <= set(contacts["kind"])
    points_a, points_b = contact_points(contacts, [x_t0], [x_t1])
    np.testing.assert_allclose(points_a, points_b, atol=1e-5)


def test_points_of_several_meshes_are_as_far_apart_as_the_contacts_say():
    meshes = [soup(seed, 20) for seed in (1, 2)]
    positions, triangles = [list(each) for each in zip(*meshes)]
    contacts = softcd.detect(positions, triangles, margin=0.05)
    assert (contacts["body_a"] != contacts["body_b"]).any()
    points_a, points_b = contact_points(contacts, positions, None)
    np.testing.assert_allclose(np.linalg.norm(points_a - points_b, axis=1), contacts["distance"], atol=1e-5)


@pytest.mark.parametrize(
    "arguments, error, text",
    [
        ((PIERCING_T0[:3], PIERCING_TRIANGLES), softcd.InvalidInput, "triangles: mesh 0 has 3 vertices"),
        ((PIERCING_T0[:, :2], PIERCING_TRIANGLES), softcd.InvalidInput, r"vertices: expected shape \(n, 3\), got \(6, 2\)"),
        (("text", PIERCING_TRIANGLES), TypeError, "vertices: expected float64"),
        ((PIERCING_T0, PIERCING_TRIANGLES + 0.5), TypeError, "triangles: expected int64"),
        (([PIERCING_T0], [PIERCING_TRIANGLES] * 2), softcd.InvalidInput, "vertices: expected 2 arrays"),
        ((PIERCING_T0, PIERCING_TRIANGLES, np.zeros(3)), TypeError, "contacts: expected an array of softcd.contact_dtype"),
    ],
)
def test_wrong_arguments_are_named(arguments, error, text):
    with pytest.raises(error, match=f"^{text}"):
        softcd.plot(*arguments, show=False)


def test_contacts_of_other_meshes_are_refused():
    contacts = softcd.detect(PIERCING_T0, PIERCING_TRIANGLES, PIERCING_T1)
    assert len(contacts) > 0
    with pytest.raises(softcd.InvalidInput, match="^contacts: they name bodies or vertices"):
        softcd.plot(PIERCING_T0[:3], PIERCING_TRIANGLES[:1], contacts, show=False)
    with pytest.raises(softcd.InvalidInput, match="^vertices_t1: expected as many"):
        softcd.plot(PIERCING_T0, PIERCING_TRIANGLES, contacts, vertices_t1=PIERCING_T0[:3], show=False)


def test_without_a_package_that_draws_the_error_says_what_to_install(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    with pytest.raises(ImportError, match="pip install pyvista"):
        softcd.plot(PIERCING_T0, PIERCING_TRIANGLES, show=False)


PICTURE = """
import sys
import numpy as np
import test_plot as t
(x_t0, triangles), (x_t1, _) = t.soup(1, 12, 0.8), t.soup(2, 12, 0.8)
contacts = t.softcd.detect(x_t0, triangles, x_t1)
if sys.argv[1] == "polyscope":
    sys.modules["pyvista"] = None
    t.importlib.util.find_spec = lambda name: name == "polyscope" or None
plot = t.softcd.plot(x_t0, triangles, contacts, vertices_t1=x_t1, show=False)
if sys.argv[1] == "polyscope":
    plot.screenshot(sys.argv[2], transparent_bg=False)
else:
    plot.screenshot(sys.argv[2])
"""


@pytest.mark.parametrize("package", ["pyvista", "polyscope"])
def test_a_picture_has_points_of_contacts(package, tmp_path):
    pytest.importorskip(package)
    image = pytest.importorskip("PIL.Image")
    # In a process of its own: these packages crash where there is no OpenGL.
    command = [sys.executable, "-c", PICTURE, package, str(tmp_path / "plot.png")]
    environment = os.environ | {"PYTHONPATH": str(pathlib.Path(__file__).parent)}
    run = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    if run.returncode != 0 and ("OpenGL" in run.stderr or "EGL" in run.stderr):
        pytest.skip(f"{package} cannot draw here: {run.stderr[-200:]}")
    assert run.returncode == 0, run.stderr
    red, _, blue = np.moveaxis(np.asarray(image.open(tmp_path / "plot.png").convert("RGB")).astype(int), 2, 0)
    assert ((red > 2 * blue) & (red > 80)).sum() > 20, "contacts of a vertex and a triangle are red"
