"""Compares probes with results that separate code finds one by one, in float64."""

import gc
import itertools
import weakref

import numpy as np
import pytest

import softcd
from meshes import sheet, soup
from oracle import point_triangle_distance, segment_distance

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
SQUARE_TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]])


def scene_of(*meshes):
    scene = softcd.Scene()
    for vertices, triangles in meshes:
        scene.set_positions(scene.add_body(triangles, len(vertices)), vertices)
    return scene


def soups(count=2, triangle_count=20):
    """Yields soups of triangles whose positions are exact in float32."""
    for seed in range(count):
        vertices, triangles = soup(seed, triangle_count, size=1)
        yield vertices.astype(np.float32).astype(float), triangles


def corners_of(meshes):
    """Yields (body, triangle, its three corners) of all triangles."""
    for body, (vertices, triangles) in enumerate(meshes):
        for triangle, corners in enumerate(vertices[triangles]):
            yield body, triangle, corners


def ray_meets(origin, direction, corners):
    """Returns the t at which the ray meets the triangle, or None."""
    a, b, c = corners
    matrix = np.stack([b - a, c - a, -direction], axis=1)
    if abs(np.linalg.det(matrix)) < 1e-12:
        return None
    u, v, t = np.linalg.solve(matrix, origin - a)
    return t if min(u, v, 1 - u - v) >= 0 else None


def segment_meets(p, q, corners):
    t = ray_meets(p, q - p, corners)
    return t is not None and 0 <= t <= 1


def segment_triangle_distance(p, q, corners):
    if segment_meets(p, q, corners):
        return 0.0
    sides = [segment_distance(p, q, corners[i], corners[i - 1]) for i in range(3)]
    return min(*sides, point_triangle_distance(p, *corners), point_triangle_distance(q, *corners))


def reaches_into(corners, sides):
    """Returns whether some of the triangle is within all sides: (outward normal, distance along it)."""
    polygon = list(corners)
    for normal, limit in sides:
        inside = [limit - normal @ p for p in polygon]
        cut = []
        for i, p in enumerate(polygon):
            if inside[i - 1] * inside[i] < 0:
                cut.append(polygon[i - 1] + inside[i - 1] / (inside[i - 1] - inside[i]) * (p - polygon[i - 1]))
            if inside[i] >= 0:
                cut.append(p)
        polygon = cut
    return len(polygon) > 0


def sides_of_box(low, high):
    return [(normal, high @ normal) for normal in np.eye(3)] + [(-normal, -low @ normal) for normal in np.eye(3)]


def sides_of_tetrahedron(corners):
    sides = []
    for i in range(4):
        x, y, z = np.delete(corners, i, axis=0)
        normal = np.cross(y - x, z - x)
        normal *= np.sign(normal @ (x - corners[i]))
        sides.append((normal, normal @ x))
    return sides


def triangles_intersect(a, b):
    return any(segment_meets(x[i], x[i - 1], y) for x, y in ((a, b), (b, a)) for i in range(3))


def pairs_of(answers):
    return list(zip(answers["body"].tolist(), answers["triangle"].tolist()))


def test_rays_meet_what_each_triangle_says():
    meshes = list(soups())
    probe = softcd.Probe(scene_of(*meshes))
    random = np.random.default_rng(1)
    origins, directions = random.random((50, 3)), random.normal(size=(50, 3))
    first = probe.first_hits(origins, directions, t_max=2.0)
    found = probe.all_hits(origins, directions, t_max=np.full(50, 2.0))
    assert len(first) == len(found) == 50
    hit_count = 0
    for ray in range(50):
        expected = []
        for body, triangle, corners in corners_of(meshes):
            t = ray_meets(origins[ray], directions[ray], corners)
            if t is not None and 0 <= t <= 2:
                expected.append((t, body, triangle))
        expected.sort()
        assert pairs_of(found[ray]) == [(body, triangle) for _, body, triangle in expected]
        assert np.allclose(found[ray]["t"], [t for t, *_ in expected], rtol=1e-9)
        hit_count += len(expected)
        if expected:
            assert first[ray] == found[ray][0]
            corners = meshes[first[ray]["body"]][0][meshes[first[ray]["body"]][1][first[ray]["triangle"]]]
            point = origins[ray] + first[ray]["t"] * directions[ray]
            assert np.allclose(first[ray]["weights"] @ corners, point, atol=1e-5)
        else:
            assert first[ray]["body"] == first[ray]["triangle"] == softcd.NO_BODY
    assert hit_count > 30


