"""Tests softcd.jax.distances against finite differences and brute force, where jax is installed."""

import numpy as np
import pytest

import oracle
import softcd
from meshes import PIERCING_T0, PIERCING_T1, PIERCING_TRIANGLES, soup

jax = pytest.importorskip("jax")
import jax.numpy as jnp  # noqa: E402
import softcd.jax  # noqa: E402

VT, EE = int(softcd.ContactKind.vertex_triangle), int(softcd.ContactKind.edge_edge)


@pytest.fixture(autouse=True)
def with_float64():
    with jax.enable_x64(True):
        yield


def pairs(kind, count):
    """Makes contacts of vertices 4 i, ..., 4 i + 3 of one body, with normals along z."""
    contacts = np.zeros(count, softcd.contact_dtype)
    contacts["kind"] = kind
    contacts["vertices"] = np.arange(4 * count).reshape(-1, 4)
    contacts["normal"] = [0, 0, 1]
    return contacts


def random_pairs(kind, count=2000):
    x = np.random.default_rng(kind).random((count, 4, 3))
    return x, pairs(kind, count)


@pytest.mark.parametrize("kind", [VT, EE])
def test_distances_and_derivatives_are_right_for_random_pairs(kind):
    x, contacts = random_pairs(kind)

    def value(x):
        return softcd.jax.distances(jnp.asarray(x).reshape(-1, 3), contacts).distance

    distance = np.asarray(value(x))
    assert distance == pytest.approx([oracle.distance(kind, pair) for pair in x], rel=1e-9, abs=1e-12)
    gradient = np.asarray(jax.grad(lambda x: value(x).sum())(x))
    expected = oracle.finite_differences(lambda x: np.asarray(value(x)), x)
    errors = np.linalg.norm((gradient - expected).reshape(len(x), -1), axis=1)
    worst = (errors / np.linalg.norm(expected.reshape(len(x), -1), axis=1)).max()
    print(f"worst relative error of a gradient, kind {kind}: {worst:.1e}")
    assert worst < 1e-7
    assert np.abs(gradient.sum(axis=1)).max() < 1e-12


@pytest.mark.parametrize("kind", [VT, EE])
def test_second_derivatives_are_those_of_the_first(kind):
    x, contacts = random_pairs(kind, 40)

    def gradient(x):
        return jax.grad(lambda x: softcd.jax.distances(x, contacts).distance.sum())(x)

    x = jnp.asarray(x.reshape(-1, 3))
    direction = np.random.default_rng(9).normal(size=x.shape)
    _, curved = jax.jvp(gradient, (x,), (jnp.asarray(direction),))
    expected = (gradient(x + oracle.STEP * direction) - gradient(x - oracle.STEP * direction)) / (2 * oracle.STEP)
    assert np.abs(curved - expected).max() < 1e-5 * np.abs(expected).max()


def test_results_are_those_of_torch():
    torch = pytest.importorskip("torch")
    import softcd.torch

    meshes = [soup(seed, 40, 0.6)[0] for seed in (1, 2)]
    triangles = soup(1, 40)[1]
    contacts = softcd.detect(meshes, [triangles] * 2, margin=0.05)
    options = {"margins": [0.01, 0.02], "signed": True}
    rest = [2 * mesh for mesh in meshes]
    found = softcd.jax.distances(
        [jnp.asarray(m) for m in meshes], contacts, rest_positions=[jnp.asarray(m) for m in rest], **options
    )
    expected = softcd.torch.distances(
        [torch.tensor(m) for m in meshes], contacts, rest_positions=[torch.tensor(m) for m in rest], **options
    )
    for ours, theirs in zip(found, expected):
        np.testing.assert_allclose(np.asarray(ours), theirs.numpy(), rtol=1e-12, atol=1e-14)
    named = softcd.jax.distances({0: jnp.asarray(meshes[0]), 1: jnp.asarray(meshes[1])}, contacts, margins={0: 0.01, 1: 0.02})
    np.testing.assert_array_equal(named.gap, softcd.jax.distances([jnp.asarray(m) for m in meshes], contacts, margins=[0.01, 0.02]).gap)


