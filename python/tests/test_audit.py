"""Tests softcd.audit with lists that brute force makes, and with lists that are wrong on purpose."""

import json
import pathlib

import numpy as np
import pytest

import oracle
import softcd
from meshes import PIERCING_T0, PIERCING_T1, PIERCING_TRIANGLES, soup
from softcd import _pair_geometry

VT, EE = softcd.ContactKind.vertex_triangle, softcd.ContactKind.edge_edge


def true_pairs(vertices_t0, triangles, vertices_t1=None, reach=0.0):
    """Returns what brute force finds: vertices and triangles, of shape (k, 2), and edges, of shape (k, 4)."""
    faces = [tuple(t) for t in triangles.tolist()]
    pairs = {oracle.VERTEX_TRIANGLE: [], oracle.EDGE_EDGE: []}
    for kind, corners in oracle.candidates(triangles):
        x_t0 = vertices_t0[list(corners)]
        if vertices_t1 is None:
            touches = oracle.distance(kind, x_t0) <= reach
        else:
            touches = oracle.first_touch(kind, x_t0, vertices_t1[list(corners)]) is not None
        if touches:
            is_face = kind == oracle.VERTEX_TRIANGLE
            pairs[kind].append((corners[0], faces.index(corners[1:])) if is_face else corners)
    return np.array(pairs[0]).reshape(-1, 2), np.array(pairs[1]).reshape(-1, 4)


def features(found):
    return {(int(row["kind"]), *row["vertices"].tolist()) for row in found}


def moving(seed):
    vertices_t0, triangles = soup(seed, 10, size=0.9)
    return vertices_t0, triangles, soup(seed + 50, 10, size=0.9)[0]


@pytest.mark.parametrize("seed", range(4))
def test_the_pairs_of_brute_force_are_all_confirmed(seed):
    vertices_t0, triangles, vertices_t1 = moving(seed)
    vertex_triangle, edge_edge = true_pairs(vertices_t0, triangles, vertices_t1)
    audit = softcd.audit(
        vertices_t0, triangles, vertices_t1, vertex_triangle_pairs=vertex_triangle, edge_edge_pairs=edge_edge
    )
    assert audit.is_correct and len(audit.undecided) == len(audit.ignored) == audit.repeated_count == 0
    assert len(audit.confirmed) == len(vertex_triangle) + len(edge_edge) > 20
    assert (audit.confirmed["distance"] == 0).all()
    for row in audit.confirmed:
        corners = row["vertices"]
        first = oracle.first_touch(row["kind"], vertices_t0[corners], vertices_t1[corners])
        assert first - 1e-5 < row["time_of_impact"] <= first + 1e-12


@pytest.mark.parametrize("seed", range(4))
def test_the_pairs_of_brute_force_within_a_margin_are_all_confirmed(seed):
    vertices, triangles = soup(seed, 10, size=0.9)
    vertex_triangle, edge_edge = true_pairs(vertices, triangles, reach=0.1)
    audit = softcd.audit(
        vertices, triangles, vertex_triangle_pairs=vertex_triangle, edge_edge_pairs=edge_edge, margin=0.05
    )
    assert audit.is_correct and len(audit.undecided) == 0 and not audit.is_continuous and audit.reach == 0.1
    assert len(audit.confirmed) == len(vertex_triangle) + len(edge_edge) > 10
    for row in audit.confirmed:
        assert row["distance"] == pytest.approx(oracle.distance(row["kind"], vertices[row["vertices"]]), abs=1e-12)
        assert row["time_of_impact"] == 1


