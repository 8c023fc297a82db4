"""Tests the contacts that softcd reads out of PyBullet's worlds: ids, places, forces, and what begins and ends."""

import os
import subprocess
import sys

import numpy as np
import pytest

from bullet_worlds import SIDE, WORLDS, border_of, load_cloth, pybullet
import softcd
import softcd._bullet_plugin
import softcd.bullet
from softcd.bullet import Feature, PairState

GRAVITY = 10
STEPS_A_SECOND = 240


class Scene:
    """A client with gravity, and softcd attached to its world."""

    def __init__(self, kind, folder, **settings):
        self.client = pybullet.connect(pybullet.DIRECT)
        self.folder = folder
        pybullet.resetSimulation(WORLDS[kind], physicsClientId=self.client)
        pybullet.setGravity(0, 0, -GRAVITY, physicsClientId=self.client)
        pybullet.setTimeStep(1 / STEPS_A_SECOND, physicsClientId=self.client)
        self.attachment = softcd.bullet.attach(self.client, **({"read_out": "impulses"} | settings))
        self.bodies = softcd.bullet.SoftBodies(self.client)

    def add_cloth(self, height, **options):
        path = self.folder / f"cloth{len(self.bodies.ids)}.obj"
        return load_cloth(self.client, path, [0, 0, height], **options)

    def hold_border(self, cloth):
        for node in border_of(SIDE):
            pybullet.createSoftBodyAnchor(cloth, int(node), -1, -1, physicsClientId=self.client)

    def add_box(self, halves, place, mass=0.0, **options):
        shape = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=halves, physicsClientId=self.client)
        box = pybullet.createMultiBody(mass, shape, basePosition=place, physicsClientId=self.client, **options)
        pybullet.changeDynamics(box, -1, linearDamping=0, angularDamping=0, physicsClientId=self.client)
        return box

    def add_two_links(self):
        """Adds a fixed body whose links 0 and 1 are boxes beside each other, left and right of x = 0."""
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_BOX, halfExtents=[0.3, 0.6, 0.05], physicsClientId=self.client
        )
        return pybullet.createMultiBody(
            0, basePosition=[0, 0, 0], linkMasses=[1, 1], linkCollisionShapeIndices=[shape, shape],
            linkVisualShapeIndices=[-1, -1], linkPositions=[[-0.4, 0, 0], [0.8, 0, 0]],
            linkOrientations=[[0, 0, 0, 1]] * 2, linkInertialFramePositions=[[0, 0, 0]] * 2,
            linkInertialFrameOrientations=[[0, 0, 0, 1]] * 2, linkParentIndices=[0, 1],
            linkJointTypes=[pybullet.JOINT_FIXED] * 2, linkJointAxis=[[0, 0, 1]] * 2,
            physicsClientId=self.client)  # fmt: skip

    def step(self, count=1):
        for _ in range(count):
            pybullet.stepSimulation(physicsClientId=self.client)
            contacts = self.attachment.contacts()
        return contacts

    def momentum(self, cloth):
        nodes = self.bodies.nodes(cloth)
        return nodes["mass"] @ nodes["velocity"]

    def velocity(self, box):
        return np.array(pybullet.getBaseVelocity(box, physicsClientId=self.client)[0])


@pytest.fixture(params=list(WORLDS))
def kind(request):
    return request.param


@pytest.fixture
def make_scene(tmp_path):
    scenes = []

    def make(kind, **settings):
        scenes.append(Scene(kind, tmp_path, **settings))
        return scenes[-1]

    yield make
    for scene in scenes:
        if pybullet.isConnected(scene.client):
            pybullet.disconnect(scene.client)


def test_forces_on_a_cloth_at_rest_are_its_weight(make_scene, kind):
    scene = make_scene(kind)
    table = scene.add_box([1, 1, 0.1], [0, 0, -0.1])
    cloth = scene.add_cloth(0.05, mass=0.7)
    scene.step(300)
    forces = [(each.force_on(cloth), each.force_on(table)) for each in (scene.step() for _ in range(60))]
    on_cloth, on_table = np.mean(forces, axis=0)
    np.testing.assert_allclose(on_cloth, [0, 0, 0.7 * GRAVITY], atol=0.01 * 0.7 * GRAVITY)
    np.testing.assert_allclose(on_table, -on_cloth, atol=1e-9)


