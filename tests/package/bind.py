"""Calls softcd's shared library by ctypes, as an example of a language that can call C: bind.py LIBRARY."""

import ctypes
import sys
from ctypes import POINTER, byref, c_float, c_int32, c_uint8, c_uint16, c_uint32, c_uint64, c_void_p, sizeof


class Positions(ctypes.Structure):
    _fields_ = [("struct_size", c_uint32), ("scalar", c_uint32), ("memory", c_uint32), ("data", c_void_p),
                ("count", c_uint64), ("stride", c_uint64), ("ready", c_void_p)]


class Contact(ctypes.Structure):
    _fields_ = [("kind", c_uint8), ("is_unsettled", c_uint8), ("unused", c_uint16), ("body_a", c_uint32),
                ("body_b", c_uint32), ("feature_a", c_uint32), ("feature_b", c_uint32), ("vertices", c_uint32 * 4),
                ("weights", c_float * 4), ("normal", c_float * 3), ("distance", c_float), ("time_of_impact", c_float)]


PAIR_FILTER = ctypes.CFUNCTYPE(c_uint32, c_void_p, c_uint32, c_uint32)

softcd = ctypes.CDLL(sys.argv[1])
softcd.softcd_last_error.restype = ctypes.c_char_p
SIGNATURES = {
    "scene_create": [c_void_p, POINTER(c_void_p)],
    "query_create": [c_void_p, c_void_p, POINTER(c_void_p)],
    "scene_add_body": [c_void_p, c_void_p, c_uint64, c_uint32, c_void_p, POINTER(c_uint32)],
    "scene_set_positions": [c_void_p, c_uint32, POINTER(Positions), POINTER(Positions)],
    "scene_remove_body": [c_void_p, c_uint32],
    "query_set_pair_filter": [c_void_p, PAIR_FILTER, c_void_p],
    "query_detect": [c_void_p, c_uint32, POINTER(POINTER(Contact)), POINTER(c_uint64)],
}


def call(name, *arguments):
    function = getattr(softcd, "softcd_" + name)
    function.argtypes, function.restype = SIGNATURES[name], c_int32
    if function(*arguments) != 0:
        raise RuntimeError(softcd.softcd_last_error().decode())


scene, query, contacts, count = c_void_p(), c_void_p(), POINTER(Contact)(), c_uint64()
call("scene_create", None, byref(scene))
call("query_create", scene, None, byref(query))
bodies, kept = [], []
for coordinates in ([0, 0, 0, 1, 0, 0, 0, 1, 0], [0.25, 0.25, 0, 0.25, 0.5, 5, 0.5, 0.25, 5]):
    x, body = (ctypes.c_double * 9)(*coordinates), c_uint32()
    kept.append(x)
    call("scene_add_body", scene, (c_uint32 * 3)(0, 1, 2), 1, 3, None, byref(body))
    call("scene_set_positions", scene, body, None, Positions(sizeof(Positions), 1, 0, ctypes.addressof(x), 3, 24, None))
    bodies.append(body.value)
asked = []
pair_filter = PAIR_FILTER(lambda data, a, b: asked.append((a, b)) or 1)  # must live as long as it is called
call("query_set_pair_filter", query, pair_filter, None)
call("query_detect", query, 0, byref(contacts), byref(count))
assert sizeof(Contact) == 72 and tuple(bodies) in asked
assert count.value == 1 and (contacts[0].body_a, contacts[0].body_b) == (bodies[1], bodies[0])
assert list(contacts[0].vertices) == [0, 0, 1, 2] and list(contacts[0].weights) == [1, 0.5, 0.25, 0.25]
try:
    call("scene_remove_body", scene, 99)
except RuntimeError as error:
    assert "body 99" in str(error)
else:
    raise AssertionError("a body that is not there was removed")
