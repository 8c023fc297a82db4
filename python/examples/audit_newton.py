"""Audits the mesh collision detector of Newton's VBD solver, in float32, on the CPU: pip install newton.

The detector finds vertices and triangles, and edges, that are within a distance. It is no public part of Newton, and
was read in version 1.8.0.
"""

import newton
import numpy as np
import warp as wp
from newton._src.geometry.tri_mesh_collision import TriMeshCollisionDetector

import softcd

DISTANCE = 0.05


def detector_of(x, triangles):
    """Returns Newton's detector for a mesh, with lists that are long enough."""
    builder = newton.ModelBuilder()
    builder.add_cloth_mesh(
        pos=wp.vec3(), rot=wp.quat_identity(), scale=1.0, vel=wp.vec3(), vertices=[wp.vec3(*each) for each in x],
        indices=triangles.ravel().tolist(), density=1.0, tri_ke=0.0, tri_ka=0.0, tri_kd=0.0)  # fmt: skip
    return TriMeshCollisionDetector(
        builder.finalize(device="cpu"), init_collision_info=True, vertex_collision_buffer_pre_alloc=128,
        edge_collision_buffer_pre_alloc=256)  # fmt: skip


def pairs_in(found):
    """Returns the pairs of a flat list in which unused places are -1."""
    pairs = found.numpy().reshape(-1, 2)
    return pairs[(pairs >= 0).all(axis=1)]


random = np.random.default_rng(0)
for offset in (0.0, 1000.0):
    corners = 4 * random.random((3000, 1, 3)) + 0.3 * (random.random((3000, 3, 3)) - 0.5)
    x = (corners.reshape(-1, 3) + offset).astype(np.float32)
    triangles = np.arange(len(x)).reshape(-1, 3)
    detector = detector_of(x, triangles)
    detector.vertex_triangle_collision_detection(DISTANCE)
    detector.edge_edge_collision_detection(DISTANCE)
    assert not detector.resize_flags.numpy().any(), "lists are long enough"
    audit = softcd.audit(
        x,
        triangles,
        vertex_triangle_pairs=pairs_in(detector.vertex_colliding_triangles),
        edge_edge_pairs=pairs_in(detector.edge_colliding_edges),
        edges=detector.model.edge_indices.numpy()[:, 2:],
        margin=DISTANCE / 2,
    )
    print(f"offset {offset}:", audit)
