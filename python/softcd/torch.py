"""Distances of contacts as torch computes them: differentiable in the positions, in batches. `import softcd.torch`.

x.requires_grad_()
contacts = softcd.detect(x.detach(), triangles, margin=0.005)
found = softcd.torch.distances(x, contacts, margins=0.005)
torch.where(found.gap < 0, found.gap**2, 0).sum().backward()
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from numbers import Real
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import torch

from ._core import ContactKind
from ._distances import difference_of, length_of, pairs_of_one_kind, unit_of
from ._errors import InvalidInput

Positions: TypeAlias = torch.Tensor | Sequence[torch.Tensor] | Mapping[int, torch.Tensor]
"""One body's positions, of shape (n, 3), or those of each body: in the order of their numbers, or by number."""


class Distances(NamedTuple):
    """The result of distances(): a row for each contact, in the contacts' order."""

    distance: torch.Tensor
    """The features' distance, of shape (k,), in the unit of the positions."""
    gap: torch.Tensor
    """The distance minus both bodies' margins, of shape (k,). Negative within the margins."""
    mollifier: torch.Tensor
    """IPC's factor for nearly parallel edges, in [0, 1], of shape (k,). 1 for a vertex and a triangle."""
    weights: torch.Tensor
    """The nearest points, of shape (k, 4), as in a contact's `weights`: 1, then the triangle's three, or two of each
    edge. Differentiable, too."""


def distances(
    x: Positions,
    contacts: Any,
    *,
    margins: float | Sequence[float] | Mapping[int, float] = 0.0,
    signed: bool = False,
    rest_positions: Positions | None = None,
) -> Distances:
    """Computes the distances of contacts' features at the positions x, differentiable in x.

    - `x`: float32 or float64 tensors of shape (n, 3), on any device. A tensor alone is the only body's. For several
      bodies it is a sequence, where body i has the i-th tensor, as in `softcd.detect`, or a dict by body number.
    - `contacts`: k contacts of a detection of any kind: an array of softcd.contact_dtype, or DeviceContacts. They say
      which features to compare; their nearest points are searched again, at x, which may have moved since.
    - `margins`: a number for all bodies, or one for each, ordered as x is.
    - `signed`: distances are negative where the nearest points have changed sides, compared with the contact's
      `normal`: where the features have passed through each other. Otherwise distances are not negative.
    - `rest_positions`: as x, for the mollifier's lengths; without them lengths at x are used.

    Features are closed: the nearest points may be in a face, on an edge or at a vertex, and derivatives are those of
    that case. First derivatives exist almost everywhere: not where edges are parallel, or a distance that is not signed
    is 0. There the result is a derivative from one side, along the contact's normal at 0. Second derivatives exist
    except where the case changes. The mollifier makes energies of parallel edges smooth: multiply by it. With c =
    |e_a x e_b|^2 and eps = 1e-3 |rest e_a|^2 |rest e_b|^2 it is c / eps (2 - c / eps) where c < eps, else 1 (Li et al.,
    "Incremental Potential Contact", ACM Transactions on Graphics 39(4), 2020).

    Raises TypeError or InvalidInput, which name the argument.

        found = softcd.torch.distances(x, contacts)
        (found.mollifier * -((found.distance - d) ** 2) * torch.log(found.distance / d)).sum().backward()
    """
    joined, begins = _joined("x", x)
    columns = _columns(contacts, joined)
    is_face = columns["kind"] == int(ContactKind.vertex_triangle)
    side_b = torch.arange(4, device=joined.device) >= torch.where(is_face, 1, 2)[:, None]
    bodies = torch.where(side_b, columns["body_b"][:, None], columns["body_a"][:, None])
    begin, end = _ranges(x, bodies, begins)
    corners = columns["vertices"] + begin
    if (corners >= end).any():
        raise InvalidInput("x: contacts name vertices that it lacks; they belong to other meshes")
    length, mollifier, weights = _by_kind(
        joined,
        corners,
        is_face,
        columns["normal"],
        signed,
        None if rest_positions is None else _rest(rest_positions, joined, begins),
    )
    return Distances(length, length - _summed_margins(margins, x, columns, joined), mollifier, weights)


