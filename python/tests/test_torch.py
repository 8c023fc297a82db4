"""Tests softcd.torch.distances against brute force and finite differences, where torch is installed."""

import numpy as np
import pytest

import oracle
import softcd
from meshes import PIERCING_T0, PIERCING_T1, PIERCING_TRIANGLES, soup

torch = pytest.importorskip("torch")
import softcd.torch  # noqa: E402

VT, EE = int(softcd.ContactKind.vertex_triangle), int(softcd.ContactKind.edge_edge)


def pairs(kind, count):
    """Makes contacts of vertices 4 i, ..., 4 i + 3 of one body, with normals along z."""
    contacts = np.zeros(count, softcd.contact_dtype)
    contacts["kind"] = kind
    contacts["vertices"] = np.arange(4 * count).reshape(-1, 4)
    contacts["normal"] = [0, 0, 1]
    return contacts


def values(x, kind, **options):
    """Returns distances of pairs x, of shape (k, 4, 3), and the derivatives of each."""
    p = torch.tensor(x.reshape(-1, 3), dtype=torch.float64, requires_grad=True)
    found = softcd.torch.distances(p, pairs(kind, len(x)), **options)
    (gradient,) = torch.autograd.grad(found.distance.sum(), p)
    return found.distance.detach().numpy(), gradient.numpy().reshape(x.shape)


def worst_error(gradient, expected):
    """Returns the largest error of a pair's gradient, relative to the gradient's length."""
    errors = np.linalg.norm((gradient - expected).reshape(len(gradient), -1), axis=1)
    return (errors / np.linalg.norm(expected.reshape(len(gradient), -1), axis=1)).max()


FACE = np.array([[0, 0, 0], [2, 0, 0], [0, 2, 0]], float)
REGIONS = {
    "the face": (VT, [0.5, 0.6, 0.7], [1, 0.45, 0.25, 0.3]),
    "the face from below": (VT, [0.5, 0.6, -0.7], [1, 0.45, 0.25, 0.3]),
    "the first edge": (VT, [0.5, -0.6, 0.7], [1, 0.75, 0.25, 0]),
    "the second edge": (VT, [1.5, 1.7, 0.7], [1, 0, 0.45, 0.55]),
    "the third edge": (VT, [-0.5, 0.6, 0.7], [1, 0.7, 0, 0.3]),
    "the first corner": (VT, [-0.5, -0.6, 0.7], [1, 1, 0, 0]),
    "the second corner": (VT, [2.5, -0.6, 0.7], [1, 0, 1, 0]),
    "the third corner": (VT, [-0.5, 2.6, 0.7], [1, 0, 0, 1]),
    "both insides": (EE, [[-0.5, 0.2, 0.7], [1.5, 0.2, 0.9]], None),
    "an end and an inside": (EE, [[0.3, 0.2, 0.7], [1.5, 0.2, 0.9]], None),
    "the other end and an inside": (EE, [[-1.5, 0.2, 0.7], [-0.3, 0.2, 0.9]], None),
    "an inside and an end": (EE, [[-0.5, 1.4, 0.7], [1.5, 1.2, 0.9]], None),
    "an inside and the other end": (EE, [[-0.5, -1.4, 0.7], [1.5, -1.2, 0.9]], None),
    "two ends": (EE, [[0.3, 1.4, 0.7], [1.5, 1.9, 0.9]], None),
}


def region(name):
    kind, points, weights = REGIONS[name]
    other = FACE if kind == VT else [[0, -1, 0.1], [0, 1, 0]]
    return kind, np.array([[*np.atleast_2d(points), *other]], float), weights


@pytest.mark.parametrize("name", REGIONS)
def test_each_nearest_feature_has_its_derivatives(name):
    kind, x, weights = region(name)
    distance, gradient = values(x, kind)
    assert distance == pytest.approx(oracle.distance(kind, x[0]), rel=1e-14)
    error = worst_error(gradient, oracle.finite_differences(lambda moved: values(moved, kind)[0], x))
    assert error < 1e-9, error
    found = softcd.torch.distances(torch.tensor(x[0]), pairs(kind, 1))
    if weights is not None:
        assert found.weights[0].tolist() == pytest.approx(weights, abs=1e-15)
    is_end = [weight in (0, 1) for weight in found.weights[0].tolist()]
    expected = {"both insides": [False] * 4, "an end and an inside": [True, True, False, False],
                "the other end and an inside": [True, True, False, False], "two ends": [True] * 4}  # fmt: skip
    assert kind == VT or is_end == expected.get(name, [False, False, True, True])


