"""softcd in PyBullet's world, in place of Bullet's own detection of soft bodies: docs/use/pybullet.md.

    client = pybullet.connect(pybullet.DIRECT)
    ...
    attachment = softcd.bullet.attach(client, detection="ccd", read_out="impulses")
    pybullet.stepSimulation(client)
    print(attachment.contacts().force_on(table))
"""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np
import pybullet

from ._bullet_bodies import SoftBodies, _id, near_dtype, node_dtype
from ._bullet_contacts import (
    Feature,
    Impulses,
    PairState,
    StepContacts,
    contact_dtype,
    edge_contact_dtype,
    impulse_dtype,
    intersection_dtype,
    pair_dtype,
)
from ._bullet_plugin import PLUGIN, Plugin, read_array
from ._bullet_settings import (
    Contacts,
    ConvexShapes,
    EdgeContacts,
    Preset,
    ReadOut,
    SelfCollision,
    Settings,
    Untangle,
    words_of,
)
from ._core import LogLevel
from ._errors import InvalidInput

if TYPE_CHECKING:
    from typing_extensions import Unpack

__all__ = [
    "PLUGIN",
    "Attachment",
    "Contacts",
    "ConvexShapes",
    "EdgeContacts",
    "Feature",
    "Impulses",
    "PairState",
    "Preset",
    "ReadOut",
    "SelfCollision",
    "Settings",
    "SoftBodies",
    "StepContacts",
    "Untangle",
    "attach",
    "contact_dtype",
    "edge_contact_dtype",
    "impulse_dtype",
    "intersection_dtype",
    "near_dtype",
    "node_dtype",
    "pair_dtype",
]


def attach(client: int = 0, *, preset: Preset = "balanced", **settings: Unpack[Settings]) -> Attachment:
    """Gives the world of a PyBullet client softcd's detection, and returns an Attachment.

    The world has soft bodies (the default) or deformable ones (RESET_USE_DEFORMABLE_WORLD). It may be new or in use.
    preset, "fast", "balanced" or "safe", chooses settings to begin with. settings are those of softcd::bullet::Settings
    by keyword, enumerators by name or as enumerations; the class Settings lists them and says what each does. In place
    of C++'s callbacks there are Attachment.contacts() and Attachment.messages(). A step in which softcd fails goes on
    with Bullet's own detection: `failed_steps` of Attachment.report() counts such steps.

    Raises softcd.Error where softcd was built without the plugin or for another version of PyBullet; InvalidInput,
    naming the setting, where a setting is unknown or out of range, where the world has no soft bodies, and where softcd
    is attached already; BackendError for a backend that is not there; TypeError for a value of a wrong type.

    >>> attachment = softcd.bullet.attach(client, preset="safe", read_out="impulses")
    """
    words = words_of(preset, dict(settings))
    plugin = Plugin(client)
    plugin.execute(f"attach {words}")
    return Attachment(plugin)


