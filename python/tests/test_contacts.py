import numpy as np
import pytest

import oracle
import softcd
from meshes import PIERCING_T0, PIERCING_T1, PIERCING_TRIANGLES, soup


def key(kind, vertices):
    """Returns a key of a contact that does not depend on the order of its edges."""
    if kind == oracle.EDGE_EDGE:
        vertices = sorted([sorted(vertices[:2]), sorted(vertices[2:])])
        return kind, *map(tuple, vertices)
    return kind, vertices[0], tuple(sorted(vertices[1:]))


def found(contacts):
    return {key(int(c["kind"]), c["vertices"].tolist()): c for c in contacts}


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("seed", range(3))
def test_discrete_detection_finds_what_brute_force_does(seed, dtype):
    vertices, triangles = soup(seed, 12)
    vertices = vertices.astype(dtype)
    margin = 0.05
    contacts = found(softcd.detect(vertices, triangles, margin=margin, accuracy=softcd.Accuracy.precise))
    expected = {}
    for kind, corners in oracle.candidates(triangles):
        distance = oracle.distance(kind, vertices[list(corners)].astype(float))
        assert abs(distance - 2 * margin) > 1e-6, "choose another seed: this one leaves it to rounding"
        if distance < 2 * margin:
            expected[key(kind, list(corners))] = distance
    assert contacts.keys() == expected.keys() and len(expected) > 10
    for feature, distance in expected.items():
        assert contacts[feature]["distance"] == pytest.approx(distance, abs=1e-6)
        assert contacts[feature]["time_of_impact"] == 1


@pytest.mark.parametrize("seed", range(3))
def test_continuous_detection_finds_what_brute_force_does(seed):
    vertices_t0, triangles = soup(seed, 10, size=0.9)
    vertices_t1, _ = soup(seed + 100, 10, size=0.9)
    contacts = found(softcd.detect(vertices_t0, triangles, vertices_t1, accuracy=softcd.Accuracy.precise))
    expected = {}
    for kind, corners in oracle.candidates(triangles):
        corners = list(corners)
        time = oracle.first_touch(kind, vertices_t0[corners], vertices_t1[corners])
        if time is not None:
            expected[key(kind, corners)] = time
    assert contacts.keys() == expected.keys() and len(expected) > 10
    for feature, time in expected.items():
        assert contacts[feature]["time_of_impact"] == pytest.approx(time, abs=1e-5)


def test_a_contact_says_where_it_is():
    contacts = softcd.detect(PIERCING_T0, PIERCING_TRIANGLES, PIERCING_T1, edge_edge=False)
    assert contacts.dtype == softcd.contact_dtype
    assert len(contacts) == 1
    contact = contacts[0]
    assert contact["kind"] == softcd.ContactKind.vertex_triangle
    assert contact["vertices"].tolist() == [3, 0, 1, 2]
    assert contact["weights"] == pytest.approx([1, 0.5, 0.25, 0.25], abs=1e-6)
    assert contact["normal"] == pytest.approx([0, 0, 1], abs=1e-6)
    assert contact["time_of_impact"] == pytest.approx(0.5, abs=1e-6)
    assert not contact["is_unsettled"]


def test_no_contact_is_an_empty_array():
    contacts = softcd.detect(PIERCING_T0, PIERCING_TRIANGLES)
    assert contacts.shape == (0,) and contacts.dtype == softcd.contact_dtype
    assert contacts["normal"].shape == (0, 3)


def test_contacts_are_read_only_views_of_one_memory():
    vertices, triangles = soup(1)
    contacts = softcd.detect(vertices, triangles, margin=0.1)
    with pytest.raises(ValueError, match="read-only"):
        contacts["distance"][0] = 1
    begin = contacts.ctypes.data
    offsets = {name: contacts[name].ctypes.data - begin for name in contacts.dtype.names}
    assert offsets == {name: softcd.contact_dtype.fields[name][1] for name in contacts.dtype.names}
    assert memoryview(contacts["weights"]).strides == (softcd.contact_dtype.itemsize, 4)


@pytest.mark.skipif(np.lib.NumpyVersion(np.__version__) < "2.1.0", reason="older ones refuse what is read-only")
def test_columns_go_through_dlpack_without_a_copy():
    vertices, triangles = soup(1)
    distance = softcd.detect(vertices, triangles, margin=0.1)["distance"]
    column = np.from_dlpack(distance)
    assert column.ctypes.data == distance.ctypes.data and np.array_equal(column, distance)


def test_several_meshes_are_bodies_in_their_order():
    vertices, triangles = soup(2)
    contacts = softcd.detect(
        [vertices, vertices + 0.01], [triangles, triangles], margin=0.02, self_collision=False, edge_edge=False
    )
    pairs = {tuple(pair) for pair in np.stack([contacts["body_a"], contacts["body_b"]], axis=1).tolist()}
    assert pairs == {(0, 1), (1, 0)}


def test_contacts_on_the_host_are_told_of_when_they_are_waited_for():
    scene = softcd.Scene(backend=softcd.Backend.cpu)
    ticket = softcd.Query(scene).start()
    with pytest.raises(softcd.Error, match="on the host; use wait"):
        ticket.on_device()
    assert len(ticket.wait()) == 0