@pytest.mark.parametrize("name", REGIONS)
def test_each_nearest_feature_has_its_second_derivatives(name):
    kind, x, _ = region(name)
    p = torch.tensor(x[0], requires_grad=True)

    def distance(p):
        return softcd.torch.distances(p, pairs(kind, 1)).distance

    assert torch.autograd.gradgradcheck(distance, [p], atol=1e-7, rtol=1e-6)


@pytest.mark.parametrize("kind", [VT, EE])
def test_distances_and_derivatives_are_right_for_random_pairs(kind):
    x = np.random.default_rng(kind).random((2000, 4, 3))
    distance, gradient = values(x, kind)
    assert distance == pytest.approx([oracle.distance(kind, pair) for pair in x], rel=1e-9, abs=1e-12)
    error = worst_error(gradient, oracle.finite_differences(lambda moved: values(moved, kind)[0], x))
    print(f"worst relative error of a gradient, kind {kind}: {error:.1e}")
    assert error < 1e-7
    assert np.abs(gradient.sum(axis=1)).max() < 1e-12  # nothing changes when a pair is moved as a whole


def test_values_are_those_of_the_contacts():
    x, triangles = soup(1, 40, 0.6)
    contacts = softcd.detect(x, triangles, margin=0.05)
    found = softcd.torch.distances(torch.tensor(x), contacts, margins=0.05)
    assert len(contacts) > 300 and {*contacts["kind"].tolist()} == {VT, EE}
    assert found.distance.numpy() == pytest.approx(contacts["distance"], rel=1e-6, abs=1e-9)
    assert found.weights.numpy() == pytest.approx(contacts["weights"], abs=1e-6)
    assert found.gap.numpy() == pytest.approx(found.distance.numpy() - 0.1, abs=1e-15) and (found.gap <= 0).all()
    assert (found.mollifier[contacts["kind"] == VT] == 1).all() and found.distance.shape == (len(contacts),)
    single = softcd.torch.distances(torch.tensor(x, dtype=torch.float32), contacts)
    assert single.distance.dtype == torch.float32
    assert single.distance.numpy() == pytest.approx(contacts["distance"], abs=1e-6)


def test_parallel_edges_have_a_distance_a_derivative_and_no_weight():
    x = np.array([[[0, 0, 1], [2, 0, 1], [1, 0, 0], [3, 0, 0]], [[0, 0, 1], [1, 0, 1], [3, 0, 0], [5, 0, 0]],
                  [[0, 0, 1], [2, 0, 1], [2, 0, 0], [0, 0, 0]], [[0, 0, 1], [0, 0, 1], [0, 0, 0], [0, 0, 0]]], float)  # fmt: skip
    distance, gradient = values(x, EE)
    assert distance == pytest.approx([1, 5**0.5, 1, 1]) and np.isfinite(gradient).all()
    # One of the many derivatives from a side: the pair's sides are moved apart along the nearest points' difference.
    assert gradient[:, :2].sum(axis=1) == pytest.approx(np.array([[0, 0, 1], [-2, 0, 1], [0, 0, 1], [0, 0, 1]]) /
                                                        distance[:, None])  # fmt: skip
    p = torch.tensor(x.reshape(-1, 3), requires_grad=True)
    found = softcd.torch.distances(p, pairs(EE, 4))
    assert found.mollifier.tolist() == [0, 0, 0, 0]
    (of_mollifier,) = torch.autograd.grad(found.mollifier.sum(), p)
    assert (of_mollifier == 0).all()


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
@pytest.mark.parametrize("kind", [VT, EE])
def test_derivatives_of_nearly_parallel_edges_and_thin_triangles_are_accurate(kind, dtype):
    random = np.random.default_rng(11)
    x = random.normal(size=(2000, 4, 3))
    a, b = ((2, 1), (3, 1)) if kind == VT else ((1, 0), (3, 2))
    angles = 10.0 ** -random.uniform(1, 16, (2000, 1))
    x[:, b[0]] = x[:, b[1]] + 0.9 * (x[:, a[0]] - x[:, a[1]]) + angles * random.normal(size=(2000, 3))
    p = torch.tensor(x.reshape(-1, 3), dtype=dtype, requires_grad=True)
    found = softcd.torch.distances(p, pairs(kind, len(x)))
    (gradient,) = torch.autograd.grad(found.distance.sum(), p)
    gradient, exact = gradient.numpy().reshape(x.shape).astype(float), p.detach().numpy().reshape(x.shape).astype(float)
    distance = np.array([oracle.distance(kind, pair) for pair in exact])
    eps = torch.finfo(dtype).eps
    assert found.distance.detach().numpy() == pytest.approx(distance, abs=64 * eps)
    # Each side of a pair is pulled along one unit vector, in shares of its vertices that sum to 1.
    split = 1 if kind == VT else 2
    sides = gradient[:, :split].sum(axis=1), -gradient[:, split:].sum(axis=1)
    for side in sides:
        assert np.linalg.norm(side, axis=1) == pytest.approx(1, abs=64 * eps)
    assert sides[0] == pytest.approx(sides[1], abs=64 * eps)


