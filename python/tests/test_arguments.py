"""Tests that wrong arguments raise an exception that names them, and never crash."""

import copy
import itertools
import pickle
import random

import numpy as np
import pytest

import softcd
from meshes import PIERCING_T0, PIERCING_T1, PIERCING_TRIANGLES

GOOD = PIERCING_T0
CCD = softcd.Detection.ccd


def set_positions(*vertices):
    scene = softcd.Scene()
    scene.set_positions(scene.add_body(PIERCING_TRIANGLES, 6), *vertices)


WRONG_POSITIONS = {
    "a ragged list": (TypeError, [[0, 0, 0]] * 5 + [[0, 0]]),
    "a list of words": (TypeError, [["0", "0", "1"]] * 6),
    "a number": (TypeError, 3.0),
    "text": (TypeError, "012"),
    "bytes": (ValueError, b"012345678901234567"),
    "long double": (TypeError, GOOD.astype(np.longdouble)),
    "complex numbers": (TypeError, GOOD.astype(complex)),
    "objects": (TypeError, GOOD.astype(object)),
    "one dimension": (ValueError, GOOD.ravel()),
    "three dimensions": (ValueError, GOOD[None]),
    "no dimension": (ValueError, np.array(1.0)),
    "four columns": (ValueError, np.zeros((6, 4))),
    "not a number": (ValueError, GOOD * np.nan),
    "too large": (ValueError, GOOD + 1e38),
}


@pytest.mark.parametrize("what", WRONG_POSITIONS)
def test_positions_that_cannot_be_read_are_named(what):
    error, wrong = WRONG_POSITIONS[what]
    with pytest.raises(error, match="^vertices_t0: "):
        set_positions(wrong)
    with pytest.raises(error, match="^vertices_t1: "):
        set_positions(GOOD, wrong)


def test_positions_of_the_wrong_number_or_two_types_are_refused():
    with pytest.raises(softcd.InvalidInput, match="5 positions were given for t1, but the body has 6"):
        set_positions(GOOD, GOOD[:5])
    with pytest.raises(softcd.InvalidInput, match="t0 and t1 are of different types"):
        set_positions(GOOD, GOOD.astype(np.float32))


@pytest.mark.parametrize(
    "error, text, triangles",
    [
        (TypeError, "^triangles: .*got list", [[0, 1, 2.5]]),
        (TypeError, "^triangles: .*got list", [[0, 1, 2], [3, 4]]),
        (TypeError, "^triangles: .*got float64", PIERCING_TRIANGLES.astype(float)),
        (TypeError, "^triangles: .*got bool8", PIERCING_TRIANGLES.astype(bool)),
        (ValueError, r"^triangles: .*got \(6,\)", PIERCING_TRIANGLES.ravel()),
        (ValueError, "^triangles: row 1 has the index -1", np.array([[0, 1, 2], [3, -1, 4]])),
        (ValueError, "^triangles: row 0 has the index 4294967296", np.array([[0, 1, 2**32]])),
        (ValueError, "triangle 0 has vertex index 6", np.array([[0, 1, 6]])),
    ],
)
def test_triangles_that_cannot_be_read_are_named(error, text, triangles):
    with pytest.raises(error, match=text):
        softcd.Scene().add_body(triangles, 6)


@pytest.mark.parametrize(
    "error, text, segments",
    [
        (TypeError, "^segments: .*got list", [[0, 1.0]]),
        (TypeError, "^segments: .*got float64", np.zeros((1, 2))),
        (ValueError, r"^segments: expected shape \(n, 2\), got \(2, 3\)", PIERCING_TRIANGLES),
        (ValueError, r"^segments: expected shape \(n, 2\), got \(2,\)", np.array([0, 1])),
        (ValueError, "^segments: row 1 has the index -1", np.array([[0, 1], [-1, 2]])),
        (ValueError, "segment 0 has vertex index 6", np.array([[0, 6]])),
    ],
)
def test_segments_that_cannot_be_read_are_named(error, text, segments):
    scene = softcd.Scene()
    with pytest.raises(error, match=text):
        scene.add_body(PIERCING_TRIANGLES, 6, segments=segments)
    body = scene.add_body(PIERCING_TRIANGLES, 6)
    with pytest.raises(error, match=text):
        scene.update_body(body, PIERCING_TRIANGLES, 6, segments=segments)


