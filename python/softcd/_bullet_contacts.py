"""The contacts of a step in PyBullet, as structured arrays."""

from __future__ import annotations

import enum

import numpy as np

from ._bullet_plugin import read_array
from ._errors import InvalidInput


class PairState(enum.IntEnum):
    """The values of a pair's field `state`: the change since the previous call of Attachment.contacts()."""

    begun = 0
    """The bodies did not touch then."""
    persists = 1
    """They touched then, too."""
    ended = 2
    """They do not touch any more."""


class Feature(enum.IntEnum):
    """The values of the fields `feature_a` and `feature_b`."""

    node = 0
    """A node of a soft body."""
    edge = 1
    """An edge of a soft body."""
    face = 2
    """A face of a soft body."""
    object = 3
    """A rigid body or a link, whose parts Bullet does not distinguish."""


def _pair_fields() -> list[tuple]:
    ids = [(f"{name}_{side}", "i4") for side in "ab" for name in ("body", "link")]
    counts = [("state", "i4"), ("has_impulses", "?"), ("contact_count", "i4"), ("ended_count", "i4")]
    return ids + counts + [(f"{name}_{side}", "f8", 3) for name in ("impulse", "force") for side in "ab"]


def _contact_fields() -> list[tuple]:
    ids = [(f"{name}_{side}", "i4") for side in "ab" for name in ("body", "link")]
    fields = [("feature", "i4"), ("face", "i4"), ("nodes", "i4", 3), ("weights", "f4", 3), ("position", "f8", 3)]
    sides = [(f"{field[0]}_{side}", *field[1:]) for side in "ab" for field in fields]
    middle = [("normal", "f8", 3), ("depth", "f8"), ("time_of_impact", "f8")]
    impulses = [(f"{name}_{side}", "f8", 3) for name in ("impulse", "force") for side in "ab"]
    return [*ids, ("pair", "i4"), ("is_new", "?"), *sides, *middle, *impulses]


def _edge_contact_fields() -> list[tuple]:
    fields = [("body", "i4"), ("nodes", "i4", 2), ("weights", "f4", 2)]
    sides = [(f"{field[0]}_{side}", *field[1:]) for side in "ab" for field in fields]
    return [*sides, ("normal", "f8", 3), ("distance", "f8"), ("time_of_impact", "f8")]


# The structs of bullet_integration/pybullet/contact_answers.cpp.
pair_dtype = np.dtype(_pair_fields(), align=True)
"""The fields of StepContacts.pairs."""
contact_dtype = np.dtype(_contact_fields(), align=True)
"""The fields of StepContacts.contacts and StepContacts.ended."""
edge_contact_dtype = np.dtype(_edge_contact_fields(), align=True)
"""The fields of Attachment.edge_contacts()."""
intersection_dtype = np.dtype(
    [("body_a", "i4"), ("body_b", "i4"), ("regions", "u4"), ("steps", "u8"), ("curve_length", "f8")], align=True
)
"""The fields of Attachment.intersecting_bodies()."""
impulse_dtype = np.dtype(
    [(f"{name}_{side}", "i4") for side in "ab" for name in ("body", "link")]
    + [("impulse_a", "f8", 3), ("impulse_b", "f8", 3)],
    align=True,
)
"""The fields of Impulses.pairs."""


def _is_integer(name: str, value: object) -> None:
    if value is not None and not isinstance(value, (int, np.integer)):
        raise InvalidInput(f"{name}: expected an integer, got {value!r}")


def _is_side(rows: np.ndarray, side: str, body: int, link: int | None, other: int | None) -> np.ndarray:
    """Returns which rows have the body, or its link, on that side, and the other body on the other one."""
    _is_integer("body", body)
    _is_integer("link", link)
    _is_integer("other", other)
    is_side = rows[f"body_{side}"] == body
    if link is not None:
        is_side &= rows[f"link_{side}"] == link
    if other is not None:
        is_side &= rows["body_b" if side == "a" else "body_a"] == other
    return is_side


def _sum_on(rows: np.ndarray, field: str, body: int, link: int | None, by: int | None) -> np.ndarray:
    sides = [rows[_is_side(rows, side, body, link, by)][f"{field}_{side}"] for side in "ab"]
    return np.concatenate(sides).sum(axis=0)