@pytest.mark.parametrize("kind", [VT, EE])
def test_points_and_features_far_smaller_than_their_distance_have_derivatives(kind):
    for size in (0, 1e-21, 1e-12):
        x = np.zeros((2, 4, 3))
        x[:, 1:] = size * np.array([[1, 0, 0], [0, 1, 0], [0, 0, 1]])
        x[0, 2 if kind == EE else 1 :, 2] += 1
        p = torch.tensor(x.reshape(-1, 3), dtype=torch.float32, requires_grad=True)
        found = softcd.torch.distances(p, pairs(kind, 2))
        (gradient,) = torch.autograd.grad((found.distance + found.mollifier + (found.weights**2).sum(1)).sum(), p)
        assert torch.isfinite(gradient).all()
        assert found.distance.tolist() == pytest.approx([1, 0], rel=1e-6, abs=2e-12)


def test_the_order_of_contacts_is_kept():
    x, triangles = soup(1, 40, 0.6)
    contacts = softcd.detect(x, triangles, margin=0.05)
    mixed = contacts[np.random.default_rng(0).permutation(len(contacts))]
    found = softcd.torch.distances(torch.tensor(x), mixed)
    assert found.distance.numpy() == pytest.approx(mixed["distance"], rel=1e-6, abs=1e-9)
    assert found.weights.numpy() == pytest.approx(mixed["weights"], abs=1e-6)


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_nearly_parallel_edges_have_finite_derivatives(dtype):
    angles = 10.0 ** -np.arange(1, 46)
    x = np.zeros((len(angles), 4, 3))
    x[:, 0], x[:, 1] = [-1, 0, 0.01], [1, 0, 0.01]
    x[:, 2], x[:, 3, 0], x[:, 3, 1] = [-1, 0, 0], 1, 2 * angles
    p = torch.tensor(x.reshape(-1, 3), dtype=dtype, requires_grad=True)
    found = softcd.torch.distances(p, pairs(EE, len(angles)))
    (gradient,) = torch.autograd.grad((found.distance * found.mollifier + (found.weights**2).sum(1)).sum(), p)
    assert torch.isfinite(gradient).all() and found.distance.detach().numpy() == pytest.approx(0.01, rel=1e-5)
    assert found.mollifier[0] == 1 and (found.mollifier.diff() <= 0).all() and found.mollifier[-1] < 1e-30


def test_the_mollifier_is_the_papers():
    # c / eps = sin^2 / 1e-3 with the edges' own lengths.
    angles = np.array([0.001, 0.01, 0.02, 0.0316, 0.032, 0.5])
    x = np.zeros((len(angles), 4, 3))
    x[:, 0], x[:, 1] = [-3, 0, 1], [3, 0, 1]
    x[:, 3, 0], x[:, 3, 1] = 2 * np.cos(angles), 2 * np.sin(angles)
    share = np.sin(angles) ** 2 / 1e-3
    expected = np.where(share < 1, -(share**2) + 2 * share, 1)
    p = torch.tensor(x.reshape(-1, 3))
    found = softcd.torch.distances(p, pairs(EE, len(x)))
    assert found.mollifier.numpy() == pytest.approx(expected, rel=1e-12)
    assert 0 < expected[0] < 0.01 and expected[3] < 1 and expected[4] == 1
    # Edges that are twice as long as at rest count as 16 times less parallel.
    stretched = softcd.torch.distances(p, pairs(EE, len(x)), rest_positions=p / 2)
    share = np.minimum(16 * share, 1)
    assert stretched.mollifier.numpy() == pytest.approx(share * (2 - share), rel=1e-12)
    assert stretched.distance.tolist() == found.distance.tolist()


