"""Lets each allocation of each call fail, and prints the number of failures.

test_faults.py runs it with a preloaded library.
"""

import ctypes
import gc
import sys

import numpy as np

import softcd
from meshes import PIERCING_T0, PIERCING_T1, PIERCING_TRIANGLES

allocations = ctypes.CDLL(sys.argv[1])
allocations.living_allocations.restype = ctypes.c_int64
allocations.fail_allocation.argtypes = [ctypes.c_int64, ctypes.c_int]

GOOD = PIERCING_T1
RAY = (np.array([1.0, 1.5, 9]), np.array([0.0, 0, -1]))


class World:
    """A body that collides with itself, a query and a probe."""

    def __init__(self):
        self.scene = softcd.Scene(backend=softcd.Backend.cpu, max_threads=1)
        self.body = self.scene.add_body(PIERCING_TRIANGLES, 6, self_collision=True)
        self.scene.set_positions(self.body, PIERCING_T0, PIERCING_T1)
        self.query = softcd.Query(self.scene, detection=softcd.Detection.ccd)
        self.probe = softcd.Probe(self.scene)

    def bytes(self):
        """Returns the results of the query and of the probe. A failed call must not change them."""
        return self.query.detect().tobytes() + self.probe.first_hits(*RAY).tobytes()


def change(world):
    world.scene.update_body(world.body, PIERCING_TRIANGLES[::-1].copy(), 6, self_collision=True)


def change_in_part(world):
    triangles = PIERCING_TRIANGLES[[0, 1, 1]]
    world.scene.update_body(world.body, triangles, 6, changed=np.array([1]), self_collision=True)


def add_and_remove(world):
    world.scene.remove_body(world.scene.add_body(PIERCING_TRIANGLES, 6, segments=np.array([[0, 5]])))


def detect_in_environments(world):
    scene = softcd.BatchScene(2, backend=softcd.Backend.cpu, max_threads=1)
    scene.add_body(PIERCING_TRIANGLES, 6)
    scene.set_positions(0, np.stack([PIERCING_T0, PIERCING_T0 + 9]), np.stack([PIERCING_T1, PIERCING_T1 + 9]))
    return softcd.BatchQuery(scene, detection=softcd.Detection.ccd).detect().all.tobytes()


# Calls that change the world change all or nothing: afterwards the world is one of two. Calls that convert strings and
# lists by nanobind are left out: they end the process where memory runs out.
CALLS = {
    "Scene": lambda world: softcd.Scene(backend=softcd.Backend.cpu) is None,
    "Query": lambda world: softcd.Query(world.scene) is None,
    "Probe": lambda world: softcd.Probe(world.scene) is None,
    "MeshChange": lambda world: softcd.MeshChange(0, np.array([0]), PIERCING_TRIANGLES, PIERCING_T0) is None,
    "add_body, remove_body": add_and_remove,
    "update_body": change,
    "update_body, changed": change_in_part,
    "set_settings": lambda world: world.scene.set_settings(world.body, margin=0.1, self_collision=True),
    "set_positions": lambda world: world.scene.set_positions(world.body, PIERCING_T0, PIERCING_T1),
    "set_vertex_filters": lambda world: world.scene.set_vertex_filters(world.body, np.zeros(6, np.uint32)),
    "set_rest_positions": lambda world: world.scene.set_rest_positions(world.body, PIERCING_T0),
    "set_pair_filter": lambda world: world.query.set_pair_filter(lambda a, b: False),
    "set_body_filter": lambda world: world.probe.set_body_filter(lambda body: False),
    "options": lambda world: setattr(world.query, "options", softcd.QueryOptions(cell_size_factor=2.0)),
    "detect": lambda world: world.query.detect().tobytes(),
    "start, wait": lambda world: world.query.start().wait().tobytes(),
    "BatchScene": detect_in_environments,
    "first_hits": lambda world: world.probe.first_hits(*RAY).tobytes(),
    "all_hits": lambda world: world.probe.all_hits(*RAY).all.tobytes(),
    "closest_points": lambda world: world.probe.closest_points(GOOD).tobytes(),
    "sphere_overlaps": lambda world: world.probe.sphere_overlaps(GOOD, 1).all.tobytes(),
    "capsule_overlaps": lambda world: world.probe.capsule_overlaps(GOOD, RAY[0], 1).all.tobytes(),
    "intersection_regions": lambda world: world.probe.intersection_regions().points.tobytes(),
    "box_overlaps": lambda world: world.probe.box_overlaps(GOOD, GOOD + 1).all.tobytes(),
    "oriented_box_overlaps": lambda world: world.probe.oriented_box_overlaps(GOOD, RAY[0], np.eye(3)).all.tobytes(),
    "hull_overlaps": lambda world: world.probe.hull_overlaps(GOOD, [0, 2, len(GOOD)], 1).all.tobytes(),
    "has_intersections": lambda world: world.probe.has_intersections(),
    "softcd.detect": lambda world: softcd.detect(PIERCING_T0, PIERCING_TRIANGLES, PIERCING_T1).tobytes(),
    "self_intersections": lambda world: softcd.self_intersections(PIERCING_T1, PIERCING_TRIANGLES).tobytes(),
}


def attempt(call, n, for_good):
    """Lets the n-th allocation of a call fail. Returns the call's result or "failed", its result when repeated after a
    failure, whether an allocation failed, and the results of the world afterwards."""
    world = World()
    world.bytes()
    allocations.fail_allocation(n, for_good)
    try:
        answer = call(world)
    except MemoryError:
        answer = "failed"
    finally:
        has_failed = allocations.allocation_has_failed() != 0
        allocations.fail_allocation(0, 0)
    try:
        afterwards = world.bytes()
    except softcd.InvalidInput as error:
        afterwards = str(error)
    if answer == "failed":
        again = call(world)
    else:
        again = answer
    return answer, again, has_failed, afterwards


def try_every_allocation(name, call, for_good):
    """Lets each allocation of a call fail in turn. Returns the number of failures."""
    before = attempt(lambda world: None, 0, False)[3]
    for _ in range(3):  # memory that a first call keeps is not a leak
        expected, _, _, after = attempt(call, 0, False)
    gc.collect()
    living = allocations.living_allocations()
    for n in range(1, 100000):
        answer, again, has_failed, afterwards = attempt(call, n, for_good)
        gc.collect()
        what = f"{name}, allocation {n}{' and all after it' if for_good else ''}"
        assert answer == expected or answer == "failed" and has_failed, what
        assert again == expected, f"{what}: the call in the next attempt"
        assert afterwards in (before, after), f"{what}: something has changed: {afterwards}"
        assert allocations.living_allocations() <= living, f"{what}: {allocations.living_allocations() - living} leaked"
        if not has_failed:
            return n - 1
    raise AssertionError(f"{name} does not end")


points = 0
for name, call in CALLS.items():
    for for_good in (False, True):
        count = try_every_allocation(name, call, for_good)
        points += count
        if not for_good:
            print(f"{name}: {count}", flush=True)
print(f"{points} failures in {len(CALLS)} calls")
