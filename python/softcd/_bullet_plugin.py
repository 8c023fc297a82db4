"""softcd's plugin in a PyBullet client: loads it, and passes commands and arrays to it."""

from __future__ import annotations

import array
import ctypes
import importlib.metadata
import importlib.util
import pathlib

import numpy as np
import pybullet

from ._errors import BackendError, Error, InvalidInput, OutOfMemory



def _find_plugin() -> pathlib.Path | None:
    package = importlib.util.find_spec("softcd_pybullet")
    if package is None or package.origin is None:
        return None
    return pathlib.Path(package.origin).with_name("softcd_pybullet.so")


PLUGIN = _find_plugin()
"""The plugin that PyBullet loads. None where the package softcd-pybullet is not installed."""

_ERRORS = {-2: InvalidInput, -3: BackendError, -4: OutOfMemory}
# PyBullet cuts off longer commands, and takes no more numbers in one.
_LONGEST_COMMAND = 1023
_MOST_NUMBERS = 128


class Plugin:
    """The plugin in one client. All Plugins of a client are the same one of PyBullet's."""

    def __init__(self, client: int) -> None:
        """Loads the plugin. Raises softcd.Error where it is not installed, or was built for another PyBullet."""
        if PLUGIN is None:
            raise Error("softcd's plugin for PyBullet is not installed: install the package softcd-pybullet.")
        self.client = client
        # PyBullet passes bytes one by one; here they are copied at once.
        self._is_near = pybullet.getConnectionInfo(client)["connectionMethod"] in (pybullet.DIRECT, pybullet.GUI)
        self.id = pybullet.loadPlugin(str(PLUGIN), "_softcd", physicsClientId=client)
        if self.id < 0:
            raise Error(f"PyBullet could not load {PLUGIN}; what it has printed says why.")
        built_for = self.text("version")
        installed = importlib.metadata.version("pybullet")
        if built_for != installed:
            pybullet.unloadPlugin(self.id, physicsClientId=client)
            raise Error(
                f"softcd's plugin was built for PyBullet {built_for}, but this is {installed}, whose objects may lie "
                f"in memory otherwise: install pybullet=={built_for}."
            )

    def execute(self, command: str, data: bytes | None = None) -> bytes:
        """Executes a command and returns its answer. `data`, a multiple of four bytes, becomes its input."""
        if data is not None and self._is_near:
            memory = np.frombuffer(data, np.uint8)
            self._send(f"input_at {memory.ctypes.data} {memory.size}", [])
        elif data is not None:
            numbers = np.frombuffer(data, np.int32).tolist()
            for first in range(0, max(len(numbers), 1), _MOST_NUMBERS):
                self._send("input new" if first == 0 else "input", numbers[first : first + _MOST_NUMBERS])
        if not self._is_near:
            return self._send(command, [])
        address, size = self._send("@" + command, []).split()
        return ctypes.string_at(int(address), int(size) - 1)

    def text(self, command: str) -> str:
        """Executes a command and returns its answer as text."""
        return self.execute(command).decode()

    def _send(self, command: str, numbers: list[int]) -> bytes:
        if len(command) > _LONGEST_COMMAND:
            raise InvalidInput(f"'{command[:40]}...' has {len(command)} characters; PyBullet takes {_LONGEST_COMMAND}.")
        reply = pybullet.executePluginCommand(self.id, command, numbers, physicsClientId=self.client)
        if not isinstance(reply, tuple):
            raise Error("PyBullet did not pass a command on to softcd's plugin; it was unloaded.")
        result, _, signed_bytes = reply
        answer = array.array("b", signed_bytes).tobytes()[:-1]  # without the plugin's last byte
        if result != 0:
            raise _ERRORS.get(result, Error)(answer.decode())
        return answer


def read_array(data: bytes, dtype: np.dtype, offset: int = 0, count: int = -1) -> np.ndarray:
    """Returns a part of an answer as an array of its own."""
    size = count * dtype.itemsize if count >= 0 else len(data) - offset
    return np.frombuffer(bytearray(data[offset : offset + size]), dtype)