def _joined(name: str, x: Positions) -> tuple[torch.Tensor, dict[int, tuple[int, int]]]:
    """Joins the positions of all bodies. Returns also where each body's begin and end."""
    if isinstance(x, Mapping):
        named = {int(body): tensor for body, tensor in x.items()}
    else:
        named = dict(enumerate([x] if isinstance(x, torch.Tensor) else x if isinstance(x, Sequence) else [x]))
    ranges, count = {}, 0
    for body, tensor in named.items():
        if not isinstance(tensor, torch.Tensor):
            raise TypeError(f"{name}: expected tensors, got {type(tensor).__name__}")
        if tensor.dtype not in (torch.float32, torch.float64):
            raise TypeError(f"{name}: expected float32 or float64, got {tensor.dtype}")
        if tensor.ndim != 2 or tensor.shape[1] != 3:
            raise InvalidInput(f"{name}: expected shape (n, 3), got {tuple(tensor.shape)}")
        ranges[body] = count, count + len(tensor)
        count += len(tensor)
    tensors = list(named.values())
    if len({(tensor.dtype, tensor.device) for tensor in tensors}) != 1:
        raise InvalidInput(f"{name}: expected tensors of one type on one device, at least one")
    return tensors[0] if len(tensors) == 1 else torch.cat(tensors), ranges


def _columns(contacts: Any, x: torch.Tensor) -> dict[str, torch.Tensor]:
    """Reads the columns that are needed, on the positions' device."""
    types = {
        "kind": torch.int64,
        "body_a": torch.int64,
        "body_b": torch.int64,
        "vertices": torch.int64,
        "normal": x.dtype,
    }
    columns = {}
    for name, dtype in types.items():
        try:
            column = contacts[name]
        except (TypeError, KeyError, IndexError, ValueError):
            raise TypeError("contacts: expected an array of softcd.contact_dtype, or DeviceContacts") from None
        if isinstance(column, np.ndarray):
            column = torch.from_numpy(column.astype(np.float64 if name == "normal" else np.int64))
        else:
            column = torch.from_dlpack(column)
        columns[name] = column.to(x.device, dtype)
    return columns


def _ranges(
    x: Positions, bodies: torch.Tensor, ranges: dict[int, tuple[int, int]]
) -> tuple[torch.Tensor, torch.Tensor]:
    """Returns where the positions of each corner's body begin and end."""
    present = bodies.unique().tolist()
    if isinstance(x, torch.Tensor):
        if len(present) > 1:
            raise InvalidInput(
                f"x: the contacts are of {len(present)} bodies: give their positions as a sequence or a dict"
            )
        ranges = {body: ranges[0] for body in present}
    for body in present:
        if body not in ranges:
            raise InvalidInput(f"x: it lacks the positions of body {body}")
    found = torch.tensor([ranges[body] for body in present], dtype=torch.int64, device=bodies.device).reshape(-1, 2)
    place = torch.searchsorted(torch.tensor(present, dtype=torch.int64, device=bodies.device), bodies)
    return found[place, 0], found[place, 1]


def _rest(rest_positions: Positions, x: torch.Tensor, ranges: dict[int, tuple[int, int]]) -> torch.Tensor:
    joined, own_ranges = _joined("rest_positions", rest_positions)
    if own_ranges != ranges:
        raise InvalidInput("rest_positions: expected as many bodies and positions as x has")
    return joined.to(x.device, x.dtype)


