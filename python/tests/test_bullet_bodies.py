"""Tests softcd.bullet.SoftBodies against softcd.Probe, which has the same meshes, and against PyBullet."""

import numpy as np
import pytest

from bullet_worlds import SIDE, WORLDS, load_cloth, pybullet
from meshes import sheet
import softcd
import softcd.bullet
from softcd.bullet import Feature


class Room:
    """A client with three cloths above each other, the upper two crossing, and a rigid body between them."""

    def __init__(self, kind, folder):
        self.client = pybullet.connect(pybullet.DIRECT)
        self.kind, self.folder = kind, folder
        self.reset()
        self.bodies = softcd.bullet.SoftBodies(self.client)

    def reset(self):
        pybullet.resetSimulation(WORLDS[self.kind], physicsClientId=self.client)
        shape = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=0.1, physicsClientId=self.client)
        self.ball = pybullet.createMultiBody(1, shape, basePosition=[0, 0, 0.2], physicsClientId=self.client)
        tilted = pybullet.getQuaternionFromEuler([0.3, 0.2, 0])
        places = [([0, 0, 0], [0, 0, 0, 1]), ([0.1, 0, 0.5], [0, 0, 0, 1]), ([0, 0.05, 0.5], tilted)]
        self.cloths = [
            load_cloth(self.client, self.folder / f"{i}.obj", place, mass=0.6, baseOrientation=orientation)
            for i, (place, orientation) in enumerate(places)
        ]

    def probe(self):
        """Returns a Probe of the same meshes, and the cloths' ids in it."""
        scene = softcd.Scene(backend="cpu")
        ids = {}
        for cloth in self.bodies.ids:
            positions = self.bodies.nodes(cloth)["position"]
            ids[cloth] = scene.add_body(self.bodies.faces(cloth), len(positions))
            scene.set_positions(ids[cloth], positions)
        return softcd.Probe(scene), ids


@pytest.fixture(params=list(WORLDS))
def room(request, tmp_path):
    room = Room(request.param, tmp_path)
    yield room
    pybullet.disconnect(room.client)


def same(answers, expected, ids):
    """Tests that structured arrays are equal, but for the bodies' ids: theirs are PyBullet's."""
    cloths = {number: cloth for cloth, number in ids.items()} | {softcd.NO_BODY: -1}
    assert len(answers) == len(expected) and answers.dtype.names == expected.dtype.names
    for name in answers.dtype.names:
        if name.startswith("body"):
            np.testing.assert_array_equal(answers[name], [cloths[number] for number in expected[name]])
        else:
            np.testing.assert_array_equal(answers[name], expected[name])


def same_lists(answers, expected, ids):
    np.testing.assert_array_equal(answers.begins, expected.begins)
    same(answers.all, expected.all, ids)


def test_meshes_are_pybullets(room):
    assert room.bodies.ids == room.cloths
    flags = pybullet.MESH_DATA_SIMULATION_MESH
    for cloth in room.cloths:
        nodes = room.bodies.nodes(cloth)
        mesh = pybullet.getMeshData(cloth, -1, flags=flags, physicsClientId=room.client)[1]
        np.testing.assert_array_equal(nodes["position"], mesh)
        np.testing.assert_array_equal(nodes["velocity"], 0)
        assert nodes["mass"].sum() == pytest.approx(0.6)
        expected = {tuple(sorted(face)) for face in sheet(SIDE)[1].tolist()}
        assert {tuple(sorted(face)) for face in room.bodies.faces(cloth).tolist()} == expected
    pybullet.createSoftBodyAnchor(room.cloths[0], 7, -1, -1, physicsClientId=room.client)
    assert np.flatnonzero(room.bodies.nodes(room.cloths[0])["mass"] == 0).tolist() == [7]
    pybullet.resetBaseVelocity(room.cloths[1], [1, 2, 3], physicsClientId=room.client)
    np.testing.assert_allclose(room.bodies.nodes(room.cloths[1])["velocity"], np.tile([1, 2, 3], (SIDE * SIDE, 1)))


