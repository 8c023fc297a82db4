"""Audits a vertex-triangle test as many programs have it: in float32, by signs of the volume at sampled times."""

import numpy as np
import softcd

SIDE = 24


def crumpled_cloth(random):
    """Returns two frames of a folded cloth whose vertices move at random, and its triangles."""
    x, y = np.meshgrid(np.arange(SIDE), np.arange(SIDE), indexing="ij")
    folded = np.stack([x.ravel(), np.minimum(y, SIDE - y).ravel(), 0.02 * y.ravel()], axis=1)
    frames = [(folded + 0.3 * random.normal(size=folded.shape)).astype(np.float32) for _ in range(2)]
    corner = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    a, b, c, d = (corner[i : SIDE - 1 + i, j : SIDE - 1 + j].ravel() for i in (0, 1) for j in (0, 1))
    return *frames, np.concatenate([np.stack([a, c, b], axis=1), np.stack([b, c, d], axis=1)])


def candidates(frames, triangles):
    """Returns all vertices and triangles whose swept boxes overlap and that share no vertex."""
    points, corners = np.stack(frames), np.stack([frame[triangles] for frame in frames])
    low, high = corners.min(axis=(0, 2)), corners.max(axis=(0, 2))
    overlap = (points.max(axis=0)[:, None] >= low).all(axis=2) & (points.min(axis=0)[:, None] <= high).all(axis=2)
    vertex, triangle = np.nonzero(overlap)
    is_apart = (triangles[triangle] != vertex[:, None]).all(axis=1)
    return vertex[is_apart], triangle[is_apart]


def float32_test(frames, triangles, vertex, triangle, sample_count=5):
    """Returns which pairs meet: the volume changes its sign between samples, and the vertex is inside just then."""
    x = np.stack([np.concatenate([f[vertex][:, None], f[triangles[triangle]]], axis=1) for f in frames])

    def at(t):
        v, f0, f1, f2 = np.moveaxis(x[0] + t[:, None, None] * (x[1] - x[0]), 1, 0)
        a, b, c = v - f0, f1 - f0, f2 - f0
        n = np.cross(b, c)
        area = (n * n).sum(axis=1)
        first, second = ((np.cross(p, q) * n).sum(axis=1) / area for p, q in ((a, c), (b, a)))
        return (a * n).sum(axis=1), (first >= 0) & (second >= 0) & (first + second <= 1)

    meets = np.zeros(len(vertex), bool)
    times = np.linspace(0, 1, sample_count, dtype=np.float32)
    for begin, end in zip(times, times[1:]):
        low, high = np.full(len(vertex), begin), np.full(len(vertex), end)
        sign = np.sign(at(low)[0])
        crosses = sign != np.sign(at(high)[0])
        for _ in range(20):
            middle = (low + high) / 2
            is_before = np.sign(at(middle)[0]) == sign
            low, high = np.where(is_before, middle, low), np.where(is_before, high, middle)
        meets |= crosses & at(high)[1]
    return meets


*frames, triangles = crumpled_cloth(np.random.default_rng(1))
vertex, triangle = candidates(frames, triangles)
for sample_count in (2, 5, 65):
    meets = float32_test(frames, triangles, vertex, triangle, sample_count)
    pairs = np.stack([vertex[meets], triangle[meets]], axis=1)
    print(f"{sample_count} samples:", softcd.audit(frames[0], triangles, frames[1], vertex_triangle_pairs=pairs))