def test_nearest_points_are_the_least_distances():
    meshes = list(soups())
    probe = softcd.Probe(scene_of(*meshes))
    points = np.random.default_rng(2).random((20, 3))
    closest = probe.closest_points(points)
    within = probe.closest_points(points, max_distance=0.05)
    for i, point in enumerate(points):
        expected = min((point_triangle_distance(point, *x), body, face) for body, face, x in corners_of(meshes))
        assert closest[i]["distance"] == pytest.approx(expected[0], abs=1e-9)
        assert (closest[i]["body"], closest[i]["triangle"]) == expected[1:]
        assert np.linalg.norm(closest[i]["position"] - point) == pytest.approx(expected[0], abs=1e-9)
        assert (within[i]["body"] == softcd.NO_BODY) == (expected[0] > 0.05)


def test_the_side_of_a_closed_surface():
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    probe = softcd.Probe(scene_of((corners, np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]))))
    assert probe.closest_points([[0.1, 0.1, 0.1], [2, 2, 2]])["side"].tolist() == [-1, 1]


def test_shapes_overlap_what_each_triangle_says():
    meshes = list(soups(2, 12))
    probe = softcd.Probe(scene_of(*meshes))
    random = np.random.default_rng(3)
    centres, ends, halves = random.random((12, 3)), random.random((12, 3)), 0.05 + 0.2 * random.random((12, 3))
    turned = np.stack([np.linalg.qr(random.normal(size=(3, 3)))[0].T for _ in range(12)])
    tetrahedra = random.random((12, 4, 3))
    answers = {
        "spheres": probe.sphere_overlaps(centres, 0.15),
        "capsules": probe.capsule_overlaps(centres, ends, halves[:, 0]),
        "boxes": probe.box_overlaps(centres - halves, centres + halves),
        "turned boxes": probe.oriented_box_overlaps(centres, halves, turned),
        "hulls": probe.hull_overlaps(tetrahedra.reshape(-1, 3), np.arange(0, 49, 4)),
    }
    for i in range(12):
        overlaps = {
            "spheres": lambda x: point_triangle_distance(centres[i], *x) <= 0.15,
            "capsules": lambda x: segment_triangle_distance(centres[i], ends[i], x) <= halves[i, 0],
            "boxes": lambda x: reaches_into(x, sides_of_box(centres[i] - halves[i], centres[i] + halves[i])),
            "turned boxes": lambda x: reaches_into((x - centres[i]) @ turned[i].T, sides_of_box(-halves[i], halves[i])),
            "hulls": lambda x: reaches_into(x, sides_of_tetrahedron(tetrahedra[i])),
        }
        for shape, overlap in overlaps.items():
            expected = [(body, triangle) for body, triangle, corners in corners_of(meshes) if overlap(corners)]
            assert pairs_of(answers[shape][i]) == expected, f"{shape}, {i}"
    assert all(len(found.all) > 9 for found in answers.values())


