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
      which features to compare; the nearest points are found anew. Positions may have moved since.
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
        parts.append(_of_one_kind(x, corners[row], kind_is_face, normal[row], signed, rest))
    order = torch.argsort(torch.cat(rows))
    length, mollifier, weights = (torch.cat(columns)[order] for columns in zip(*parts))
    return length, mollifier, weights


def _dot(a: torch.Tensor, b: torch.Tensor) -> torch.Tensor:
    return (a * b).sum(dim=-1)


def _quotient(a: torch.Tensor, b: torch.Tensor, least: Any = 0.0) -> torch.Tensor:
    """Divides. Where b is at most `least` the result is a: derivatives must be finite where nothing uses them, too."""
    return a / torch.where(b > least, b, 1)


def _edges(p: torch.Tensor, is_face: bool) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Returns a, b, c such that the nearest points differ by a - s b - t c: a vertex and s + t <= 1 on a triangle, or
    s and t in [0, 1] along two edges."""
    if is_face:
        return p[:, 0] - p[:, 1], p[:, 2] - p[:, 1], p[:, 3] - p[:, 1]
    return p[:, 0] - p[:, 2], p[:, 0] - p[:, 1], p[:, 3] - p[:, 2]


class _Length(torch.autograd.Function):
    """The length of a - s b - t c at the nearest points. To first order, it does not depend on s and t there. Its
    derivatives leave s and t out, because they would only add roundings: large ones where edges are nearly parallel.
    Second derivatives differentiate the first ones, by s and t too."""

    @staticmethod
    def forward(*inputs: Any) -> torch.Tensor:
        difference, along, _ = _Length._difference(*inputs[:-1])
        length = difference.norm(dim=1)
        return torch.where(along < 0, -length, length) if inputs[-1] else length

    @staticmethod
    def setup_context(ctx: Any, inputs: tuple[Any, ...], output: torch.Tensor) -> None:
        ctx.save_for_backward(*inputs[:-1])
        ctx.signed = inputs[-1]

    @staticmethod
    def backward(ctx: Any, gradient: torch.Tensor) -> tuple[torch.Tensor | None, ...]:
        *_, s, t, normal = ctx.saved_tensors
        difference, along, squared = _Length._difference(*ctx.saved_tensors)
        unit = difference / torch.sqrt(torch.where(squared > 0, squared, 1))[:, None]
        if ctx.signed:
            unit = torch.where((along < 0)[:, None], -unit, unit)
        along_unit = gradient[:, None] * torch.where(squared[:, None] > 0, unit, normal)
        return along_unit, -s[:, None] * along_unit, -t[:, None] * along_unit, None, None, None, None

    @staticmethod
    def _difference(a: Any, b: Any, c: Any, s: Any, t: Any, normal: Any) -> tuple[torch.Tensor, ...]:
        difference = a - s[:, None] * b - t[:, None] * c
        return difference, _dot(difference, normal), _dot(difference, difference)


def _of_one_kind(
    x: torch.Tensor, corners: torch.Tensor, is_face: bool, normal: torch.Tensor, signed: bool, rest: torch.Tensor | None
) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    a, b, c = _edges(x[corners], is_face)
    # Scales edges to size 1, so that no power of a length overflows or vanishes.
    scale = torch.stack([a, b, c]).detach().abs().amax(dim=(0, 2))[:, None]
    scale = torch.where(scale > 0, scale, 1)
    a, b, c = a / scale, b / scale, c / scale
    s, t = _nearest(a, b, c, is_face)
    length = _Length.apply(a, b, c, s, t, normal, signed) * scale[:, 0]
    if is_face:
        return length, torch.ones_like(length), torch.stack([torch.ones_like(s), 1 - s - t, s, t], dim=1)
    rest_b, rest_c = (b, c) if rest is None else (edge / scale for edge in _edges(rest[corners], False)[1:])
    return length, _mollifier(b, c, rest_b, rest_c), torch.stack([1 - s, s, 1 - t, t], dim=1)


def _nearest(a: torch.Tensor, b: torch.Tensor, c: torch.Tensor, is_face: bool) -> tuple[torch.Tensor, torch.Tensor]:
    """Returns the s and t of the nearest points: the best of those inside and those on each side of the domain."""
    n = torch.linalg.cross(b, c)
    area = _dot(n, n)
    # Below this the normal is nothing but rounding: b and c are parallel, or points.
    info = torch.finfo(a.dtype)
    least = 16 * info.eps**2 * _dot(b, b) * _dot(c, c)
    inner_s = _quotient(_dot(torch.linalg.cross(a, c), n), area, least)
    inner_t = _quotient(_dot(torch.linalg.cross(b, a), n), area, least)
    is_inside = (area > least) & (inner_s >= 0) & (inner_t >= 0)
    is_inside &= (inner_s + inner_t <= 1) if is_face else ((inner_s <= 1) & (inner_t <= 1))

    def on_side(from_start: torch.Tensor, side: torch.Tensor) -> torch.Tensor:
        return _quotient(_dot(from_start, side), _dot(side, side), info.eps**2).clamp(0, 1)

    zero, one = torch.zeros_like(inner_s), torch.ones_like(inner_s)
    candidates = [(inner_s, inner_t), (on_side(a, b), zero), (zero, on_side(a, c))]
    if is_face:
        share = on_side(a - b, c - b)
        candidates.append((1 - share, share))
    else:
        candidates += [(on_side(a - c, b), one), (one, on_side(a - b, c))]
    s, t = (torch.stack(values, dim=1) for values in zip(*candidates))
    with torch.no_grad():
        difference = a[:, None] - s[..., None] * b[:, None] - t[..., None] * c[:, None]
        squared = _dot(difference, difference)
        squared[:, 0] = torch.where(is_inside, squared[:, 0], torch.inf)
        best = squared.argmin(dim=1, keepdim=True)
    return s.gather(1, best)[:, 0], t.gather(1, best)[:, 0]


def _mollifier(b: torch.Tensor, c: torch.Tensor, rest_b: torch.Tensor, rest_c: torch.Tensor) -> torch.Tensor:
    n = torch.linalg.cross(b, c)
    share = _quotient(_dot(n, n), 1e-3 * _dot(rest_b, rest_b) * _dot(rest_c, rest_c))
    return torch.where(share < 1, share * (2 - share), 1)
