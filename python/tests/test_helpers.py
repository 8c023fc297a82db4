import numpy as np
import pytest

import oracle
import softcd
from meshes import PIERCING_T0, PIERCING_T1, PIERCING_TRIANGLES, sheet, soup


def test_a_step_is_free_until_something_touches():
    assert softcd.collision_free_step(PIERCING_T0, PIERCING_TRIANGLES, PIERCING_T1) == pytest.approx(0.5, abs=1e-5)
    assert softcd.collision_free_step(PIERCING_T0, PIERCING_TRIANGLES, PIERCING_T1) <= 0.5
    assert softcd.collision_free_step(PIERCING_T0, PIERCING_TRIANGLES, PIERCING_T0) == 1
    touching = PIERCING_T0.copy()
    touching[3, 2] = 0
    assert softcd.collision_free_step(touching, PIERCING_TRIANGLES, PIERCING_T1) == 0


@pytest.mark.parametrize("seed", range(4))
def test_nothing_touches_on_a_collision_free_step(seed):
    vertices_t0, triangles = soup(seed, 10, size=0.9)
    if len(softcd.self_intersections(vertices_t0, triangles)) > 0:
        vertices_t0 = vertices_t0 + [1, 0, 0] * np.repeat(np.arange(10.0), 3)[:, None]
    vertices_t1 = soup(seed + 50, 10, size=0.9)[0]
    step = softcd.collision_free_step(vertices_t0, triangles, vertices_t1)
    times = [
        oracle.first_touch(kind, vertices_t0[list(corners)], vertices_t1[list(corners)])
        for kind, corners in oracle.candidates(triangles)
    ]
    first = min(time for time in times if time is not None)
    assert first - 1e-5 < step <= first + 1e-12


def test_long_calls_tell_how_far_they_are():
    frames = [PIERCING_T0, PIERCING_T0 + 1, PIERCING_T0 + 2]
    told = []
    softcd.certify(frames, PIERCING_TRIANGLES, progress=lambda *numbers: told.append(numbers))
    assert told == [(1, 3), (2, 3), (3, 3)]
    told.clear()
    softcd.certify(iter(frames), PIERCING_TRIANGLES, progress=lambda *numbers: told.append(numbers))
    assert told == [(1, None), (2, None), (3, None)]
    told.clear()
    softcd.self_intersections(PIERCING_T0, PIERCING_TRIANGLES, progress=lambda *numbers: told.append(numbers))
    assert told == [(2, 2)]
    told.clear()
    pairs = np.zeros((0, 2), int)
    softcd.audit(
        PIERCING_T0, PIERCING_TRIANGLES, PIERCING_T1, vertex_triangle_pairs=pairs, edge_edge_pairs=pairs,
        progress=lambda *numbers: told.append(numbers))  # fmt: skip
    assert told == [(done, 11) for done in range(1, 12)]


def test_a_progress_function_can_stop_a_long_call():
    def stop(done, total):
        raise KeyboardInterrupt

    for call in (
        lambda: softcd.certify([PIERCING_T0] * 3, PIERCING_TRIANGLES, progress=stop),
        lambda: softcd.self_intersections(PIERCING_T0, PIERCING_TRIANGLES, progress=stop),
        lambda: softcd.audit(PIERCING_T0, PIERCING_TRIANGLES, vertex_triangle_pairs=[], margin=0.1, progress=stop),
    ):
        with pytest.raises(KeyboardInterrupt):
            call()


def test_a_margin_keeps_its_distance():
    step = softcd.collision_free_step(PIERCING_T0, PIERCING_TRIANGLES, PIERCING_T1, margin=0.1)
    assert step == pytest.approx(0.4, abs=1e-4) and step <= 0.4


def intersects(edge, triangle):
    """Returns whether they cross, in float64. That suffices, as no tested case is close."""
    p, q = edge
    a, b, c = triangle

    def side(*corners):
        return np.linalg.det([corners[i] - corners[3] for i in range(3)])

    sides = [side(p, q, a, b), side(p, q, b, c), side(p, q, c, a)]
    return side(a, b, c, p) * side(a, b, c, q) < 0 and (min(sides) > 0 or max(sides) < 0)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("seed", range(3))
def test_self_intersections_are_those_of_brute_force(seed, dtype):
    vertices, triangles = soup(seed, 16, size=2)
    vertices = vertices.astype(dtype)
    expected = set()
    for i, j in np.ndindex(16, 16):
        for k in range(3):
            edge = vertices[triangles[i][[k, (k + 1) % 3]]].astype(float)
            if i != j and intersects(edge, vertices[triangles[j]].astype(float)):
                expected.add((min(i, j), max(i, j)))
    found = softcd.self_intersections(vertices, triangles)
    assert found.dtype == np.uint32 and found.tolist() == sorted(map(list, expected)) and len(expected) > 10


