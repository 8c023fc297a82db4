"""Tests python -m softcd."""

import csv
import json
import subprocess
import sys

import numpy as np
import pytest

import softcd
from meshes import soup, write_ply

ABOVE = "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 1 1 1\nv 1 1.5 8\nv 1.5 1 8\nf 1 2 3\nf 4 5 6\n"
BELOW = ABOVE.replace("v 1 1 1\n", "v 1 1 -1\n")


@pytest.fixture
def frames(tmp_path):
    (tmp_path / "t0.obj").write_text(ABOVE)
    (tmp_path / "t1.obj").write_text(BELOW)
    return tmp_path


def run(folder, *arguments):
    return subprocess.run(
        [sys.executable, "-m", "softcd", *arguments], cwd=folder, capture_output=True, text=True, timeout=60
    )


def test_finds_what_the_module_does(frames):
    result = run(frames, "t0.obj", "t1.obj", "--contacts", "contacts.csv", "--json", "figures.json", "--backend", "cpu")
    assert result.returncode == 0 and result.stderr == ""
    assert "contacts    1 vt, 0 ee, the first at 0.5 of the step" in result.stdout
    with open(frames / "contacts.csv") as file:
        (row,) = csv.DictReader(file)
    vertices_t0, triangles = softcd.read_mesh(frames / "t0.obj")
    vertices_t1, _ = softcd.read_mesh(str(frames / "t1.obj"))
    (contact,) = softcd.detect(vertices_t0, triangles, vertices_t1, accuracy=softcd.Accuracy.precise)
    assert [int(row[name]) for name in ("a0", "b0", "b1", "b2")] == contact["vertices"].tolist()
    assert np.float32(row["toi"]) == contact["time_of_impact"]
    assert json.loads((frames / "figures.json").read_text())["vt_contacts"] == 1


def test_defaults_are_those_of_detect_and_of_scenes(tmp_path):
    vertices_t0, triangles = soup(3, 40, size=0.9)
    vertices_t1 = soup(53, 40, size=0.9)[0]
    write_ply(tmp_path / "t0.ply", vertices_t0, triangles)
    write_ply(tmp_path / "t1.ply", vertices_t1, triangles)
    result = run(tmp_path, "t0.ply", "t1.ply", "--json", "figures.json", "--backend", "cpu")
    assert result.returncode == 0
    figures = json.loads((tmp_path / "figures.json").read_text())
    contacts = softcd.detect(vertices_t0, triangles, vertices_t1)
    counts = [int((contacts["kind"] == kind).sum()) for kind in (0, 1)]
    assert [figures["vt_contacts"], figures["ee_contacts"]] == counts and min(counts) > 0
    scene = softcd.Scene()
    body = scene.add_body(triangles, len(vertices_t0))
    scene.set_positions(body, vertices_t0, vertices_t1)
    query = softcd.Query(scene, detection=softcd.Detection.ccd)
    assert query.options.accuracy == softcd.QueryOptions().accuracy == softcd.Accuracy.automatic
    assert query.detect().tobytes() == contacts.tobytes()


def test_explains_itself(frames):
    result = run(frames, "--help")
    assert result.returncode == 0 and "softcd-detect" in result.stdout and "--memory-limit" in result.stdout


def test_says_what_is_wrong(frames):
    for arguments in (["t0.obj", "--nonsense"], ["missing.ply", "t1.obj"], ["t0.obj"]):
        result = run(frames, *arguments)
        assert result.returncode == 2 and result.stderr != "" and "Traceback" not in result.stderr


def test_meshes_are_read_as_arrays(frames):
    vertices, triangles = softcd.read_mesh(frames / "t0.obj")
    assert vertices.dtype == np.float64 and vertices.shape == (6, 3) and vertices.flags.writeable
    assert triangles.dtype == np.uint32 and triangles.tolist() == [[0, 1, 2], [3, 4, 5]]
    for copy in (frames / "copy.ply", str(frames / "copy.ply")):
        softcd.write_mesh(copy, vertices + 0.5, triangles.tolist())
        again = softcd.read_mesh(copy)
        assert (again[0] == (vertices + 0.5).astype(np.float32)).all() and again[1].tobytes() == triangles.tobytes()
        (frames / "copy.ply").unlink()
    with pytest.raises(softcd.MeshError, match="copy.txt"):
        softcd.write_mesh(frames / "copy.txt", vertices, triangles)
    with pytest.raises(softcd.InvalidInput, match="^triangles: row 1 has the index 5, but there are 5 vertices"):
        softcd.write_mesh(frames / "copy.ply", vertices[:5], triangles)
    with pytest.raises(softcd.InvalidInput, match=r"^vertices: expected shape \(n, 3\), got \(6, 2\)"):
        softcd.write_mesh(frames / "copy.ply", vertices[:, :2], triangles)
    assert not (frames / "copy.ply").exists()
    (frames / "broken.ply").write_text("ply\nformat ascii 1.0\nelement vertex 1\n")
    with pytest.raises(softcd.MeshError, match="broken.ply"):
        softcd.read_mesh(frames / "broken.ply")
