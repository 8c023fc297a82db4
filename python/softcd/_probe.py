"""Spatial questions about a scene's bodies."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from . import _core
from ._core import MeshChange, Scene, StepEnd
from ._errors import InvalidInput

Numbers = Any
"""Numbers, or an array of any real type: numpy's, or what numpy.asarray makes one of."""

BodyPairs = Sequence[tuple["int | None", "int | None"]]
"""Pairs of bodies; None stands for all."""


def _array(name: str, values: Numbers) -> np.ndarray:
    try:
        return np.asarray(values)
    except (TypeError, ValueError, RuntimeError) as error:
        raise TypeError(f"{name}: expected numbers, got what cannot be read as such: {error}") from None


def _numbers(name: str, values: Numbers, shape: tuple[int, ...]) -> np.ndarray:
    """Converts to float64, of that shape or of several such in a row."""
    array = _array(name, values)
    if array.dtype.kind not in "fiu":
        raise TypeError(f"{name}: expected numbers, got {array.dtype}")
    if array.shape[array.ndim - len(shape) :] != shape or not 0 <= array.ndim - len(shape) <= 1:
        one = f"({', '.join(map(str, shape))}{',' if len(shape) == 1 else ''})" if shape else "one number"
        several = f"({', '.join(map(str, ('n', *shape)))}{'' if shape else ','})"
        raise InvalidInput(f"{name}: expected shape {several}, or {one} for all, got {array.shape}")
    with np.errstate(over="ignore"):
        return array.astype(np.float64)


def _batch(**columns: tuple[Numbers, tuple[int, ...]]) -> np.ndarray:
    """Makes a row for each question: the columns side by side, with single values repeated."""
    arrays = {name: _numbers(name, values, shape) for name, (values, shape) in columns.items()}
    counts = {name: len(arrays[name]) for name, (_, shape) in columns.items() if arrays[name].ndim > len(shape)}
    first, count = next(iter(counts.items()), (None, 1))
    for name in counts:
        if counts[name] != count:
            raise InvalidInput(f"{name}: expected {count} rows, as {first} has, got {counts[name]}")
    rows = [arrays[name].reshape(counts.get(name, 1), math.prod(shape)) for name, (_, shape) in columns.items()]
    return np.concatenate([np.broadcast_to(row, (count, row.shape[1])) for row in rows], axis=1)


class AnswerLists(Sequence[np.ndarray]):
    """A list of results for each question of a batch, in the questions' order: an array each, part of `all`."""

    def __init__(self, begins: np.ndarray, answers: np.ndarray) -> None:
        self.begins = begins
        """Where each question's results begin in `all`, and at last where the last ones end: int64."""
        self.all = answers
        """All results, question by question."""

    def __len__(self) -> int:
        return len(self.begins) - 1

    def __getitem__(self, question: Any) -> Any:
        if isinstance(question, slice):
            return [self[i] for i in range(len(self))[question]]
        i = range(len(self))[question]
        return self.all[self.begins[i] : self.begins[i + 1]]

    def __iter__(self) -> Iterator[np.ndarray]:
        return (self[i] for i in range(len(self)))

    def __repr__(self) -> str:
        return f"<softcd.AnswerLists, {len(self.all)} answers to {len(self)} questions>"


