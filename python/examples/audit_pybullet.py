"""Audits PyBullet's steps: counts the nodes and edges of a thrown cloth that pass through a held one.

PyBullet reports no list of what touches. So each step is audited with empty lists: every crossing of the paths that
its nodes took is missed. Counts crossings between the cloths. Prints the totals of 5 steps for both of its worlds.
"""

import numpy as np
import pybullet
import softcd.bullet

from pybullet_common import grid, load_mesh

SIDE, WIDTH, SPEED, STEPS = 11, 1.0, 60, 5
NONE = np.zeros((0, 2), int)


def throw(world, settings):
    """Returns how many crossings of vertices with triangles and of edges with edges the steps leave."""
    pybullet.resetSimulation(world)
    pybullet.setTimeStep(1 / 60)
    vertices, triangles = grid(SIDE, WIDTH)
    options = {"mass": 1, "springElasticStiffness": 100, "collisionMargin": 0.02}
    held = load_mesh(vertices, triangles, **options)
    for node in np.flatnonzero(np.abs(vertices).max(axis=1) > 0.49 * WIDTH):
        pybullet.createSoftBodyAnchor(held, int(node), -1, -1)
    thrown = load_mesh(vertices, triangles, basePosition=[0.03, 0.02, 0.5], **options)
    pybullet.resetBaseVelocity(thrown, [0, 0, -SPEED])
    attachment = None if settings is None else softcd.bullet.attach(**settings)
    bodies, crossings = softcd.bullet.SoftBodies(), np.zeros(2, int)
    both = np.concatenate([bodies.faces(held), bodies.faces(thrown) + len(vertices)])

    def positions():
        return np.concatenate([bodies.nodes(body)["position"] for body in (held, thrown)])

    for _ in range(STEPS):
        before = positions()
        pybullet.stepSimulation()
        if attachment is not None:
            attachment.finish_step()
        audit = softcd.audit(before, both, positions(), vertex_triangle_pairs=NONE, edge_edge_pairs=NONE)
        is_held = audit.missed["vertices"] < len(vertices)
        between = audit.missed["kind"][is_held[:, 0] != is_held[:, 3]]
        crossings += np.bincount(between, minlength=2)
    return crossings


pybullet.connect(pybullet.DIRECT)
for name, world in {"soft": 0, "deformable": pybullet.RESET_USE_DEFORMABLE_WORLD}.items():
    for who, settings in {"PyBullet alone": None, "with preset 'safe'": {"preset": "safe"}}.items():
        vt, ee = throw(world, settings)
        print(f"{name} world, {who}: {vt} vertices pass through triangles, {ee} edges through edges")