@pytest.mark.parametrize("is_near", [True, False])
def test_answers_are_those_of_a_probe(room, is_near):
    room.bodies._plugin._is_near = is_near
    probe, ids = room.probe()
    random = np.random.default_rng(5)
    points = random.uniform(-0.6, 0.6, (200, 3)) + [0, 0, 0.3]
    directions = random.normal(size=(200, 3))
    hits = room.bodies.first_hits(points, directions)
    assert -1 in hits["body"] and set(hits["body"]) >= set(room.cloths)
    same(hits, probe.first_hits(points, directions), ids)
    same_lists(room.bodies.all_hits(points, directions), probe.all_hits(points, directions), ids)
    same(room.bodies.closest_points(points, 0.1), probe.closest_points(points, 0.1), ids)
    same_lists(room.bodies.sphere_overlaps(points, 0.1), probe.sphere_overlaps(points, 0.1), ids)
    ends = points + 0.1 * directions
    same_lists(room.bodies.capsule_overlaps(points, ends, 0.1), probe.capsule_overlaps(points, ends, 0.1), ids)
    same_lists(room.bodies.box_overlaps(points, points + 0.1), probe.box_overlaps(points, points + 0.1), ids)
    boxes = (points, [0.1, 0.2, 0.05], np.linalg.qr(random.normal(size=(200, 3, 3)))[0])
    same_lists(room.bodies.oriented_box_overlaps(*boxes), probe.oriented_box_overlaps(*boxes), ids)
    hulls = (points, np.arange(0, 201, 4), random.uniform(0, 0.1, 50))
    same_lists(room.bodies.hull_overlaps(*hulls), probe.hull_overlaps(*hulls), ids)
    same_lists(room.bodies.hull_overlaps(points[:9]), probe.hull_overlaps(points[:9]), ids)


def test_distances_and_intersections_are_those_of_a_probe(room):
    probe, ids = room.probe()
    low, middle, high = room.cloths
    pairs = [(low, middle), (middle, high), (low, None), (None, None)]
    asked = [(ids.get(a), ids.get(b)) for a, b in pairs]
    same(room.bodies.distances(pairs), probe.distances(asked), ids)
    assert room.bodies.distance(low, middle)["distance"] == pytest.approx(0.5)
    assert room.bodies.distance(middle, high)["distance"] == 0
    same_lists(room.bodies.intersections(pairs), probe.intersections(asked), ids)
    assert len(room.bodies.intersections([(middle, high)]).all) > 0
    assert room.bodies.has_intersections() and room.bodies.has_intersections(middle, high)
    assert not room.bodies.has_intersections(low, middle)


def test_empty_batches_have_empty_answers(room):
    none = np.empty((0, 3))
    assert len(room.bodies.first_hits(none, none)) == 0 and len(room.bodies.closest_points(none)) == 0
    assert len(room.bodies.all_hits(none, none)) == 0 and len(room.bodies.sphere_overlaps(none, 1)) == 0
    assert len(room.bodies.distances([])) == 0 and len(room.bodies.intersections([])) == 0
    assert len(room.bodies.hull_overlaps(none, [0])) == 0


def test_features_near_a_ball_are_at_their_distance(room):
    low, middle, _ = room.cloths
    rows = room.bodies.near(room.ball, 0.1)
    assert set(rows["body_a"]) == {room.ball} and set(rows["feature_a"]) == {Feature.object}
    assert set(rows["body_b"]) == {low} and set(rows["feature_b"]) <= {Feature.node, Feature.edge, Feature.face}
    # Between the ball's surface, 0.1 above the cloth, and the cloth's margin.
    assert rows["distance"].min() == pytest.approx(0.08, abs=1e-3) and rows["distance"].max() <= 0.1
    nearest = rows[rows["distance"].argmin()]
    np.testing.assert_allclose(nearest["normal"], [0, 0, 1], atol=1e-3)
    assert len(room.bodies.near(room.ball, 0.05)) == 0
    of_cloth = room.bodies.near(low, 0.1)
    assert set(of_cloth["body_a"]) == {low} and set(of_cloth["body_b"]) == {room.ball}
    assert of_cloth["distance"].min() == pytest.approx(rows["distance"].min())
    crossing = room.bodies.near(middle)
    assert (crossing["distance"] <= 0).all() and room.cloths[2] in crossing["body_b"]


