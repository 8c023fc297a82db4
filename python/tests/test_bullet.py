"""Tests softcd's plugin for PyBullet. Skipped where the wheel has no plugin, or PyBullet is not installed."""

import pathlib
import re

import numpy as np
import pytest

pybullet = pytest.importorskip("pybullet", reason="PyBullet is not installed")

import softcd  # noqa: E402
import softcd.bullet  # noqa: E402
from meshes import sheet  # noqa: E402

if not softcd.bullet.PLUGIN.exists():
    pytest.skip("the wheel was built without SOFTCD_PYBULLET_SOURCE", allow_module_level=True)

SIDE = 11
WORLDS = {"soft": 0, "deformable": pybullet.RESET_USE_DEFORMABLE_WORLD}


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
        place = np.arange(SIDE * SIDE)
        border = (place % SIDE % (SIDE - 1) == 0) | (place // SIDE % (SIDE - 1) == 0)
        for node in np.flatnonzero(border):
            pybullet.createSoftBodyAnchor(self.lower, int(node), -1, -1, physicsClientId=self.client)

    def add_cloth(self, name, height, shift):
        vertices, triangles = sheet(SIDE)
        vertices = vertices / (SIDE - 1) - [0.5 - shift, 0.5 - 0.7 * shift, 0]
        lines = [f"v {x} {y} {z}" for x, y, z in vertices] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles]
        (self.folder / name).write_text("\n".join(lines) + "\n")
        return pybullet.loadSoftBody(
            name, basePosition=[0, 0, height], mass=1, useMassSpring=1, useNeoHookean=0, useBendingSprings=1,
            springElasticStiffness=100, springDampingStiffness=0.1, collisionMargin=0.02, frictionCoeff=0.5,
            useFaceContact=1, physicsClientId=self.client)  # fmt: skip

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


@pytest.fixture(params=list(WORLDS))
def world(request, tmp_path):
    world = World(tmp_path, request.param)
    yield world
    if pybullet.isConnected(world.client):
        pybullet.disconnect(world.client)


def test_pybullets_own_detection_lets_a_thrown_cloth_through(world):
    world.throw(60, 2)
    assert world.nodes_below() == SIDE * SIDE


def test_a_thrown_cloth_does_not_pass_with_ccd(world):
    attachment = softcd.bullet.attach(world.client, detection="ccd", edge_contacts="respond")
    world.throw(60, 1, attachment)
    report = attachment.report()
    assert report["contacts"]["bodies"] == 2 and report["contacts"]["triangles"] == 2 * 2 * (SIDE - 1) ** 2
    assert report["crossing_answers"]["impacts"] + report["contacts"]["vt_contacts"] > 0
    for _ in range(20):
        world.step(attachment)
        assert world.intersections() == 0
    assert world.positions(world.upper)[:, 2].mean() > world.positions(world.lower)[:, 2].mean()
    assert attachment.report()["contacts"]["failed_steps"] == 0 == attachment.report()["crossings"]["failed_steps"]


def test_what_is_detached_goes_on_as_if_never_attached(world, tmp_path):
    other = World(tmp_path, world.kind)
    try:
        softcd.bullet.attach(world.client).detach()
        for each in (world, other):
            each.throw(2, 5)
        np.testing.assert_array_equal(world.positions(world.upper), other.positions(other.upper))
    finally:
        pybullet.disconnect(other.client)


def test_a_reset_ends_the_attachment(world):
    attachment = softcd.bullet.attach(world.client)
    world.throw(2, 3, attachment)
    assert attachment.is_attached
    world.reset()
    assert not attachment.is_attached
    with pytest.raises(softcd.Error, match="the world was reset"):
        attachment.finish_step()
    with softcd.bullet.attach(world.client) as again:
        world.throw(2, 3, again)
        assert again.report()["contacts"]["bodies"] == 2
    assert not again.is_attached


def test_bodies_may_go(world):
    attachment = softcd.bullet.attach(world.client, detection="ccd")
    world.throw(10, 2, attachment)
    pybullet.removeBody(world.lower, physicsClientId=world.client)
    world.step(attachment)
    assert attachment.report()["contacts"]["bodies"] == 1


