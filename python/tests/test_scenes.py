import gc
import threading
import warnings
import weakref

import numpy as np
import pytest

import softcd
from meshes import PIERCING_T0, PIERCING_T1, PIERCING_TRIANGLES, sheet, soup


def piercing_scene(**options):
    scene = softcd.Scene(**options)
    body = scene.add_body(PIERCING_TRIANGLES, 6, self_collision=True)
    scene.set_positions(body, PIERCING_T0, PIERCING_T1)
    return scene, body


def ccd(scene, **options):
    return softcd.Query(scene, detection=softcd.Detection.ccd, **options)


def test_queries_of_one_scene_find_different_things():
    scene, _ = piercing_scene()
    at_the_end = softcd.Query(scene)
    on_the_way = ccd(scene)
    assert len(on_the_way.detect()) == 1 and len(at_the_end.detect()) == 0
    assert on_the_way.statistics.vt_contacts == 1 and at_the_end.statistics.vt_contacts == 0
    assert on_the_way.statistics.backend == scene.backend
    assert on_the_way.statistics.ms.total > 0


def test_bodies_come_change_and_go():
    scene, body = piercing_scene()
    query = ccd(scene)
    assert len(scene) == 1 and scene.has_body(body)
    scene.set_settings(body, self_collision=False)
    assert len(query.detect()) == 0
    scene.update_body(body, PIERCING_TRIANGLES, 6)
    with pytest.warns(RuntimeWarning, match="has no positions"):
        assert len(query.detect()) == 0
    scene.set_positions(body, PIERCING_T0, PIERCING_T1)
    assert len(query.detect()) == 1
    scene.remove_body(body)
    assert len(scene) == 0 and not scene.has_body(body)
    assert len(query.detect()) == 0


def test_ropes_are_segments():
    x = np.array([[0, 0, 1], [1, 0, 1], [2, 0, 1]], float)
    moved = x - [0, 0, 2]
    across = np.array([[0.25, -1, 0], [0.25, 1, 0], [1.75, -1, 0], [1.75, 1, 0]], float)
    scene = softcd.Scene()
    rope = scene.add_body(np.zeros((0, 3), int), 3, segments=np.array([[0, 1], [1, 2]]), edge_edge=True)
    post = scene.add_body(np.zeros((0, 3), int), 4, segments=np.array([[0, 1], [2, 3]], np.int16), edge_edge=True)
    scene.set_positions(rope, x, moved)
    scene.set_positions(post, across)
    contacts = ccd(scene).detect()
    assert (contacts["kind"] == softcd.ContactKind.edge_edge).all()
    assert sorted(zip(contacts["feature_a"], contacts["feature_b"])) == [(0, 0), (1, 1)]
    assert np.allclose(contacts["time_of_impact"], 0.5)
    scene.update_body(rope, np.zeros((0, 3), int), 3, segments=np.array([[1, 2]]), edge_edge=True)
    scene.set_positions(rope, x, moved)
    assert len(ccd(scene).detect()) == 1


def told(contacts):
    """Returns the contacts without edges' numbers and order, which differ after a change of the mesh."""
    is_edges = contacts["kind"] == softcd.ContactKind.edge_edge
    features = [sorted([v[:2], v[2:]]) if e else [v] for e, v in zip(is_edges, contacts["vertices"].tolist())]
    return sorted(zip(is_edges, features, contacts["distance"]))


def torn(triangles, first_new_vertex, which):
    """Returns the mesh, with new vertices as the corners of some triangles."""
    triangles = triangles.copy()
    triangles[which] = first_new_vertex + np.arange(3 * len(which)).reshape(-1, 3)
    return triangles


def test_changed_triangles_are_all_that_is_read():
    vertices, triangles = sheet(12)
    vertices[:, 2] = 3 * np.random.default_rng(3).random(len(vertices))
    scene = softcd.Scene()
    settings = {"self_collision": True, "edge_edge": True, "margin": 0.1}
    body = scene.add_body(triangles, len(vertices), **settings)
    scene.set_positions(body, vertices)
    before = len(softcd.Query(scene).detect())

    for which in (np.array([7, 3, 100]), np.array([3, 200])):
        triangles = torn(triangles, len(vertices), which)
        vertices = np.concatenate([vertices, vertices[: 3 * len(which)] + 0.05])
        only_changed = np.full_like(triangles, 77777)
        only_changed[which] = triangles[which]
        scene.update_body(body, only_changed, len(vertices), changed=which, **settings)
        scene.set_positions(body, vertices)
        # Float positions: distances of touching edges are not all rounding, and do not depend on the edges' order.
        contacts = softcd.Query(scene, accuracy=softcd.Accuracy.precise).detect()
        fresh = softcd.detect(vertices, triangles, margin=0.1, accuracy=softcd.Accuracy.precise)
        assert len(contacts) == len(fresh) != before
        assert told(contacts) == told(fresh)

    with pytest.raises(softcd.InvalidInput, match="triangle 0 has vertex index 77777"):
        scene.update_body(body, only_changed, len(vertices), **settings)