def test_forces_are_what_changes_a_cloths_momentum(make_scene, kind):
    scene = make_scene(kind)
    table = scene.add_two_links()
    cloth = scene.add_cloth(0.1)
    greatest = 0
    for _ in range(80):
        before = scene.momentum(cloth)
        contacts = scene.step()
        gained = (scene.momentum(cloth) - before) * STEPS_A_SECOND
        np.testing.assert_allclose(contacts.force_on(cloth), gained + [0, 0, GRAVITY], atol=1e-6)
        np.testing.assert_allclose(contacts.force_on(table), -contacts.force_on(cloth), atol=1e-9)
        greatest = max(greatest, np.abs(gained).max())
    assert greatest > 2 * GRAVITY


def test_forces_are_what_changes_the_momentum_of_cloths_that_meet(make_scene, kind):
    scene = make_scene(kind)
    cloths = [scene.add_cloth(0), scene.add_cloth(0.1)]
    pybullet.resetBaseVelocity(cloths[1], [0.2, 0, -2], physicsClientId=scene.client)
    greatest = 0
    for _ in range(60):
        before = [scene.bodies.nodes(cloth) for cloth in cloths]
        contacts = scene.step()
        for cloth, start in zip(cloths, before, strict=True):
            end = scene.bodies.nodes(cloth)
            # In soft worlds the contacts of the second body move the first one, whose velocities Bullet has taken then.
            # Bullet passes soft bodies the step's length as a float.
            seconds = float(np.float32(contacts.step_length))
            velocity = (end["position"] - start["position"]) / seconds if kind == "soft" else end["velocity"]
            gained = end["mass"] @ (velocity - start["velocity"]) / seconds
            np.testing.assert_allclose(contacts.force_on(cloth), gained + [0, 0, GRAVITY], atol=1e-6)
            greatest = max(greatest, np.abs(gained).max())
    assert greatest > 2 * GRAVITY


@pytest.mark.parametrize("is_rigid_body", [False, True])
@pytest.mark.parametrize("preset", ["balanced", "safe"])
def test_forces_are_what_changes_a_dropped_boxs_momentum(make_scene, kind, is_rigid_body, preset):
    scene = make_scene(kind, preset=preset)
    cloth = scene.add_cloth(0)
    scene.hold_border(cloth)
    box = scene.add_box([0.2, 0.2, 0.1], [0, 0, 0.2], 0.5, useMaximalCoordinates=int(is_rigid_body))
    greatest = 0
    for _ in range(120):
        before = scene.velocity(box)
        contacts = scene.step()
        needed = 0.5 * ((scene.velocity(box) - before) * STEPS_A_SECOND + [0, 0, GRAVITY])
        np.testing.assert_allclose(contacts.force_on(box, by=cloth), needed, atol=1e-6)
        greatest = max(greatest, needed[2])
    assert greatest > 20


def test_a_pair_begins_persists_and_ends(make_scene, kind):
    scene = make_scene(kind)
    table = scene.add_box([1, 1, 0.1], [0, 0, -0.1])
    cloth = scene.add_cloth(0.04)
    states = []
    for step in range(300):
        if step == 200:
            pybullet.resetBaseVelocity(cloth, [0, 0, 20], physicsClientId=scene.client)
        contacts = scene.step()
        assert len(contacts.pairs) <= 1
        for pair in contacts.pairs:
            assert (pair["body_a"], pair["body_b"]) == (cloth, table)
            assert pair["contact_count"] == len(contacts.contacts) and pair["ended_count"] == len(contacts.ended)
            states.append(PairState(pair["state"]))
            if states[-1] == PairState.begun:
                assert contacts.contacts["is_new"].all()
            if states[-1] == PairState.ended:
                assert len(contacts.contacts) == 0 < len(contacts.ended)
                np.testing.assert_array_equal(contacts.force_on(cloth), 0)
    first = states[: states.index(PairState.ended) + 1]
    assert first[0] == PairState.begun and set(first[1:-1]) <= {PairState.persists}
    assert states[-1] == PairState.ended and PairState.persists in states
    assert scene.step().pairs.size == 0


def test_a_removed_body_has_ended_and_no_id(make_scene, kind):
    scene = make_scene(kind)
    table = scene.add_box([1, 1, 0.1], [0, 0, -0.1])
    cloth = scene.add_cloth(0.01)
    assert len(scene.step(60).pairs) == 1
    pybullet.removeBody(table, physicsClientId=scene.client)
    (pair,) = scene.step().pairs
    assert (pair["body_a"], pair["body_b"], pair["state"]) == (cloth, -1, PairState.ended)


