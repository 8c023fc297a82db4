"""Tests all pairs of features one by one, in float64. Shares no code with the library."""

import itertools

import numpy as np

VERTEX_TRIANGLE, EDGE_EDGE = 0, 1
STEP = 1e-6  # of finite differences; their error is about STEP**2 + 1e-16 / STEP


def edges_of(triangles):
    return sorted({tuple(sorted(pair)) for t in triangles.tolist() for pair in itertools.combinations(t, 2)})


def candidates(triangles):
    """Yields (kind, four vertices) of each pair of a mesh's features that share no vertex."""
    faces = triangles.tolist()
    for vertex, face in itertools.product(sorted({v for t in faces for v in t}), faces):
        if vertex not in face:
            yield VERTEX_TRIANGLE, (vertex, *face)
    for a, b in itertools.combinations(edges_of(triangles), 2):
        if not set(a) & set(b):
            yield EDGE_EDGE, (*a, *b)


def segment_distance(p, q, r, s):
    """Returns the distance of two segments: that of an end of one, or that of the lines."""
    ends = [point_segment_distance(p, r, s), point_segment_distance(q, r, s)]
    ends += [point_segment_distance(r, p, q), point_segment_distance(s, p, q)]
    u, v, w = q - p, s - r, r - p
    matrix = np.array([[u @ u, -(u @ v)], [-(u @ v), v @ v]])
    if abs(np.linalg.det(matrix)) > 1e-30:
        a, b = np.linalg.solve(matrix, [u @ w, -(v @ w)])
        if 0 <= a <= 1 and 0 <= b <= 1:
            ends.append(np.linalg.norm(p + a * u - r - b * v))
    return min(ends)


def point_segment_distance(p, a, b):
    along = np.clip((p - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
    return np.linalg.norm(p - a - along * (b - a))


def point_triangle_distance(p, a, b, c):
    weights = np.linalg.lstsq(np.stack([b - a, c - a], axis=1), p - a, rcond=None)[0]
    if (weights >= 0).all() and weights.sum() <= 1:
        return np.linalg.norm(p - a - weights @ [b - a, c - a])
    return min(point_segment_distance(p, *side) for side in ((a, b), (b, c), (c, a)))


def distance(kind, x):
    return point_triangle_distance(*x) if kind == VERTEX_TRIANGLE else segment_distance(*x)


def first_touch(kind, x_t0, x_t1):
    """Returns the time at which the moving features meet first, or None."""

    def at(t):
        return x_t0 + t * (x_t1 - x_t0)

    def volume(t):
        a, b, c, d = at(t)
        return np.linalg.det([b - a, c - a, d - a])

    # The volume is a cubic in t. Four values determine it.
    nodes = np.array([0, 1 / 3, 2 / 3, 1])
    roots = np.roots(np.polyfit(nodes, [volume(t) for t in nodes], 3))
    times = sorted(t.real for t in roots if abs(t.imag) < 1e-9 and 0 <= t.real <= 1)
    return next((t for t in times if distance(kind, at(t)) < 1e-7), None)


def finite_differences(function, x):
    """Differentiates function(x), a value for each pair, by each coordinate of the pairs, centrally."""
    result = np.empty(x.shape)
    for corner, axis in np.ndindex(4, 3):
        offset = np.zeros((4, 3))
        offset[corner, axis] = STEP
        result[:, corner, axis] = (function(x + offset) - function(x - offset)) / (2 * STEP)
    return result