class IntersectionRegions(Sequence[np.void]):
    """Regions of surfaces on the wrong side, as structured arrays: a sequence of the rows of `regions`."""

    def __init__(self, *arrays: Any) -> None:
        self.regions, self.vertices, self.triangles, self.region_curves, self.curves, self.points = arrays[:6]
        self.touching_pairs: int = arrays[6]
        """How many pairs of intersecting triangles only touch."""

    def __len__(self) -> int:
        return len(self.regions)

    def __getitem__(self, region: Any) -> Any:
        return self.regions[region]

    def vertices_of(self, region: int) -> np.ndarray:
        """Returns the region's vertices: `vertex`, and the way out, `direction` and `distance`."""
        return self._part(self.vertices, self.regions[region], "first_vertex", "vertex_count")

    def triangles_of(self, region: int) -> np.ndarray:
        """Returns the region's triangles."""
        return self._part(self.triangles, self.regions[region], "first_triangle", "triangle_count")

    def curves_of(self, region: int) -> np.ndarray:
        """Returns the curves that bound the region."""
        return self.curves[self._part(self.region_curves, self.regions[region], "first_curve", "curve_count")]

    def points_of(self, curve: int) -> np.ndarray:
        """Returns the points of a row of `curves`, in the order of the curve."""
        return self._part(self.points, self.curves[curve], "first_point", "point_count")

    @staticmethod
    def _part(array: np.ndarray, row: np.void, first: str, count: str) -> np.ndarray:
        begin = int(row[first])
        return array[begin : begin + int(row[count])]

    def __repr__(self) -> str:
        return f"<softcd.IntersectionRegions, {len(self.regions)} regions, {len(self.curves)} curves>"


class Questions:
    """Spatial questions about bodies, in batches: one result or one list for each question.

    Points and directions are of shape (n, 3), or (3,) for one, or one for all; numbers are of shape (n,), or one number
    for all. Answers are structured arrays of their own.
    """

    def __init__(self, core: Any) -> None:
        self._core = core

    def first_hits(
        self, origins: Numbers, directions: Numbers, t_min: Numbers = 0.0, t_max: Numbers = np.inf
    ) -> np.ndarray:
        """Finds the first triangle that each ray origin + t * direction, t_min <= t <= t_max, meets: `body`,
        `triangle`, `t`, `weights` of the triangle's vertices, and its unit `normal`."""
        return self._core.first_hits(self._rays(origins, directions, t_min, t_max))

    def all_hits(
        self, origins: Numbers, directions: Numbers, t_min: Numbers = 0.0, t_max: Numbers = np.inf
    ) -> AnswerLists:
        """Finds all triangles that each ray meets, in the order of t, then of bodies and triangles."""
        return AnswerLists(*self._core.all_hits(self._rays(origins, directions, t_min, t_max)))

    @staticmethod
    def _rays(origins: Numbers, directions: Numbers, t_min: Numbers, t_max: Numbers) -> np.ndarray:
        return _batch(origins=(origins, (3,)), directions=(directions, (3,)), t_min=(t_min, ()), t_max=(t_max, ()))

    def closest_points(self, points: Numbers, max_distance: Numbers = np.inf) -> np.ndarray:
        """Finds the nearest point of all triangles within max_distance: `body`, `triangle`, `position`, `distance`,
        `weights` of the triangle's vertices, and `side`. On a closed surface, `side` is 1 where normals point to and -1
        opposite; else it is 0."""
        return self._core.closest_points(_batch(points=(points, (3,)), max_distance=(max_distance, ())))

    def sphere_overlaps(self, centres: Numbers, radii: Numbers) -> AnswerLists:
        """Finds all triangles that have a point in common with each sphere: `body` and `triangle`, in their order."""
        return AnswerLists(*self._core.sphere_overlaps(_batch(centres=(centres, (3,)), radii=(radii, ()))))

    def capsule_overlaps(self, starts: Numbers, ends: Numbers, radii: Numbers) -> AnswerLists:
        """Finds all triangles that overlap capsules: all points at most a radius from the segments starts to ends."""
        batch = _batch(starts=(starts, (3,)), ends=(ends, (3,)), radii=(radii, ()))
        return AnswerLists(*self._core.capsule_overlaps(batch))

    def box_overlaps(self, lows: Numbers, highs: Numbers) -> AnswerLists:
        """Finds all triangles that overlap boxes, given by their lowest and highest coordinates."""
        return AnswerLists(*self._core.box_overlaps(_batch(lows=(lows, (3,)), highs=(highs, (3,)))))

    def oriented_box_overlaps(self, centres: Numbers, halves: Numbers, axes: Numbers) -> AnswerLists:
        """Finds all triangles that overlap oriented boxes. halves has half their extent along each of three axes. axes,
        of shape (n, 3, 3), has the axes as rows: unit vectors at right angles to each other."""
        batch = _batch(centres=(centres, (3,)), halves=(halves, (3,)), axes=(axes, (3, 3)))
        return AnswerLists(*self._core.oriented_box_overlaps(batch))

    def hull_overlaps(self, points: Numbers, begins: Numbers | None = None, radii: Numbers = 0.0) -> AnswerLists:
        """Finds all triangles that are at most a radius from convex hulls. Hull i has the points begins[i] up to, but
        without, begins[i + 1], in any order; without points it is empty. begins, integers of shape (n + 1,), lead
        from 0 to the number of points, as AnswerLists.begins do. Without begins all points are one hull."""
        corners = _numbers("points", points, (3,)).reshape(-1, 3)
        places = np.array([0, len(corners)]) if begins is None else _array("begins", begins)
        return AnswerLists(*self._core.hull_overlaps(corners, places, _numbers("radii", radii, ())))

    def distances(self, pairs: BodyPairs) -> np.ndarray:
        """Finds the nearest points of a triangle of a and a triangle of b for each pair (a, b) of different bodies:
        `body_a`, `triangle_a`, `position_a`, `weights_a`, the same of b, and `distance`, exactly 0 where they
        intersect. None stands for all bodies. Takes time for each triangle of a, so the smaller body should be a."""
        return self._core.distances(pairs)

    def distance(self, a: int | None, b: int | None) -> np.void:
        """Finds the nearest points of one pair."""
        return self.distances([(a, b)])[0]

    def intersections(self, pairs: BodyPairs = ((None, None),)) -> AnswerLists:
        """Finds all intersecting triangles of a and b for each pair (a, b): `body_a`, `triangle_a`, `body_b`,
        `triangle_b`. The decision is exact for the positions as given, float32 or float64. Where a is b, it finds
        intersections within the body. Where both are None, the default, it compares all bodies with each other and
        with themselves. Each intersection is reported once, in the order of the first, then of the second triangle."""
        return AnswerLists(*self._core.intersections(pairs))

    def has_intersections(self, a: int | None = None, b: int | None = None) -> bool:
        """Returns whether intersections() would find one. Stops at the first one."""
        return self._core.has_intersections(a, b)