def test_links_are_pybullets(make_scene, kind):
    scene = make_scene(kind)
    table = scene.add_two_links()
    cloth = scene.add_cloth(0.1)
    contacts = scene.step(100)
    rows = contacts.contacts
    assert set(rows["body_a"]) == {cloth} and set(rows["body_b"]) == {table} and set(rows["link_a"]) == {-1}
    assert set(rows["link_b"]) == {0, 1}
    np.testing.assert_array_equal(rows["link_b"] == 1, rows["position_b"][:, 0] > 0)
    np.testing.assert_array_equal(contacts.between(table, link=1), rows[rows["link_b"] == 1])
    np.testing.assert_array_equal(contacts.between(cloth, table), rows)
    assert len(contacts.between(cloth, cloth)) == 0
    both = contacts.force_on(table, link=0) + contacts.force_on(table, link=1)
    np.testing.assert_allclose(both, contacts.force_on(table), atol=1e-12)


def test_contacts_lie_on_their_features_and_sum_up_to_their_pairs(make_scene, kind):
    scene = make_scene(kind, edge_contacts="respond", contacts="all")
    scene.add_box([0.2, 0.2, 0.2], [0, 0, -0.25])
    cloths = [scene.add_cloth(0.01), scene.add_cloth(0.06)]
    contacts = scene.step(60)
    assert {tuple(pair) for pair in contacts.pairs[["body_a", "body_b"]]} >= {(cloths[0], 0), (cloths[0], cloths[1])}
    features = set()
    for row in contacts.contacts:
        pair = contacts.pairs[row["pair"]]
        assert all(row[name] == pair[name] for name in ("body_a", "link_a", "body_b", "link_b"))
        assert np.linalg.norm(row["normal"]) == pytest.approx(1, abs=1e-6) and 0 <= row["time_of_impact"] <= 1
        for side in "ab":
            features.add(Feature(row[f"feature_{side}"]))
            check_side(scene, row, side)
    assert features >= {Feature.node, Feature.face, Feature.object, Feature.edge}
    for name in "impulse_a", "impulse_b", "force_a", "force_b":
        for i, pair in enumerate(contacts.pairs):
            summed = contacts.contacts[contacts.contacts["pair"] == i][name].sum(axis=0)
            np.testing.assert_allclose(summed, pair[name], atol=1e-9)
    assert contacts.pairs["has_impulses"].all()


def check_side(scene, row, side):
    """Tests that a side of a contact names nodes, and a place on them, as its feature has them."""
    feature, nodes, weights = row[f"feature_{side}"], row[f"nodes_{side}"], row[f"weights_{side}"]
    count = {Feature.node: 1, Feature.edge: 2, Feature.face: 3, Feature.object: 0}[feature]
    assert (nodes[:count] >= 0).all() and (nodes[count:] == -1).all() and (weights[count:] == 0).all()
    if count > 0:
        positions = scene.bodies.nodes(row[f"body_{side}"])["position"]
        assert weights.sum() == pytest.approx(1, abs=1e-5)
        on_feature = weights[:count] @ positions[nodes[:count]]
        assert np.linalg.norm(on_feature - row[f"position_{side}"]) < 0.02, "nodes move less than that in a step"
    is_face = feature == Feature.face
    assert (row[f"face_{side}"] >= 0) == is_face
    if is_face:
        faces = scene.bodies.faces(row[f"body_{side}"])
        np.testing.assert_array_equal(faces[row[f"face_{side}"]], nodes)


def test_edge_contacts_are_between_edges_that_are_near(make_scene, kind):
    scene = make_scene(kind, edge_contacts="report")
    cloths = [scene.add_cloth(0), scene.add_cloth(0.03)]
    scene.step()
    found = scene.attachment.edge_contacts()
    assert len(found) > 10
    edges = {body: edges_of(scene.bodies.faces(body)) for body in cloths}
    for row in found:
        assert {row["body_a"], row["body_b"]} == set(cloths)
        points = []
        for side in "ab":
            nodes, weights = row[f"nodes_{side}"], row[f"weights_{side}"]
            assert tuple(sorted(nodes)) in edges[row[f"body_{side}"]]
            assert weights.sum() == pytest.approx(1, abs=1e-5) and (weights >= 0).all()
            points.append(weights @ scene.bodies.nodes(row[f"body_{side}"])["position"][nodes])
        gap = points[0] - points[1]
        # One cloth is right above the other. Bullet's solver may have pushed them apart since the detection.
        assert row["distance"] == pytest.approx(0.03, abs=1e-4) and np.abs(gap[:2]).max() < 1e-3
        np.testing.assert_allclose(row["normal"], np.sign(gap) * [0, 0, 1], atol=1e-3)


