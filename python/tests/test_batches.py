"""Tests many environments in one scene."""

import gc

import numpy as np
import pytest

import softcd
from meshes import PIERCING_T0, PIERCING_T1, PIERCING_TRIANGLES, sheet, soup

CLOTH = sheet(6)
ROCKS = soup(1, 24, 0.8)
SETTINGS = [{"margin": 0.03}, {"kinematic": True, "margin": 0.03}]


def motions(environments, dtype=np.float32, seed=0):
    """Returns both ends of a step of both bodies, of shape (environments, vertices, 3): a cloth falls onto rocks."""
    random = np.random.default_rng(seed)
    bodies = []
    for (vertices, _), height, fall in ((CLOTH, 0.6, -0.7), (ROCKS, 0.0, 0.0)):
        t0 = vertices * [0.2, 0.2, 1] if vertices is CLOTH[0] else vertices
        t0 = t0 + [0, 0, height] + 0.05 * random.normal(size=(environments, len(vertices), 3))
        bodies.append((t0.astype(dtype), (t0 + [0, 0, fall] + 0.1 * random.normal(size=t0.shape)).astype(dtype)))
    return bodies


def batch_of(environments, **options):
    scene = softcd.BatchScene(environments, backend="cpu")
    for (vertices, triangles), settings in zip((CLOTH, ROCKS), SETTINGS):
        scene.add_body(triangles, len(vertices), **settings)
    return scene, softcd.BatchQuery(scene, **options)


def alone(step, environment, **options):
    """Returns the contacts of one environment in a Scene of its own."""
    scene = softcd.Scene(backend="cpu")
    for (vertices, triangles), settings, ends in zip((CLOTH, ROCKS), SETTINGS, step):
        body = scene.add_body(triangles, len(vertices), **settings)
        scene.set_positions(body, *(end[environment] for end in ends))
    return softcd.Query(scene, **options).detect()


def detect(scene, query, step):
    for body, ends in enumerate(step):
        scene.set_positions(body, *ends)
    return query.detect()


def assert_each_is_as_alone(contacts, step, **options):
    for environment, own in enumerate(contacts):
        expected = alone(step, environment, **options)
        assert own.dtype == expected.dtype and own.tobytes() == expected.tobytes(), f"environment {environment}"


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("accuracy", ["fast", "precise", "conservative", "automatic"])
@pytest.mark.parametrize("detection", ["dcd", "ccd"])
def test_contacts_are_those_of_single_scenes(detection, accuracy, dtype):
    options = {"detection": detection, "accuracy": accuracy}
    scene, query = batch_of(9, **options)
    for seed in range(3):
        step = motions(9, dtype, seed)
        contacts = detect(scene, query, step)
        assert len(contacts) == 9 and min(map(len, contacts)) > 0
        found = set(zip(*(contacts.all[name].tolist() for name in ("kind", "body_a", "body_b"))))
        assert found == {(0, 0, 0), (0, 0, 1), (0, 1, 0), (1, 0, 0), (1, 0, 1)}
        assert contacts.begins.dtype == np.int64 and contacts.begins.tolist()[::9] == [0, len(contacts.all)]
        assert_each_is_as_alone(contacts, step, **options)


def test_contacts_do_not_depend_on_the_number_of_environments():
    step = motions(40)
    expected = None
    for environments in (40, 1, 17):
        scene, query = batch_of(environments, detection="ccd")
        contacts = detect(scene, query, [[end[:environments] for end in ends] for ends in step])
        expected = expected or [own.tobytes() for own in contacts]
        assert [own.tobytes() for own in contacts] == expected[:environments]


@pytest.mark.parametrize("spacing", [4.0, 1000.3, -1e5])
@pytest.mark.parametrize("detection", ["dcd", "ccd"])
@pytest.mark.parametrize(
    "accuracy, dtype",
    [("fast", np.float32), ("precise", np.float32), ("conservative", np.float32), ("conservative", np.float64)],
)
def test_environments_may_be_anywhere(accuracy, dtype, detection, spacing):
    options = {"detection": detection, "accuracy": accuracy}
    places = spacing * np.stack([np.arange(1, 9), np.arange(8) % 3, np.zeros(8)], axis=1)[:, None]
    step = [[(end + places).astype(dtype) for end in ends] for ends in motions(8, np.float64)]
    scene, query = batch_of(8, **options)
    contacts = detect(scene, query, step)
    assert min(map(len, contacts)) > 0
    assert_each_is_as_alone(contacts, step, **options)


def test_an_environment_may_rest_while_others_move():
    step = motions(3)
    for t0, t1 in step:
        t1[1] = t0[1]
        t0[1] = t1[1] = t1[2]
    for accuracy in ("precise", "conservative"):
        options = {"detection": "ccd", "accuracy": accuracy}
        scene, query = batch_of(3, **options)
        contacts = detect(scene, query, step)
        assert len(contacts[1]) > 0
        assert_each_is_as_alone(contacts, step, **options)


