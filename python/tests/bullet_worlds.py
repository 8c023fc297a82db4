"""PyBullet clients with soft bodies, for tests of softcd.bullet. Tests are skipped where PyBullet or the plugin is not
installed."""

import numpy as np
import pytest

pybullet = pytest.importorskip("pybullet", reason="PyBullet is not installed")

import softcd  # noqa: E402
import softcd.bullet  # noqa: E402
from meshes import sheet  # noqa: E402

if softcd.bullet.PLUGIN is None:
    pytest.skip("softcd-pybullet is not installed", allow_module_level=True)

SIDE = 11
WORLDS = {"soft": 0, "deformable": pybullet.RESET_USE_DEFORMABLE_WORLD}


def load_cloth(client, path, place, side=SIDE, **options):
    """Loads a flat cloth of side * side nodes, 1 m wide, around a place."""
    vertices, triangles = sheet(side)
    vertices = vertices / (side - 1) - [0.5, 0.5, 0]
    lines = [f"v {x} {y} {z}" for x, y, z in vertices] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles]
    path.write_text("\n".join(lines) + "\n")
    options = {
        "mass": 1, "useMassSpring": 1, "useNeoHookean": 0, "useBendingSprings": 1, "springElasticStiffness": 100,
        "springDampingStiffness": 0.1, "collisionMargin": 0.02, "frictionCoeff": 0.5, "useFaceContact": 1, **options,
    }  # fmt: skip
    return pybullet.loadSoftBody(str(path), basePosition=place, physicsClientId=client, **options)


def border_of(side):
    """Returns the indices of a cloth's nodes at its border."""
    x, y = np.divmod(np.arange(side * side), side)
    return np.flatnonzero((x % (side - 1) == 0) | (y % (side - 1) == 0))


class World:
    """A cloth with a held border, and a cloth above it. Both have sides of 1 m."""

    def __init__(self, folder, kind):
        self.client = pybullet.connect(pybullet.DIRECT)
        pybullet.setAdditionalSearchPath(str(folder), physicsClientId=self.client)
        self.kind = kind
        self.folder = folder
        self.reset()

    def reset(self):
        pybullet.resetSimulation(WORLDS[self.kind], physicsClientId=self.client)
        pybullet.setTimeStep(1 / 60, physicsClientId=self.client)
        self.lower = self.add_cloth("lower.obj", 0, 0)
        self.upper = self.add_cloth("upper.obj", 0.5, 0.03)
        for node in border_of(SIDE):
            pybullet.createSoftBodyAnchor(self.lower, int(node), -1, -1, physicsClientId=self.client)

    def add_cloth(self, name, height, shift):
        return load_cloth(self.client, self.folder / name, [shift, 0.7 * shift, height])

    def positions(self, body):
        flags = pybullet.MESH_DATA_SIMULATION_MESH
        return np.array(pybullet.getMeshData(body, -1, flags=flags, physicsClientId=self.client)[1])

    def throw(self, speed, steps, attachment=None):
        pybullet.resetBaseVelocity(self.upper, [0, 0, -speed], physicsClientId=self.client)
        for _ in range(steps):
            self.step(attachment)

    def step(self, attachment=None):
        pybullet.stepSimulation(physicsClientId=self.client)
        if attachment is not None:
            attachment.finish_step()

    def intersections(self):
        """Returns the exact number of pairs of triangles, one of each cloth, that intersect."""
        triangles = sheet(SIDE)[1]
        positions = np.concatenate([self.positions(self.lower), self.positions(self.upper)])
        pairs = softcd.self_intersections(positions, np.concatenate([triangles, triangles + SIDE * SIDE]))
        return int(np.sum((pairs < len(triangles)).sum(axis=1) == 1))

    def nodes_below(self):
        """Returns the number of the upper cloth's nodes that are clearly below the lower cloth's lowest node."""
        lower, upper = self.positions(self.lower), self.positions(self.upper)
        return int(np.sum(upper[:, 2] < lower[:, 2].min() - 0.05))
