"""softcd in PyBullet's world, in place of Bullet's own detection of soft bodies: docs/use/pybullet.md.

    client = pybullet.connect(pybullet.DIRECT)
    ...
    attachment = softcd.bullet.attach(client, detection="ccd")
    pybullet.stepSimulation(client)
"""

from __future__ import annotations

import importlib.metadata
import json
import pathlib
from typing import Any

import pybullet

from ._errors import Error

PLUGIN = pathlib.Path(__file__).parent / "softcd_pybullet.so"
"""The plugin that PyBullet loads; it is there where softcd was built with SOFTCD_PYBULLET_SOURCE."""


def attach(client: int = 0, **settings: str | float | bool) -> Attachment:
    """Gives the world of a PyBullet client softcd's detection, and returns an Attachment.

    The world has soft bodies (the default) or deformable ones (RESET_USE_DEFORMABLE_WORLD). It may be new or in use.
    settings are those of softcd::bullet::Settings: backend ("automatic", "cpu", "cuda"), detection ("dcd", "ccd"),
    accuracy ("fast", "precise", "conservative", "automatic"), broad_phase ("exact", "uniform"), cell_size_factor,
    reuse_pairs, self_collision ("flagged", "all", "none"), edge_contacts ("off", "report", "respond"), contacts
    ("all", "closest_feature", "automatic"), contacts_per_node, rigid_meshes, convex_shapes ("nodes",
    "faces_and_edges"), filter_deformables. Not available: callbacks, the read-out that they receive, and on_error.

    Raises softcd.Error where softcd was built without the plugin or for another version of PyBullet, where a setting
    is invalid, and where softcd is attached already.
    """
    plugin = _load(client)
    words = [f"{name}={value}" for name, value in settings.items()]
    attachment = Attachment(client, plugin)
    attachment._execute(" ".join(["attach", *words]))
    return attachment


class Attachment:
    """softcd in a world of PyBullet's. It does not end with this object, but by detach(), resetSimulation, disconnect
    or the end of a `with` statement."""

    def __init__(self, client: int, plugin: int) -> None:
        self._client = client
        self._plugin = plugin

    def _execute(self, command: str) -> str:
        answer = pybullet.executePluginCommand(self._plugin, command, physicsClientId=self._client)
        if not isinstance(answer, tuple):
            raise Error("PyBullet did not pass a command on to softcd's plugin; it was unloaded.")
        text = bytes(byte % 256 for byte in answer[2]).decode().removesuffix("\n")
        if answer[0] != 0:
            raise Error(text)
        return text

    @property
    def is_attached(self) -> bool:
        """False after detach() and when the world was reset."""
        return self._execute("is_attached") == "1"

    @property
    def limitations(self) -> list[str]:
        """The differences from softcd's own worlds: one sentence each."""
        return self._execute("limitations").splitlines()

    def finish_step(self) -> None:
        """Ends a step in worlds with soft bodies, not deformable ones, with detection="ccd". Call it after
        stepSimulation, before positions are read. Otherwise the next step, or detach(), does it first."""
        self._execute("finish_step")

    def report(self) -> dict[str, dict[str, Any]]:
        """Returns the results of the last step: a dict of dicts, `contacts`, `crossings`, `crossing_answers` and
        `rigid_meshes`, as softcd::bullet::WorldDetection names them."""
        return json.loads(self._execute("report"))

    def detach(self) -> None:
        """Removes everything of softcd's from the world. Bullet then detects as before."""
        self._execute("detach")

    def __enter__(self) -> Attachment:
        return self

    def __exit__(self, *exception: object) -> None:
        if pybullet.isConnected(self._client):
            self.detach()


def _load(client: int) -> int:
    if not PLUGIN.exists():
        raise Error(
            f"softcd was built without its plugin for PyBullet ({PLUGIN} is not there): build it with "
            "--config-settings=cmake.define.SOFTCD_PYBULLET_SOURCE, as docs/use/pybullet.md says."
        )
    plugin = pybullet.loadPlugin(str(PLUGIN), "_softcd", physicsClientId=client)
    if plugin < 0:
        raise Error(f"PyBullet could not load {PLUGIN}; what it has printed says why.")
    built_for = Attachment(client, plugin)._execute("version")
    installed = importlib.metadata.version("pybullet")
    if built_for != installed:
        pybullet.unloadPlugin(plugin, physicsClientId=client)
        raise Error(
            f"softcd's plugin was built for PyBullet {built_for}, but this is {installed}, whose objects may lie in "
            "memory otherwise: build it with this version's sources."
        )
    return plugin
