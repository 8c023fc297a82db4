"""Tests softcd's plugin for PyBullet: detection, and what attaching and detaching leave."""

import importlib.metadata
import pathlib
import re

import numpy as np
import pytest

from bullet_worlds import SIDE, WORLDS, World, pybullet
import softcd
import softcd.bullet

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
        pybullet.unloadPlugin(attachments[1]._plugin.id, physicsClientId=other.client)
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


def test_a_plugin_that_does_not_fit_is_refused(world, monkeypatch):
    monkeypatch.setattr(softcd._bullet_plugin.importlib.metadata, "version", lambda name: "3.2.6")
    with pytest.raises(softcd.Error, match="built for PyBullet .*, but this is 3.2.6"):
        softcd.bullet.attach(world.client)
    monkeypatch.setattr(softcd._bullet_plugin, "PLUGIN", None)
    with pytest.raises(softcd.Error, match="install the package softcd-pybullet"):
        softcd.bullet.attach(world.client)


def test_the_plugins_package_names_its_softcd_and_pybullet():
    assert importlib.metadata.version("softcd-pybullet") == softcd.__version__
    requirements = importlib.metadata.requires("softcd-pybullet")
    assert f"softcd=={softcd.__version__}" in requirements
    assert f"pybullet=={importlib.metadata.version('pybullet')}" in requirements


def test_worlds_without_soft_bodies_are_refused(world):
    pybullet.resetSimulation(pybullet.RESET_USE_DISCRETE_DYNAMICS_WORLD, physicsClientId=world.client)
    with pytest.raises(softcd.Error, match="none of Bullet's with soft bodies"):
        softcd.bullet.attach(world.client)


def test_the_documents_examples_run(capfd):
    document = next((pathlib.Path(__file__).resolve().parents[2] / "docs").rglob("pybullet.md"))
    examples = re.findall(r"^```python\n(.*?)^```", document.read_text(), re.MULTILINE | re.DOTALL)
    assert len(examples) >= 5
    try:
        exec(compile("\n".join(examples), "pybullet.md", "exec"), {})
    finally:
        pybullet.disconnect()
    assert "'vt_contacts': " in capfd.readouterr().out