@pytest.mark.parametrize("seed", range(4))
def test_planted_mistakes_are_named_and_nothing_else(seed):
    vertices_t0, triangles, vertices_t1 = moving(seed)
    vertex_triangle, edge_edge = true_pairs(vertices_t0, triangles, vertices_t1)
    true = {tuple(pair) for pair in edge_edge.tolist()}
    apart = next(c for kind, c in oracle.candidates(triangles) if kind == oracle.EDGE_EDGE and c not in true)
    planted = np.insert(edge_edge, 5, apart, axis=0)
    audit = softcd.audit(
        vertices_t0, triangles, vertices_t1, vertex_triangle_pairs=vertex_triangle[1:], edge_edge_pairs=planted
    )
    assert features(audit.missed) == {(VT, vertex_triangle[0, 0], *triangles[vertex_triangle[0, 1]])}
    assert audit.missed["feature_b"].tolist() == [vertex_triangle[0, 1]] and audit.missed["row"].tolist() == [-1]
    assert features(audit.invented) == {(EE, *apart)}
    assert audit.invented["row"].tolist() == [5] and np.isnan(audit.invented["time_of_impact"]).all()
    corners = list(apart)
    samples = [vertices_t0[corners] + t * (vertices_t1 - vertices_t0)[corners] for t in np.linspace(0, 1, 2001)]
    nearest = min(oracle.distance(EE, x) for x in samples)
    assert nearest - 1e-2 < audit.invented["distance"][0] <= nearest + 1e-12
    assert sorted(audit.confirmed["row"][audit.confirmed["kind"] == EE]) == [i for i in range(len(planted)) if i != 5]
    assert not audit.is_correct
    assert audit.counts() == {
        "confirmed": {"vertex_triangle": len(vertex_triangle) - 1, "edge_edge": len(edge_edge)},
        "missed": {"vertex_triangle": 1, "edge_edge": 0},
        "invented": {"vertex_triangle": 0, "edge_edge": 1},
        "undecided": {"vertex_triangle": 0, "edge_edge": 0},
        "ignored": {"vertex_triangle": 0, "edge_edge": 0},
    }


def test_a_contact_of_a_margin_during_the_step_is_missed_with_its_time():
    pairs = np.zeros((0, 2), int)
    audit = softcd.audit(
        PIERCING_T0, PIERCING_TRIANGLES, PIERCING_T1, vertex_triangle_pairs=pairs, edge_edge_pairs=pairs, margin=0.1
    )
    assert features(audit.missed) == {(VT, 3, 0, 1, 2)} and len(audit.confirmed) == len(audit.invented) == 0
    assert audit.missed["time_of_impact"][0] == pytest.approx(0.4, abs=1e-4)
    assert 0 <= audit.missed["distance"][0] < 1e-5


def test_contacts_that_softcd_could_not_decide_are_undecided(monkeypatch):
    class Query(softcd.Query):
        def detect(self):
            contacts = super().detect().copy()
            contacts["is_unsettled"] = True
            return contacts

    monkeypatch.setattr(softcd._audit, "Query", Query)
    audit = softcd.audit(PIERCING_T0, PIERCING_TRIANGLES, PIERCING_T1, vertex_triangle_pairs=[], margin=0.1)
    assert audit.is_correct and features(audit.undecided) == {(VT, 3, 0, 1, 2)}


def test_kinds_without_a_list_are_not_audited():
    audit = softcd.audit(PIERCING_T0, PIERCING_TRIANGLES, PIERCING_T1, edge_edge_pairs=[])
    assert audit.is_correct and audit.audited_kinds == (EE,)
    assert audit.counts()["missed"] == {"edge_edge": 0}
    audit = softcd.audit(PIERCING_T0, PIERCING_TRIANGLES, PIERCING_T1, vertex_triangle_pairs=[])
    assert audit.counts()["missed"] == {"vertex_triangle": 1}


def test_empty_lists_of_a_mesh_that_touches_nothing_are_correct():
    audit = softcd.audit(PIERCING_T0, PIERCING_TRIANGLES, vertex_triangle_pairs=[], edge_edge_pairs=[], margin=0.01)
    assert audit.is_correct
    assert all(len(getattr(audit, name)) == 0 for name in audit.counts())
    assert all(getattr(audit, name).dtype == softcd.audit_dtype for name in audit.counts())
    none = np.zeros((0, 3), np.uint32)
    assert softcd.audit(PIERCING_T0, none, PIERCING_T1, vertex_triangle_pairs=[], edge_edge_pairs=[]).is_correct


def test_the_order_of_rows_edges_and_vertices_does_not_matter():
    vertices_t0, triangles, vertices_t1 = moving(0)
    edge_edge = true_pairs(vertices_t0, triangles, vertices_t1)[1]
    random = np.random.default_rng(0)
    turned = edge_edge[random.permutation(len(edge_edge))]
    turned[::2] = turned[::2][:, [2, 3, 0, 1]]
    turned[::3] = turned[::3][:, [1, 0, 2, 3]]
    audit = softcd.audit(vertices_t0, triangles, vertices_t1, edge_edge_pairs=turned)
    assert audit.is_correct and len(audit.confirmed) == len(edge_edge)
    for row in audit.confirmed:
        assert {*turned[row["row"]].tolist()} == {*row["vertices"].tolist()}


