"""One-call functions for those who keep no scene."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from . import _core
from ._core import Accuracy, ContactRule, Detection, Query, QueryOptions, Scene, SceneOptions
from ._errors import InvalidInput
from ._probe import Probe

Array = Any
"""numpy's, anything with the buffer protocol or `__dlpack__` in the CPU's memory, or lists of numbers."""


def _scene(function: Callable[..., Any], options: dict[str, Any]) -> Scene:
    """A Scene of the keywords that a function passes on, with an error that knows its own ones, too."""
    known = [name for name in dir(SceneOptions) if not name.startswith("_") and name != "replace"] + ["log"]
    for name in options:
        if name not in known:
            own = [own for own, parameter in inspect.signature(function).parameters.items()]
            _core.refuse_keyword(function.__name__, name, own[:-1] + known)
    return Scene(**options)


def _is_several(meshes: Array | Sequence[Array]) -> bool:
    return isinstance(meshes, (list, tuple)) and all(hasattr(mesh, "shape") for mesh in meshes)


def _row_count(name: str, array: Array) -> int:
    if not hasattr(array, "shape"):
        if not isinstance(array, (list, tuple)):
            raise TypeError(f"{name}: expected an array of shape (n, 3), got {type(array).__name__}")
        return len(array)
    if len(array.shape) != 2:
        raise InvalidInput(f"{name}: expected shape (n, 3), got {tuple(array.shape)}")
    return int(array.shape[0])


def _scene_of(
    vertices_t0: Array | Sequence[Array],
    triangles: Array | Sequence[Array],
    vertices_t1: Array | Sequence[Array] | None,
    scene: Scene,
    **settings: Any,
) -> Scene:
    if not _is_several(triangles):
        vertices_t0, triangles = [vertices_t0], [triangles]
        vertices_t1 = None if vertices_t1 is None else [vertices_t1]
    if vertices_t1 is None:
        vertices_t1 = [None] * len(triangles)
    for name, meshes in ("vertices_t0", vertices_t0), ("vertices_t1", vertices_t1):
        if not isinstance(meshes, (list, tuple)) or len(meshes) != len(triangles):
            raise InvalidInput(f"{name}: expected {len(triangles)} arrays, one for each of triangles")
    for t0, faces, t1 in zip(vertices_t0, triangles, vertices_t1):
        body = scene.add_body(faces, _row_count("vertices_t0", t0), **settings)
        scene.set_positions(body, t0, t1)
    return scene


def detect(
    vertices_t0: Array | Sequence[Array],
    triangles: Array | Sequence[Array],
    vertices_t1: Array | Sequence[Array] | None = None,
    *,
    margin: float = 0.0,
    self_collision: bool = True,
    vertex_triangle: bool = True,
    edge_edge: bool = True,
    detection: Detection | str | None = None,
    accuracy: Accuracy | str = Accuracy.automatic,
    contact_rule: ContactRule | str = ContactRule.distance,
    **scene_options: Any,
) -> np.ndarray:
    """The contacts of a mesh with itself, or of several meshes, as an array of `softcd.contact_dtype`.

    Positions have the shape (n, 3) and are float32 or float64, triangles the shape (m, 3) and are integers. With
    sequences of arrays each is a mesh, and `body_a` and `body_b` of a contact count them from 0. Two features are in
    contact when their distance is at most twice `margin`: the sum of both sides'.

    With `vertices_t1` detection is continuous: what touches on straight lines from t0 to t1. Else it is discrete.
    Further keywords are those of `Scene`.
    """
    if detection is None:
        detection = Detection.dcd if vertices_t1 is None else Detection.ccd
    options = QueryOptions(detection=detection, accuracy=accuracy, contact_rule=contact_rule)
    if options.detection == Detection.ccd and vertices_t1 is None:
        raise InvalidInput("vertices_t1: continuous detection needs the positions at the end of the step")
    scene = _scene_of(
        vertices_t0,
        triangles,
        vertices_t1,
        _scene(detect, scene_options),
        margin=margin,
        self_collision=self_collision,
        vertex_triangle=vertex_triangle,
        edge_edge=edge_edge,
    )
    return Query(scene, detection=detection, accuracy=accuracy, contact_rule=contact_rule).detect()


def collision_free_step(
    vertices_t0: Array | Sequence[Array],
    triangles: Array | Sequence[Array],
    vertices_t1: Array | Sequence[Array],
    *,
    margin: float = 0.0,
    self_collision: bool = True,
    **scene_options: Any,
) -> float:
    """How much of the step from t0 to t1 can be made before anything touches: a number in [0, 1].

    Along `vertices_t0 + s * (vertices_t1 - vertices_t0)` nothing touches for s below the result, or comes nearer than
    twice `margin`. Never too large: float64 positions count as they are. At the result itself something may
    touch: a solver that goes on from there takes a little less, or a margin. 0 where something touches at t0. Arguments
    are as for `detect`, further keywords those of `Scene`.
    """
    scene = _scene_of(
        vertices_t0,
        triangles,
        vertices_t1,
        _scene(collision_free_step, scene_options),
        margin=margin,
        self_collision=self_collision,
        edge_edge=True,
    )
    contacts = Query(scene, detection=Detection.ccd, accuracy=Accuracy.conservative).detect()
    return float(contacts["time_of_impact"].min(initial=1.0))


_TRIANGLES_AT_ONCE = 1 << 16


def self_intersections(vertices: Array, triangles: Array, **scene_options: Any) -> np.ndarray:
    """The pairs of a mesh's triangles that intersect, as uint32 of shape (k, 2): sorted, each once, the smaller first.

    Two triangles intersect when an edge of one has a point in common with the other, to which none of its vertices
    belongs: neighbours count where they meet elsewhere than in what they share, and never where that is an edge.
    Touching counts. Decided exactly for the positions as they are. Further keywords are those of `Scene`.
    """
    scene = _scene(self_intersections, scene_options)
    scene.set_positions(scene.add_body(triangles, _row_count("vertices", vertices)), vertices)
    positions = np.ascontiguousarray(vertices, np.float64)
    faces = np.ascontiguousarray(triangles, np.uint32).reshape(-1, 3)
    probe = Probe(scene)
    # Far more than the scene rounds positions by, from which it finds candidates.
    slack = 2.0**-20 * np.ptp(positions, axis=0).max(initial=0.0)
    found = [np.empty((0, 2), np.uint32)]
    for first in range(0, len(faces), _TRIANGLES_AT_ONCE):
        corners = positions[faces[first : first + _TRIANGLES_AT_ONCE]]
        near = probe.box_overlaps(corners.min(axis=1) - slack, corners.max(axis=1) + slack)
        candidates = np.ascontiguousarray(near.all["triangle"])
        found.append(_core.intersecting_pairs(positions, faces, first, near.begins, candidates))
    return np.concatenate(found)