def test_environments_may_be_without_contacts():
    step = motions(4)
    step[0][0][2] += 100
    step[0][1][2] += 100
    scene, query = batch_of(4, detection="ccd")
    contacts = detect(scene, query, step)
    only_rocks = alone(step, 2, detection="ccd")
    assert contacts[2].tobytes() == only_rocks.tobytes()
    step[1][0][2] = step[1][1][2] = np.arange(3 * len(ROCKS[0])).reshape(-1, 3)  # far from each other
    scene.set_positions(1, *step[1])
    assert_each_is_as_alone(contacts := query.detect(), step, detection="ccd")
    assert len(contacts[3]) > len(contacts[2])


@pytest.mark.parametrize("environments", [0, 3])
def test_there_may_be_nothing(environments):
    scene = softcd.BatchScene(environments, backend="cpu")
    query = softcd.BatchQuery(scene)
    assert [len(own) for own in query.detect()] == [0] * environments
    assert scene.add_body(PIERCING_TRIANGLES, 6) == 0 and scene.add_body(PIERCING_TRIANGLES[:0], 0) == 1
    scene.set_positions(0, np.zeros((environments, 6, 3)))
    scene.set_positions(1, np.zeros((environments, 0, 3)))
    contacts = query.detect()
    assert len(contacts) == environments and scene.bodies == 2 and scene.environments == environments
    assert repr(contacts) == f"<softcd.BatchContacts, {len(contacts.all)} contacts in {environments} environments>"


def test_positions_are_not_copied():
    step = motions(3)
    scene, query = batch_of(3, detection="ccd")
    for body, ends in enumerate(step):
        scene.set_positions(body, *ends)
    step[0][1][1] += [0, 0, -0.05]
    assert_each_is_as_alone(query.detect(), step, detection="ccd")


def test_arrays_may_have_any_layout():
    step = motions(4)
    scene, query = batch_of(4, detection="ccd")
    expected = detect(scene, query, step).all.tobytes()

    def padded(end):
        rows = np.full((8, end.shape[1], 4), np.nan, end.dtype)
        rows[::2, :, :3] = end
        return rows[::2, :, :3]

    for layout in (padded, np.asfortranarray, lambda end: end[::-1].copy()[::-1], lambda end: memoryview(end), list):
        contacts = detect(scene, query, [[layout(end) for end in ends] for ends in step])
        assert contacts.all.tobytes() == expected


def test_one_body_may_be_shown_to_all_environments():
    step = motions(4)
    one = [np.broadcast_to(end[0], end.shape) for end in step[1]]
    scene, query = batch_of(4, detection="ccd")
    assert_each_is_as_alone(detect(scene, query, [step[0], one]), [step[0], one], detection="ccd")


def test_tensors_of_torch_are_read():
    torch = pytest.importorskip("torch")
    step = motions(4)
    scene, query = batch_of(4, detection="ccd")
    expected = detect(scene, query, step).all.tobytes()
    assert detect(scene, query, [[torch.tensor(end) for end in ends] for ends in step]).all.tobytes() == expected


def test_detections_may_be_started():
    scene, query = batch_of(3, detection="ccd")
    first, second = motions(3), motions(3, seed=1)
    for body, ends in enumerate(first):
        scene.set_positions(body, *ends)
    ticket = query.start()
    for body, ends in enumerate(second):
        scene.set_positions(body, *ends)
    assert isinstance(ticket, softcd.BatchTicket)
    contacts = ticket.wait()
    with pytest.raises(softcd.Error):
        ticket.wait()
    following = query.detect()
    assert_each_is_as_alone(contacts, first, detection="ccd")
    assert_each_is_as_alone(following, second, detection="ccd")
    assert query.statistics.vt_contacts + query.statistics.ee_contacts == len(following.all)
    assert query.options.detection == softcd.Detection.ccd and query.explain()


def test_contacts_outlive_their_scene():
    scene, query = batch_of(3, detection="ccd")
    step = motions(3)
    contacts = detect(scene, query, step)
    assert not contacts.all.flags.writeable
    own = contacts[2]
    expected = own.tobytes()
    del scene, query, contacts
    gc.collect()
    assert own.tobytes() == expected


def test_settings_hold_in_all_environments():
    step = motions(3)
    scene, query = batch_of(3)
    many = detect(scene, query, step)
    scene.set_settings(0, margin=0.01)
    scene.set_settings(1, kinematic=True, margin=0.01)
    few = query.detect()
    assert all(0 < len(after) < len(before) for before, after in zip(many, few))
    scene.set_ignored_pairs([(0, 1)])
    assert not (query.detect().all["body_a"] != query.detect().all["body_b"]).any()
    scene.set_ignored_pairs([(0, 1), (0, 0)])
    assert [len(own) for own in query.detect()] == [0, 0, 0]
    scene.set_ignored_pairs([])
    assert query.detect().all.tobytes() == few.all.tobytes()
    scene.set_vertex_filters(0, masks=np.zeros(len(CLOTH[0]), np.uint32))
    assert [len(own) for own in query.detect()] == [0, 0, 0]