def edges_of(faces):
    return {tuple(sorted((face[i], face[i - 1]))) for face in faces for i in range(3)}


def test_what_is_not_read_out_is_refused_or_unknown(make_scene, kind):
    scene = make_scene(kind, read_out="off", edge_contacts="off")
    scene.add_box([1, 1, 0.1], [0, 0, -0.1])
    cloth = scene.add_cloth(0.01)
    with pytest.raises(softcd.InvalidInput, match="contacts: read_out is 'off'; .*'contacts' or 'impulses'"):
        scene.attachment.contacts()
    with pytest.raises(softcd.InvalidInput, match="edge_contacts: the setting is 'off'; .*'report' or 'respond'"):
        scene.attachment.edge_contacts()
    scene.attachment.set_settings(read_out="contacts")
    contacts = scene.step(60)
    assert len(contacts.contacts) > 0 and not contacts.pairs["has_impulses"].any()
    assert np.isnan(contacts.force_on(cloth)).all() and np.isnan(contacts.contacts["impulse_b"]).all()
    np.testing.assert_array_equal(contacts.force_on(77), 0)
    with pytest.raises(softcd.InvalidInput, match="body: expected an integer, got 'cloth'"):
        contacts.force_on("cloth")
    with pytest.raises(softcd.InvalidInput, match="link: expected an integer, got 0.5"):
        contacts.between(cloth, link=0.5)
    scene.attachment.detach()
    with pytest.raises(softcd.Error, match="not attached"):
        scene.attachment.contacts()


def test_the_step_is_the_last_one_of_several(make_scene, kind):
    scene = make_scene(kind)
    assert scene.step().step_length == pytest.approx(1 / STEPS_A_SECOND)
    pybullet.setPhysicsEngineParameter(numSubSteps=4, physicsClientId=scene.client)
    assert scene.step().step_length == pytest.approx(1 / STEPS_A_SECOND / 4)
    table = scene.add_box([1, 1, 0.1], [0, 0, -0.1])
    scene.add_cloth(0.03, mass=0.7)
    scene.step(150)
    forces = [scene.step().force_on(table)[2] for _ in range(60)]
    assert np.mean(forces) == pytest.approx(-0.7 * GRAVITY, rel=0.02)


def test_impulses_add_up_over_all_steps(make_scene, kind):
    scene = make_scene(kind)
    pybullet.setPhysicsEngineParameter(numSubSteps=3, physicsClientId=scene.client)
    table = scene.add_two_links()
    cloth = scene.add_cloth(0.1)
    assert len(scene.attachment.impulses().pairs) == 0
    for count in (40, 1, 10, 25):
        before = scene.momentum(cloth)
        for _ in range(count):
            pybullet.stepSimulation(physicsClientId=scene.client)
        impulses = scene.attachment.impulses()
        assert impulses.seconds == pytest.approx(count / STEPS_A_SECOND)
        gained = scene.momentum(cloth) - before + [0, 0, GRAVITY * impulses.seconds]
        np.testing.assert_allclose(impulses.on(cloth), gained, atol=1e-6)
        assert len(impulses.pairs) == 2 and set(impulses.pairs["link_b"]) == {0, 1}
        of_links = [impulses.on(table, link=link, by=cloth) for link in (0, 1)]
        np.testing.assert_allclose(sum(of_links), -gained, atol=1e-6)
    assert scene.attachment.impulses().seconds == 0
    pybullet.stepSimulation(physicsClientId=scene.client)
    scene.attachment.set_settings(read_out="contacts")
    with pytest.raises(softcd.InvalidInput, match="impulses: read_out is not 'impulses'; .*read_out='impulses'"):
        scene.attachment.impulses()


def test_impulses_of_a_body_that_was_removed_keep_its_id(make_scene, kind):
    scene = make_scene(kind)
    table = scene.add_box([1, 1, 0.1], [0, 0, -0.1])
    cloth = scene.add_cloth(0.01)
    scene.step(30)
    pybullet.removeBody(table, physicsClientId=scene.client)
    scene.step()
    assert scene.attachment.impulses().on(cloth, by=table)[2] > 0