def _summed_margins(margins: Any, x: Positions, columns: dict[str, torch.Tensor], joined: torch.Tensor) -> Any:
    if isinstance(margins, Real):
        return 2 * float(margins)
    if isinstance(x, torch.Tensor) or not isinstance(margins, (Sequence, Mapping)):
        raise TypeError("margins: expected a number, or one for each of several bodies")
    named = {
        int(body): value for body, value in (margins.items() if isinstance(margins, Mapping) else enumerate(margins))
    }
    known = set(x) if isinstance(x, Mapping) else set(range(len(x)))
    if set(named) != known:
        raise InvalidInput(f"margins: expected one for each of x's {len(known)} bodies, got {len(named)}")
    numbers = sorted(named)
    values = torch.tensor([float(named[body]) for body in numbers], dtype=joined.dtype, device=joined.device)
    places = torch.tensor(numbers, dtype=torch.int64, device=joined.device)
    return sum(values[torch.searchsorted(places, columns[body])] for body in ("body_a", "body_b"))


def _by_kind(
    x: torch.Tensor,
    corners: torch.Tensor,
    is_face: torch.Tensor,
    normal: torch.Tensor,
    signed: bool,
    rest: torch.Tensor | None,
) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Computes distances, mollifiers and weights of each kind, and returns them in the contacts' order."""
    parts, rows = [], []
    for kind_is_face in (True, False):
        row = torch.nonzero(is_face == kind_is_face)[:, 0]
        rows.append(row)
        at_rest = None if rest is None else rest[corners[row]]
        parts.append(pairs_of_one_kind(_FUNCTIONS, x[corners[row]], kind_is_face, normal[row], signed, at_rest))
    order = torch.argsort(torch.cat(rows))
    length, mollifier, weights = (torch.cat(columns)[order] for columns in zip(*parts))
    return length, mollifier, weights


class _Functions:
    """torch's Functions."""

    cross = staticmethod(torch.linalg.cross)
    zeros = staticmethod(torch.zeros_like)

    def where(self, condition: torch.Tensor, a: Any, b: Any) -> torch.Tensor:
        return torch.where(condition, a, b)

    def stack(self, arrays: list[torch.Tensor]) -> torch.Tensor:
        return torch.stack(arrays, dim=1)

    def clip(self, values: torch.Tensor) -> torch.Tensor:
        return values.clamp(0, 1)

    def pick(self, values: torch.Tensor, place: torch.Tensor) -> torch.Tensor:
        return values.gather(1, place[:, None])[:, 0]

    def constant(self, values: torch.Tensor) -> torch.Tensor:
        return values.detach()

    def largest(self, arrays: list[torch.Tensor]) -> torch.Tensor:
        return torch.stack(arrays).abs().amax(dim=(0, 2))

    def eps(self, values: torch.Tensor) -> float:
        return torch.finfo(values.dtype).eps

    def length(self, *inputs: Any) -> torch.Tensor:
        return _Length.apply(*inputs)


_FUNCTIONS = _Functions()


class _Length(torch.autograd.Function):
    """The length of a - s b - t c, whose first derivatives leave s and t out: see unit_of(). Second derivatives
    differentiate the first ones, by s and t too."""

    @staticmethod
    def forward(*inputs: Any) -> torch.Tensor:
        return length_of(_FUNCTIONS, difference_of(*inputs[:5]), *inputs[5:])

    @staticmethod
    def setup_context(ctx: Any, inputs: tuple[Any, ...], output: torch.Tensor) -> None:
        ctx.save_for_backward(*inputs[:-1])
        ctx.signed = inputs[-1]

    @staticmethod
    def backward(ctx: Any, *grad_outputs: torch.Tensor) -> tuple[torch.Tensor | None, ...]:
        (gradient,) = grad_outputs
        a, b, c, s, t, normal = ctx.saved_tensors
        along_unit = gradient[:, None] * unit_of(_FUNCTIONS, difference_of(a, b, c, s, t), normal, ctx.signed)
        return along_unit, -s[:, None] * along_unit, -t[:, None] * along_unit, None, None, None, None