@pytest.mark.parametrize(
    "error, text, changed",
    [
        (TypeError, "^changed: .*got list", [0.0]),
        (TypeError, "^changed: .*got float64", np.zeros(1)),
        (ValueError, r"^changed: expected shape \(n,\), got \(2, 3\)", PIERCING_TRIANGLES),
        (ValueError, r"^changed: expected shape \(n,\), got \(\)", np.array(0)),
        (ValueError, "^changed: row 1 has the index -1", np.array([0, -1])),
        (ValueError, "^changed: row 0 has the index 4294967295", np.array([2**32 - 1])),
        (ValueError, "triangle 2 is said to have changed, but there are 2", np.array([2], np.uint16)),
    ],
)
def test_changes_that_cannot_be_read_are_named(error, text, changed):
    scene = softcd.Scene()
    body = scene.add_body(PIERCING_TRIANGLES, 6, self_collision=True)
    scene.set_positions(body, PIERCING_T0, PIERCING_T1)
    with pytest.raises(error, match=text):
        scene.update_body(body, PIERCING_TRIANGLES, 6, changed=changed)
    assert len(softcd.Query(scene, detection=softcd.Detection.ccd).detect()) == 1, "everything is as it was"


@pytest.mark.parametrize(
    "error, text, call",
    [
        (softcd.InvalidInput, "margin is nan", lambda: softcd.Scene().add_body(PIERCING_TRIANGLES, 6, margin=np.nan)),
        (softcd.InvalidInput, "margin is -1", lambda: softcd.detect(GOOD, PIERCING_TRIANGLES, margin=-1)),
        (softcd.InvalidInput, "cell_size_factor is 1000", lambda: softcd.Query(softcd.Scene(), cell_size_factor=1000)),
        (softcd.InvalidInput, "motion_margin", lambda: softcd.Query(softcd.Scene(), motion_margin=-0.5)),
        (softcd.InvalidInput, "body 7 is not in the scene", lambda: softcd.Scene().remove_body(7)),
        (softcd.InvalidInput, "^vertices_t1: expected 1", lambda: softcd.detect([GOOD], [PIERCING_TRIANGLES], [])),
        (softcd.InvalidInput, "^vertices_t1: continuous", lambda: softcd.detect(GOOD, PIERCING_TRIANGLES, detection=CCD)),
        (TypeError, "^detection: expected Detection or the name of one, got 1", lambda: softcd.QueryOptions(detection=1)),
        (ValueError, "^detection: expected one of dcd, ccd, got 'cdc'", lambda: softcd.QueryOptions(detection="cdc")),
        (ValueError, "^pairs: expected one of all, changed, got 'some'", lambda: softcd.Query(softcd.Scene()).detect("some")),
        (ValueError, "^step_end: expected one of t0, t1, got 't2'", lambda: softcd.Probe(softcd.Scene(), step_end="t2")),
        (TypeError, "^edge_edge: expected bool, got 'yes'", lambda: softcd.QueryOptions(edge_edge="yes")),
        (TypeError, "scene: Scene", lambda: softcd.Query("scene")),
        (TypeError, "^memory_limit: expected int from 0 to 1844.*, got -1", lambda: softcd.Scene(memory_limit=-1)),
        (TypeError, "there is no keyword 'nonsense'; there are backend, ", lambda: softcd.Scene(nonsense=1)),
        (TypeError, r"^Scene\(\).*'backnd'; did you mean 'backend'", lambda: softcd.Scene(backnd="cpu")),
        (TypeError, r"^Query\(\).*did you mean 'accuracy'", lambda: softcd.Query(softcd.Scene(), acuracy="fast")),
        (TypeError, r"^QueryOptions\(\).*did you mean 'margins'", lambda: softcd.QueryOptions().replace(margin=1)),
        (TypeError, r"^add_body\(\).*did you mean 'segments'", lambda: softcd.Scene().add_body([], 0, segmnts=[])),
        (TypeError, r"^update_body\(\).*did you mean 'changed'", lambda: softcd.Scene().update_body(0, [], 0, chnged=[])),
        (TypeError, r"^detect\(\).*did you mean 'margin'", lambda: softcd.detect(GOOD, PIERCING_TRIANGLES, margn=1)),
        (TypeError, r"^self_intersections\(\).*did you mean 'max_threads'",
         lambda: softcd.self_intersections(GOOD, PIERCING_TRIANGLES, max_thread=1)),
        (TypeError, "vertices_t0", lambda: softcd.detect(None, PIERCING_TRIANGLES)),
        (TypeError, "triangles", lambda: softcd.detect(GOOD, None)),
        (TypeError, "vertices", lambda: softcd.self_intersections(None, PIERCING_TRIANGLES)),
    ],
)
def test_other_arguments_are_named(error, text, call):
    with pytest.raises(error, match=text):
        call()


