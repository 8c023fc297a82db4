"""Collision detection between deformable triangle meshes, on a GPU where one exists, else on the CPU."""

from ._core import (
    NO_BODY,
    Accuracy,
    Backend,
    BatchQuery,
    BatchScene,
    BatchTicket,
    BroadPhase,
    ContactKind,
    ContactRule,
    Detection,
    DeviceArray,
    DeviceContacts,
    LogLevel,
    MeshChange,
    Pairs,
    PendingContacts,
    Query,
    QueryOptions,
    RegionKind,
    Scene,
    SceneOptions,
    StageReport,
    StageTimes,
    Statistics,
    StepEnd,
    Ticket,
    read_mesh,
    write_mesh,
)
from ._core import contact_dtype as _contact_dtype
from ._core import version as __version__
from ._audit import Audit, audit, audit_dtype
from ._batch import BatchContacts
from ._errors import BackendError, Error, InvalidInput, MeshError, OutOfMemory
from ._helpers import Certificate, certify, collision_free_step, detect, self_intersections
from ._plot import plot
from ._probe import AnswerLists, IntersectionRegions, Probe

contact_dtype = _contact_dtype()
"""The fields of a contact; what they mean stands in softcd/core/contact.hpp and docs/use/python.md."""

__all__ = [
    "NO_BODY",
    "Accuracy",
    "AnswerLists",
    "Audit",
    "Backend",
    "BackendError",
    "BatchContacts",
    "BatchQuery",
    "BatchScene",
    "BatchTicket",
    "BroadPhase",
    "Certificate",
    "ContactKind",
    "ContactRule",
    "Detection",
    "DeviceArray",
    "DeviceContacts",
    "Error",
    "IntersectionRegions",
    "InvalidInput",
    "LogLevel",
    "MeshChange",
    "MeshError",
    "OutOfMemory",
    "Pairs",
    "PendingContacts",
    "Probe",
    "Query",
    "QueryOptions",
    "RegionKind",
    "Scene",
    "SceneOptions",
    "StageReport",
    "StageTimes",
    "Statistics",
    "StepEnd",
    "Ticket",
    "__version__",
    "audit",
    "audit_dtype",
    "certify",
    "collision_free_step",
    "contact_dtype",
    "detect",
    "plot",
    "read_mesh",
    "self_intersections",
    "write_mesh",
]
