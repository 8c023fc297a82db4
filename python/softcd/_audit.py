"""softcd.audit: compares another engine's pairs with the true contacts."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import _core, _pair_geometry
from ._core import Accuracy, ContactKind, Detection, Query, Scene
from ._errors import InvalidInput
from ._helpers import Array, Progress, _row_count, _scene

audit_dtype = np.dtype(
    [
        ("kind", np.uint8),
        ("feature_a", np.uint32),
        ("feature_b", np.uint32),
        ("vertices", np.uint32, 4),
        ("distance", np.float64),
        ("time_of_impact", np.float64),
        ("row", np.int64),
    ]
)
"""The fields of a judged pair: see Audit."""

_KINDS = (ContactKind.vertex_triangle, ContactKind.edge_edge)
_LISTS = {
    "confirmed": "",
    "missed": "",
    "invented": "",
    "undecided": "within the tolerance: not judged",
    "ignored": "never compared: with common or unused vertices",
}


@dataclass(frozen=True, repr=False, eq=False)
class Audit:
    """The result of softcd.audit: five arrays of softcd.audit_dtype, sorted by kind.

    - `kind`: ContactKind.vertex_triangle or edge_edge.
    - `feature_a`, `feature_b`: vertex and triangle, or the two edges. Edges count the rows of `edges`, and are NO_BODY
      where it lacks one. Without `edges` they count the mesh's edges in the order of their sorted vertex pairs.
    - `vertices`: the vertex and the triangle's three, or two of each edge.
    - `distance`: the smallest distance found during the step, in the unit of the positions; never less than the true
      one. Of a discrete audit: the distance.
    - `time_of_impact`: the first time within `reach`, in [0, 1] and never late; 1 for a discrete audit; NaN where the
      features stay farther apart.
    - `row`: the pair's row in the list of its kind, -1 for a pair that the list lacks.
    """

    missed: np.ndarray
    """True contacts that the list lacks."""
    invented: np.ndarray
    """Pairs of the list that are no contacts."""
    confirmed: np.ndarray
    """Pairs of the list that are contacts."""
    undecided: np.ndarray
    """Pairs, listed or not, whose verdict depends on roundings: they come within `tolerance` of the other verdict."""
    ignored: np.ndarray
    """Pairs of the list that softcd never compares: with a vertex in common, or a vertex that no triangle has."""
    repeated_count: int
    """Number of rows that repeat an earlier one. Each pair is judged once."""
    audited_kinds: tuple[ContactKind, ...]
    """The kinds whose lists were given."""
    reach: float
    """The distance up to which features are in contact: twice the margin."""
    tolerance: float
    """A verdict stands where moving each vertex by half of this cannot change it. Unit: the positions'."""
    is_continuous: bool
    """True for a step, false for one set of positions."""

    @property
    def is_correct(self) -> bool:
        """Returns whether nothing is missed and nothing is invented."""
        return len(self.missed) == 0 and len(self.invented) == 0

    def counts(self) -> dict[str, dict[str, int]]:
        """Returns the number of pairs by list, then by kind: counts()["missed"]["edge_edge"]."""
        return {
            name: {kind.name: int((getattr(self, name)["kind"] == kind).sum()) for kind in self.audited_kinds}
            for name in _LISTS
        }

    def __repr__(self) -> str:
        step = "continuous" if self.is_continuous else "discrete"
        lines = [f"softcd.Audit: {step}, contacts within {self.reach:.3g}, tolerance {self.tolerance:.2g}"]
        names = [kind.name for kind in self.audited_kinds]
        lines.append("  " + " " * 9 + "".join(f"{name:>17}" for name in names))
        for name, counts in self.counts().items():
            row = f"  {name:<9}" + "".join(f"{counts[kind]:>17}" for kind in names)
            lines.append(f"{row}   {_LISTS[name]}".rstrip())
        if self.repeated_count:
            lines.append(f"  {self.repeated_count} rows repeat an earlier one")
        return "\n".join(lines)