class Attachment:
    """softcd in a world of PyBullet's. It does not end with this object, but by detach(), resetSimulation, disconnect
    or the end of a `with` statement. All functions raise softcd.Error after its end, but for detach() and
    is_attached."""

    def __init__(self, plugin: Plugin) -> None:
        self._plugin = plugin

    @property
    def is_attached(self) -> bool:
        """False after detach() and when the world was reset."""
        return self._plugin.text("is_attached") == "1"

    @property
    def limitations(self) -> list[str]:
        """The differences from softcd's own worlds: one sentence each."""
        return self._plugin.text("limitations").splitlines()

    @property
    def settings(self) -> dict[str, str | float | bool]:
        """The current settings by keyword, enumerators by name."""
        return json.loads(self._plugin.text("settings"))

    def set_settings(self, *, preset: Preset | None = None, **settings: Unpack[Settings]) -> None:
        """Changes settings from the next step on, by the keywords of attach(); others stay. A preset replaces all
        settings first. Raises what attach() raises for settings; nothing changes then.

        >>> attachment.set_settings(detection="ccd")
        """
        self._plugin.execute(f"set {words_of(preset, dict(settings))}")

    def finish_step(self) -> None:
        """Ends a step in worlds with soft bodies, not deformable ones: runs the last pass of detection="ccd" and
        measures impulses. Call it after stepSimulation, before positions are read. Otherwise contacts(), the next step
        or detach() does it first."""
        self._plugin.execute("finish_step")

    def contacts(self) -> StepContacts:
        """Returns the contacts of soft bodies in the last step, with each other, within themselves and with rigid
        bodies and links, whether softcd or Bullet found them. Finishes the step first.

        `state` and `is_new` compare with the previous call, so call it after every step. Raises InvalidInput unless the
        setting read_out is "contacts" or "impulses".

        >>> contacts = attachment.contacts()
        >>> weight = contacts.force_on(cloth, by=table)
        >>> began = contacts.pairs[contacts.pairs["state"] == softcd.bullet.PairState.begun]
        """
        return StepContacts(self._plugin.execute("contacts"))

    def impulses(self) -> Impulses:
        """Returns the impulses of all pairs since the previous call, over all steps. Finishes the step first.

        For clients that read less often than PyBullet steps, also with numSubSteps. Raises InvalidInput unless the
        setting read_out is "impulses".

        >>> impulses = attachment.impulses()
        >>> mean_force = impulses.on(table, by=cloth) / impulses.seconds
        """
        return Impulses(self._plugin.execute("impulses"))

    def edge_contacts(self) -> np.ndarray:
        """Returns the contacts between edges in the last step, a row each: for each side `body_a`, PyBullet's id,
        `nodes_a` and `weights_a` of shape (2,); `normal`, a unit vector from b's point towards a's; `distance` of the
        two points in metres, at `time_of_impact` in [0, 1] of the step. Raises InvalidInput unless the setting
        edge_contacts is "report" or "respond". With "respond", contacts() has those that the solver got, too."""
        return read_array(self._plugin.execute("edge_contacts"), edge_contact_dtype)

    def intersecting_bodies(self) -> np.ndarray:
        """Returns the pairs of bodies that the last step was moving apart, as they were when it began: a row each.

        `body_a` is a soft body's id, and `body_b` another one's, the same where it intersects itself, or a rigid body's
        with a triangle mesh; `regions` the number of parts of both surfaces on the wrong side; `steps` the steps since
        the intersection was found; `curve_length` the length in metres of the curves along which the surfaces
        intersect. A pair that came apart is missing, and one that was given up for a while. Raises InvalidInput if the
        setting untangle is off.

        >>> for pair in attachment.intersecting_bodies():
        ...     print(pair["body_a"], pair["body_b"], pair["curve_length"])
        """
        return read_array(self._plugin.execute("intersecting_bodies"), intersection_dtype)

    def set_filters(
        self,
        body: int,
        *,
        groups: Any = None,
        masks: Any = None,
        neighbour_rings: int = 1,
        rest_distance: float = 0.0,
    ) -> None:
        """Excludes contacts of single nodes of a soft body from the next step on; replaces the body's earlier filters.

        Nodes i and j may touch when groups[i] & masks[j] and groups[j] & masks[i]. groups and masks are integers of
        32 bits, of shape (number of nodes,) or one for all; without them all nodes are in group 1 and may touch all.
        Nodes within neighbour_rings (1 to 16) rings of neighbours do not touch each other, and neither do features that
        are at most rest_distance metres apart now. Filters do not apply to contacts that Bullet finds itself, with
        convex shapes. For pairs of whole bodies there is PyBullet's setCollisionFilterPair.

        Raises InvalidInput where the client has no such soft body, an array has not a row for each node, or a value is
        out of range; nothing changes then.

        >>> attachment.set_filters(cloth, neighbour_rings=2)
        """
        data = b""
        if groups is not None or masks is not None:
            count = len(read_array(self._plugin.execute(f"nodes {_id('body', body)}"), node_dtype))
            columns = [_bits("groups", 1 if groups is None else groups, count)]
            columns.append(_bits("masks", 0xFFFFFFFF if masks is None else masks, count))
            data = np.stack(columns, axis=1).tobytes()
        if not isinstance(neighbour_rings, (int, np.integer)) or neighbour_rings < 0:
            raise InvalidInput(f"neighbour_rings: expected an integer from 1 to 16, got {neighbour_rings!r}")
        if not isinstance(rest_distance, (int, float, np.number)) or not np.isfinite(rest_distance):
            raise InvalidInput(f"rest_distance: expected a finite number of at least 0, got {rest_distance!r}")
        command = f"set_filters {_id('body', body)} {int(neighbour_rings)} {float(rest_distance)!r}"
        self._plugin.execute(command, data)

    def report(self) -> dict[str, dict[str, Any]]:
        """Returns the results of the last step: a dict of dicts, `contacts`, `crossings`, `crossing_answers`,
        `rigid_meshes` and `convex_shapes`, as softcd::bullet::WorldDetection names them. Detectors have the members of
        softcd.Statistics, with `ms` the whole time and `stages_ms` that of each stage, and `failed_steps`.

        >>> attachment.report()["contacts"]["vt_contacts"]
        """
        return json.loads(self._plugin.text("report"))

    def explain(self) -> dict[str, list[dict[str, Any]]]:
        """Returns for each detector of report() which stages of the last detection ran: a list of dicts with `stage`,
        `ran` and `reason`."""
        return json.loads(self._plugin.text("stages"))

    def messages(self) -> list[tuple[LogLevel, str]]:
        """Returns softcd's warnings and other messages since the last call, at most a thousand of them."""
        return [(LogLevel[level], text) for level, text in json.loads(self._plugin.text("messages"))]

    def detach(self) -> None:
        """Removes everything of softcd's from the world. Bullet then detects as before. Does nothing where softcd is
        not attached."""
        self._plugin.execute("detach")

    def __enter__(self) -> Attachment:
        return self

    def __exit__(self, *exception: object) -> None:
        if pybullet.isConnected(self._plugin.client):
            self.detach()


def _bits(name: str, values: Any, count: int) -> np.ndarray:
    array = np.asarray(values)
    if array.dtype.kind not in "iu" or array.min(initial=0) < 0 or array.max(initial=0) > 0xFFFFFFFF:
        raise InvalidInput(f"{name}: expected integers from 0 to 0xFFFFFFFF, got {array.dtype}")
    if array.shape not in ((), (count,)):
        raise InvalidInput(f"{name}: expected shape ({count},), a row for each node, or one for all, got {array.shape}")
    return np.broadcast_to(array.astype(np.uint32), (count,))
