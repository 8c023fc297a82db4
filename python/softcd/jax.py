"""Distances of contacts as jax computes them: differentiable in the positions, in batches. `import softcd.jax`.

contacts = softcd.detect(np.asarray(x), triangles, margin=0.005)
value, gradient = jax.value_and_grad(lambda x: (softcd.jax.distances(x, contacts).distance**2).sum())(x)
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Real
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from ._core import ContactKind
from ._distances import difference_of, length_of, pairs_of_one_kind, unit_of
from ._errors import InvalidInput

Positions = Any
"""One body's positions, of shape (n, 3), or those of each body: in the order of their numbers, or by number."""


class Distances(NamedTuple):
    """The result of distances(): a row for each contact, in the contacts' order, as in softcd.torch."""

    distance: jax.Array
    """The features' distance, of shape (k,), in the unit of the positions."""
    gap: jax.Array
    """The distance minus both bodies' margins, of shape (k,). Negative within the margins."""
    mollifier: jax.Array
    """IPC's factor for nearly parallel edges, in [0, 1], of shape (k,). 1 for a vertex and a triangle."""
    weights: jax.Array
    """The nearest points, of shape (k, 4): 1, then the triangle's three, or two of each edge."""


def distances(
    x: Positions,
    contacts: np.ndarray,
    *,
    margins: float | Sequence[float] | Mapping[int, float] = 0.0,
    signed: bool = False,
    rest_positions: Positions | None = None,
) -> Distances:
    """Computes the distances of contacts' features at the positions x, differentiable in x, by jax.grad, jax.jvp and
    jax.hessian. Arguments, derivatives and errors are those of softcd.torch.distances(), which describes them.

    - `x`: arrays of jax of shape (n, 3), float32 or, with jax_enable_x64, float64. An array alone is the only body's.
      For several bodies it is a sequence in their order or a dict by body number. x may be traced by jax.jit.
    - `contacts`: an array of softcd.contact_dtype, with k contacts. Inside jax.jit contacts are constants: other
      contacts compile again, so functions of changing contacts are better not compiled as a whole.

        gradient = jax.grad(lambda x: softcd.jax.distances(x, contacts).gap.sum())(x)
    """
    if "weights" not in (getattr(getattr(contacts, "dtype", None), "names", None) or ()):
        raise TypeError("contacts: expected an array of softcd.contact_dtype")
    named = _named("x", x)
    numbers = list(named)
    begins = dict(zip(numbers, np.cumsum([0, *(len(array) for array in named.values())])))
    joined = jnp.concatenate(list(named.values()))
    is_face = contacts["kind"] == int(ContactKind.vertex_triangle)
    side_b = np.arange(4) >= np.where(is_face, 1, 2)[:, None]
    bodies = np.where(side_b, contacts["body_b"][:, None], contacts["body_a"][:, None]).astype(np.int64)
    present = np.unique(bodies)
    if not isinstance(x, (Mapping, Sequence)):
        if len(present) > 1:
            raise InvalidInput(
                f"x: the contacts are of {len(present)} bodies: give their positions as a sequence or a dict"
            )
        bodies[:] = 0
    for body in np.unique(bodies).tolist():
        if body not in named:
            raise InvalidInput(f"x: it lacks the positions of body {body}")
    corners = contacts["vertices"].astype(np.int64)
    counts = np.vectorize(lambda body: len(named[body]), otypes=[np.int64])(bodies)
    if (corners >= counts).any():
        raise InvalidInput("x: contacts name vertices that it lacks; they belong to other meshes")
    corners += np.vectorize(begins.__getitem__, otypes=[np.int64])(bodies)
    rest = None
    if rest_positions is not None:
        at_rest = _named("rest_positions", rest_positions)
        if {body: len(array) for body, array in at_rest.items()} != {b: len(array) for b, array in named.items()}:
            raise InvalidInput("rest_positions: expected as many bodies and positions as x has")
        rest = jnp.concatenate([at_rest[body] for body in numbers]).astype(joined.dtype)
    parts, rows = [], []
    for kind_is_face in (True, False):
        row = np.flatnonzero(is_face == kind_is_face)
        rows.append(row)
        normal = jnp.asarray(contacts["normal"][row], joined.dtype)
        vertices = corners[row]
        parts.append(
            pairs_of_one_kind(
                _FUNCTIONS, joined[vertices], kind_is_face, normal, signed, None if rest is None else rest[vertices]
            )
        )
    order = np.argsort(np.concatenate(rows))
    length, mollifier, weights = (jnp.concatenate(columns)[order] for columns in zip(*parts))
    return Distances(length, length - _summed_margins(margins, x, named, contacts), mollifier, weights)