class _Mesh:
    """A mesh's features and the numbers that identify pairs of them."""

    def __init__(self, vertex_count: int, triangles: np.ndarray, edges: np.ndarray | None) -> None:
        self.vertex_count = vertex_count
        self.triangles = triangles
        sides = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        self.codes = np.unique(self._code(sides[sides[:, 0] != sides[:, 1]]))
        self.edges = (
            np.stack(np.divmod(self.codes, vertex_count), axis=1) if len(self.codes) else np.zeros((0, 2), np.int64)
        )
        self.is_used = np.zeros(vertex_count, bool)
        self.is_used[triangles] = True
        self.given_edges = edges
        # The number that results show for each edge.
        self.shown = np.arange(len(self.codes))
        if edges is not None:
            self.places = self.edge_indices("edges", edges)
            self.shown = np.full(len(self.codes), _core.NO_BODY, np.int64)
            self.shown[self.places[::-1]] = np.arange(len(edges))[::-1]

    def _code(self, edges: np.ndarray) -> np.ndarray:
        ordered = np.sort(edges, axis=1)
        return ordered[:, 0] * self.vertex_count + ordered[:, 1]

    def edge_indices(self, name: str, edges: np.ndarray) -> np.ndarray:
        """Finds edges, given by their vertices, among the mesh's."""
        codes = self._code(edges)
        places = np.minimum(np.searchsorted(self.codes, codes), max(len(self.codes) - 1, 0))
        is_known = self.codes[places] == codes if len(self.codes) else np.zeros(len(codes), bool)
        if not is_known.all():
            row = int(np.flatnonzero(~is_known)[0])
            a, b = edges[row].tolist()
            raise InvalidInput(f"{name}: row {row} names the edge of vertices {a} and {b}, which no triangle has.")
        return places

    def key(self, kind: ContactKind, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return a * (len(self.triangles) if kind == ContactKind.vertex_triangle else len(self.codes)) + b

    def features(self, kind: ContactKind, keys: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        count = len(self.triangles) if kind == ContactKind.vertex_triangle else len(self.codes)
        return np.divmod(keys, max(count, 1))

    def vertices(self, kind: ContactKind, a: np.ndarray, b: np.ndarray) -> np.ndarray:
        if kind == ContactKind.vertex_triangle:
            return np.concatenate([a[:, None], self.triangles[b]], axis=1)
        return np.concatenate([self.edges[a], self.edges[b]], axis=1)

    def is_compared(self, kind: ContactKind, vertices: np.ndarray) -> np.ndarray:
        """Returns which pairs softcd compares: those that share no vertex and whose vertices triangles have."""
        split = 1 if kind == ContactKind.vertex_triangle else 2
        shared = (vertices[:, :split, None] == vertices[:, None, split:]).any(axis=(1, 2))
        return ~shared & self.is_used[vertices].all(axis=1)

    def keys_of_contacts(self, kind: ContactKind, contacts: np.ndarray) -> np.ndarray:
        found = contacts[contacts["kind"] == kind]
        if kind == ContactKind.vertex_triangle:
            return self.key(kind, found["feature_a"].astype(np.int64), found["feature_b"].astype(np.int64))
        corners = found["vertices"].astype(np.int64)
        a, b = (self.edge_indices("edges", corners[:, side]) for side in (slice(0, 2), slice(2, 4)))
        return self.key(kind, np.minimum(a, b), np.maximum(a, b))


def _integers(
    name: str, values: Array, widths: tuple[int, ...], counts: tuple[int, ...], what: tuple[str, ...]
) -> np.ndarray:
    """Reads an array of indices of shape (k, width). counts and what have the number and the name of each column's
    features."""
    try:
        array = np.asarray(values)
    except (TypeError, ValueError, RuntimeError) as error:
        raise TypeError(f"{name}: expected integers, got what cannot be read as such: {error}") from None
    if array.size == 0 and array.ndim <= 2:
        return np.zeros((0, widths[0]), np.int64)
    if array.dtype.kind not in "iu":
        raise TypeError(f"{name}: expected integers, got {array.dtype}")
    if array.ndim != 2 or array.shape[1] not in widths:
        shapes = " or ".join(f"(k, {width})" for width in widths)
        raise InvalidInput(f"{name}: expected shape {shapes}, got {array.shape}")
    for column in range(array.shape[1]):
        count, thing = counts[min(column, len(counts) - 1)], what[min(column, len(what) - 1)]
        wrong = np.flatnonzero((array[:, column] < 0) | (array[:, column] >= count))
        if len(wrong):
            index = int(array[wrong[0], column])
            raise InvalidInput(
                f"{name}: row {wrong[0]} names {thing} {index}, but there are {count}; indices count from 0."
            )
    return array.astype(np.int64)


def _given_pairs(mesh: _Mesh, vertex_triangle: Array | None, edge_edge: Array | None) -> dict[ContactKind, np.ndarray]:
    """Returns the keys of the listed pairs by kind, row by row."""
    given = {}
    if vertex_triangle is not None:
        counts = (mesh.vertex_count, len(mesh.triangles))
        pairs = _integers("vertex_triangle_pairs", vertex_triangle, (2,), counts, ("vertex", "triangle"))
        given[_KINDS[0]] = mesh.key(_KINDS[0], pairs[:, 0], pairs[:, 1])
    if edge_edge is not None:
        name = "edge_edge_pairs"
        if np.ndim(edge_edge) == 2 and np.shape(edge_edge)[1] == 2 and len(edge_edge):
            if mesh.given_edges is None:
                raise InvalidInput(f"{name}: pairs of edge indices need edges, the array that they count")
            pairs = _integers(name, edge_edge, (2,), (len(mesh.given_edges),), ("edge",))
            ends = mesh.places[pairs]
        else:
            pairs = _integers(
                name, edge_edge, (4,) if mesh.given_edges is None else (2, 4), (mesh.vertex_count,), ("vertex",)
            )
            pairs = pairs.reshape(-1, 4) if len(pairs) else np.zeros((0, 4), np.int64)
            ends = np.stack([mesh.edge_indices(name, pairs[:, side]) for side in (slice(0, 2), slice(2, 4))], axis=1)
        given[_KINDS[1]] = mesh.key(_KINDS[1], ends.min(axis=1), ends.max(axis=1))
    return given


class _Judge:
    """Finds certain and possible contacts of one kind, as keys of pairs, with their times and distances."""

    def __init__(
        self,
        mesh: _Mesh,
        positions: tuple[np.ndarray, np.ndarray | None],
        kinds: Collection[ContactKind],
        reach: float,
        tolerance: float,
        scene: Scene,
    ) -> None:
        self._mesh, self._tolerance = mesh, tolerance
        self._x_t0, x_t1 = positions
        self._is_continuous = x_t1 is not None
        self._x_t1 = self._x_t0 if x_t1 is None else x_t1
        features = {kind.name: kind in kinds for kind in _KINDS}
        body = scene.add_body(mesh.triangles, mesh.vertex_count, **features)
        scene.set_positions(body, *positions)
        detection = Detection.ccd if self._is_continuous else Detection.dcd
        query = Query(scene, detection=detection, accuracy=Accuracy.conservative)

        def contacts_within(distance: float) -> np.ndarray:
            scene.set_settings(body, margin=distance / 2, **features)
            return query.detect()

        self._contacts = contacts_within(reach)
        self._wider = contacts_within(reach + tolerance)
        self._narrower = contacts_within(reach - tolerance) if reach > tolerance else None
        self._crossing = {kind: self._find_crossing(kind) for kind in kinds}

    def _corners(self, kind: ContactKind, keys: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        vertices = self._mesh.vertices(kind, *self._mesh.features(kind, keys))
        return self._x_t0[vertices], self._x_t1[vertices]

    def _find_crossing(self, kind: ContactKind) -> np.ndarray:
        """Returns the pairs that cross, where a smaller distance cannot tell what certainly is a contact."""
        keys = self._mesh.keys_of_contacts(kind, self._contacts)
        if self._narrower is not None or not self._is_continuous:
            return keys[:0]
        corners = self._corners(kind, keys)
        return keys[_pair_geometry.certainly_cross(*corners, kind == _KINDS[0], self._tolerance / 2)]

    def certain(self, kind: ContactKind) -> np.ndarray:
        """Returns the pairs that are in contact wherever the tolerance puts their vertices."""
        if self._narrower is None:
            return self._crossing[kind]
        return self._mesh.keys_of_contacts(kind, self._narrower[~self._narrower["is_unsettled"]])

    def possible(self, kind: ContactKind) -> np.ndarray:
        """Returns the pairs that are in contact somewhere within the tolerance."""
        return self._mesh.keys_of_contacts(kind, self._wider)

    def times(self, kind: ContactKind, keys: np.ndarray) -> np.ndarray:
        """Returns times of impact: NaN without contact."""
        order, place, is_found = _places(self._mesh.keys_of_contacts(kind, self._contacts), keys)
        times = np.full(len(keys), np.nan)
        of_kind = self._contacts[self._contacts["kind"] == kind]
        times[is_found] = of_kind["time_of_impact"][order[place[is_found]]]
        return times

    def nearest(self, kind: ContactKind, keys: np.ndarray, times: np.ndarray) -> np.ndarray:
        """Returns the smallest distances found."""
        x_t0, x_t1 = self._corners(kind, keys)
        if not self._is_continuous:
            return _pair_geometry.distances(x_t0, kind == _KINDS[0])
        nearest = _pair_geometry.nearest_approach(x_t0, x_t1, kind == _KINDS[0], np.nan_to_num(times))
        return np.where(np.isin(keys, self._crossing[kind]), 0, nearest)


def _places(values: np.ndarray, wanted: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns an order that sorts values, the place of each wanted one in it, and whether it is there."""
    order = np.argsort(values, kind="stable")
    if len(values) == 0:
        return order, np.zeros(len(wanted), np.int64), np.zeros(len(wanted), bool)
    place = np.minimum(np.searchsorted(values, wanted, sorter=order), len(values) - 1)
    return order, place, values[order[place]] == wanted


def audit(
    vertices_t0: Array,
    triangles: Array,
    vertices_t1: Array | None = None,
    *,
    vertex_triangle_pairs: Array | None = None,
    edge_edge_pairs: Array | None = None,
    edges: Array | None = None,
    margin: float = 0.0,
    tolerance: float | None = None,
    progress: Progress | None = None,
    **scene_options: Any,
) -> Audit:
    """Judges another engine's list of contacts of a mesh: which true contacts it lacks, and which it invents.

    Positions, of shape (n, 3), and triangles, of shape (m, 3), are as for `detect`. With `vertices_t1` the audit is of
    a step, along straight lines; else of `vertices_t0` alone. Several meshes are joined into one first.

    - `vertex_triangle_pairs`: integers of shape (k, 2), a vertex and a triangle.
    - `edge_edge_pairs`: integers of shape (k, 4), two vertices of each edge, or of shape (k, 2), two rows of `edges`.
    - `edges`: integers of shape (e, 2), the engine's own edges.

    A kind without a list is not audited; an empty list is. The order of rows, of edges and of an edge's vertices does
    not matter. Two features are in contact when their distance is at most twice `margin`, as for `detect`: for an
    engine with one distance, pass half of it. A list of candidates, before the engine's exact test, is not meant: most
    of it would be invented.

    softcd judges with Accuracy.conservative. A verdict stands only where no vertex, moved by half of `tolerance`, would
    change it. Other pairs are `undecided`. The default `tolerance` is what an engine that computes in the positions'
    type cannot be blamed for: 16 units in the last place of the largest coordinate. With 0 only softcd's own roundings
    in float64 count, and a smaller value than those is raised to them. Where the contact distance is not larger than
    `tolerance`, as without a margin, a pair of a step is missed only if it certainly crosses; a discrete audit then
    finds no missed pair. So give discrete audits a margin.

    `progress(done, total)` is called when the detections are done and after each list of results, and may raise to stop
    the call. Raises InvalidInput or TypeError, which name the argument. Further keywords are those of `Scene`.

        audit = softcd.audit(x0, triangles, x1, vertex_triangle_pairs=pairs)
        print(audit)
        assert len(audit.missed) == 0
    """
    scene = _scene(audit, scene_options)
    if vertex_triangle_pairs is None and edge_edge_pairs is None:
        raise InvalidInput("vertex_triangle_pairs, edge_edge_pairs: at least one list is needed; it may be empty")
    x_t0, rounding = _positions("vertices_t0", vertices_t0)
    x_t1 = None
    if vertices_t1 is not None:
        x_t1, rounding_t1 = _positions("vertices_t1", vertices_t1)
        rounding = max(rounding, rounding_t1)
        if len(x_t1) != len(x_t0):
            raise InvalidInput(f"vertices_t1: expected {len(x_t0)} positions, as vertices_t0 has, got {len(x_t1)}")
    faces = _integers("triangles", triangles, (3,), (len(x_t0),), ("vertex",))
    own_edges = None if edges is None else _integers("edges", edges, (2,), (len(x_t0),), ("vertex",))
    mesh = _Mesh(len(x_t0), faces, own_edges)
    given = _given_pairs(mesh, vertex_triangle_pairs, edge_edge_pairs)
    reach = 2 * _not_negative("margin", margin)
    both = x_t0 if x_t1 is None else np.concatenate([x_t0, x_t1])
    # softcd's own: see how conservative decides, in docs/measured/accuracy.md; margins are float32.
    least = 2.0**-43 * np.ptp(both, axis=0).max(initial=0.0) + 2.0**-19 * reach
    if tolerance is None:
        tolerance = 16 * rounding * np.abs(both).max(initial=0.0)
    tolerance = max(_not_negative("tolerance", tolerance), float(least))
    judge = _Judge(mesh, (x_t0, x_t1), tuple(given), reach, tolerance, scene)
    return Audit(
        **_judge_all(mesh, judge, given, progress),
        repeated_count=sum(len(rows) - len(np.unique(rows)) for rows in given.values()),
        audited_kinds=tuple(given),
        reach=reach,
        tolerance=tolerance,
        is_continuous=x_t1 is not None,
    )


def _positions(name: str, values: Array) -> tuple[np.ndarray, float]:
    """Returns positions in float64, and the relative rounding of their own type."""
    _row_count(name, values)
    try:
        array = np.asarray(values)
    except (TypeError, ValueError, RuntimeError) as error:
        raise TypeError(f"{name}: expected numbers, got what cannot be read as such: {error}") from None
    if array.dtype.kind not in "fiu" or array.dtype.itemsize > 8:
        raise TypeError(f"{name}: expected an array of float32 or float64 of shape (n, 3), got {array.dtype}")
    if array.ndim != 2 or array.shape[1] != 3:
        raise InvalidInput(f"{name}: expected shape (n, 3), got {array.shape}")
    if not np.isfinite(array).all():
        row = int(np.flatnonzero(~np.isfinite(array).all(axis=1))[0])
        raise InvalidInput(f"{name}: vertex {row} is not finite.")
    rounding = np.finfo(np.float32 if array.dtype == np.float32 else np.float64).eps
    return np.ascontiguousarray(array, np.float64), float(rounding)


def _not_negative(name: str, value: Any) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise TypeError(f"{name}: expected a number, got {value!r}") from None
    if not 0 <= number < np.inf:
        raise InvalidInput(f"{name} is {number:g}, but must be finite and at least 0.")
    return number


def _judge_all(
    mesh: _Mesh, judge: _Judge, given: dict[ContactKind, np.ndarray], progress: Progress | None
) -> dict[str, np.ndarray]:
    """Returns the lists of an Audit. Its detections are done."""
    done, total = 1, 1 + len(given) * len(_LISTS)
    if progress is not None:
        progress(done, total)
    lists: dict[str, list[np.ndarray]] = {name: [np.zeros(0, audit_dtype)] for name in _LISTS}
    for kind, rows in given.items():
        listed = np.unique(rows)
        is_compared = mesh.is_compared(kind, mesh.vertices(kind, *mesh.features(kind, listed)))
        judged, certain = listed[is_compared], np.unique(judge.certain(kind))
        possible = np.union1d(judge.possible(kind), certain)
        keys_of = {
            "confirmed": np.intersect1d(judged, certain),
            "missed": np.setdiff1d(certain, listed),
            "invented": np.setdiff1d(judged, possible),
            "undecided": np.setdiff1d(possible, certain),
            "ignored": listed[~is_compared],
        }
        for name, keys in keys_of.items():
            lists[name].append(_judged(mesh, judge, kind, keys, rows))
            done += 1
            if progress is not None:
                progress(done, total)
    joined = {name: np.concatenate(parts) for name, parts in lists.items()}
    for array in joined.values():
        array.flags.writeable = False
    return joined


def _judged(mesh: _Mesh, judge: _Judge, kind: ContactKind, keys: np.ndarray, listed: np.ndarray) -> np.ndarray:
    """Makes an array of audit_dtype of pairs of one kind. listed has the keys of the list, row by row."""
    result = np.zeros(len(keys), audit_dtype)
    a, b = mesh.features(kind, keys)
    result["kind"] = kind
    shown = mesh.shown[np.stack([a, b])] if kind == ContactKind.edge_edge else (a, b)
    result["feature_a"], result["feature_b"] = shown
    result["vertices"] = mesh.vertices(kind, a, b)
    result["time_of_impact"] = judge.times(kind, keys)
    result["distance"] = judge.nearest(kind, keys, result["time_of_impact"])
    order, place, is_listed = _places(listed, keys)
    result["row"] = -1
    result["row"][is_listed] = order[place[is_listed]]
    return result