def test_names_of_enumerators_are_enumerators():
    options = softcd.QueryOptions(detection="ccd", accuracy="fast", step_end="t0", broad_phase="uniform")
    assert options.detection is softcd.Detection.ccd and options.accuracy is softcd.Accuracy.fast
    assert options.step_end is softcd.StepEnd.t0 and options.broad_phase is softcd.BroadPhase.uniform
    assert softcd.Scene(backend="cpu").options.backend is softcd.Backend.cpu
    found = softcd.detect(GOOD, PIERCING_TRIANGLES, PIERCING_T1, detection="ccd", accuracy="precise")
    assert len(found) == 1 and len(softcd.detect(GOOD, PIERCING_TRIANGLES, PIERCING_T1, detection="dcd")) == 0
    with pytest.raises(softcd.InvalidInput, match="^vertices_t1: continuous"):
        softcd.detect(GOOD, PIERCING_TRIANGLES, detection="ccd")


@pytest.mark.parametrize("duplicate", [copy.copy, copy.deepcopy, lambda x: pickle.loads(pickle.dumps(x))])
def test_options_and_statistics_are_copied_and_pickled(duplicate):
    query = softcd.QueryOptions(detection="ccd", cell_size_factor=2.0, margins=False)
    scene = softcd.SceneOptions(backend="cpu", memory_limit=10**12)
    assert duplicate(query) == query and duplicate(scene) == scene
    world = softcd.Scene(backend="cpu")
    world.set_positions(world.add_body(PIERCING_TRIANGLES, 6, self_collision=True), GOOD, PIERCING_T1)
    asked = softcd.Query(world, detection="ccd")
    asked.detect()
    assert repr(duplicate(asked.statistics)) == repr(asked.statistics)
    assert repr(duplicate(asked.explain())) == repr(asked.explain())


def test_what_was_forgotten_is_said():
    scene = softcd.Scene()
    body = scene.add_body(PIERCING_TRIANGLES, 6, self_collision=True)
    query = softcd.Query(scene, detection="ccd")
    with pytest.warns(RuntimeWarning, match="body 0 has no positions and is left out; use set_positions"):
        query.detect()
    scene = softcd.Scene()
    body = scene.add_body(PIERCING_TRIANGLES, 6)
    query = softcd.Query(scene, detection="ccd")
    scene.set_positions(body, GOOD)
    with pytest.warns(RuntimeWarning, match="give set_positions.. x_t0 and x_t1"):
        query.detect()
    scene.set_positions(body, GOOD, GOOD)
    assert len(query.detect()) == 0


def probe_of_one_body():
    scene = softcd.Scene()
    scene.set_positions(scene.add_body(PIERCING_TRIANGLES, 6), GOOD)
    return softcd.Probe(scene)


def change_to(new_vertices):
    return softcd.MeshChange(0, new_vertices=new_vertices)


UP = np.array([0.0, 0.0, 1.0])