@pytest.mark.parametrize("has_rest", [False, True])
def test_the_mollifiers_derivatives_are_right(has_rest):
    random = np.random.default_rng(7)
    x = random.random((300, 4, 3))
    x[:, 3] = x[:, 2] + (x[:, 1] - x[:, 0]) * random.uniform(0.5, 2, (300, 1)) + 0.01 * random.normal(size=(300, 3))
    rest = {"rest_positions": torch.tensor(x.reshape(-1, 3))} if has_rest else {}

    def mollifier(x):
        p = torch.tensor(x.reshape(-1, 3), requires_grad=True)
        return p, softcd.torch.distances(p, pairs(EE, len(x)), **rest).mollifier

    p, value = mollifier(x)
    (gradient,) = torch.autograd.grad(value.sum(), p)
    is_smooth = (value < 0.99).numpy() & (value > 1e-3).numpy()
    expected = oracle.finite_differences(lambda moved: mollifier(moved)[1].detach().numpy(), x)
    error = worst_error(gradient.numpy().reshape(x.shape)[is_smooth], expected[is_smooth])
    print(f"worst relative error of the mollifier's gradient: {error:.1e}")
    assert is_smooth.sum() > 100 and error < 1e-6


def test_signed_distances_go_through_zero():
    contacts = softcd.detect(PIERCING_T0, PIERCING_TRIANGLES, PIERCING_T1)
    assert len(contacts) == 1 and contacts["normal"][0].tolist() == [0, 0, 1]
    for time, expected in (0, 1), (0.25, 0.5), (0.5, 0), (0.75, -0.5), (1, -1):
        x = torch.tensor(PIERCING_T0 + time * (PIERCING_T1 - PIERCING_T0), requires_grad=True)
        for signed in (True, False):
            found = softcd.torch.distances(x, contacts, signed=signed, margins=0.25)
            assert found.distance.item() == pytest.approx(expected if signed else abs(expected), abs=1e-15)
            assert found.gap.item() == found.distance.item() - 0.5
            (gradient,) = torch.autograd.grad(found.distance, x)
            up = 1 if signed or expected >= 0 else -1
            assert gradient[3].tolist() == pytest.approx([0, 0, up]) and gradient[:3, 2].sum() == pytest.approx(-up)


def test_touching_features_have_a_derivative_along_the_normal():
    x = torch.tensor([[0.5, 0.5, 0], *FACE.tolist()], dtype=torch.float64, requires_grad=True)
    found = softcd.torch.distances(x, pairs(VT, 1))
    (gradient,) = torch.autograd.grad(found.distance, x)
    assert found.distance.item() == 0 and gradient[:, 2].tolist() == [1, -0.5, -0.25, -0.25]


def test_several_bodies_are_a_sequence_or_a_dict():
    mesh, triangles = soup(3, 20, 0.6)
    meshes = [mesh, mesh[::-1].copy() + 0.02]
    contacts = softcd.detect(meshes, [triangles, triangles], margin=0.04)
    assert {(int(c["body_a"]), int(c["body_b"])) for c in contacts} >= {(0, 0), (0, 1), (1, 0), (1, 1)}
    x = [torch.tensor(m, requires_grad=True) for m in meshes]
    found = softcd.torch.distances(x, contacts, margins=[0.01, 0.02])
    assert found.distance.detach().numpy() == pytest.approx(contacts["distance"], rel=1e-6, abs=1e-9)
    margins = np.array([0.01, 0.02])
    expected = found.distance.detach().numpy() - margins[contacts["body_a"]] - margins[contacts["body_b"]]
    assert found.gap.detach().numpy() == pytest.approx(expected, abs=1e-15)
    gradients = torch.autograd.grad(found.distance.sum(), x)
    assert min(g.abs().sum() for g in gradients) > 1

    scene = softcd.Scene()
    scene.remove_body(scene.add_body(triangles, len(mesh)))
    bodies = [scene.add_body(triangles, len(m), margin=0.04) for m in meshes]
    for body, m in zip(bodies, meshes):
        scene.set_positions(body, m)
    numbered = softcd.Query(scene).detect()
    assert bodies != [0, 1] and len(numbered) == len(contacts)
    named = softcd.torch.distances(dict(zip(bodies, x)), numbered, margins=dict(zip(bodies, [0.01, 0.02])))
    assert named.gap.tolist() == found.gap.tolist()
    alone = softcd.torch.distances(x[1], numbered[(numbered["body_a"] == 2) & (numbered["body_b"] == 2)])
    assert len(alone.distance) > 0 and (alone.distance <= 0.08).all()