def test_neighbours_intersect_only_elsewhere():
    vertices, triangles = sheet(5)
    assert softcd.self_intersections(vertices, triangles).shape == (0, 2)
    folded = vertices.copy()
    folded[24] = [0.3, 0.4, 0]  # the corner lands inside the first square, and touches what it passes
    found = softcd.self_intersections(folded, triangles)
    corner = int(np.flatnonzero((triangles == 24).any(axis=1))[0])
    assert len(found) > 0 and (found == corner).any(axis=1).all()


def test_self_intersections_are_found_in_parts(monkeypatch):
    vertices, triangles = soup(1, 16, size=2)
    expected = softcd.self_intersections(vertices, triangles)
    monkeypatch.setattr(softcd._helpers, "_TRIANGLES_AT_ONCE", 7)
    assert np.array_equal(softcd.self_intersections(vertices, triangles), expected)


def test_a_mesh_without_triangles_has_no_self_intersections():
    assert softcd.self_intersections(np.zeros((4, 3)), np.empty((0, 3), np.uint32)).shape == (0, 2)


def test_touching_triangles_intersect():
    vertices = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, 0], [1, 1, 2], [2, 1, 2]], np.float32)
    triangles = np.arange(6).reshape(2, 3)
    assert softcd.self_intersections(vertices, triangles).tolist() == [[0, 1]]
    vertices[3, 2] = np.nextafter(np.float32(0), np.float32(1))
    assert softcd.self_intersections(vertices, triangles).tolist() == []


def falling(heights):
    """Returns frames of the piercing triangles, with vertex 3 at these heights."""
    frames = np.repeat(PIERCING_T0[None], len(heights), axis=0)
    frames[:, 3, 2] = heights
    return frames


def test_frames_that_do_not_cross_are_proved():
    certificate = softcd.certify(falling([1, 0.5, 1e-12]), PIERCING_TRIANGLES)
    assert certificate.proved
    assert [len(contacts) for contacts in certificate.contacts] == [0, 0]
    assert [len(pairs) for pairs in certificate.intersections] == [0, 0, 0]


def test_frames_that_cross_or_touch_are_not_proved():
    for heights in ([1, -1e-12], [1, 0], [-1, -1]):
        assert not softcd.certify(falling(heights), PIERCING_TRIANGLES).proved
    certificate = softcd.certify((frame for frame in falling([2, 1, -1])), PIERCING_TRIANGLES)
    assert [len(contacts) for contacts in certificate.contacts] == [0, 1]
    assert certificate.contacts[1]["vertices"].tolist() == [[3, 0, 1, 2]]
    assert [pairs.tolist() for pairs in certificate.intersections] == [[], [], [[0, 1]]]


def test_distances_are_proved():
    frames = falling([1, 0.5]).astype(np.float32)
    assert softcd.certify(frames, PIERCING_TRIANGLES, margin=0.2499).proved
    certificate = softcd.certify(frames, PIERCING_TRIANGLES, margin=0.25)
    assert not certificate.proved and [len(pairs) for pairs in certificate.intersections] == [0, 0]


def test_frames_that_cannot_be_proved_are_refused():
    frames = falling([1, 0.5, np.nan])
    with pytest.raises(softcd.InvalidInput, match="frame 2 has a position that is not finite"):
        softcd.certify(frames, PIERCING_TRIANGLES)
    with pytest.raises(softcd.InvalidInput, match="there are 1; give at least two"):
        softcd.certify(frames[:1], PIERCING_TRIANGLES)
    with pytest.raises(softcd.InvalidInput, match="there are 0; give at least two"):
        softcd.certify([], PIERCING_TRIANGLES)
    with pytest.raises(softcd.InvalidInput, match=r"frame 1 has the shape \(5, 3\), not \(6, 3\)"):
        softcd.certify([frames[0], frames[1, :5]], PIERCING_TRIANGLES)
    with pytest.raises(softcd.InvalidInput, match="nothing to prove"):
        softcd.certify(frames[:2], np.empty((0, 3), int))
    with pytest.raises(softcd.InvalidInput, match="frames"):
        softcd.certify(frames[:2, 0], PIERCING_TRIANGLES)
    with pytest.raises(TypeError, match="margin"):
        softcd.certify(frames[:2], PIERCING_TRIANGLES, margins=1)