@pytest.mark.parametrize(
    "error, text, ask",
    [
        (TypeError, "^origins: .*got <U1", lambda probe: probe.first_hits(["0", "0", "1"], UP)),
        (TypeError, "^origins: .*got complex", lambda probe: probe.first_hits(GOOD * 1j, UP)),
        (TypeError, "^directions: .*got bool", lambda probe: probe.all_hits(GOOD, GOOD > 0)),
        (TypeError, "^origins: .*got object", lambda probe: probe.first_hits([2**70, None, 1], UP)),
        (TypeError, "^origins: expected numbers", lambda probe: probe.first_hits([[0, 0, 1], [0]], UP)),
        (ValueError, r"^origins: .*\(n, 3\).*got \(6, 2\)", lambda probe: probe.first_hits(GOOD[:, :2], UP)),
        (ValueError, r"^directions: .*got \(1, 6, 3\)", lambda probe: probe.first_hits(GOOD, GOOD[None])),
        (ValueError, "^directions: expected 6 rows, as origins", lambda probe: probe.first_hits(GOOD, GOOD[:5])),
        (ValueError, r"^t_max: .*\(n,\), or one number", lambda probe: probe.first_hits(GOOD, UP, t_max=GOOD)),
        (ValueError, "^max_distance: expected 6 rows", lambda probe: probe.closest_points(GOOD, np.ones(2))),
        (ValueError, r"^points: .*got \(\)", lambda probe: probe.closest_points(1.0)),
        (ValueError, r"^axes: .*\(n, 3, 3\)", lambda probe: probe.oriented_box_overlaps(GOOD, UP, GOOD)),
        (TypeError, "radii", lambda probe: probe.sphere_overlaps(GOOD, None)),
        (ValueError, r"^points: .*\(n, 3\)", lambda probe: probe.hull_overlaps(GOOD[:, :2])),
        (ValueError, "^begins: .* 0 first, and 6, .* got 0 and 4", lambda probe: probe.hull_overlaps(GOOD, [0, 4])),
        (ValueError, "^begins: .* got 1 and 6", lambda probe: probe.hull_overlaps(GOOD, [1, 6])),
        (ValueError, "^begins: row 2 is 3, .* than 7", lambda probe: probe.hull_overlaps(GOOD, [0, 7, 3, 6])),
        (ValueError, "^begins: row 1 .* -1", lambda probe: probe.hull_overlaps(GOOD, [0, -1, 6])),
        (ValueError, r"^begins: .*\(n \+ 1,\)", lambda probe: probe.hull_overlaps(GOOD, np.zeros(0, int))),
        (ValueError, r"^begins: .*\(n,\), got \(1, 2\)", lambda probe: probe.hull_overlaps(GOOD, [[0, 6]])),
        (TypeError, "^begins: .*float64", lambda probe: probe.hull_overlaps(GOOD, [0, 6.0])),
        (TypeError, "^begins", lambda probe: probe.hull_overlaps(GOOD, [[0], [6, 1]])),
        (ValueError, "^radii: expected 2 rows", lambda probe: probe.hull_overlaps(GOOD, [0, 3, 6], [1.0])),
        (TypeError, "^radii", lambda probe: probe.hull_overlaps(GOOD, radii=None)),
        (TypeError, "pairs", lambda probe: probe.distances([0, 1])),
        (TypeError, "pairs", lambda probe: probe.intersections([(0, -1)])),
        (ValueError, "pair 1: body 3 is not in the scene", lambda probe: probe.distances([(0, 0), (3, None)])),
        (ValueError, "body 3 is not in the scene", lambda probe: probe.has_intersections(3)),
        (TypeError, "a: int", lambda probe: probe.has_intersections("x")),
        (TypeError, "changes", lambda probe: probe.intersections_after([0])),
        (ValueError, "change 0: body 3", lambda probe: probe.intersections_after([softcd.MeshChange(3)])),
        (ValueError, "change 0 .*2", lambda probe: probe.intersections_after([softcd.MeshChange(0, np.array([2]))])),
        (TypeError, "^removed: .*got list", lambda _: softcd.MeshChange(0, [0.5])),
        (ValueError, r"^added: expected shape \(n, 3\)", lambda _: softcd.MeshChange(0, added=np.array([0, 1]))),
        (TypeError, "^new_vertices: .*got complex128", lambda _: softcd.MeshChange(0, new_vertices=GOOD * 1j)),
        (ValueError, "not finite", lambda probe: probe.intersections_after([change_to(GOOD * np.nan)])),
        (TypeError, "scene: softcd", lambda _: softcd.Probe(None)),
        (TypeError, "step_end", lambda _: softcd.Probe(softcd.Scene(), step_end=0.5)),
    ],
)
def test_questions_that_cannot_be_read_are_named(error, text, ask):
    with pytest.raises(error, match=text):
        ask(probe_of_one_body())


