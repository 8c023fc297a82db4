"""Functions for a single call, without a scene."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Iterable, Sequence, Sized
from typing import Any, NamedTuple

import numpy as np

from . import _core
from ._core import Accuracy, ContactRule, Detection, Query, QueryOptions, Scene, SceneOptions
from ._errors import InvalidInput
from ._probe import Probe

Array = Any
"""numpy's, anything with the buffer protocol or `__dlpack__` in the CPU's memory, or lists of numbers."""


Progress = Callable[[int, "int | None"], object]
"""A function that long calls call with the number of finished parts and the number of all parts, None if unknown."""


def _scene(function: Callable[..., Any], options: dict[str, Any]) -> Scene:
    """Makes a Scene of the keywords that a function passes on. Its error also knows the function's own keywords."""
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
    """Finds the contacts of a mesh with itself, or of several meshes, as an array of `softcd.contact_dtype`.

    Positions have the shape (n, 3) and are float32 or float64, triangles the shape (m, 3) and are integers. With
    sequences of arrays each is a mesh, and `body_a` and `body_b` of a contact count them from 0. Two features are in
    contact when their distance is at most twice `margin`: the sum of both sides'.

    With `vertices_t1` detection is continuous, along straight lines from t0 to t1; else it is discrete.
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
    """Returns the part of the step from t0 to t1 that is free of collisions: a number in [0, 1].

    Along `vertices_t0 + s * (vertices_t1 - vertices_t0)` nothing touches for s below the result, or comes nearer than
    twice `margin`. The result is never too large, also for float64 positions. At the result itself features may touch:
    a solver that continues there takes a little less, or a margin. The result is 0 where features touch at t0.
    Arguments are as for `detect`, further keywords those of `Scene`.
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


def self_intersections(
    vertices: Array, triangles: Array, *, progress: Progress | None = None, **scene_options: Any
) -> np.ndarray:
    """Finds a mesh's pairs of intersecting triangles, as uint32 of shape (k, 2): sorted, each once, smaller first.

    Two triangles intersect when an edge of one has a point in common with the other, and no vertex of the other. So
    neighbours count where they meet outside of their shared features, and never if they share an edge. Touching
    counts. The decision is exact for the given positions. `progress(done, total)` is called with the number of
    triangles, and may raise to stop the call. Further keywords are those of `Scene`.

        >>> for first, second in softcd.self_intersections(vertices, triangles): ...
    """
    scene = _scene(self_intersections, scene_options)
    scene.set_positions(scene.add_body(triangles, _row_count("vertices", vertices)), vertices)
    positions = np.ascontiguousarray(vertices, np.float64)
    faces = np.ascontiguousarray(triangles, np.uint32).reshape(-1, 3)
    probe = Probe(scene)
    # Far more than the rounding of the scene's positions, by which it finds candidates.
    slack = 2.0**-20 * np.ptp(positions, axis=0).max(initial=0.0)
    found = [np.empty((0, 2), np.uint32)]
    for first in range(0, len(faces), _TRIANGLES_AT_ONCE):
        corners = positions[faces[first : first + _TRIANGLES_AT_ONCE]]
        near = probe.box_overlaps(corners.min(axis=1) - slack, corners.max(axis=1) + slack)
        candidates = np.ascontiguousarray(near.all["triangle"])
        found.append(_core.intersecting_pairs(positions, faces, first, near.begins, candidates))
        if progress is not None:
            progress(min(first + _TRIANGLES_AT_ONCE, len(faces)), len(faces))
    return np.concatenate(found)


class Certificate(NamedTuple):
    """The result of `certify`."""

    proved: bool
    """Whether nothing touches: all of the arrays are empty."""
    contacts: list[np.ndarray]
    """For each step, from a frame to the next: the features that touch, or that may, as `detect` returns them."""
    intersections: list[np.ndarray]
    """For each frame: the triangles that intersect, as `self_intersections` returns them."""


def certify(
    frames: Iterable[Array],
    triangles: Array,
    *,
    margin: float = 0.0,
    progress: Progress | None = None,
    **scene_options: Any,
) -> Certificate:
    """Proves that the frames of a mesh do not cross, or returns what touches.

    If the result's `proved` is true, then, while all vertices move straight and evenly from each frame to the next, no
    vertex touches a triangle and no edge an edge, unless they share a vertex; and in no frame do triangles intersect.
    With a margin, vertices also stay more than twice `margin` away from triangles, and edges from edges.

    Each frame has the positions of all vertices, float32 or float64, in the shape (n, 3). An iterator may compute
    them: two are kept. Reported contacts touch or come within rounding of it, about 1e-14 of their size.
    `progress(done, total)` is called after each frame, with None as total where frames come from an iterator, and may
    raise to stop the call. Further keywords are those of `Scene`.

        >>> certificate = softcd.certify(frames, triangles, progress=lambda done, total: print(done, "of", total))
    """
    scene = _scene(certify, scene_options)
    faces = np.ascontiguousarray(triangles, np.uint32).reshape(-1, 3)
    if len(faces) == 0:
        raise InvalidInput("triangles: there are none, so there is nothing to prove")
    allowed = np.float32(margin)
    if float(allowed) < margin:
        allowed = np.nextafter(allowed, np.float32(np.inf))
    certificate = Certificate(True, [], [])
    query = Query(scene, detection=Detection.ccd, accuracy=Accuracy.conservative)
    total = len(frames) if isinstance(frames, Sized) else None
    body = None
    before = None
    for number, frame in enumerate(frames):
        after = np.array(frame, np.float64)
        if before is not None and after.shape != before.shape:
            raise InvalidInput(f"frames: frame {number} has the shape {after.shape}, not {before.shape} as before")
        if not (np.abs(after) <= 1e37).all():
            raise InvalidInput(f"frames: frame {number} has a position that is not finite or beyond 1e37")
        if body is None:
            body = scene.add_body(faces, _row_count("frames", after), margin=float(allowed))
        if before is not None:
            scene.set_positions(body, before, after)
            certificate.contacts.append(query.detect().copy())
        certificate.intersections.append(self_intersections(after, faces, **scene_options))
        before = after
        if progress is not None:
            progress(number + 1, total)
    if len(certificate.intersections) < 2:
        raise InvalidInput(f"frames: there are {len(certificate.intersections)}; give at least two")
    found = [*certificate.contacts, *certificate.intersections]
    return certificate._replace(proved=all(len(array) == 0 for array in found))