def test_rest_positions_hold_in_all_environments():
    vertices, triangles = CLOTH
    folded = np.broadcast_to(vertices * [0.01, 1, 1], (2, *vertices.shape))
    scene = softcd.BatchScene(2, backend="cpu")
    scene.add_body(triangles, len(vertices), rest_distance=100.0, margin=0.1)
    scene.set_positions(0, folded)
    query = softcd.BatchQuery(scene)
    with pytest.raises(softcd.InvalidInput, match="rest"):
        query.detect()
    scene.set_rest_positions(0, vertices)
    assert len(query.detect().all) == 0
    scene.set_settings(0, margin=0.1)
    assert min(map(len, query.detect())) > 0


@pytest.mark.parametrize(
    "t0, t1, error, words",
    [
        (np.zeros((4, 6, 3)), None, softcd.InvalidInput, r"^vertices_t0: expected shape \(3, 6, 3\), got \(4, 6, 3\)"),
        (np.zeros((3, 5, 3)), None, softcd.InvalidInput, r"^vertices_t0: expected shape \(3, 6, 3\), got \(3, 5, 3\)"),
        (np.zeros((18, 3)), None, softcd.InvalidInput, r"^vertices_t0: expected shape \(3, 6, 3\), got \(18, 3\)"),
        (np.zeros((3, 6, 2)), None, softcd.InvalidInput, r"^vertices_t0: expected shape \(3, 6, 3\), got \(3, 6, 2\)"),
        (np.zeros((3, 6, 3)), np.zeros((3, 6)), softcd.InvalidInput, r"^vertices_t1: expected shape \(3, 6, 3\)"),
        (np.zeros((3, 6, 3), complex), None, TypeError, r"^vertices_t0: expected .*float32 or float64.*\(3, 6, 3\)"),
        (np.zeros((3, 6, 3)), "there", TypeError, r"^vertices_t1: expected .*float32 or float64.*got str"),
        (np.full((3, 6, 3), np.nan), None, softcd.InvalidInput, r"^vertices_t0: environment 0, row 0 is \(nan"),
        (np.zeros((3, 6, 3)), np.zeros((3, 6, 3), np.float32), TypeError, "^vertices_t1: expected float64.*vertices_t0.*got float32"),
    ],
)
def test_wrong_positions_are_refused(t0, t1, error, words):
    scene = softcd.BatchScene(3, backend="cpu")
    scene.add_body(PIERCING_TRIANGLES, 6)
    query = softcd.BatchQuery(scene, detection="ccd")
    right = [np.broadcast_to(end, (3, 6, 3)) for end in (PIERCING_T0, PIERCING_T1)]
    scene.set_positions(0, *right)
    with pytest.raises(error, match=words):
        scene.set_positions(0, t0, t1)
    assert min(map(len, query.detect())) > 0, "positions that were set before count"


def test_wrong_arguments_are_refused():
    for wrong in (-1, 2.5, "3", 2**32):
        with pytest.raises(TypeError, match="^environments: expected int"):
            softcd.BatchScene(wrong)
    with pytest.raises(TypeError, match="backends.*backend"):
        softcd.BatchScene(2, backends="cpu")
    scene = softcd.BatchScene(2, backend="cpu")
    with pytest.raises(softcd.InvalidInput, match="^batch: "):
        scene.add_body(PIERCING_TRIANGLES, 6, batch=1)
    with pytest.raises(softcd.InvalidInput, match="triangle"):
        scene.add_body(PIERCING_TRIANGLES, 5)
    assert scene.add_body(PIERCING_TRIANGLES, 6) == 0, "bodies that were refused have no number"
    with pytest.raises(softcd.InvalidInput, match="^batch: "):
        scene.set_settings(0, batch=1)
    for call in (
        lambda: scene.set_positions(1, np.zeros((2, 6, 3))),
        lambda: scene.set_settings(1),
        lambda: scene.set_ignored_pairs([(0, 1)]),
        lambda: scene.set_vertex_filters(1),
        lambda: scene.set_rest_positions(1, None),
    ):
        with pytest.raises(softcd.InvalidInput, match="^body: there is no body 1"):
            call()
    with pytest.raises(softcd.InvalidInput, match=r"^vertices: expected shape \(6, 3\), got \(5, 3\)"):
        scene.set_rest_positions(0, np.zeros((5, 3)))
    with pytest.raises(softcd.InvalidInput, match="^groups and masks: expected 6, one for each vertex, got 5"):
        scene.set_vertex_filters(0, np.zeros(5, np.uint32))
    with pytest.raises(TypeError):
        softcd.Query(scene)
    with pytest.raises(TypeError):
        softcd.BatchQuery(softcd.Scene(backend="cpu"))