def some_arguments(choose):
    """Returns arguments of every kind, more wrong than right ones. None requires gigabytes."""
    arrays = [wrong for _, wrong in WRONG_POSITIONS.values()]
    arrays += [GOOD, PIERCING_T1, PIERCING_TRIANGLES, PIERCING_TRIANGLES.astype("i2"), GOOD.astype("f4"), GOOD[:0]]
    arrays += [np.array([[0, 1], [4, 5]]), np.array([1, 0]), np.arange(3, dtype="u2"), np.zeros(0, int)]
    arrays += [memoryview(GOOD), np.ma.masked_array(GOOD), np.zeros((6, 0)), np.zeros((0, 3), int), GOOD[:4]]
    others = [None, True, 0, 1, 6, -1, 2**32, 2**70, 0.5, -1.0, np.inf, np.nan, "", "x", b"", (), [], {}, object()]
    others += [*softcd.Detection, *softcd.Backend, *softcd.Pairs, softcd.Scene(), softcd.QueryOptions(), len]
    others += [[(0, None)], [(None, None), (0, 0)], [(7, 0)]]
    others += [softcd.MeshChange(0), [softcd.MeshChange(0, added=PIERCING_TRIANGLES)]]
    return choose(arrays) if choose([True, False]) else choose(others)


def test_random_arguments_only_raise():
    choose = random.Random(1).choice
    scene = softcd.Scene()
    query = softcd.Query(scene)
    probe = softcd.Probe(scene)
    scene.add_body(PIERCING_TRIANGLES, 6, self_collision=True)
    batch = softcd.BatchScene(1)
    batch_query = softcd.BatchQuery(batch)
    batch.add_body(PIERCING_TRIANGLES, 6)
    calls = {
        softcd.Scene: ["log", "backend", "memory_limit", "max_threads", "cuda_device"],
        softcd.Query: ["detection", "accuracy", "margins", "motion_margin", "cell_size_factor", "edge_edge"],
        softcd.QueryOptions: ["detection", "step_end", "contact_rule"],
        query.options.replace: ["detection", "margins", "nonsense"],
        scene.set_positions: ["vertices_t1", "check_finite"],
        scene.add_body: ["vertex_count", "segments", "margin", "self_collision", "filter_mask"],
        scene.update_body: ["vertex_count", "segments", "changed", "margin", "kinematic"],
        scene.set_settings: ["margin", "edge_edge", "filter_group"],
        scene.remove_body: [],
        scene.has_body: [],
        query.set_pair_filter: [],
        query.detect: ["pairs"],
        query.start: ["pairs"],
        softcd.detect: ["vertices_t1", "margin", "backend", "detection"],
        softcd.collision_free_step: ["margin", "self_collision"],
        softcd.self_intersections: ["max_threads", "memory_limit"],
        softcd.read_mesh: [],
        softcd.write_mesh: [],
        softcd.BatchScene: ["log", "backend", "max_threads"],
        softcd.BatchQuery: ["detection", "accuracy", "nonsense"],
        batch.add_body: ["vertex_count", "segments", "margin", "batch"],
        batch.set_settings: ["margin", "edge_edge", "batch"],
        batch.set_positions: ["vertices_t1", "check_finite"],
        batch.set_rest_positions: [],
        batch.set_vertex_filters: ["groups", "masks"],
        batch.set_ignored_pairs: [],
        batch_query.detect: ["pairs"],
        softcd._core.intersecting_pairs: [],
        softcd.Probe: ["step_end"],
        softcd.MeshChange: ["removed", "added", "new_vertices"],
        probe.first_hits: ["t_min", "t_max"],
        probe.all_hits: ["t_max"],
        probe.closest_points: ["max_distance"],
        probe.sphere_overlaps: [],
        probe.capsule_overlaps: [],
        probe.box_overlaps: [],
        probe.oriented_box_overlaps: [],
        probe.hull_overlaps: ["begins", "radii"],
        probe.distances: [],
        probe.distance: [],
        probe.intersections: [],
        probe.has_intersections: ["a", "b"],
        probe.intersections_after: [],
        probe.set_body_filter: [],
    }
    good = [scene, batch, 0, PIERCING_TRIANGLES, GOOD, GOOD[None], 6]
    succeeded, raised = 0, 0
    for _, call in itertools.product(range(250), calls):
        arguments = [choose(good) if choose([True, False]) else some_arguments(choose) for _ in range(choose(range(4)))]
        keywords = {name: some_arguments(choose) for name in calls[call] if choose([True, False, False])}
        try:
            call(*arguments, **keywords)
            succeeded += 1
        except (softcd.Error, TypeError, ValueError, OverflowError, AttributeError, RuntimeWarning):
            raised += 1
    assert succeeded > 100 and raised > 2000
    assert repr(scene) and len(softcd.detect(GOOD, PIERCING_TRIANGLES, PIERCING_T1)) == 1