def test_only_changed_pairs_are_looked_at():
    scene, body = piercing_scene()
    query = ccd(scene)
    assert len(query.detect(softcd.Pairs.changed)) == 1
    assert len(query.detect(softcd.Pairs.changed)) == 0
    scene.set_positions(body, PIERCING_T0, PIERCING_T1)
    assert len(query.start(softcd.Pairs.changed).wait()) == 1
    assert len(query.detect()) == 1


def test_pairs_of_bodies_are_ignored_or_the_only_ones():
    scene, body = piercing_scene()
    query = ccd(scene)
    scene.set_ignored_pairs([(body, body)])
    assert len(query.detect()) == 0
    scene.set_ignored_pairs([])
    query.set_only_pairs([(body, body + 1)])
    assert len(query.detect()) == 0
    query.set_only_pairs([])
    assert len(query.detect()) == 1
    with pytest.raises(softcd.InvalidInput, match="body 7 is not in the scene"):
        scene.set_ignored_pairs([(body, 7)])


def test_vertices_have_groups_and_masks():
    scene, body = piercing_scene()
    query = ccd(scene)
    scene.set_vertex_filters(body, masks=np.zeros(6, np.uint32))
    assert len(query.detect()) == 0
    scene.set_vertex_filters(body, np.uint32([1, 1, 1, 2, 2, 2]), np.uint32([2, 2, 2, 1, 1, 1]))
    assert len(query.detect()) == 1
    scene.set_vertex_filters(body)
    assert len(query.detect()) == 1
    with pytest.raises(softcd.InvalidInput, match="groups and masks"):
        scene.set_vertex_filters(body, np.zeros(6, np.uint32), np.zeros(5, np.uint32))


def test_neighbours_and_what_is_near_at_rest_do_not_touch():
    scene, body = piercing_scene()
    query = ccd(scene)
    scene.set_settings(body, self_collision=True, rest_distance=100.0, neighbour_rings=2)
    with pytest.raises(softcd.InvalidInput, match="rest_distance is 100"):
        query.detect()
    scene.set_rest_positions(body, PIERCING_T0)
    assert len(query.detect()) == 0
    query.options = query.options.replace(neighbour_filters=False)
    assert len(query.detect()) == 1
    scene.set_rest_positions(body, None)
    assert len(query.detect()) == 1


def test_pair_filters_are_asked():
    scene, body = piercing_scene()
    query = ccd(scene)
    asked = []
    query.set_pair_filter(lambda a, b: asked.append((a, b)))
    assert len(query.detect()) == 0 and asked == [(body, body)]
    query.set_pair_filter(None)
    assert len(query.detect()) == 1


def test_what_a_pair_filter_raises_comes_through():
    scene, _ = piercing_scene()
    query = ccd(scene)
    query.set_pair_filter(lambda a, b: {}["missing"])
    with pytest.raises(KeyError, match="missing"):
        query.detect()
    query.set_pair_filter(None)
    assert len(query.detect()) == 1


def test_callbacks_must_not_call_the_scene():
    scene, _ = piercing_scene()
    query = ccd(scene)
    query.set_pair_filter(lambda a, b: query.detect())
    with pytest.raises(softcd.Error, match="must not call"):
        query.detect()


def test_vertices_that_are_not_finite_are_refused_or_left_out_with_a_warning():
    scene, body = piercing_scene()
    broken = PIERCING_T1.copy()
    broken[4, 1] = np.nan
    with pytest.raises(ValueError, match="vertices_t1: row 4"):
        scene.set_positions(body, PIERCING_T0, broken)
    query = ccd(scene)
    assert len(query.detect()) == 1
    scene.set_positions(body, PIERCING_T0, broken, check_finite=False)
    with pytest.warns(RuntimeWarning, match="vertex 4 is not finite"):
        query.detect()
    assert query.statistics.left_out_triangles == 1


def test_logs_are_told_instead_of_warnings():
    told = []
    scene, body = piercing_scene(log=lambda level, text: told.append((level, text)))
    broken = np.full_like(PIERCING_T0, np.inf)
    scene.set_positions(body, broken, check_finite=False)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        softcd.Query(scene).detect()
    assert told[-1][0] == softcd.LogLevel.warning and "not finite" in told[-1][1]


def test_tickets_are_waited_for_once():
    scene, _ = piercing_scene()
    query = ccd(scene)
    ticket = query.start()
    assert len(ticket.wait()) == 1
    with pytest.raises(softcd.Error, match="waited for twice"):
        ticket.wait()
    late = query.start()
    query.detect()
    with pytest.raises(softcd.Error, match="another detection"):
        late.wait()


