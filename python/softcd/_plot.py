"""softcd.plot: meshes and contacts in a window, by pyvista or polyscope."""

from __future__ import annotations

import importlib
import importlib.util
from collections.abc import Sequence
from typing import Any

import numpy as np

from ._core import ContactKind
from ._errors import InvalidInput
from ._helpers import Array, _is_several

_COLOURS = {ContactKind.vertex_triangle: (0.84, 0.15, 0.16), ContactKind.edge_edge: (0.12, 0.35, 0.8)}
_MESH_COLOUR = (0.85, 0.85, 0.82)


def plot(
    vertices: Array | Sequence[Array],
    triangles: Array | Sequence[Array],
    contacts: np.ndarray | None = None,
    *,
    vertices_t1: Array | Sequence[Array] | None = None,
    normal_length: float | None = None,
    show: bool = True,
) -> Any:
    """Shows meshes and their contacts: a point on each side, red for a vertex and a triangle, blue for two edges, and
    an arrow from side b along the normal.

    Takes the arrays that `detect` took, and what it returned. Positions are of shape (n, 3), triangles of shape (m, 3);
    with sequences of arrays each is a mesh. For continuous contacts pass `vertices_t1` too: points are then those at
    the time of impact, and meshes are shown at t0 and, translucent, at t1. Arrows are `normal_length` long, in the unit
    of the positions; by default a twentieth of the meshes' diagonal.

    Needs pyvista, or polyscope where pyvista is not installed. Returns a pyvista.Plotter, or the module polyscope. With
    show=False no window opens, and the result may be changed, shown or saved:

        softcd.plot(vertices, triangles, contacts)
        softcd.plot(vertices, triangles, contacts, show=False).screenshot("contacts.png")  # with pyvista

    Raises ImportError where neither is installed, InvalidInput where shapes do not fit or contacts name other meshes.
    """
    several = _is_several(triangles)
    faces = [_rows("triangles", each, np.int64) for each in (triangles if several else [triangles])]
    x_t0 = _meshes("vertices", vertices, several, len(faces))
    x_t1 = None if vertices_t1 is None else _meshes("vertices_t1", vertices_t1, several, len(faces))
    if x_t1 is not None and [x.shape for x in x_t0] != [x.shape for x in x_t1]:
        raise InvalidInput("vertices_t1: expected as many positions as vertices has")
    for mesh, (x, face) in enumerate(zip(x_t0, faces)):
        if len(face) and not 0 <= face.min() <= face.max() < len(x):
            raise InvalidInput(f"triangles: mesh {mesh} has {len(x)} vertices; an index is out of range")
    points_a, points_b = contact_points(contacts, x_t0, x_t1)
    every = np.concatenate(x_t0 if x_t1 is None else [*x_t0, *x_t1])
    if normal_length is None:
        normal_length = 0.05 * float(np.linalg.norm(np.ptp(every, axis=0))) if len(every) else 1.0
    layers = [(x_t0, 1.0)] if x_t1 is None else [(x_t0, 1.0), (x_t1, 0.3)]
    markers = []
    if contacts is not None:
        for kind, colour in _COLOURS.items():
            rows = contacts["kind"] == kind
            if rows.any():
                markers.append((kind.name, colour, points_a[rows], points_b[rows], contacts["normal"][rows]))
    for name, draw in ("pyvista", _draw_with_pyvista), ("polyscope", _draw_with_polyscope):
        if importlib.util.find_spec(name) is not None:
            return draw(importlib.import_module(name), layers, faces, markers, normal_length, show)
    raise ImportError("softcd.plot needs pyvista or polyscope: pip install pyvista")


def _rows(name: str, values: Array, dtype: Any) -> np.ndarray:
    try:
        array = np.asarray(values)
        array = array.astype(dtype, casting="same_kind" if array.size else "unsafe")
    except (TypeError, ValueError, RuntimeError) as error:
        raise TypeError(f"{name}: expected {np.dtype(dtype).name} of shape (n, 3): {error}") from None
    if array.ndim != 2 or array.shape[1] != 3:
        raise InvalidInput(f"{name}: expected shape (n, 3), got {array.shape}")
    return array


