"""Audits a vertex-triangle test in NVIDIA Warp, in float32, over its mesh queries: pip install warp-lang."""

# Types in kernels are Warp's, which pyright does not know:
# pyright: reportArgumentType=false, reportOperatorIssue=false

import numpy as np
import warp as wp

import softcd

DISTANCE = 0.05
MOST_FACES = 256  # of a vertex


@wp.func
def to_segment(p: wp.vec3, a: wp.vec3, b: wp.vec3):
    share = wp.clamp(wp.dot(p - a, b - a) / wp.dot(b - a, b - a), 0.0, 1.0)
    return wp.length(p - a - share * (b - a))


@wp.func
def to_triangle(p: wp.vec3, x0: wp.vec3, x1: wp.vec3, x2: wp.vec3):
    a, b, c = p - x0, x1 - x0, x2 - x0
    n = wp.cross(b, c)
    first, second = wp.dot(wp.cross(a, c), n) / wp.dot(n, n), wp.dot(wp.cross(b, a), n) / wp.dot(n, n)
    if first > 0.0 and second > 0.0 and first + second < 1.0:
        return wp.abs(wp.dot(a, wp.normalize(n)))
    return wp.min(to_segment(p, x0, x1), wp.min(to_segment(p, x1, x2), to_segment(p, x2, x0)))


@wp.kernel
def near_faces(mesh: wp.uint64, reach: float, found: wp.array[wp.int32]):
    vertex = wp.tid()
    m = wp.mesh_get(mesh)
    p = m.points[vertex]
    query = wp.mesh_query_aabb(mesh, p - wp.vec3(reach), p + wp.vec3(reach))
    face = int(0)
    count = int(0)
    while wp.mesh_query_aabb_next(query, face):
        i, j, k = m.indices[3 * face], m.indices[3 * face + 1], m.indices[3 * face + 2]
        if vertex != i and vertex != j and vertex != k:
            if to_triangle(p, m.points[i], m.points[j], m.points[k]) <= reach:
                found[vertex * MOST_FACES + count] = face  # type: ignore
                count += 1


def main():
    random = np.random.default_rng(0)
    for offset in (0.0, 1000.0):
        corners = 4 * random.random((3000, 1, 3)) + 0.3 * (random.random((3000, 3, 3)) - 0.5)
        x = (corners.reshape(-1, 3) + offset).astype(np.float32)
        triangles = np.arange(len(x)).reshape(-1, 3)
        with wp.ScopedDevice("cpu"):
            mesh = wp.Mesh(wp.array(x, dtype=wp.vec3), wp.array(triangles.ravel(), dtype=wp.int32))
            found = wp.full(len(x) * MOST_FACES, -1, dtype=wp.int32)
            wp.launch(near_faces, len(x), [mesh.id, DISTANCE, found])
            faces = found.numpy().reshape(len(x), MOST_FACES)
        vertex, place = np.nonzero(faces >= 0)
        pairs = np.stack([vertex, faces[vertex, place]], axis=1)
        audit = softcd.audit(x, triangles, vertex_triangle_pairs=pairs, margin=DISTANCE / 2, tolerance=0)
        print(f"offset {offset}:", audit)


if __name__ == "__main__":
    main()
