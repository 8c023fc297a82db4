"""Questions about the soft bodies of a PyBullet client."""

from __future__ import annotations

import functools
import math
import operator
from typing import Any

import numpy as np

from ._bullet_plugin import Plugin, read_array
from ._core import Scene
from ._errors import InvalidInput
from ._probe import BodyPairs, Numbers, Probe, Questions

node_dtype = np.dtype([("position", "f8", 3), ("velocity", "f8", 3), ("mass", "f8")])
"""The fields of SoftBodies.nodes()."""


def _near_fields() -> list[tuple]:
    ids = [(f"{name}_{side}", "i4") for side in "ab" for name in ("body", "link")]
    features = [(f"{name}_{side}", "i4") for side in "ab" for name in ("feature", "index")]
    points = [("position_a", "f8", 3), ("position_b", "f8", 3), ("normal", "f8", 3), ("distance", "f8")]
    return ids + features + points


near_dtype = np.dtype(_near_fields(), align=True)
"""The fields of SoftBodies.near()."""


class SoftBodies(Questions):
    """The soft bodies of a PyBullet client: their meshes, and spatial questions about them.

    softcd need not be attached. Every call sees the nodes where they are now. Bodies are PyBullet's unique ids; answers
    have -1 where there is none. Triangles are faces, as in faces(); further ones are nodes without a face, then links of
    ropes. Lengths are in metres.

    >>> bodies = softcd.bullet.SoftBodies(client)
    >>> hit = bodies.first_hits([0, 0, 2], [0, 0, -1])[0]
    >>> hit["body"] == cloth, bodies.faces(cloth)[hit["triangle"]]
    """

    def __init__(self, client: int = 0) -> None:
        """Finds the soft bodies of a client. Raises softcd.Error where softcd was built without the plugin or for
        another version of PyBullet, and pybullet.error where the client is not connected."""
        self._plugin = Plugin(client)
        super().__init__(_AskedPlugin(self._plugin))

    @property
    def ids(self) -> list[int]:
        """The unique ids of all soft bodies."""
        return np.frombuffer(self._plugin.execute("soft_bodies"), np.int32).tolist()

    def nodes(self, body: int) -> np.ndarray:
        """Returns a row for each node of a body: `position` in metres and `velocity` in m/s, both of shape (3,), and
        `mass` in kg, 0 for a node that is held. Nodes are those of getMeshData with MESH_DATA_SIMULATION_MESH. Raises
        InvalidInput where the client has no such soft body.

        >>> nodes = bodies.nodes(cloth)
        >>> momentum = nodes["mass"] @ nodes["velocity"]
        """
        return read_array(self._plugin.execute(f"nodes {_id('body', body)}"), node_dtype)

    def faces(self, body: int) -> np.ndarray:
        """Returns the nodes of each face of a body: int32 of shape (n, 3). Raises InvalidInput where the client has no
        such soft body."""
        return read_array(self._plugin.execute(f"faces {_id('body', body)}"), np.dtype(np.int32)).reshape(-1, 3)

    def near(self, body: int, max_distance: float = 0.0) -> np.ndarray:
        """Finds the features of a body, soft or rigid, that are at most max_distance from another body, if one of both
        is soft. Distances are between the bodies' margins, and negative where these overlap.

        Returns a row for each pair of features: `body_a` is the body, `body_b` the other one, `link_a` and `link_b`
        their links; `feature_a` and `feature_b`, each a Feature, with `index_a` and `index_b`, the number of the
        node or face; `position_a`, `position_b`; `normal` from b towards a; `distance`. Planes are not found. Raises
        InvalidInput where the client has no such body, or max_distance is negative or not finite.

        >>> gap = bodies.near(gripper, 0.1)["distance"].min(initial=0.1)
        """
        if not (isinstance(max_distance, (int, float, np.number)) and 0 <= max_distance < math.inf):
            raise InvalidInput(f"max_distance: expected a finite number of at least 0, got {max_distance!r}")
        command = f"near_features {_id('body', body)} {float(max_distance)!r}"
        return read_array(self._plugin.execute(command), near_dtype)

    def __repr__(self) -> str:
        return f"<softcd.bullet.SoftBodies {self.ids} of client {self._plugin.client}>"


