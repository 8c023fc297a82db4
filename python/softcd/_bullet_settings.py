"""The settings of softcd in PyBullet: their names, types and words."""

from __future__ import annotations

import difflib
import enum
import re
from typing import Any, Literal, TypedDict

import numpy as np

from ._core import Accuracy, Backend, BroadPhase, Detection
from ._errors import InvalidInput


class SelfCollision(enum.Enum):
    """The soft bodies that collide with themselves."""

    flagged = "flagged"
    """Those loaded with useSelfCollision=1, which PyBullet ignores where soft bodies are not deformable."""
    all = "all"
    """Every body."""
    none = "none"
    """No body."""


class EdgeContacts(enum.Enum):
    """Whether edges touch edges."""

    off = "off"
    """Edge contacts are not detected."""
    report = "report"
    """They are detected, for Attachment.edge_contacts() only."""
    respond = "respond"
    """They are detected and given to Bullet's solver."""
    automatic = "automatic"
    """respond in the deformable world, off in the soft world."""


class Contacts(enum.Enum):
    """Which of a node's contacts with the faces of one body Bullet's solver gets."""

    all = "all"
    """All within the margin."""
    closest_feature = "closest_feature"
    """In the soft world one for each place where the body's surface is nearest to the node; in the deformable, all."""
    automatic = "automatic"
    """closest_feature with detection="dcd", otherwise all."""


class ConvexShapes(enum.Enum):
    """Which features of soft bodies touch convex rigid shapes."""

    nodes = "nodes"
    """Nodes, by Bullet's own test: a shape smaller than a face passes between its nodes."""
    faces_and_edges = "faces_and_edges"
    """Also faces and edges, against corners and edges of the shapes."""


class Untangle(enum.Enum):
    """Which soft bodies that intersect each other, themselves or rigid meshes are moved apart."""

    off = "off"
    """None."""
    later = "later"
    """Those that did not intersect when both were first in the world."""
    all = "all"
    """Those that intersect from the start, and those with filters, too."""
    automatic = "automatic"
    """As later, and with dcd also those that intersect from the start, except pairs of deformable bodies."""


class ReadOut(enum.Enum):
    """What Attachment.contacts() returns."""

    off = "off"
    """Nothing, at no cost."""
    contacts = "contacts"
    """Which bodies touch, and where."""
    impulses = "impulses"
    """Also impulses and forces."""


Preset = Literal["fast", "balanced", "safe"]
"""Settings to begin with. "fast" and "balanced", the default, use discrete detection. "safe" uses continuous detection:
a body crosses another one only if it has nowhere else to go. docs/measured/apps.md compares them in 24 programs."""


class Settings(TypedDict, total=False):
    """All settings by keyword. Enumerators are given by name or as enumerations. attach() and set_settings() also take
    preset, which gives values to all of these first."""

    backend: Backend | Literal["automatic", "cpu", "cuda"]
    """Where detections run."""
    detection: Detection | Literal["dcd", "ccd"]
    """dcd detects at one end of the step; ccd along all of it, and stops what would cross."""
    accuracy: Accuracy | Literal["fast", "precise", "conservative", "automatic"]
    """The arithmetic of contacts."""
    broad_phase: BroadPhase | Literal["exact", "uniform"]
    """How candidates are found; changes no contact."""
    cell_size_factor: float
    """The cell size in mean sizes of triangles, on the CPU of patches: 0.1 to 100, or 0 to let softcd choose."""
    reuse_pairs: bool
    """Whether pairs found in one step serve later ones; changes no contact."""
    self_collision: SelfCollision | Literal["flagged", "all", "none"]
    """Which bodies collide with themselves."""
    edge_contacts: EdgeContacts | Literal["off", "report", "respond", "automatic"]
    """Whether edges touch edges."""
    contacts: Contacts | Literal["all", "closest_feature", "automatic"]
    """Which contacts of a node the solver gets."""
    contacts_per_node: int
    """The most contacts of a node with faces of one body on one side; 0 for no limit."""
    rigid_meshes: bool
    """Whether softcd detects contacts with rigid triangle meshes."""
    convex_shapes: ConvexShapes | Literal["nodes", "faces_and_edges"]
    """Which features touch boxes, spheres and other convex shapes."""
    untangle: Untangle | Literal["off", "later", "all", "automatic"]
    """Which bodies that intersect are moved apart."""
    untangle_speed: float
    """The greatest speed, in metres a second, at which untangle moves a node; 0 chooses by the lengths of edges."""
    filter_deformables: bool
    """Whether setCollisionFilterPair applies between deformable bodies, where Bullet ignores it."""
    read_out: ReadOut | Literal["off", "contacts", "impulses"]
    """What Attachment.contacts() returns."""


_ELSEWHERE = {
    "on_contacts": "PyBullet calls no function in a step; read Attachment.contacts() after it.",
    "log": "PyBullet calls no function in a step; read Attachment.messages() after it.",
}


def words_of(preset: str | None, settings: dict[str, Any]) -> str:
    """Returns the words in which the plugin gets settings. Raises InvalidInput and TypeError, naming the setting."""
    words = [] if preset is None else [f"preset={_word('preset', preset)}"]
    for name, value in settings.items():
        if name in _ELSEWHERE:
            raise InvalidInput(f"{name}: {_ELSEWHERE[name]}")
        if name not in Settings.__annotations__ and name != "on_error":
            names = ["preset", *Settings.__annotations__]
            similar = difflib.get_close_matches(name, names, 1)
            hint = f"did you mean '{similar[0]}'?" if similar else f"there are {', '.join(names)}."
            raise InvalidInput(f"{name}: there is no such setting; {hint}")
        words.append(f"{name.removesuffix('_')}={_word(name, value)}")
    return " ".join(words)


def _word(name: str, value: object) -> str:
    if isinstance(value, enum.Enum):
        return value.name
    if not isinstance(value, (str, bool, int, float, np.generic)):
        raise TypeError(f"{name}: expected a name, an enumerator, True, False or a number, got {type(value).__name__}")
    word = str(value)
    if not re.fullmatch(r"[^\s]+", word):
        raise InvalidInput(f"{name}: {word!r} is no value of a setting.")
    return word
