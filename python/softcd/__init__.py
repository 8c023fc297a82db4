"""Collision detection between deformable triangle meshes, on the GPU when there is one and on the CPU when not."""

from ._core import (
    Accuracy,
    Backend,
    BroadPhase,
    ContactKind,
    ContactRule,
    Detection,
    DeviceContacts,
    LogLevel,
    Pairs,
    Query,
    QueryOptions,
    Scene,
    SceneOptions,
    StageReport,
    StageTimes,
    Statistics,
    StepEnd,
    Ticket,
    read_mesh,
)
from ._core import contact_dtype as _contact_dtype
from ._core import version as __version__
from ._errors import BackendError, Error, InvalidInput, MeshError, OutOfMemory
from ._helpers import collision_free_step, detect, self_intersections

contact_dtype = _contact_dtype()
"""The fields of a contact; what they mean stands in softcd/core/contact.hpp and docs/python.md."""

__all__ = [
    "Accuracy",
    "Backend",
    "BackendError",
    "BroadPhase",
    "ContactKind",
    "ContactRule",
    "Detection",
    "DeviceContacts",
    "Error",
    "InvalidInput",
    "LogLevel",
    "MeshError",
    "OutOfMemory",
    "Pairs",
    "Query",
    "QueryOptions",
    "Scene",
    "SceneOptions",
    "StageReport",
    "StageTimes",
    "Statistics",
    "StepEnd",
    "Ticket",
    "__version__",
    "collision_free_step",
    "contact_dtype",
    "detect",
    "read_mesh",
    "self_intersections",
]