def test_a_sleeping_cloth_keeps_its_forces(make_scene):
    scene = make_scene("deformable")
    pybullet.setPhysicsEngineParameter(numSubSteps=4, physicsClientId=scene.client)
    scene.add_box([1, 1, 0.1], [0, 0, -0.1])
    cloth = scene.add_cloth(0.03, mass=0.7, side=4)
    for _ in range(700):
        force = scene.step().force_on(cloth)
        if not scene.bodies.nodes(cloth)["velocity"].any():
            break
    else:
        pytest.fail("the cloth does not sleep")
    # From step to step the force is a little more or less than the weight.
    assert 0.5 < force[2] / (0.7 * GRAVITY) < 1.5
    np.testing.assert_array_equal(scene.step(3).force_on(cloth), force)


SERVER = """
import sys, pybullet
assert pybullet.connect(pybullet.SHARED_MEMORY_SERVER, key=int(sys.argv[1])) >= 0
print("ready", flush=True)
sys.stdin.read()  # until the test is through
"""


def test_clients_of_another_process_read_the_same(make_scene, monkeypatch):
    key = os.getpid()
    with subprocess.Popen(
        [sys.executable, "-c", SERVER, str(key)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as server:
        while "ready" not in (line := server.stdout.readline()):
            assert line, "the server has ended"
        near = make_scene("deformable")
        connect = pybullet.connect
        monkeypatch.setattr(pybullet, "connect", lambda _: connect(pybullet.SHARED_MEMORY, key=key))
        far = make_scene("deformable")
        answers = []
        for scene in near, far:
            scene.add_box([1, 1, 0.1], [0, 0, -0.1])
            cloth = scene.add_cloth(0.02)
            contacts = scene.step(40)
            hits = scene.bodies.first_hits(np.tile([0.1, 0.1, 1], (40, 1)), [0, 0, -1])
            answers.append((contacts.pairs, contacts.contacts, hits, scene.bodies.nodes(cloth)))
        assert near.attachment._plugin._is_near and not far.attachment._plugin._is_near
        for of_near, of_far in zip(*answers, strict=True):
            assert len(of_near) > 0 and of_near.dtype == of_far.dtype
            np.testing.assert_array_equal(of_near, of_far)
        server.stdin.close()


def test_filters_let_nodes_through(make_scene, kind):
    def height_after(filters):
        scene = make_scene(kind)
        lower, upper = scene.add_cloth(0), scene.add_cloth(0.05)
        scene.hold_border(lower)
        if filters:
            scene.attachment.set_filters(upper, groups=2)
            scene.attachment.set_filters(lower, masks=np.full(SIDE * SIDE, 0xFFFFFFFD, np.uint32))
        contacts = scene.step(120)
        assert (len(contacts.between(upper, lower)) == 0) == filters
        return scene.bodies.nodes(upper)["position"][:, 2].mean()

    assert height_after(True) < -1 < -0.5 < height_after(False)


@pytest.mark.parametrize("is_followed", [True, False])
def test_pairs_that_pybullet_filters_do_not_touch(make_scene, kind, is_followed):
    scene = make_scene(kind, filter_deformables=is_followed)
    lower, upper = scene.add_cloth(0), scene.add_cloth(0.05)
    scene.hold_border(lower)
    pybullet.setCollisionFilterPair(lower, upper, -1, -1, 0, physicsClientId=scene.client)
    contacts = scene.step(60)
    assert (len(contacts.between(lower, upper)) == 0) == (is_followed or kind == "soft")


@pytest.mark.parametrize("is_near", [True, False])
def test_wrong_filters_are_named(make_scene, is_near):
    scene = make_scene("soft")
    cloth = scene.add_cloth(0)
    box = scene.add_box([1, 1, 0.1], [0, 0, -1])
    scene.attachment._plugin._is_near = is_near
    for filters, error, text in (
        ({"groups": [1, 2]}, softcd.InvalidInput, r"groups: expected shape \(121,\), .* got \(2,\)"),
        ({"masks": 1.5}, softcd.InvalidInput, "masks: expected integers from 0 to 0xFFFFFFFF, got float64"),
        ({"groups": -1}, softcd.InvalidInput, "groups: expected integers"),
        ({"neighbour_rings": 17}, softcd.InvalidInput, "neighbour_rings"),
        ({"neighbour_rings": 0}, softcd.InvalidInput, "neighbour_rings"),
        ({"neighbour_rings": 1.5}, softcd.InvalidInput, "neighbour_rings: expected an integer"),
        ({"rest_distance": -1.0}, softcd.InvalidInput, "rest_distance"),
        ({"rest_distance": float("inf")}, softcd.InvalidInput, "rest_distance: expected a finite"),
    ):
        with pytest.raises(error, match=text):
            scene.attachment.set_filters(cloth, **filters)
    for body in (box, 77):
        with pytest.raises(softcd.InvalidInput, match=f"body: {body} is no soft body of this client"):
            scene.attachment.set_filters(body)
    with pytest.raises(TypeError, match="body: expected PyBullet's id of a body, got str"):
        scene.attachment.set_filters("cloth")
    scene.attachment.set_filters(cloth, groups=np.arange(SIDE * SIDE), neighbour_rings=2, rest_distance=0.01)
    scene.step()


def test_messages_and_reports_say_what_happened(make_scene, kind):
    scene = make_scene(kind, preset="safe")
    scene.add_cloth(0)
    scene.add_cloth(0, baseOrientation=pybullet.getQuaternionFromEuler([0.1, 1.5, 0]))
    scene.step(2)
    levels = {level for level, _ in scene.attachment.messages()}
    assert levels <= set(softcd.LogLevel) and levels
    assert scene.attachment.messages() == []
    report = scene.attachment.report()
    assert set(report) == {"contacts", "crossings", "crossing_answers", "rigid_meshes", "convex_shapes"}
    members = {name for name in dir(softcd.Statistics) if not name.startswith("_")}
    detectors = [report[name] for name in report if name != "crossing_answers"]
    assert all(set(detector) == members | {"stages_ms", "failed_steps"} for detector in detectors)
    assert report["contacts"]["triangles"] == 2 * 2 * (SIDE - 1) ** 2 and report["contacts"]["backend"] == "cpu"
    stages = scene.attachment.explain()
    assert set(stages) == set(report) - {"crossing_answers"}
    assert all(set(stage) == {"stage", "ran", "reason"} for stage in stages["contacts"]) and stages["contacts"]


def test_intersecting_bodies_are_told_of_until_they_are_apart(make_scene, kind):
    scene = make_scene(kind, untangle="all", self_collision="all")
    pybullet.setGravity(0, 0, 0, physicsClientId=scene.client)
    lower = scene.add_cloth(0)
    upper = scene.add_cloth(0)
    nodes = scene.bodies.nodes(upper)["position"]
    assert nodes.shape == (SIDE * SIDE, 3)
    pybullet.resetBasePositionAndOrientation(
        upper, [0.3, 0, 0.05], pybullet.getQuaternionFromEuler([0, 0.4, 0]), physicsClientId=scene.client
    )
    assert scene.bodies.has_intersections(lower, upper)
    scene.step()
    (pair,) = scene.attachment.intersecting_bodies()
    assert {int(pair["body_a"]), int(pair["body_b"])} == {lower, upper}
    assert pair["steps"] == 1 and pair["curve_length"] == pytest.approx(1, abs=0.3)
    scene.step()
    assert scene.attachment.intersecting_bodies()["steps"].tolist() == [2]
    for _ in range(600):
        scene.step()
        if len(scene.attachment.intersecting_bodies()) == 0 and not scene.bodies.has_intersections(lower, upper):
            return
    pytest.fail("they are not apart after 600 steps")


def test_bodies_that_have_gone_are_told_of_no_more(make_scene, kind):
    scene = make_scene(kind, untangle="all", self_collision="all", edge_contacts="report")
    pybullet.setGravity(0, 0, 0, physicsClientId=scene.client)
    scene.add_cloth(0)
    upper = scene.add_cloth(0)
    pybullet.resetBasePositionAndOrientation(
        upper, [0.3, 0, 0.05], pybullet.getQuaternionFromEuler([0, 0.4, 0]), physicsClientId=scene.client
    )
    scene.step()
    assert len(scene.attachment.intersecting_bodies()) == 1 and len(scene.attachment.edge_contacts()) > 0
    pybullet.removeBody(upper, physicsClientId=scene.client)
    assert len(scene.attachment.intersecting_bodies()) == len(scene.attachment.edge_contacts()) == 0


def test_intersecting_bodies_need_untangle(make_scene, kind):
    with pytest.raises(softcd.InvalidInput, match="untangle is off; attach with untangle="):
        make_scene(kind, untangle="off").attachment.intersecting_bodies()