@pytest.mark.parametrize("size", [1e-25, 1e25])
def test_units_do_not_matter(size):
    x = np.random.default_rng(2).random((200, 4, 3))
    for kind in (VT, EE):
        plain = softcd.torch.distances(torch.tensor(x.reshape(-1, 3), dtype=torch.float32), pairs(kind, len(x)))
        p = torch.tensor(size * x.reshape(-1, 3), dtype=torch.float32, requires_grad=True)
        found = softcd.torch.distances(p, pairs(kind, len(x)))
        assert (found.distance / size).detach().numpy() == pytest.approx(plain.distance.numpy(), rel=1e-3)
        assert found.mollifier.detach().numpy() == pytest.approx(plain.mollifier.numpy(), rel=1e-3)
        (gradient,) = torch.autograd.grad(found.distance.sum(), p)
        assert torch.isfinite(gradient).all()


def test_columns_on_a_device_are_read():
    x, triangles = soup(1, 20, 0.6)
    contacts = softcd.detect(x, triangles, margin=0.05)
    columns = {name: torch.tensor(contacts[name].astype(float if name == "normal" else np.int32))
               for name in ("kind", "body_a", "body_b", "vertices", "normal")}  # fmt: skip
    found = softcd.torch.distances(torch.tensor(x), columns)
    assert found.distance.tolist() == softcd.torch.distances(torch.tensor(x), contacts).distance.tolist()


def test_no_contacts_are_no_distances():
    x = torch.tensor(PIERCING_T0, requires_grad=True)
    found = softcd.torch.distances(x, np.zeros(0, softcd.contact_dtype), margins=0.1)
    assert found.distance.shape == found.gap.shape == found.mollifier.shape == (0,) and found.weights.shape == (0, 4)
    found.distance.sum().backward()
    assert (x.grad == 0).all()


def test_wrong_arguments_are_named():
    x = torch.tensor(PIERCING_T0)
    contacts = softcd.detect(PIERCING_T0, PIERCING_TRIANGLES, PIERCING_T1)

    def refuses(error, text, *arguments, **options):
        with pytest.raises(error, match=text):
            softcd.torch.distances(*arguments, **options)

    refuses(TypeError, "^x: expected tensors, got ndarray", PIERCING_T0, contacts)
    refuses(TypeError, "^x: expected float32 or float64, got torch.int64", x.long(), contacts)
    refuses(ValueError, r"^x: expected shape \(n, 3\), got \(18,\)", x.ravel(), contacts)
    refuses(ValueError, "^x: .* one type", [x, x.float()], contacts)
    refuses(ValueError, "^x: .* at least one", [], contacts)
    refuses(ValueError, "^x: contacts name vertices that it lacks", x[:3], contacts)
    refuses(ValueError, "^x: it lacks the positions of body 0", {1: x}, contacts)
    refuses(TypeError, "^contacts: expected an array of softcd.contact_dtype", x, [1, 2])
    refuses(TypeError, "^contacts: expected an array of softcd.contact_dtype", x, np.zeros((3, 4), int))
    refuses(TypeError, "^margins: expected a number", x, contacts, margins=[0.1])
    refuses(ValueError, "^margins: expected one for each of x's 2 bodies, got 1", [x, x], contacts, margins=[0.1])
    refuses(ValueError, "^rest_positions: expected as many", x, contacts, rest_positions=x[:5])
    between = softcd.detect([PIERCING_T0, PIERCING_T0], [PIERCING_TRIANGLES] * 2, margin=0.1)
    refuses(ValueError, "^x: the contacts are of 2 bodies", x, between)