def test_bodies_are_seen_where_they_are_now(room):
    ray = ([0, 0, 3], [0, 0, -1])
    assert room.bodies.first_hits(*ray)["body"][0] in room.cloths[1:]
    for cloth in room.cloths[1:]:
        pybullet.removeBody(cloth, physicsClientId=room.client)
    assert room.bodies.first_hits(*ray)["body"][0] == room.cloths[0] and room.bodies.ids == room.cloths[:1]
    before = room.bodies.first_hits(*ray)["t"][0]
    pybullet.setTimeStep(0.1, physicsClientId=room.client)
    pybullet.resetBaseVelocity(room.cloths[0], [0, 0, -1], physicsClientId=room.client)
    pybullet.stepSimulation(physicsClientId=room.client)
    assert room.bodies.first_hits(*ray)["t"][0] == pytest.approx(before + 0.1, abs=1e-3)
    room.reset()
    assert room.bodies.ids == room.cloths and room.bodies.first_hits(*ray)["body"][0] in room.cloths[1:]


def test_questions_change_nothing(room):
    other = Room(room.kind, room.folder)
    try:
        for each in (room, other):
            pybullet.removeBody(each.cloths.pop(), physicsClientId=each.client)
        for _ in range(20):
            room.bodies.first_hits([0, 0, 3], [0, 0, -1])
            room.bodies.near(room.ball, 0.3)
            for each in (room, other):
                pybullet.stepSimulation(physicsClientId=each.client)
        for cloth, same_cloth in zip(room.cloths, other.cloths, strict=True):
            for name in ("position", "velocity"):
                nodes, expected = room.bodies.nodes(cloth)[name], other.bodies.nodes(same_cloth)[name]
                # Bullet's deformable solver shuffles with a generator that all worlds of a process share.
                np.testing.assert_allclose(nodes, expected, atol=1e-12)
    finally:
        pybullet.disconnect(other.client)


def test_an_attachment_and_questions_do_not_disturb_each_other(room):
    room.bodies.first_hits([0, 0, 3], [0, 0, -1])
    attachment = softcd.bullet.attach(room.client, read_out="contacts")
    pybullet.stepSimulation(physicsClientId=room.client)
    assert room.bodies.has_intersections() and attachment.contacts().step_length > 0
    attachment.detach()
    assert room.bodies.has_intersections() and not attachment.is_attached
    pybullet.stepSimulation(physicsClientId=room.client)


def test_errors_name_the_argument(room):
    for function in (room.bodies.nodes, room.bodies.faces):
        for body in (room.ball, 77, -1):
            with pytest.raises(softcd.InvalidInput, match=f"body: {body} is no soft body of this client"):
                function(body)
    with pytest.raises(softcd.InvalidInput, match="body: 77 is no body of this client"):
        room.bodies.near(77)
    for distance in (-1, float("inf"), float("nan"), "far"):
        with pytest.raises(softcd.InvalidInput, match="max_distance: expected a finite number of at least 0"):
            room.bodies.near(room.ball, distance)
    with pytest.raises(TypeError, match="pairs: expected PyBullet's id of a body, got str"):
        room.bodies.distances([("cloth", None)])
    with pytest.raises(softcd.InvalidInput, match="body: 77 is no soft body"):
        room.bodies.distance(77, room.cloths[0])
    with pytest.raises(softcd.InvalidInput, match=r"directions: expected shape \(n, 3\)"):
        room.bodies.first_hits([0, 0, 0], [0, 1])
    with pytest.raises(softcd.InvalidInput, match="begins: expected ascending integers from 0 to 2"):
        room.bodies.hull_overlaps([[0, 0, 0], [1, 1, 1]], [0, 3])
    with pytest.raises(softcd.InvalidInput, match="radii: expected 1 rows"):
        room.bodies.hull_overlaps([[0, 0, 0], [1, 1, 1]], None, [1, 2])
    with pytest.raises(pybullet.error):
        softcd.bullet.SoftBodies(room.client + 1)