def _meshes(name: str, values: Any, several: bool, count: int) -> list[np.ndarray]:
    meshes = values if several else [values]
    if not isinstance(meshes, (list, tuple)) or len(meshes) != count:
        raise InvalidInput(f"{name}: expected {count} arrays, one for each of triangles")
    return [_rows(name, each, np.float64) for each in meshes]


def contact_points(
    contacts: np.ndarray | None, x_t0: list[np.ndarray], x_t1: list[np.ndarray] | None
) -> tuple[np.ndarray, np.ndarray]:
    """Returns the points of side a and of side b of each contact, at its time where x_t1 is given."""
    if contacts is None or len(contacts) == 0:
        return np.zeros((0, 3)), np.zeros((0, 3))
    if "weights" not in (getattr(getattr(contacts, "dtype", None), "names", None) or ()):
        raise TypeError("contacts: expected an array of softcd.contact_dtype, as detect returns it")
    counts = np.array([len(x) for x in x_t0])
    begins = np.concatenate([[0], np.cumsum(counts)])
    is_on_b = np.arange(4) >= np.where(contacts["kind"] == ContactKind.vertex_triangle, 1, 2)[:, None]
    bodies = np.where(is_on_b, contacts["body_b"][:, None], contacts["body_a"][:, None]).astype(np.int64)
    vertices = contacts["vertices"].astype(np.int64)
    if bodies.max() >= len(counts) or (vertices >= counts[np.minimum(bodies, len(counts) - 1)]).any():
        raise InvalidInput("contacts: they name bodies or vertices that vertices lacks; they belong to other meshes")
    corners = np.concatenate(x_t0)[begins[bodies] + vertices]
    if x_t1 is not None:
        moved = np.concatenate(x_t1)[begins[bodies] + vertices]
        corners = corners + contacts["time_of_impact"].astype(np.float64)[:, None, None] * (moved - corners)
    weighted = contacts["weights"].astype(np.float64)[:, :, None] * corners
    is_on_b = is_on_b[:, :, None]
    return np.where(is_on_b, 0, weighted).sum(axis=1), np.where(is_on_b, weighted, 0).sum(axis=1)


def _draw_with_pyvista(
    pyvista: Any, layers: Any, faces: list[np.ndarray], markers: Any, normal_length: float, show: bool
) -> Any:
    plotter = pyvista.Plotter(off_screen=not show)
    for meshes, opacity in layers:
        for x, face in zip(meshes, faces):
            if len(face):
                surface = pyvista.PolyData.from_regular_faces(x, face)
                plotter.add_mesh(surface, color=_MESH_COLOUR, opacity=opacity, show_edges=opacity == 1)
    for _, colour, points_a, points_b, normals in markers:
        points = np.concatenate([points_a, points_b])
        plotter.add_points(points, color=colour, render_points_as_spheres=True, point_size=8)
        plotter.add_arrows(points_b, normals.astype(np.float64), mag=normal_length, color=colour)
    if show:
        plotter.show()
    return plotter


def _draw_with_polyscope(
    polyscope: Any, layers: Any, faces: list[np.ndarray], markers: Any, normal_length: float, show: bool
) -> Any:
    if not show:
        polyscope.set_allow_headless_backends(True)
    polyscope.init()
    polyscope.remove_all_structures()
    polyscope.set_ground_plane_mode("none")
    for layer, (meshes, opacity) in enumerate(layers):
        for i, (x, face) in enumerate(zip(meshes, faces)):
            name = f"mesh {i} at t{layer}" if len(layers) > 1 else f"mesh {i}"
            polyscope.register_surface_mesh(name, x, face, color=_MESH_COLOUR, transparency=opacity, edge_width=1.0)
    for name, colour, points_a, points_b, normals in markers:
        side_a = polyscope.register_point_cloud(f"{name}, side a", points_a, color=colour)
        side_b = polyscope.register_point_cloud(f"{name}, side b", points_b, color=colour)
        for side in (side_a, side_b):
            side.set_radius(0.1 * normal_length, relative=False)
        arrows = normals.astype(np.float64) * normal_length
        side_b.add_vector_quantity("normal", arrows, vectortype="ambient", color=colour, enabled=True)
    if show:
        polyscope.show()
    return polyscope