def test_pairs_of_edges_may_count_the_callers_own_edges():
    vertices_t0, triangles, vertices_t1 = moving(1)
    edge_edge = true_pairs(vertices_t0, triangles, vertices_t1)[1]
    edges = np.random.default_rng(3).permutation(np.array(oracle.edges_of(triangles)))[:, ::-1]
    number = {tuple(sorted(edge)): i for i, edge in enumerate(edges.tolist())}
    pairs = np.array([[number[tuple(row[:2])], number[tuple(row[2:])]] for row in edge_edge.tolist()])
    audit = softcd.audit(vertices_t0, triangles, vertices_t1, edge_edge_pairs=pairs[2:], edges=edges)
    assert len(audit.missed) == 2 and len(audit.invented) == 0 and len(audit.confirmed) == len(pairs) - 2
    missed = {frozenset((int(row["feature_a"]), int(row["feature_b"]))) for row in audit.missed}
    assert missed == {frozenset(pair) for pair in pairs[:2].tolist()}
    for row in audit.missed:
        assert {*edges[row["feature_a"]], *edges[row["feature_b"]]} == {*row["vertices"]}
    fewer = softcd.audit(vertices_t0, triangles, vertices_t1, edge_edge_pairs=[], edges=edges[:5])
    assert len(fewer.missed) == len(pairs) and (fewer.missed["feature_a"] == softcd.NO_BODY).any()


def test_pairs_that_are_never_compared_and_repeated_rows_are_set_aside():
    vertices = np.append(PIERCING_T0, [[1, 1, 0.5]], axis=0)  # no triangle has the last one
    given = {"vertex_triangle_pairs": [[0, 0], [6, 0], [3, 0], [3, 0]], "edge_edge_pairs": [[0, 1, 1, 2]]}
    vertices_t1 = np.append(PIERCING_T1, vertices[6:], axis=0)
    audit = softcd.audit(vertices, PIERCING_TRIANGLES, vertices_t1, **given)
    assert audit.is_correct and audit.repeated_count == 1 and features(audit.confirmed) == {(VT, 3, 0, 1, 2)}
    assert features(audit.ignored) == {(VT, 0, 0, 1, 2), (VT, 6, 0, 1, 2), (EE, 0, 1, 1, 2)}


def test_a_pair_at_the_margin_is_undecided_within_the_tolerance():
    vertices = PIERCING_T0.copy()
    vertices[3, 2] = 0.25
    for height, outcome in (0.25, "undecided"), (0.25 + 1e-7, "invented"), (0.25 - 1e-7, "confirmed"):
        vertices[3, 2] = height
        audit = softcd.audit(vertices, PIERCING_TRIANGLES, vertex_triangle_pairs=[[3, 0]], margin=0.125, tolerance=1e-8)
        # Margins are compared with 2e-6 of themselves to spare, which is more than that.
        assert audit.tolerance == pytest.approx(0.25 * 2**-19, rel=1e-5)
        assert features(audit.undecided) == {(VT, 3, 0, 1, 2)} and audit.undecided["row"].tolist() == [0]
    for height, outcome in (0.25 + 1e-6, "invented"), (0.25 - 1e-6, "confirmed"):
        vertices[3, 2] = height
        listed = softcd.audit(vertices, PIERCING_TRIANGLES, vertex_triangle_pairs=[[3, 0]], margin=0.125)
        assert features(getattr(listed, outcome)) == {(VT, 3, 0, 1, 2)} and len(listed.undecided) == 0
        empty = softcd.audit(vertices, PIERCING_TRIANGLES, vertex_triangle_pairs=[], margin=0.125)
        assert len(empty.missed) == (outcome == "confirmed") and len(empty.undecided) == 0
        blunt = softcd.audit(vertices, PIERCING_TRIANGLES, vertex_triangle_pairs=[], margin=0.125, tolerance=1e-5)
        assert blunt.is_correct and blunt.undecided["row"].tolist() == [-1]


def test_a_vertex_that_passes_through_an_edge_is_undecided():
    vertices_t0, vertices_t1 = PIERCING_T0.copy(), PIERCING_T1.copy()
    vertices_t0[3, :2] = vertices_t1[3, :2] = [1, 0]
    for pairs in ([], [[3, 0]]):
        audit = softcd.audit(vertices_t0, PIERCING_TRIANGLES, vertices_t1, vertex_triangle_pairs=pairs)
        assert audit.is_correct and features(audit.undecided) == {(VT, 3, 0, 1, 2)}
    # An engine that computes in float32 is blamed for more than its roundings.
    for y, missed in (1e-4, 1), (1e-7, 0):
        vertices_t0[3, 1] = vertices_t1[3, 1] = y
        given = vertices_t0.astype(np.float32), PIERCING_TRIANGLES, vertices_t1.astype(np.float32)
        assert len(softcd.audit(*given, vertex_triangle_pairs=[]).missed) == missed
        assert len(softcd.audit(*given, vertex_triangle_pairs=[], tolerance=0).missed) == 1


