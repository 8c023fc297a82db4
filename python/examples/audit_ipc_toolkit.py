"""Audits the continuous tests of IPC Toolkit: pip install ipctk."""

import ipctk
import numpy as np

import softcd


def random_step(random, triangle_count=300):
    """Returns two frames of triangles that fly through each other, and their indices."""
    centres = random.random((2, triangle_count, 1, 3))
    corners = 0.15 * (random.random((2, triangle_count, 3, 3)) - 0.5)
    x_t0, x_t1 = (centres[0] + 0.1 * (centres - 0.5) + corners).reshape(2, -1, 3)
    return x_t0, x_t1, np.arange(3 * triangle_count).reshape(-1, 3)


x_t0, x_t1, triangles = random_step(np.random.default_rng(0))
edges = ipctk.edges(triangles)
mesh = ipctk.CollisionMesh(x_t0, edges, triangles)
candidates = ipctk.Candidates()
candidates.build(mesh, x_t0, x_t1)
print(len(candidates.fv_candidates), "candidates of a face and a vertex,", len(candidates.ee_candidates), "of edges")

for name, ccd in {
    "Tight-Inclusion": ipctk.TightInclusionCCD(),
    "Additive CCD": ipctk.AdditiveCCD(),
}.items():

    def meets(candidate):
        corners = [candidate.dof(x, edges, triangles) for x in (x_t0, x_t1)]
        return candidate.ccd(*corners, narrow_phase_ccd=ccd)[0]

    audit = softcd.audit(
        x_t0,
        triangles,
        x_t1,
        vertex_triangle_pairs=[(c.vertex_id, c.face_id) for c in candidates.fv_candidates if meets(c)],
        edge_edge_pairs=[(c.edge0_id, c.edge1_id) for c in candidates.ee_candidates if meets(c)],
        edges=edges,
    )
    print(f"{name}: {audit}")
    if len(audit.invented):
        print(f"  invented pairs pass at up to {audit.invented['distance'].max():.2g}")
