"""Meshes for the tests."""

import numpy as np


def soup(seed, triangle_count=24, size=0.5):
    """Returns positions and indices of triangles in the unit cube that share no vertex."""
    random = np.random.default_rng(seed)
    corners = random.random((triangle_count, 1, 3)) + size * (random.random((triangle_count, 3, 3)) - 0.5)
    return corners.reshape(-1, 3), np.arange(3 * triangle_count, dtype=np.uint32).reshape(-1, 3)


def sheet(side):
    """Returns a flat square of side * side vertices in the plane z = 0."""
    x, y = np.meshgrid(np.arange(side, dtype=float), np.arange(side, dtype=float), indexing="ij")
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(side * side)], axis=1)
    corner = np.arange(side * side).reshape(side, side)
    a, b, c, d = (corner[i : side - 1 + i, j : side - 1 + j].ravel() for i in (0, 1) for j in (0, 1))
    return vertices, np.concatenate([np.stack([a, c, b], axis=1), np.stack([b, c, d], axis=1)]).astype(np.uint32)


def write_ply(path, vertices, triangles):
    header = f"ply\nformat ascii 1.0\nelement vertex {len(vertices)}\n"
    header += "".join(f"property double {axis}\n" for axis in "xyz")
    header += f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    rows = [" ".join(map(repr, row)) for row in vertices.tolist()]
    rows += [f"3 {a} {b} {c}" for a, b, c in triangles.tolist()]
    path.write_text(header + "\n".join(rows) + "\n")


# Two triangles side by side: vertex 3 passes through the first at half of the step.
PIERCING_TRIANGLES = np.array([[0, 1, 2], [3, 4, 5]], np.uint32)
PIERCING_T0 = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, 1], [1, 1.5, 8], [1.5, 1, 8]], float)
PIERCING_T1 = PIERCING_T0.copy()
PIERCING_T1[3, 2] = -1
