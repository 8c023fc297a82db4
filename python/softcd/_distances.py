"""Distances of pairs of features, written once for every package that differentiates: softcd.torch and softcd.jax.

Each passes its functions, by the names of Functions, and the edges of pairs of one kind: see edges_of().
"""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

Array = Any
"""A package's own."""


class Functions(Protocol):
    """The functions of a package that arrays lack. `axis` counts from 0."""

    def where(self, condition: Array, a: Any, b: Any, /) -> Array: ...
    def cross(self, a: Array, b: Array, /) -> Array: ...
    def stack(self, arrays: list[Array], /) -> Array:
        """Stacks columns of shape (k,) to (k, n)."""
        ...

    def clip(self, values: Array, /) -> Array:
        """Limits to [0, 1]."""
        ...

    def pick(self, values: Array, place: Array, /) -> Array:
        """Returns values[i, place[i]] for each i."""
        ...

    def constant(self, values: Array, /) -> Array:
        """Returns the values without their derivatives."""
        ...

    def zeros(self, values: Array, /) -> Array:
        """Returns zeros of the values' shape and type."""
        ...

    def largest(self, arrays: list[Array], /) -> Array:
        """Returns the largest absolute value in the rows of all arrays, of shape (k,)."""
        ...

    def eps(self, values: Array, /) -> float: ...
    def length(self, a: Array, b: Array, c: Array, s: Array, t: Array, normal: Array, signed: bool, /) -> Array:
        """Returns difference_of() as a length, with the derivatives of unit_of(): without those of s and t."""
        ...


class Pairs(NamedTuple):
    """A row for each pair: see softcd.torch.Distances."""

    length: Array
    mollifier: Array
    weights: Array


def dot(a: Array, b: Array) -> Array:
    """Returns the products of rows."""
    return (a * b).sum(axis=-1)


def difference_of(a: Array, b: Array, c: Array, s: Array, t: Array) -> Array:
    """Returns the difference of the nearest points."""
    return a - s[..., None] * b - t[..., None] * c


def length_of(fn: Functions, difference: Array, normal: Array, signed: bool) -> Array:
    """Returns the length of the difference, negative where it is signed and against the normal."""
    squared = dot(difference, difference)
    length = fn.where(squared > 0, fn.where(squared > 0, squared, 1) ** 0.5, 0)
    return fn.where(dot(difference, normal) < 0, -length, length) if signed else length


def unit_of(fn: Functions, difference: Array, normal: Array, signed: bool) -> Array:
    """Returns the derivative of the length by the difference. To first order the length does not depend on s and t.
    Their derivatives would only add roundings: large ones where edges are nearly parallel."""
    squared = dot(difference, difference)[..., None]
    unit = difference / fn.where(squared > 0, squared, 1) ** 0.5
    if signed:
        unit = fn.where(dot(difference, normal)[..., None] < 0, -unit, unit)
    return fn.where(squared > 0, unit, normal)


def edges_of(p: Array, is_face: bool) -> tuple[Array, Array, Array]:
    """Returns a, b, c such that the nearest points differ by a - s b - t c: a vertex and s + t <= 1 on a triangle, or
    s and t in [0, 1] along two edges. p has the positions of each pair's four vertices."""
    if is_face:
        return p[:, 0] - p[:, 1], p[:, 2] - p[:, 1], p[:, 3] - p[:, 1]
    return p[:, 0] - p[:, 2], p[:, 0] - p[:, 1], p[:, 3] - p[:, 2]


def pairs_of_one_kind(
    fn: Functions, p: Array, is_face: bool, normal: Array, signed: bool, rest: Array | None
) -> Pairs:
    """Computes pairs of one kind. `rest` has their vertices' positions at rest, as p, or is None."""
    a, b, c = edges_of(p, is_face)
    # Scales edges to size 1, so that no power of a length overflows or vanishes.
    scale = fn.constant(fn.largest([a, b, c]))[:, None]
    scale = fn.where(scale > 0, scale, 1)
    a, b, c = a / scale, b / scale, c / scale
    s, t = nearest(fn, a, b, c, is_face)
    length = fn.length(a, b, c, s, t, normal, signed) * scale[:, 0]
    one = fn.zeros(s) + 1
    if is_face:
        return Pairs(length, one, fn.stack([one, 1 - s - t, s, t]))
    rest_b, rest_c = (b, c) if rest is None else (edge / scale for edge in edges_of(rest, False)[1:])
    return Pairs(length, mollifier(fn, b, c, rest_b, rest_c), fn.stack([1 - s, s, 1 - t, t]))


def quotient(fn: Functions, a: Array, b: Array, least: Any = 0.0) -> Array:
    """Divides. Where b is at most `least` the result is a: derivatives must be finite where nothing uses them, too."""
    return a / fn.where(b > least, b, 1)


def nearest(fn: Functions, a: Array, b: Array, c: Array, is_face: bool) -> tuple[Array, Array]:
    """Returns the s and t of the nearest points: the best of those inside and those on each side of the domain."""
    n = fn.cross(b, c)
    area = dot(n, n)
    # Below this the normal is nothing but rounding: b and c are parallel, or points.
    eps = fn.eps(a)
    least = 16 * eps**2 * dot(b, b) * dot(c, c)
    inner_s = quotient(fn, dot(fn.cross(a, c), n), area, least)
    inner_t = quotient(fn, dot(fn.cross(b, a), n), area, least)
    is_inside = (area > least) & (inner_s >= 0) & (inner_t >= 0)
    is_inside &= (inner_s + inner_t <= 1) if is_face else ((inner_s <= 1) & (inner_t <= 1))

    def on_side(from_start: Array, side: Array) -> Array:
        return fn.clip(quotient(fn, dot(from_start, side), dot(side, side), eps**2))

    zero, one = fn.zeros(inner_s), fn.zeros(inner_s) + 1
    candidates = [(inner_s, inner_t), (on_side(a, b), zero), (zero, on_side(a, c))]
    if is_face:
        share = on_side(a - b, c - b)
        candidates.append((1 - share, share))
    else:
        candidates += [(on_side(a - c, b), one), (one, on_side(a - b, c))]
    differences = [fn.constant(difference_of(a, b, c, *candidate)) for candidate in candidates]
    squares = [dot(difference, difference) for difference in differences]
    squares[0] = fn.where(is_inside, squares[0], float("inf"))
    best = fn.stack(squares).argmin(1)
    s, t = (fn.pick(fn.stack(list(values)), best) for values in zip(*candidates))
    return s, t


def mollifier(fn: Functions, b: Array, c: Array, rest_b: Array, rest_c: Array) -> Array:
    """Returns IPC's factor for nearly parallel edges: see softcd.torch.distances()."""
    n = fn.cross(b, c)
    share = quotient(fn, dot(n, n), 1e-3 * dot(rest_b, rest_b) * dot(rest_c, rest_c))
    return fn.where(share < 1, share * (2 - share), 1)