def test_hulls_of_the_corners_of_other_shapes_overlap_the_same():
    probe = softcd.Probe(scene_of(*soups(2, 12)))
    random = np.random.default_rng(4)
    centres, ends, radii = random.random((12, 3)), random.random((12, 3)), 0.05 + 0.2 * random.random(12)
    low, high = np.minimum(centres, ends), np.maximum(centres, ends)
    corners = np.stack([np.where(of_high, high, low) for of_high in itertools.product((True, False), repeat=3)], axis=1)
    balls, capsules = probe.sphere_overlaps(centres, radii), probe.capsule_overlaps(centres, ends, radii)
    answers = {
        "spheres": (balls, probe.hull_overlaps(centres, np.arange(13), radii)),
        "capsules": (capsules, probe.hull_overlaps(np.hstack([centres, ends]).reshape(-1, 3), range(0, 25, 2), radii)),
        "boxes": (probe.box_overlaps(low, high), probe.hull_overlaps(corners.reshape(-1, 3), np.arange(0, 97, 8))),
    }
    for shape, (expected, found) in answers.items():
        assert len(expected.all) > 9 and found.begins.tolist() == expected.begins.tolist(), shape
        assert found.all.tobytes() == expected.all.tobytes(), shape
    for places in (centres[2], centres[2:3], [centres[2]] * 3):
        assert [pairs_of(found) for found in probe.hull_overlaps(places, radii=radii[2])] == [pairs_of(balls[2])]
    mixed = probe.hull_overlaps([*corners[3], centres[2], ends[2]], [0, 8, 8, 10], [0, 1, radii[2]])
    expected = [pairs_of(answers["boxes"][0][3]), [], pairs_of(capsules[2])]
    assert [pairs_of(found) for found in mixed] == expected and expected[0] and expected[2]
    assert len(probe.hull_overlaps(np.zeros((0, 3)), np.array([0]))) == 0
    assert [len(found) for found in probe.hull_overlaps(np.zeros((0, 3)), radii=1)] == [0]


def triangle_distance(a, b):
    sides = [segment_triangle_distance(x[i], x[i - 1], y) for x, y in ((a, b), (b, a)) for i in range(3)]
    return min(sides)


def test_distances_are_the_least_of_all_triangles():
    meshes = [(vertices + [0, 0, 2.0 * i], triangles) for i, (vertices, triangles) in enumerate(soups(3, 4))]
    probe = softcd.Probe(scene_of(*meshes))
    found = probe.distances([(0, 1), (2, 0), (1, None), (0, 0)])
    for answer, (a, b) in zip(found, [(0, 1), (2, 0)]):
        expected = min(triangle_distance(x, y) for x in meshes[a][0][meshes[a][1]] for y in meshes[b][0][meshes[b][1]])
        assert answer["distance"] == pytest.approx(expected, abs=1e-6)
        assert np.linalg.norm(answer["position_a"] - answer["position_b"]) == pytest.approx(expected, abs=1e-6)
        assert (answer["body_a"], answer["body_b"]) == (a, b)
    assert found[2]["distance"] == min(probe.distance(1, 0)["distance"], probe.distance(1, 2)["distance"])
    assert found[3]["body_a"] == softcd.NO_BODY


def expected_intersections(meshes, a, b):
    faces_of = [enumerate(meshes[body][0][meshes[body][1]]) for body in (a, b)]
    for (i, x), (j, y) in itertools.product(*faces_of):
        if (a != b or i < j) and triangles_intersect(x, y):
            yield a, i, b, j


def test_intersections_are_those_of_all_triangles():
    meshes = list(soups(2, 12))
    probe = softcd.Probe(scene_of(*meshes))
    found = probe.intersections([(0, 1), (1, 1), (0, None)])
    between, within = (list(expected_intersections(meshes, *pair)) for pair in ((0, 1), (1, 1)))
    assert len(between) > 3 and len(within) > 3
    assert [tuple(answer) for answer in found[0].tolist()] == between
    assert [tuple(answer) for answer in found[1].tolist()] == within
    assert found[2].tolist() == found[0].tolist()
    everything = probe.intersections().all.tolist()
    assert everything == sorted([*between, *within, *expected_intersections(meshes, 0, 0)])
    assert probe.has_intersections() and probe.has_intersections(1, 1) and probe.has_intersections(0)
    flat = softcd.Probe(scene_of(sheet(5)))
    assert not flat.has_intersections() and len(flat.intersections().all) == 0


