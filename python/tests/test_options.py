"""Tests that Python has all options of C++."""

import pathlib
import re

import pytest

import softcd
from meshes import PIERCING_TRIANGLES

ROOT = pathlib.Path(__file__).resolve().parents[2]
FEATURES = {"vertex_triangle", "edge_edge"}


def members(header, struct):
    """Returns the names of a C++ struct's members: the words before a default value or a semicolon."""
    body = re.search(rf"^struct {struct} {{\n(.*?)^}};", (ROOT / header).read_text(), re.MULTILINE | re.DOTALL)[1]
    return set(re.findall(r"^  [^/\n]*?(\w+)(?: = [^;]*|{})?;", body, re.MULTILINE))


@pytest.mark.parametrize(
    "header, struct, only_cpp, only_python",
    [
        ("plugin/include/softcd/query.hpp", "QueryOptions", {"features"}, {"replace", *FEATURES}),
        ("plugin/include/softcd/query.hpp", "StageReport", set(), set()),
        ("plugin/include/softcd/scene.hpp", "SceneOptions", {"cuda_stream", "communicator"}, {"replace"}),
        ("kernels/include/softcd/core/statistics.hpp", "StageTimes", set(), set()),
        ("kernels/include/softcd/core/statistics.hpp", "Statistics", set(), set()),
    ],
)
def test_classes_have_the_members_of_cpp(header, struct, only_cpp, only_python):
    in_cpp = members(header, struct)
    in_python = {name for name in dir(getattr(softcd, struct)) if not name.startswith("_")}
    assert in_cpp - in_python == only_cpp and in_python - in_cpp == only_python


def test_bodies_have_the_settings_of_cpp():
    scene = softcd.Scene(backend="cpu")
    body = scene.add_body(PIERCING_TRIANGLES, 6)
    names = members("plugin/include/softcd/scene.hpp", "BodySettings") - {"features"} | FEATURES
    assert len(names) >= 10
    for name in names:
        with pytest.raises(TypeError, match=f"^{name}: expected "):
            scene.set_settings(body, **{name: object()})