def test_a_discrete_audit_without_a_margin_misses_nothing_but_invents():
    touching = PIERCING_T0.copy()
    touching[3, 2] = 0
    audit = softcd.audit(touching, PIERCING_TRIANGLES, vertex_triangle_pairs=[[4, 0]])
    assert len(audit.missed) == 0 and features(audit.undecided) == {(VT, 3, 0, 1, 2)}
    assert audit.invented["distance"].tolist() == [8]


@pytest.mark.parametrize("margin", [0, 0.02])
def test_no_verdict_changes_when_vertices_move_within_the_tolerance(margin):
    vertices_t0, triangles = soup(1, 24, size=0.9)
    vertices_t1 = soup(51, 24, size=0.9)[0]
    random = np.random.default_rng(1)
    edge_edge = [corners for kind, corners in oracle.candidates(triangles) if kind == oracle.EDGE_EDGE][::2]
    given = {"edge_edge_pairs": edge_edge, "vertex_triangle_pairs": [], "margin": margin}
    judged = softcd.audit(vertices_t0, triangles, vertices_t1, **given, tolerance=0.002)
    counts = [sum(by_kind.values()) for by_kind in judged.counts().values()]
    assert min(counts[:4]) > 10 and counts[3] < counts[0] + counts[1]
    changed = set()
    for _ in range(5):
        offsets = random.normal(size=(2, *vertices_t0.shape))
        offsets *= 0.001 / np.linalg.norm(offsets, axis=2, keepdims=True)
        moved = softcd.audit(vertices_t0 + offsets[0], triangles, vertices_t1 + offsets[1], **given)
        for name in ("missed", "invented", "confirmed"):
            same = features(getattr(judged, name))
            assert same <= features(getattr(moved, name))
            changed |= features(getattr(moved, name)) - same
    assert changed <= features(judged.undecided) and len(changed) > 0


@pytest.mark.parametrize("kind", [VT, EE])
def test_certain_crossings_are_those_of_brute_force(kind):
    random = np.random.default_rng(int(kind))
    x_t0, x_t1 = random.random((2, 1500, 4, 3))
    certain = _pair_geometry.certainly_cross(x_t0, x_t1, kind == VT, 1e-15)
    touch = [oracle.first_touch(kind, *pair) is not None for pair in zip(x_t0, x_t1)]
    assert certain.tolist() == touch and 50 < certain.sum() < 1000
    loosely = _pair_geometry.certainly_cross(x_t0, x_t1, kind == VT, 2e-3)
    assert (loosely <= certain).all() and 0 < loosely.sum() < certain.sum()


@pytest.mark.parametrize("distance, is_certain", [(1.9e-3, False), (0.02, True)])
def test_crossings_near_a_border_are_certain_when_moved_vertices_cannot_end_them(distance, is_certain):
    # A vertex passes a triangle's inside at that distance from each edge; an edge passes another's ends.
    triangle = np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0]], float)
    slack = 1e-3
    for i in range(3):
        along = triangle[(i + 1) % 3] - triangle[i]
        inward = np.cross([0, 0, 1], along) / np.linalg.norm(along)
        point = triangle[i] + along / 2 + distance * inward
        x_t0, x_t1 = (np.array([[point + [0, 0, z], *triangle]]) for z in (0.5, -0.6))
        assert _pair_geometry.certainly_cross(x_t0, x_t1, True, slack).tolist() == [is_certain]
    for moved, fixed in (slice(0, 2), slice(2, 4)), (slice(2, 4), slice(0, 2)):
        for low, high in (-distance, 1), (-1, distance):
            x_t0, x_t1 = np.zeros((2, 1, 4, 3))
            x_t0[0, moved] = [[low, 0, 0.5], [high, 0, 0.5]]
            x_t1[0, moved] = [[low, 0, -0.6], [high, 0, -0.6]]
            x_t0[0, fixed] = x_t1[0, fixed] = [[0, -1, 0], [0, 1, 0]]
            assert _pair_geometry.certainly_cross(x_t0, x_t1, False, slack).tolist() == [is_certain]


