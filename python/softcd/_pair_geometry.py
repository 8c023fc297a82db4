"""Distances and crossings of single pairs of features, in float64 and without the library: what softcd.audit judges by.

A pair is four vertices, an array of shape (k, 4, 3) for k pairs of one kind: a vertex and a triangle's three, or two of
each edge.
"""

from __future__ import annotations

from typing import Any

import numpy as np

_ROUNDING = np.finfo(np.float64).eps


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("...i,...i->...", a, b)


def _quotient(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Divides. The result is 0 where b is not positive."""
    return np.divide(a, b, out=np.zeros_like(a), where=b > 0)


def _squared_point_segment(p: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    edge = b - a
    weight = np.clip(_quotient(_dot(p - a, edge), _dot(edge, edge)), 0, 1)
    difference = p - a - weight[:, None] * edge
    return _dot(difference, difference)


def _edges_of_pair(x: np.ndarray, is_vertex_triangle: bool) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Returns a, b, c: from b's side to a's, and two edges. Features touch where a is a sum of shares of b and c."""
    if is_vertex_triangle:
        return x[:, 0] - x[:, 1], x[:, 2] - x[:, 1], x[:, 3] - x[:, 1]
    return x[:, 0] - x[:, 2], x[:, 1] - x[:, 0], x[:, 3] - x[:, 2]


def distances(x: np.ndarray, is_vertex_triangle: bool) -> np.ndarray:
    """Returns the distance of each pair's features."""
    a, b, c = _edges_of_pair(x, is_vertex_triangle)
    normal = np.cross(b, c)
    area = _dot(normal, normal)
    first = _quotient(_dot(np.cross(a, c), normal), area)
    second = _quotient(_dot(np.cross(b, a), normal), area)
    if is_vertex_triangle:
        is_inside = (area > 0) & (first >= 0) & (second >= 0) & (first + second <= 1)
        difference = a - first[:, None] * b - second[:, None] * c
        ends = [(0, 1, 2), (0, 2, 3), (0, 3, 1)]
    else:
        first = -first
        is_inside = (area > 0) & (first >= 0) & (first <= 1) & (second >= 0) & (second <= 1)
        difference = a + first[:, None] * b - second[:, None] * c
        ends = [(0, 2, 3), (1, 2, 3), (2, 0, 1), (3, 0, 1)]
    squared = np.where(is_inside, _dot(difference, difference), np.inf)
    for p, q, r in ends:
        np.minimum(squared, _squared_point_segment(x[:, p], x[:, q], x[:, r]), out=squared)
    return np.sqrt(squared)


_SAMPLES = 9
_GOLDEN_STEPS = 26  # narrow a sampled interval to 1e-6 of the step
_PAIRS_AT_ONCE = 1 << 14


def nearest_approach(x_t0: np.ndarray, x_t1: np.ndarray, is_vertex_triangle: bool, hints: np.ndarray) -> np.ndarray:
    """Returns the smallest distance that a search finds during each pair's step: never less than the true one, and at
    most the distance at the pair's hint, a time in [0, 1]."""
    parts = [slice(begin, begin + _PAIRS_AT_ONCE) for begin in range(0, len(x_t0), _PAIRS_AT_ONCE)]
    nearest = [_nearest_approach(x_t0[part], x_t1[part], is_vertex_triangle, hints[part]) for part in parts]
    return np.concatenate([np.empty(0), *nearest])


def _nearest_approach(x_t0: np.ndarray, x_t1: np.ndarray, is_vertex_triangle: bool, hints: np.ndarray) -> np.ndarray:
    # From the first vertex on: as accurate as the positions, however far they are from the origin.
    x_t0, x_t1 = x_t0 - x_t0[:, :1], x_t1 - x_t1[:, :1]

    def at(t: np.ndarray) -> np.ndarray:
        share = t[:, None, None]
        return distances((1 - share) * x_t0 + share * x_t1, is_vertex_triangle)

    # Searches around the best of equidistant times and the hint, by golden sections.
    times = np.stack([*(np.full(len(x_t0), t) for t in np.linspace(0, 1, _SAMPLES)), hints])
    values = np.array([at(t) for t in times])
    best = np.take_along_axis(times, values.argmin(axis=0)[None], axis=0)[0]
    nearest = values.min(axis=0)
    low, high = np.maximum(best - 1 / (_SAMPLES - 1), 0), np.minimum(best + 1 / (_SAMPLES - 1), 1)
    share = (np.sqrt(5) - 1) / 2
    left, right = high - share * (high - low), low + share * (high - low)
    at_left, at_right = at(left), at(right)
    for _ in range(_GOLDEN_STEPS):
        nearest = np.minimum(nearest, np.minimum(at_left, at_right))
        is_left = at_left < at_right
        low, high = np.where(is_left, low, left), np.where(is_left, right, high)
        probe = np.where(is_left, high - share * (high - low), low + share * (high - low))
        at_probe = at(probe)
        left, right = np.where(is_left, probe, right), np.where(is_left, left, probe)
        at_left, at_right = np.where(is_left, at_probe, at_right), np.where(is_left, at_left, at_probe)
    return nearest


def _cross_quadratic(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Multiplies two vectors that are linear in t, of shape (2, n, 3): Bernstein coefficients of p x q."""
    middle = np.cross(p[0], q[1]) + np.cross(p[1], q[0])
    return np.stack([np.cross(p[0], q[0]), middle / 2, np.cross(p[1], q[1])])


def _dot_cubic(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Multiplies a linear and a quadratic vector: Bernstein coefficients of p . q."""
    second = (2 * _dot(p[0], q[1]) + _dot(p[1], q[0])) / 3
    third = (_dot(p[0], q[2]) + 2 * _dot(p[1], q[1])) / 3
    return np.stack([_dot(p[0], q[0]), second, third, _dot(p[1], q[2])])


def _dot_quartic(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Multiplies two quadratic vectors: Bernstein coefficients of p . q."""
    second, fourth = (_dot(p[i], q[i + 1]) + _dot(p[i + 1], q[i]) for i in (0, 1))
    third = (_dot(p[0], q[2]) + 4 * _dot(p[1], q[1]) + _dot(p[2], q[0])) / 6
    return np.stack([_dot(p[0], q[0]), second / 2, third, fourth / 2, _dot(p[2], q[2])])


_MAX_HALVINGS = 64


def certainly_cross(x_t0: np.ndarray, x_t1: np.ndarray, is_vertex_triangle: bool, slack: float) -> np.ndarray:
    """Returns which pairs meet during their step, however each vertex is moved by up to `slack` at each time.

    The four vertices are coplanar where the volume a . (b x c) is 0. The search halves the step until, on an interval,
    the volume's ends have different signs and the coplanar point is inside of both features throughout. Both have to
    hold by more than the moved vertices can change. Polynomials lie between their Bernstein coefficients.
    """
    certain = np.zeros(len(x_t0), bool)
    pair = np.arange(len(x_t0))
    low, high = np.zeros(len(pair)), np.ones(len(pair))
    for _ in range(_MAX_HALVINGS):
        if len(pair) == 0:
            break
        volume, inside, volume_error, inside_error = _volume_and_weights(
            x_t0[pair], x_t1[pair], is_vertex_triangle, low, high, slack
        )
        ends_differ = (np.minimum(volume[0], volume[3]) < -volume_error) & (
            np.maximum(volume[0], volume[3]) > volume_error
        )
        is_inside = (inside.min(axis=1) > inside_error).all(axis=0)
        certain[pair[ends_differ & is_inside]] = True
        may_cross = (volume.min(axis=0) < -volume_error) & (volume.max(axis=0) > volume_error)
        may_be_inside = (inside.max(axis=1) > inside_error).all(axis=0)
        kept = may_cross & may_be_inside & ~certain[pair]
        pair, low, high, volume = pair[kept], low[kept], high[kept], volume[:, kept]
        split = low + _split_share(volume) * (high - low)
        pair = np.concatenate([pair, pair])
        low, high = np.concatenate([low, split]), np.concatenate([split, high])
    return certain


def _split_share(volume: np.ndarray) -> np.ndarray:
    """Chooses where to split: where the volume is far from 0, as no interval that ends at a root can be decided."""
    shares = np.array([0.5, 0.4, 0.6])
    bernstein = np.stack([(1 - shares) ** 3, 3 * shares * (1 - shares) ** 2, 3 * shares**2 * (1 - shares), shares**3])
    return shares[np.abs(bernstein.T @ volume).argmax(axis=0)]


def _volume_and_weights(
    x_t0: np.ndarray, x_t1: np.ndarray, is_vertex_triangle: bool, low: np.ndarray, high: np.ndarray, slack: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Returns Bernstein coefficients on [low, high] of the volume, and of values that are positive exactly if the
    coplanar point is inside of both features, with the most that moved vertices and rounding change of each."""
    sides = zip(_edges_of_pair(x_t0, is_vertex_triangle), _edges_of_pair(x_t1, is_vertex_triangle))
    a, b, c = (np.stack([(1 - t)[:, None] * t0 + t[:, None] * t1 for t in (low, high)]) for t0, t1 in sides)
    normal, over_b, over_c = _cross_quadratic(b, c), _cross_quadratic(a, c), _cross_quadratic(b, a)
    volume = _dot_cubic(a, normal)
    area, first, second = (_dot_quartic(product, normal) for product in (normal, over_b, over_c))
    if is_vertex_triangle:
        inside = [first, second, area - first - second]
    else:
        inside = [-first, area + first, second, area - second]

    # The most that each value changes when a, b and c each change by twice the slack, and by rounding.
    length_a, length_b, length_c, of_normal, of_b, of_c = (
        np.sqrt(_dot(v, v).max(axis=0)) for v in (a, b, c, normal, over_b, over_c)
    )
    step = 2 * slack

    def product_error(length: np.ndarray, error: Any, other: np.ndarray, other_error: Any) -> np.ndarray:
        return length * other_error + other * error + error * other_error

    def cross_error(p: np.ndarray, q: np.ndarray) -> np.ndarray:
        return product_error(p, step, q, step) + 16 * _ROUNDING * p * q

    normal_error = cross_error(length_b, length_c)
    volume_error = product_error(length_a, step, of_normal, normal_error)
    area_error = product_error(of_normal, normal_error, of_normal, normal_error)
    first_error = product_error(of_b, cross_error(length_a, length_c), of_normal, normal_error)
    second_error = product_error(of_c, cross_error(length_b, length_a), of_normal, normal_error)
    if is_vertex_triangle:
        errors = [first_error, second_error, area_error + first_error + second_error]
    else:
        errors = [first_error, area_error + first_error, second_error, area_error + second_error]
    rounding = 64 * _ROUNDING * length_b * length_c
    volume_error += rounding * length_a
    inside_error = np.stack(errors) + rounding * (length_a + length_b) * (length_a + length_c)
    return volume, np.stack(inside), volume_error, inside_error