class Probe(Questions):
    """Answers spatial questions about a scene's bodies, in batches: one result or one list for each question.

    Kinematic bodies count too; groups, masks and margins do not. Bodies whose positions were never set are left
    out, and so are triangles with a vertex that is not finite. Every call reads positions that were set, and waits for
    a running detection. Points and directions are of shape (n, 3), or (3,) for one, or one for all; numbers are of
    shape (n,), or one number for all.

    Answers are structured arrays of their own. Where there is none `body` is softcd.NO_BODY.
    """

    def __init__(self, scene: Scene, *, step_end: StepEnd | str = StepEnd.t1) -> None:
        super().__init__(_core.Probe(scene, step_end))

    def intersection_regions(self, a: int | None = None, b: int | None = None) -> IntersectionRegions:
        """Finds the curves along which surfaces intersect, the regions of each surface that are on the wrong side, and
        the way out for their vertices; also surfaces that are whole inside a closed one. The bodies and the precision
        are those of intersections(); by default it compares all."""
        return IntersectionRegions(*self._core.intersection_regions(a, b))

    def intersections_after(self, changes: Sequence[MeshChange]) -> AnswerLists:
        """Finds the triangles that each change's new triangles would intersect. `added` is the new triangle's index.
        `body` and `triangle` are one of the remaining triangles or, with softcd.NO_BODY, a later one of the new ones.
        Each change is judged alone, with the scene as it is, and for positions rounded to float32."""
        return AnswerLists(*self._core.intersections_after(changes))

    def set_body_filter(self, filter: Callable[[int], bool] | None) -> None:
        """Sets the function filter(body) that every later call asks whether a body with positions counts; None excludes
        no body. It must not call the scene, its queries or probes."""
        self._core.set_body_filter(filter)