def test_regions_of_a_needle_through_a_sheet():
    vertices, triangles = sheet(5)
    corners = np.array([[x, y, z] for z in (-1, 1) for y in (2.1, 2.2) for x in (2.6, 2.7)])
    faces = [[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4]]
    faces += [[2, 6, 3], [3, 6, 7], [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]]
    probe = softcd.Probe(scene_of((vertices, triangles), (corners, np.array(faces))))
    found = probe.intersection_regions()
    assert repr(found) == "<softcd.IntersectionRegions, 2 regions, 1 curves>" and found.touching_pairs == 0
    assert found.curves["is_closed"].all() and abs(found.curves["length"][0] - 0.4) < 1e-3
    assert len(found.points_of(0)) == found.curves["point_count"][0]
    assert abs(found.points["position"][:, 2]).max() < 1e-6
    hole, half = found
    assert (hole["body"], hole["other"], half["body"], half["other"]) == (0, 1, 1, 0)
    assert hole["is_inside"] and not half["is_inside"] and hole["kind"] == softcd.RegionKind.closed
    assert len(found.vertices_of(0)) == 0 and abs(hole["area"] - 0.01) < 1e-3
    assert set(found.triangles_of(0)) <= set(range(len(triangles)))
    ends = found.vertices_of(1)
    assert len(ends) == 4 and len(found.curves_of(1)) == 1
    ends_on_sheet = corners[ends["vertex"]] + ends["direction"] * ends["distance"][:, None]
    assert abs(ends_on_sheet[:, 2]).max() < 1e-6
    assert len(probe.intersection_regions(0, 0)) == 0
    with pytest.raises(softcd.InvalidInput, match="body 7"):
        probe.intersection_regions(7)


def test_a_change_intersects_what_it_does_when_it_is_made():
    vertices, triangles = sheet(4)
    needle = np.array([[0.4, 0.2, -1], [0.4, 0.2, 1], [0.5, 0.2, 1]])
    scene = scene_of((vertices, triangles), (needle + [0, 0, 5.0], np.array([[0, 1, 2]])))
    probe = softcd.Probe(scene)
    assert not probe.has_intersections()
    # A vertex is put into the first triangle's middle, and pulled up through the needle, or only a little.
    a, b, c = triangles[0]
    new = np.array([[a, b, 16], [b, c, 16], [c, a, 16]])
    high, low = (np.float32([[0.4, 0.3, height]]) for height in (9, 0.5))
    changes = [softcd.MeshChange(0, removed=np.array([0]), added=new, new_vertices=x) for x in (high, low)]
    assert "body 0: 1 triangles removed, 3 added, 1 new vertices" in repr(changes[0])
    answers = probe.intersections_after([*changes, softcd.MeshChange(1)])
    assert [len(answer) for answer in answers[1:]] == [0, 0]

    changed = np.concatenate([triangles[1:], new])
    scene.update_body(0, changed, 17)
    scene.set_positions(0, np.concatenate([vertices, high]))
    expected = probe.intersections([(0, 1)]).all
    assert len(expected) > 0
    assert answers[0]["added"].tolist() == (expected["triangle_a"] - (len(changed) - 3)).tolist()
    assert pairs_of(answers[0]) == list(zip(expected["body_b"], expected["triangle_b"]))


