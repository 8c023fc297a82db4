"""Runs all examples of the pages."""

import importlib.util
import pathlib
import re

import numpy as np
import pytest

from meshes import sheet, write_ply

ROOT = pathlib.Path(__file__).resolve().parents[2]


def examples():
    for name in ("docs/use/python.md", "docs/use/troubleshooting.md", "README.md", "python/README.md"):
        document = ROOT / name
        text = document.read_text()
        for block in re.finditer(r"^```python( torch| jax)?\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
            line = text.count("\n", 0, block.start()) + 1
            needed = block[1].strip() if block[1] else "numpy"
            is_missing = importlib.util.find_spec(needed) is None
            marks = pytest.mark.skipif(is_missing, reason=f"there is no {needed}")
            yield pytest.param(block[2], id=f"{name}:{line}", marks=marks)


def folding_sheet():
    """Returns two positions of a sheet: its border folds over and then moves down through it."""
    vertices, triangles = sheet(8)
    vertices_t0 = vertices.copy()
    vertices_t0[vertices[:, 0] == 7] += [-5.5, 0.3, 2]
    vertices_t0[vertices[:, 0] == 6] += [-2, 0, 2]
    vertices_t1 = vertices_t0.copy()
    vertices_t1[vertices[:, 0] == 7] += [0, 0, -4]
    return vertices_t0, vertices_t1, triangles


@pytest.mark.parametrize("code", list(examples()))
def test_examples_run(code, tmp_path, monkeypatch, capsys):
    vertices_t0, vertices_t1, triangles = folding_sheet()
    write_ply(tmp_path / "t0.ply", vertices_t0, triangles)
    write_ply(tmp_path / "t1.ply", vertices_t1, triangles)
    monkeypatch.chdir(tmp_path)
    names = {}
    exec(compile(code, "example", "exec"), names)
    if "print" in code:
        assert capsys.readouterr().out
    if "points" in names:
        assert len(names["points"]) > 0 and np.isfinite(names["points"]).all()


def test_there_are_examples():
    assert len(list(examples())) >= 6