def test_a_disconnect_ends_the_attachment(world):
    attachment = softcd.bullet.attach(world.client)
    world.throw(2, 2, attachment)
    pybullet.disconnect(world.client)
    with pytest.raises(pybullet.error):
        attachment.finish_step()


def test_clients_do_not_share_anything(world, tmp_path):
    other = World(tmp_path, world.kind)
    try:
        attachments = [softcd.bullet.attach(each.client, detection="ccd") for each in (world, other)]
        pybullet.unloadPlugin(attachments[1]._plugin, physicsClientId=other.client)
        for each in (world, other):
            each.throw(60, 2)
        assert world.nodes_below() == 0 and other.nodes_below() == SIDE * SIDE
    finally:
        pybullet.disconnect(other.client)


def test_nothing_else_is_seen_of_it(world):
    before = pybullet.getOverlappingObjects([-9, -9, -9], [9, 9, 9], physicsClientId=world.client)
    with softcd.bullet.attach(world.client) as attachment:
        assert attachment.limitations and all(line.endswith(".") for line in attachment.limitations)
        assert pybullet.getOverlappingObjects([-9, -9, -9], [9, 9, 9], physicsClientId=world.client) == before
        assert pybullet.getNumBodies(physicsClientId=world.client) == 2
        state = pybullet.saveState(physicsClientId=world.client)
        pybullet.removeState(state, physicsClientId=world.client)
    assert pybullet.getOverlappingObjects([-9, -9, -9], [9, 9, 9], physicsClientId=world.client) == before


def test_wrong_settings_are_named(world):
    with pytest.raises(softcd.Error, match="detection: 'often' is none of dcd, ccd"):
        softcd.bullet.attach(world.client, detection="often")
    with pytest.raises(softcd.Error, match="speed: there is no such setting"):
        softcd.bullet.attach(world.client, speed=3)
    with pytest.raises(softcd.Error, match="contacts_per_node: '-1' is no count"):
        softcd.bullet.attach(world.client, contacts_per_node=-1)
    with pytest.raises(softcd.Error, match="cell_size_factor is 1000, but must be 0, or 0.1 to 100"):
        softcd.bullet.attach(world.client, cell_size_factor=1000)
    settings = {"contacts": "closest_feature", "contacts_per_node": 4, "rigid_meshes": False, "backend": "cpu"}
    settings |= {"cell_size_factor": 1.5, "convex_shapes": "faces_and_edges", "reuse_pairs": False}
    with softcd.bullet.attach(world.client, **settings) as attachment:
        with pytest.raises(softcd.Error, match="attached"):
            softcd.bullet.attach(world.client)
        assert attachment.is_attached


def test_a_plugin_that_does_not_fit_is_refused(world, monkeypatch, tmp_path):
    monkeypatch.setattr(softcd.bullet.importlib.metadata, "version", lambda name: "3.2.6")
    with pytest.raises(softcd.Error, match="built for PyBullet .*, but this is 3.2.6"):
        softcd.bullet.attach(world.client)
    monkeypatch.setattr(softcd.bullet, "PLUGIN", tmp_path / "none.so")
    with pytest.raises(softcd.Error, match="SOFTCD_PYBULLET_SOURCE"):
        softcd.bullet.attach(world.client)


def test_worlds_without_soft_bodies_are_refused(world):
    pybullet.resetSimulation(pybullet.RESET_USE_DISCRETE_DYNAMICS_WORLD, physicsClientId=world.client)
    with pytest.raises(softcd.Error, match="none of Bullet's with soft bodies"):
        softcd.bullet.attach(world.client)


def test_the_documents_example_runs(capfd):
    document = pathlib.Path(__file__).resolve().parents[2] / "docs" / "use" / "pybullet.md"
    example = re.search(r"^```python\n(.*?)^```", document.read_text(), re.MULTILINE | re.DOTALL)[1]
    try:
        exec(compile(example, "docs/use/pybullet.md", "exec"), {})
    finally:
        pybullet.disconnect()
    assert "'vt_contacts': " in capfd.readouterr().out