@pytest.mark.parametrize("seed", [0, 4])
def test_contacts_of_a_margin_come_within_it(seed):
    vertices_t0, triangles = soup(seed)
    audit = softcd.audit(
        vertices_t0, triangles, soup(seed + 99)[0], vertex_triangle_pairs=[], edge_edge_pairs=[], margin=5e-5
    )
    assert len(audit.missed) > 50 and audit.missed["distance"].max() <= audit.reach * (1 + 2e-6)
    assert ((audit.missed["time_of_impact"] >= 0) & (audit.missed["time_of_impact"] <= 1)).all()


@pytest.mark.parametrize("kind", [VT, EE])
def test_distances_are_those_of_brute_force(kind):
    x = np.random.default_rng(int(kind)).random((500, 4, 3))
    x[:50, 3] = x[:50, 1]  # degenerate, or touching at an end
    x[50:100] = np.round(x[50:100])
    is_edge = np.linalg.norm(x[:, 0] - x[:, 1], axis=1) > 0
    is_edge &= (np.linalg.norm(x[:, 2] - x[:, 3], axis=1) > 0) & (np.linalg.norm(x[:, 1] - x[:, 2], axis=1) > 0)
    is_edge &= (np.linalg.norm(x[:, 1] - x[:, 3], axis=1) > 0) | (kind == EE)
    expected = [oracle.distance(kind, pair) for pair in x[is_edge]]
    assert is_edge.sum() > 430
    assert _pair_geometry.distances(x[is_edge], kind == VT) == pytest.approx(expected, abs=1e-7)


GOOD = (PIERCING_T0, PIERCING_TRIANGLES, PIERCING_T1)
EDGES = oracle.edges_of(PIERCING_TRIANGLES)
WRONG = {
    "vertex_triangle_pairs": [
        (TypeError, [[3.0, 0.0]], "expected integers, got float64"),
        (TypeError, [["a", "b"]], "expected integers"),
        (TypeError, [[True, False]], "got bool"),
        (TypeError, [[1, 2], [3]], "expected integers"),
        (ValueError, [3, 0], r"expected shape \(k, 2\), got \(2,\)"),
        (ValueError, [[3, 0, 1]], r"expected shape \(k, 2\), got \(1, 3\)"),
        (ValueError, [[3, 0], [6, 0]], "row 1 names vertex 6, but there are 6"),
        (ValueError, [[3, 2]], "row 0 names triangle 2, but there are 2"),
        (ValueError, [[-1, 0]], "row 0 names vertex -1"),
    ],
    "edge_edge_pairs": [
        (TypeError, [[0.0, 1.0, 3.0, 4.0]], "expected integers"),
        (ValueError, [[0, 1, 3]], r"expected shape \(k, 4\), got \(1, 3\)"),
        (ValueError, [[0, 1]], "need edges"),
        (ValueError, [[0, 1, 3, 6]], "row 0 names vertex 6"),
        (ValueError, [[0, 1, 3, 4], [0, 3, 1, 2]], "row 1 names the edge of vertices 0 and 3, which no triangle has"),
    ],
    "edges": [
        (TypeError, [[0.5, 1]], "expected integers"),
        (ValueError, [[0, 1, 2]], r"expected shape \(k, 2\)"),
        (ValueError, [[0, 3]], "row 0 names the edge of vertices 0 and 3"),
        (ValueError, [[0, 9]], "row 0 names vertex 9"),
    ],
    "vertices_t0": [
        (TypeError, "words", "expected an array"),
        (TypeError, PIERCING_T0.astype(complex), "got complex128"),
        (TypeError, [[0, 0, 0]] * 5 + [[0, 0]], "expected numbers"),
        (ValueError, PIERCING_T0[:, :2], r"expected shape \(n, 3\), got \(6, 2\)"),
        (ValueError, PIERCING_T0 * np.nan, "vertex 0 is not finite"),
    ],
    "vertices_t1": [(ValueError, PIERCING_T1[:5], "expected 6 positions"), (TypeError, 3.0, "expected an array")],
    "triangles": [
        (TypeError, PIERCING_TRIANGLES.astype(float), "expected integers"),
        (ValueError, PIERCING_TRIANGLES[:, :2], r"expected shape \(k, 3\)"),
        (ValueError, PIERCING_TRIANGLES + 1, "row 1 names vertex 6"),
    ],
    "margin": [(ValueError, -1, "at least 0"), (TypeError, "wide", "expected a number")],
    "tolerance": [(ValueError, np.inf, "finite"), (TypeError, [1, 2], "expected a number")],
}


