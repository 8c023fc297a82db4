"""One-call functions for those who keep no scene."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from . import _core
from ._core import Accuracy, Backend, ContactRule, Detection, Query, Scene
from ._errors import InvalidInput

Array = Any
"""numpy's, anything with the buffer protocol or `__dlpack__` in the CPU's memory, or lists of numbers."""


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
    scene_options: dict[str, Any],
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
    scene = Scene(**scene_options)
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
    detection: Detection | None = None,
    accuracy: Accuracy = Accuracy.conservative,
    contact_rule: ContactRule = ContactRule.distance,
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
    elif detection == Detection.ccd and vertices_t1 is None:
        raise InvalidInput("vertices_t1: continuous detection needs the positions at the end of the step")
    scene = _scene_of(
        vertices_t0,
        triangles,
        vertices_t1,
        scene_options,
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
        scene_options,
        margin=margin,
        self_collision=self_collision,
        edge_edge=True,
    )
    contacts = Query(scene, detection=Detection.ccd, accuracy=Accuracy.conservative).detect()
    return float(contacts["time_of_impact"].min(initial=1.0))


_EDGES_AT_ONCE = 1 << 18


def _edges_of(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Each edge's two vertices, and which edges the three of each triangle are."""
    ends = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1).astype(np.uint64)
    keys, edge_of = np.unique(ends[:, 0] << np.uint64(32) | ends[:, 1], return_inverse=True)
    edges = np.stack([keys >> np.uint64(32), keys & np.uint64(0xFFFFFFFF)], axis=1).astype(np.uint32)
    return edges, edge_of.reshape(-1)


def _pairs_of_triangles(edges_met: np.ndarray, triangles_met: np.ndarray, edge_of: np.ndarray) -> np.ndarray:
    """The triangles around each edge with the triangle that it meets: each pair once, the smaller first."""
    by_edge = np.argsort(edge_of, kind="stable")
    begin = np.searchsorted(edge_of[by_edge], edges_met, side="left")
    count = np.searchsorted(edge_of[by_edge], edges_met, side="right") - begin
    place = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count) + np.repeat(begin, count)
    pairs = np.stack([by_edge[place] // 3, np.repeat(triangles_met, count)], axis=1)
    return np.unique(np.sort(pairs, axis=1), axis=0).astype(np.uint32)


def self_intersections(vertices: Array, triangles: Array, **scene_options: Any) -> np.ndarray:
    """The pairs of a mesh's triangles that intersect, as uint32 of shape (k, 2): sorted, each once, the smaller first.

    Two triangles intersect when an edge of one has a point in common with the other, to which none of its vertices
    belongs: neighbours count where they meet elsewhere than in what they share, and never where that is an edge.
    Touching counts. Decided exactly for the positions as they are. Further keywords are those of `Scene`.
    """
    scene = Scene(**scene_options)
    mesh = scene.add_body(triangles, _row_count("vertices", vertices))
    scene.set_positions(mesh, vertices)
    positions = np.ascontiguousarray(vertices, np.float64)
    faces = np.ascontiguousarray(triangles, np.uint32)
    edges, edge_of = _edges_of(faces)
    # An edge meets a triangle exactly where a point that moves along it does.
    query = Query(scene, detection=Detection.ccd, accuracy=Accuracy.conservative, edge_edge=False)
    moving = scene.add_body(np.empty((0, 3), np.uint32), 0)
    met = []
    for first in range(0, len(edges), _EDGES_AT_ONCE):
        ends = edges[first : first + _EDGES_AT_ONCE]
        scene.update_body(moving, np.repeat(np.arange(len(ends)), 3).reshape(-1, 3), len(ends))
        scene.set_positions(moving, positions[ends[:, 0]], positions[ends[:, 1]])
        contacts = query.detect()
        contacts = contacts[contacts["body_a"] == moving]
        edge, face = contacts["feature_a"], contacts["feature_b"]
        apart = ~(faces[face][:, :, None] == ends[edge][:, None, :]).any(axis=(1, 2))
        edge, face = edge[apart], face[apart]
        hit = _core.edges_meet_triangles(positions, ends[edge], faces[face])
        met.append(np.stack([edge[hit] + np.int64(first), face[hit]], axis=1))
    if not met:
        return np.empty((0, 2), np.uint32)
    edges_met, triangles_met = np.concatenate(met).T
    return _pairs_of_triangles(edges_met, triangles_met, edge_of)