def test_options_can_be_read_compared_and_replaced():
    scene, _ = piercing_scene(backend=softcd.Backend.cpu, max_threads=1)
    assert scene.options == softcd.SceneOptions(backend=softcd.Backend.cpu, max_threads=1)
    query = softcd.Query(scene, motion_margin=0.5)
    assert query.options == softcd.QueryOptions(motion_margin=0.5) != softcd.QueryOptions()
    assert hash(query.options) == hash(softcd.QueryOptions(motion_margin=0.5))
    query.options = query.options.replace(detection=softcd.Detection.ccd)
    assert query.options.detection == softcd.Detection.ccd and query.options.motion_margin == 0.5
    assert len(query.detect()) == 1
    with pytest.raises(AttributeError):
        query.options.margins = False


def test_reprs_can_be_read():
    scene, _ = piercing_scene(backend=softcd.Backend.cpu)
    query = ccd(scene, cell_size_factor=1.5, reuse_pairs=False)
    assert repr(scene) == "<softcd.Scene of 1 body, Backend.cpu>"
    assert repr(query).startswith("<softcd.Query QueryOptions(detection=Detection.ccd, ")
    assert "cell_size_factor=1.5" in repr(query)
    query.detect()
    assert "vt_contacts=1" in repr(query.statistics) and "ms=StageTimes(total=" in repr(query.statistics)
    assert repr(query.explain()[0]).startswith("StageReport(stage=DetectionStage.backend, ran=True, reason='cpu: ")
    settings = {"detection": softcd.Detection.ccd}
    assert eval(repr(softcd.QueryOptions(**settings)), vars(softcd)) == softcd.QueryOptions(**settings)


def test_threads_with_scenes_of_their_own_find_the_same():
    vertices, triangles = sheet(30)
    moved = vertices + 3 * np.random.default_rng(5).random(vertices.shape)
    expected = softcd.detect(vertices, triangles, moved)
    assert len(expected) > 100
    found = {}

    def work(name):
        scene = softcd.Scene()
        body = scene.add_body(triangles, len(vertices), self_collision=True, edge_edge=True)
        query = ccd(scene, accuracy=softcd.Accuracy.conservative)
        for _ in range(4):
            scene.set_positions(body, vertices, moved)
            found[name] = query.detect()

    threads = [threading.Thread(target=work, args=(name,)) for name in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert np.array_equal(found[0], expected) and np.array_equal(found[1], expected)


def test_threads_that_share_a_scene_wait_for_each_other():
    vertices, triangles = soup(6)
    scene = softcd.Scene()
    body = scene.add_body(triangles, len(vertices), self_collision=True, edge_edge=True, margin=0.05)
    scene.set_positions(body, vertices)
    queries = [softcd.Query(scene), softcd.Query(scene, edge_edge=False)]
    expected = [query.detect().copy() for query in queries]
    wrong = []

    def work(query, contacts):
        query.set_pair_filter(lambda a, b: True)
        for _ in range(30):
            scene.set_positions(body, vertices.copy())
            if not np.array_equal(query.detect(), contacts):
                wrong.append(query)

    threads = [threading.Thread(target=work, args=pair) for pair in zip(queries, expected)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong


def test_other_threads_run_while_a_detection_does():
    vertices, triangles = sheet(60)
    moved = vertices + 3 * np.random.default_rng(5).random(vertices.shape)
    scene = softcd.Scene(max_threads=1)
    body = scene.add_body(triangles, len(vertices), self_collision=True, edge_edge=True)
    query = ccd(scene, accuracy=softcd.Accuracy.conservative)
    done = threading.Event()
    turns = 0

    def detect():
        scene.set_positions(body, vertices, moved)
        query.detect()
        done.set()

    thread = threading.Thread(target=detect)
    thread.start()
    while not done.wait(0.001):
        turns += 1
    thread.join()
    assert turns > 2


def test_cycles_through_callbacks_are_collected():
    class Callback:
        def __call__(self, *arguments):
            return True

    log, pair_filter = Callback(), Callback()
    scene, _ = piercing_scene(log=log)
    query = ccd(scene)
    query.set_pair_filter(pair_filter)
    log.scene, pair_filter.query, pair_filter.ticket = scene, query, query.start()
    watched = [weakref.ref(log), weakref.ref(pair_filter)]
    del log, pair_filter, scene, query
    gc.collect()
    assert all(callback() is None for callback in watched)


def test_errors_are_what_python_users_catch():
    assert str(softcd.InvalidInput) == "<class 'softcd.InvalidInput'>"
    assert issubclass(softcd.Error, RuntimeError)
    assert issubclass(softcd.InvalidInput, softcd.Error) and issubclass(softcd.InvalidInput, ValueError)
    assert issubclass(softcd.OutOfMemory, softcd.Error) and issubclass(softcd.OutOfMemory, MemoryError)
    assert issubclass(softcd.BackendError, softcd.Error) and issubclass(softcd.BackendError, RuntimeError)
    assert issubclass(softcd.MeshError, softcd.Error) and issubclass(softcd.MeshError, ValueError)


def test_too_little_memory_is_an_error_and_the_scene_stays_usable():
    scene, _ = piercing_scene(backend=softcd.Backend.cpu, memory_limit=100)
    with pytest.raises(MemoryError, match="memory_limit of 100 bytes"):
        ccd(scene).detect()
    assert len(scene) == 1