def _named(name: str, x: Positions) -> dict[int, jax.Array]:
    """Returns the positions by body."""
    if isinstance(x, Mapping):
        named = {int(body): array for body, array in x.items()}
    else:
        named = dict(enumerate(x if isinstance(x, Sequence) else [x]))
    for array in named.values():
        if not hasattr(array, "dtype") or not hasattr(array, "shape"):
            raise TypeError(f"{name}: expected arrays of jax, got {type(array).__name__}")
        if array.dtype not in (np.float32, np.float64):
            raise TypeError(f"{name}: expected float32 or float64, got {array.dtype}")
        if array.ndim != 2 or array.shape[1] != 3:
            raise InvalidInput(f"{name}: expected shape (n, 3), got {tuple(array.shape)}")
    if len({array.dtype for array in named.values()}) != 1:
        raise InvalidInput(f"{name}: expected arrays of one type, at least one")
    return {body: jnp.asarray(array) for body, array in named.items()}


def _summed_margins(margins: Any, x: Positions, named: dict[int, Any], contacts: np.ndarray) -> Any:
    if isinstance(margins, Real):
        return 2 * float(margins)
    if not isinstance(x, (Mapping, Sequence)) or not isinstance(margins, (Sequence, Mapping)):
        raise TypeError("margins: expected a number, or one for each of several bodies")
    by_body = {int(b): float(v) for b, v in (margins.items() if isinstance(margins, Mapping) else enumerate(margins))}
    if set(by_body) != set(named):
        raise InvalidInput(f"margins: expected one for each of x's {len(named)} bodies, got {len(by_body)}")
    sums = [by_body[a] + by_body[b] for a, b in zip(contacts["body_a"].tolist(), contacts["body_b"].tolist())]
    return np.array(sums, np.float64).astype(next(iter(named.values())).dtype)


class _Functions:
    """jax's Functions."""

    cross = staticmethod(jnp.cross)
    zeros = staticmethod(jnp.zeros_like)
    constant = staticmethod(jax.lax.stop_gradient)

    def where(self, condition: jax.Array, a: Any, b: Any) -> jax.Array:
        return jnp.where(condition, a, b)

    def stack(self, arrays: list[jax.Array]) -> jax.Array:
        return jnp.stack(arrays, axis=1)

    def clip(self, values: jax.Array) -> jax.Array:
        return jnp.clip(values, 0, 1)

    def pick(self, values: jax.Array, place: jax.Array) -> jax.Array:
        return jnp.take_along_axis(values, place[:, None], axis=1)[:, 0]

    def largest(self, arrays: list[jax.Array]) -> jax.Array:
        return jnp.abs(jnp.stack(arrays)).max(axis=(0, 2))

    def eps(self, values: jax.Array) -> float:
        return float(jnp.finfo(values.dtype).eps)

    def length(self, *inputs: Any) -> jax.Array:
        return _length(inputs[-1], *inputs[:-1])


_FUNCTIONS = _Functions()


def _forward(signed: bool, *inputs: Any) -> jax.Array:
    return length_of(_FUNCTIONS, difference_of(*inputs[:5]), inputs[5], signed)


_length = jax.custom_jvp(_forward, nondiff_argnums=(0,))
"""The length of a - s b - t c, whose first derivatives leave s and t out: see unit_of()."""


@_length.defjvp
def _length_jvp(signed: bool, primals: Any, tangents: Any) -> tuple[jax.Array, jax.Array]:
    a, b, c, s, t, normal = primals
    unit = unit_of(_FUNCTIONS, difference_of(a, b, c, s, t), normal, signed)
    da, db, dc, *_ = tangents
    return _length(signed, *primals), (unit * difference_of(da, db, dc, s, t)).sum(axis=-1)