@pytest.mark.parametrize("name, error, value, text", [(name, *case) for name, cases in WRONG.items() for case in cases])
def test_wrong_arguments_are_named(name, error, value, text):
    arguments = dict(zip(("vertices_t0", "triangles", "vertices_t1"), GOOD), vertex_triangle_pairs=[[3, 0]])
    with pytest.raises(error, match=f"^{name}.*{text}"):
        softcd.audit(**{**arguments, name: value})


def test_edge_indices_are_checked():
    with pytest.raises(softcd.InvalidInput, match="^edge_edge_pairs: row 0 names edge 6, but there are 6"):
        softcd.audit(*GOOD, edge_edge_pairs=[[0, 6]], edges=EDGES)
    with pytest.raises(softcd.InvalidInput, match=r"^edge_edge_pairs: expected shape \(k, 2\) or \(k, 4\)"):
        softcd.audit(*GOOD, edge_edge_pairs=[[0, 1, 2]], edges=EDGES)


def test_a_list_is_needed_and_unknown_keywords_are_named():
    with pytest.raises(softcd.InvalidInput, match="^vertex_triangle_pairs, edge_edge_pairs: at least one"):
        softcd.audit(*GOOD)
    with pytest.raises(TypeError, match="vertex_triangle_pair"):
        softcd.audit(*GOOD, vertex_triangle_pair=[])
    assert softcd.audit(*GOOD, vertex_triangle_pairs=[[3, 0]], backend="cpu", max_threads=1).is_correct


def test_a_mesh_far_from_the_origin_is_judged_as_at_it():
    random = np.random.default_rng(5)
    triangles = np.arange(30).reshape(-1, 3)
    x_t0, x_t1 = random.integers(0, 64, (2, 30, 3)).astype(float)  # integers stay exact
    options = {"vertex_triangle_pairs": [[0, 1], [3, 5], [9, 6]], "edge_edge_pairs": [], "tolerance": 0}
    near = softcd.audit(x_t0, triangles, x_t1, **options)
    far = softcd.audit(x_t0 + 2.0**40, triangles, x_t1 + 2.0**40, **options)
    for name in ("missed", "invented", "confirmed", "undecided"):
        assert features(getattr(near, name)) == features(getattr(far, name))
    assert len(near.missed) > 50 and len(near.invented) > 0
    assert far.invented["distance"] == pytest.approx(near.invented["distance"], rel=1e-9)


RECORDED = pathlib.Path(__file__).resolve().parents[2] / "build/data/ccd-steps/armadillo-rollers"


@pytest.mark.skipif(not RECORDED.exists(), reason="tests/fetch_data.sh has not fetched the recorded steps")
def test_the_exact_list_of_a_recorded_step_is_confirmed():
    x_t0, triangles = softcd.read_mesh(RECORDED / "frames/326.ply")
    x_t1, _ = softcd.read_mesh(RECORDED / "frames/327.ply")
    edges = np.array(oracle.edges_of(triangles))
    edges = edges[np.lexsort((edges[:, 0], edges[:, 1]))]  # as the data numbers them
    pairs = {}
    for kind in ("vf", "ee"):
        candidates = np.array(json.loads((RECORDED / f"boxes/326{kind}.json").read_text()))
        pairs[kind] = candidates[json.loads((RECORDED / f"mma_bool/326{kind}_mma_bool.json").read_text())]
    audit = softcd.audit(
        x_t0,
        triangles,
        x_t1,
        vertex_triangle_pairs=pairs["vf"] - [0, len(x_t0) + len(edges)],
        edge_edge_pairs=pairs["ee"] - len(x_t0),
        edges=edges,
    )
    assert audit.is_correct and len(audit.undecided) == 0 and len(audit.confirmed) == 4650 + 19308


def test_the_text_says_what_was_found():
    lists = {"vertex_triangle_pairs": [[3, 0], [4, 0], [4, 0]], "edge_edge_pairs": [[0, 1, 1, 2]]}
    text = repr(softcd.audit(*GOOD, **lists))
    lines = [line.split() for line in text.splitlines()]
    assert lines[0][:3] == ["softcd.Audit:", "continuous,", "contacts"]
    assert ["vertex_triangle", "edge_edge"] in lines and ["confirmed", "1", "0"] in lines
    assert ["missed", "0", "0"] in lines and ["invented", "1", "0"] in lines
    assert ["ignored", "0", "1"] == lines[6][:3] and text.endswith("1 rows repeat an earlier one")
    assert all(len(line) < 100 for line in text.splitlines())