def _id(name: str, body: Any) -> int:
    try:
        return operator.index(body)
    except TypeError:
        raise TypeError(f"{name}: expected PyBullet's id of a body, got {type(body).__name__}") from None


@functools.cache
def _answer_dtypes() -> dict[str, np.dtype]:
    """Returns the answers' types: those of softcd.Probe, with signed bodies."""
    probe = Probe(Scene(backend="cpu"))
    none = np.empty((0, 3))
    answers = {
        "first_hits": probe.first_hits(none, none),
        "all_hits": probe.all_hits(none, none).all,
        "closest_points": probe.closest_points(none),
        "overlaps": probe.sphere_overlaps(none, 1).all,
        "distances": probe.distances([]),
        "intersections": probe.intersections([]).all,
    }
    return {name: _with_signed_bodies(answer.dtype) for name, answer in answers.items()}


def _with_signed_bodies(dtype: Any) -> np.dtype:
    names = list(dtype.names)
    formats = [np.dtype(np.int32) if name.startswith("body") else dtype.fields[name][0] for name in names]
    offsets = [dtype.fields[name][1] for name in names]
    layout: Any = {"names": names, "formats": formats, "offsets": offsets, "itemsize": dtype.itemsize}
    return np.dtype(layout)


class _AskedPlugin:
    """Passes the questions of softcd.Probe to the plugin."""

    def __init__(self, plugin: Plugin) -> None:
        self._plugin = plugin

    def first_hits(self, rays: np.ndarray) -> np.ndarray:
        return self._each("first_hits", rays.tobytes())

    def all_hits(self, rays: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return self._lists("all_hits", "all_hits", rays.tobytes(), len(rays))

    def closest_points(self, points: np.ndarray) -> np.ndarray:
        return self._each("closest_points", points.tobytes())

    def sphere_overlaps(self, spheres: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return self._lists("sphere_overlaps", "overlaps", spheres.tobytes(), len(spheres))

    def capsule_overlaps(self, capsules: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return self._lists("capsule_overlaps", "overlaps", capsules.tobytes(), len(capsules))

    def box_overlaps(self, boxes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return self._lists("box_overlaps", "overlaps", boxes.tobytes(), len(boxes))

    def oriented_box_overlaps(self, boxes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return self._lists("oriented_box_overlaps", "overlaps", boxes.tobytes(), len(boxes))

    def hull_overlaps(self, points: np.ndarray, begins: Numbers, radii: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        places = np.asarray(begins, np.int64)
        is_valid = places.ndim == 1 and len(places) > 0 and places[0] == 0 and places[-1] == len(points)
        if not is_valid or (np.diff(places) < 0).any():
            raise InvalidInput(f"begins: expected ascending integers from 0 to {len(points)}, the number of points")
        count = len(places) - 1
        if radii.ndim > 0 and len(radii) != count:
            raise InvalidInput(f"radii: expected {count} rows, as begins has hulls, got {len(radii)}")
        sizes = np.array([count], np.int64).tobytes() + places.tobytes()
        data = sizes + np.broadcast_to(radii, count).tobytes() + points.tobytes()
        return self._lists("hull_overlaps", "overlaps", data, count)

    def distances(self, pairs: BodyPairs) -> np.ndarray:
        return self._each("distances", _bytes_of(pairs))

    def intersections(self, pairs: BodyPairs) -> tuple[np.ndarray, np.ndarray]:
        return self._lists("intersections", "intersections", _bytes_of(pairs), len(pairs))

    def has_intersections(self, a: int | None, b: int | None) -> bool:
        return self._plugin.execute("ask has_intersections", _bytes_of([(a, b)])) == b"\1"

    def _each(self, name: str, questions: bytes) -> np.ndarray:
        return read_array(self._plugin.execute(f"ask {name}", questions), _answer_dtypes()[name])

    def _lists(self, name: str, answers: str, questions: bytes, count: int) -> tuple[np.ndarray, np.ndarray]:
        data = self._plugin.execute(f"ask {name}", questions)
        begins = read_array(data, np.dtype(np.int64), 0, count + 1)
        return begins, read_array(data, _answer_dtypes()[answers], 8 * (count + 1))


def _bytes_of(pairs: BodyPairs) -> bytes:
    rows = [[-1 if body is None else _id("pairs", body) for body in pair] for pair in pairs]
    return np.array(rows, np.int32).tobytes()