class Impulses:
    """The impulses between soft bodies and the objects that they touch, since the previous call, in kg m/s."""

    pairs: np.ndarray
    """A row for each pair that has touched: `body_a`, `link_a`, `body_b`, `link_b` as in StepContacts.pairs, and the
    sums of its impulses over all steps, `impulse_a` on a and `impulse_b` on b. NaN where one was not known."""
    seconds: float
    """The length of these steps."""

    def __init__(self, data: bytes) -> None:
        self.seconds = float(np.frombuffer(data, np.float64, 1)[0])
        self.pairs = read_array(data, impulse_dtype, 8)

    def on(self, body: int, *, link: int | None = None, by: int | None = None) -> np.ndarray:
        """Returns the sum of impulses on a body, or on one of its links, of shape (3,). `by` selects the other body.

        >>> impulses.on(gripper, by=cloth) / impulses.seconds  # the mean force in N
        """
        return _sum_on(self.pairs, "impulse", body, link, by)

    def __repr__(self) -> str:
        return f"<softcd.bullet.Impulses of {len(self.pairs)} pairs in {self.seconds:.4g} s>"


class StepContacts:
    """The contacts that Bullet's solver got in a step, by pairs of bodies. `a` is a soft body; `b` is another soft
    body, the same one, or a rigid body or link.

    Bodies are PyBullet's unique ids, -1 for a body that was removed since. Links are PyBullet's indices, -1 for a base
    or a soft body. Nodes are the indices that getMeshData with MESH_DATA_SIMULATION_MESH and SoftBodies.nodes() have,
    faces those of SoftBodies.faces(). Lengths are in metres, impulses in kg m/s, forces in N, in world coordinates.
    What is not known is NaN: with read_out="contacts" all impulses and forces, otherwise those of reduced bodies with
    rigid ones.
    """

    pairs: np.ndarray
    """A row for each pair that touches, or has ended: `body_a`, `link_a`, `body_b`, `link_b`; `state`, a PairState;
    `contact_count` and `ended_count`; `impulse_a` on a from b in the step, friction included, and `impulse_b` on b from
    a; `force_a` and `force_b`, the same over the step's length; `has_impulses`, whether these are known. With
    detection="ccd" they include the last pass of the step, which the contacts' own impulses do not."""
    contacts: np.ndarray
    """A row for each contact, pair by pair: `pair`, its row in pairs; bodies and links as there; `is_new`, whether
    these features did not touch before. For each side `feature_a`, a Feature; `nodes_a` of shape (3,) with `weights_a`,
    -1 and 0 where the feature has fewer; `face_a`, -1 unless it is a face; `position_a`, the point of contact.
    `normal`, a unit vector from b towards a; `depth` relative to the margins, negative while these do not touch;
    `time_of_impact` in [0, 1] of the step; `impulse_a`, `impulse_b`, `force_a`, `force_b`."""
    ended: np.ndarray
    """The contacts that have ended since the previous call, as they were, without impulses."""
    step_length: float
    """The length of the step in seconds: of the last one, if PyBullet makes several in one stepSimulation."""

    def __init__(self, data: bytes) -> None:
        self.step_length = float(np.frombuffer(data, np.float64, 1)[0])
        counts = np.frombuffer(data, np.uint64, 3, offset=8).astype(int)
        place = 32
        arrays = []
        for count, dtype in zip(counts, (pair_dtype, contact_dtype, contact_dtype), strict=True):
            arrays.append(read_array(data, dtype, place, count))
            place += count * dtype.itemsize
        self.pairs, self.contacts, self.ended = arrays

    def between(self, body: int, other: int | None = None, *, link: int | None = None) -> np.ndarray:
        """Returns the rows of contacts of a body, or of one of its links, with another body (None: with any).

        >>> contacts.between(cloth, table)["position_a"].mean(axis=0)
        """
        is_a = _is_side(self.contacts, "a", body, link, other)
        return self.contacts[is_a | _is_side(self.contacts, "b", body, link, other)]

    def force_on(self, body: int, *, link: int | None = None, by: int | None = None) -> np.ndarray:
        """Returns the force of all contacts on a body in N, of shape (3,): the sum of its pairs' forces.

        `link` selects one of its links, `by` the body that pushes. 0 without contacts; NaN where the force of a pair is
        not known. Contacts between rigid bodies are not included: PyBullet's getContactPoints has them.

        >>> contacts.force_on(gripper, link=left_finger, by=cloth)
        """
        return _sum_on(self.pairs, "force", body, link, by)

    def __repr__(self) -> str:
        return f"<softcd.bullet.StepContacts: {len(self.contacts)} contacts of {len(self.pairs)} pairs>"