def test_parallel_edges_have_finite_derivatives_and_no_weight():
    x = np.array([[[0, 0, 1], [2, 0, 1], [1, 0, 0], [3, 0, 0]], [[0, 0, 1], [0, 0, 1], [0, 0, 0], [0, 0, 0]]], float)

    def energy(x):
        found = softcd.jax.distances(x, pairs(EE, 2))
        return (found.distance + found.mollifier + (found.weights**2).sum(axis=1)).sum()

    p = jnp.asarray(x.reshape(-1, 3))
    assert np.isfinite(jax.grad(energy)(p)).all()
    assert softcd.jax.distances(p, pairs(EE, 2)).mollifier.tolist() == [0, 0]


def test_signed_distances_go_through_zero():
    contacts = softcd.detect(PIERCING_T0, PIERCING_TRIANGLES, PIERCING_T1)
    for time, expected in (0, 1), (0.5, 0), (1, -1):
        x = jnp.asarray(PIERCING_T0 + time * (PIERCING_T1 - PIERCING_T0))
        value, gradient = jax.value_and_grad(lambda x: softcd.jax.distances(x, contacts, signed=True).distance[0])(x)
        assert value == pytest.approx(expected, abs=1e-15) and gradient[3].tolist() == pytest.approx([0, 0, 1])


def test_positions_may_be_traced_and_float32():
    x, triangles = soup(1, 40, 0.6)
    contacts = softcd.detect(x, triangles, margin=0.05)
    with jax.enable_x64(False):
        compiled = jax.jit(lambda x: softcd.jax.distances(x, contacts))(jnp.asarray(x, jnp.float32))
    assert compiled.distance.dtype == np.float32
    np.testing.assert_allclose(compiled.distance, contacts["distance"], atol=1e-6)


def test_no_contacts_are_no_distances():
    found = softcd.jax.distances(jnp.asarray(PIERCING_T0), np.zeros(0, softcd.contact_dtype), margins=0.1)
    assert found.distance.shape == found.gap.shape == found.mollifier.shape == (0,) and found.weights.shape == (0, 4)


def test_wrong_arguments_are_named():
    x = jnp.asarray(PIERCING_T0)
    contacts = softcd.detect(PIERCING_T0, PIERCING_TRIANGLES, PIERCING_T1)

    def refuses(error, text, *arguments, **options):
        with pytest.raises(error, match=text):
            softcd.jax.distances(*arguments, **options)

    refuses(TypeError, "^x: expected arrays of jax, got int", 3, contacts)
    refuses(TypeError, "^x: expected float32 or float64, got int64", x.astype(int), contacts)
    refuses(ValueError, r"^x: expected shape \(n, 3\), got \(18,\)", x.ravel(), contacts)
    refuses(ValueError, "^x: .* one type", [x, x.astype(np.float32)], contacts)
    refuses(ValueError, "^x: .* at least one", [], contacts)
    refuses(ValueError, "^x: contacts name vertices that it lacks", x[:3], contacts)
    refuses(ValueError, "^x: it lacks the positions of body 0", {1: x}, contacts)
    refuses(TypeError, "^contacts: expected an array of softcd.contact_dtype", x, [1, 2])
    refuses(TypeError, "^margins: expected a number", x, contacts, margins=[0.1])
    refuses(ValueError, "^margins: expected one for each of x's 2 bodies, got 1", [x, x], contacts, margins=[0.1])
    refuses(ValueError, "^rest_positions: expected as many", x, contacts, rest_positions=x[:5])
    between = softcd.detect([PIERCING_T0, PIERCING_T0], [PIERCING_TRIANGLES] * 2, margin=0.1)
    refuses(ValueError, "^x: the contacts are of 2 bodies", x, between)