def test_ends_of_the_step_and_filters_of_bodies():
    scene = scene_of((SQUARE, SQUARE_TRIANGLES), (SQUARE + [0, 0, 2], SQUARE_TRIANGLES))
    scene.set_positions(0, SQUARE, SQUARE + [0, 0, 4])
    ray = ([0.6, 0.3, 9], [0, 0, -1])
    at_t0, at_t1 = softcd.Probe(scene, step_end=softcd.StepEnd.t0), softcd.Probe(scene)
    assert at_t0.all_hits(*ray)[0]["body"].tolist() == [1, 0]
    assert at_t1.all_hits(*ray)[0]["body"].tolist() == [0, 1]
    asked = []
    at_t1.set_body_filter(lambda body: asked.append(body) or body != 0)
    assert at_t1.first_hits(*ray)["body"].tolist() == [1]
    assert asked == [0, 1]
    with pytest.raises(softcd.Error, match="must not call"):
        at_t1.set_body_filter(lambda body: scene.has_body(body))
        at_t1.first_hits(*ray)
    with pytest.raises(ZeroDivisionError):
        at_t1.set_body_filter(lambda body: 1 // 0)
        at_t1.first_hits(*ray)
    at_t1.set_body_filter(None)
    assert at_t1.first_hits(*ray)["body"].tolist() == [0]


def test_answers_stay_and_scenes_live_as_long_as_their_probes():
    probe = softcd.Probe(scene_of((SQUARE, SQUARE_TRIANGLES)))
    first = probe.first_hits([0.6, 0.3, 9], [0, 0, -1])
    kept = first.copy()
    gc.collect()
    probe.first_hits(np.zeros((1000, 3)), [0, 0, 1])
    assert (first == kept).all() and first.flags.writeable
    lists = probe.all_hits([[0.6, 0.3, 9]] * 3, [0, 0, -1])
    assert repr(lists) == "<softcd.AnswerLists, 3 answers to 3 questions>"
    assert len(lists[1:]) == 2 and lists[-1].tobytes() == lists[0].tobytes()
    assert sum(len(hits) for hits in lists) == len(lists.all)
    with pytest.raises(IndexError):
        lists[3]

    class Filter:
        def __call__(self, body):
            return self.probe is not None

    in_a_cycle = Filter()
    in_a_cycle.probe = probe
    probe.set_body_filter(in_a_cycle)
    gone = weakref.ref(in_a_cycle)
    del in_a_cycle, probe
    gc.collect()
    assert gone() is None


def test_arrays_that_no_question_has_read_are_kept():
    """The next query or detection reads positions. Arrays are released only then."""
    scene = softcd.Scene()
    body = scene.add_body(SQUARE_TRIANGLES, 4)
    probe = softcd.Probe(scene)
    on_device = softcd.Query(scene, contacts_on_device=True)
    array = SQUARE.copy()
    gone = weakref.ref(array)
    scene.set_positions(body, array)
    del array
    assert len(probe.first_hits(np.zeros((0, 3)), [0, 0, 1])) == 0
    with pytest.raises(softcd.InvalidInput, match="pair 0: body 7"):
        probe.has_intersections(7)
    with pytest.raises(softcd.InvalidInput, match="change 0: body 7"):
        probe.intersections_after([softcd.MeshChange(7)])
    with pytest.raises(softcd.BackendError):
        on_device.start()
    gc.collect()
    assert gone() is not None
    assert probe.first_hits([0.6, 0.3, 9], [0, 0, -1])["t"].tolist() == [9]
    assert gone() is None


def test_nothing_is_near_where_there_is_nothing():
    probe = softcd.Probe(softcd.Scene())
    assert probe.first_hits([0, 0, 0], [0, 0, 1])["body"].tolist() == [softcd.NO_BODY]
    assert not probe.has_intersections() and len(probe.intersections([])) == 0
    assert probe.closest_points(np.full((2, 3), np.nan))["body"].tolist() == [softcd.NO_BODY] * 2
    assert [len(found) for found in probe.sphere_overlaps(np.zeros((2, 3)), [1, -1])] == [0, 0]
    scene = scene_of((SQUARE, SQUARE_TRIANGLES))
    probe = softcd.Probe(scene)
    assert probe.closest_points([0, 0, 1])["body"] == 0
    scene.remove_body(0)
    nothing = probe.closest_points([0, 0, 1])
    assert nothing["body"] == softcd.NO_BODY and nothing["distance"] == np.inf
    assert probe.first_hits([0, 0, 0], [0, 0, 1])["t"] == np.inf
