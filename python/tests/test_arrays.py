import ctypes
import gc
import weakref

import numpy as np
import pytest

import softcd
from meshes import PIERCING_T0, PIERCING_T1, PIERCING_TRIANGLES, soup


class OnlyDlpack:
    """An array of another library, which offers only DLPack's methods."""

    def __init__(self, array, device=(1, 0)):
        self.array = array
        self.device = device

    def __dlpack__(self, **arguments):
        return self.array.__dlpack__(**arguments)

    def __dlpack_device__(self):
        return self.device


class OnGpu:
    """A tensor in DLPack's structures that claims to be on a CUDA device."""

    class Tensor(ctypes.Structure):
        _fields_ = [
            ("data", ctypes.c_void_p),
            ("device_type", ctypes.c_int32),
            ("device_id", ctypes.c_int32),
            ("ndim", ctypes.c_int32),
            ("code", ctypes.c_uint8),
            ("bits", ctypes.c_uint8),
            ("lanes", ctypes.c_uint16),
            ("shape", ctypes.POINTER(ctypes.c_int64)),
            ("strides", ctypes.POINTER(ctypes.c_int64)),
            ("byte_offset", ctypes.c_uint64),
            ("manager", ctypes.c_void_p),
            ("deleter", ctypes.c_void_p),
        ]

    def __init__(self, rows):
        self.shape_memory = (ctypes.c_int64 * 2)(rows, 3)
        self.tensor = self.Tensor(data=0x1000, device_type=2, device_id=1, ndim=2, code=2, bits=32, lanes=1)
        self.tensor.shape = self.shape_memory

    def __dlpack__(self, **arguments):
        new_capsule = ctypes.pythonapi.PyCapsule_New
        new_capsule.restype = ctypes.py_object
        new_capsule.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_void_p]
        return new_capsule(ctypes.addressof(self.tensor), b"dltensor", None)

    def __dlpack_device__(self):
        return 2, 1


class OnlyCudaInterface:
    """An array that offers only CUDA's array interface, as numba's arrays do."""

    def __init__(self, typestr, shape, strides=None):
        self.__cuda_array_interface__ = {
            "shape": shape,
            "strides": strides,
            "typestr": typestr,
            "data": (0x1000, False),
            "version": 3,
        }


def scene_of(triangles, vertex_count, **settings):
    scene = softcd.Scene()
    return scene, scene.add_body(triangles, vertex_count, self_collision=True, edge_edge=True, **settings)


def contacts_of(vertices_t0, triangles, vertices_t1=None):
    scene, body = scene_of(triangles, len(PIERCING_T0))
    scene.set_positions(body, vertices_t0, vertices_t0 if vertices_t1 is None else vertices_t1)
    return softcd.Query(scene, detection=softcd.Detection.ccd).detect()


def in_rows_of(array, width):
    rows = np.full((len(array), width), np.nan, array.dtype)
    rows[:, :3] = array
    return rows[:, :3]


def every_second_row(array):
    rows = np.full((2 * len(array), 3), np.nan, array.dtype)
    rows[::2] = array
    return rows[::2]


LAYOUTS = {
    "contiguous": lambda x: x,
    "rows of four": lambda x: in_rows_of(x, 4),
    "rows of eleven": lambda x: in_rows_of(x, 11),
    "every second row": every_second_row,
    "a field of records": lambda x: np.rec.fromarrays([x, x[:, 0]], dtype=[("x", x.dtype, 3), ("mass", x.dtype)])["x"],
    "read-only": lambda x: np.frombuffer(x.tobytes(), x.dtype).reshape(-1, 3),
    "a memoryview": memoryview,
    "DLPack": OnlyDlpack,
    # These arrays are copied.
    "lists": lambda x: x.astype(np.float64).tolist(),
    "other endianness": lambda x: x.astype(x.dtype.newbyteorder()),
    "Fortran's order": np.asfortranarray,
    "backwards": lambda x: x[::-1].copy()[::-1],
    "columns backwards": lambda x: x[:, ::-1].copy()[:, ::-1],
    "not aligned": lambda x: np.frombuffer(b"\0" + x.tobytes(), np.uint8)[1:].view(x.dtype).reshape(-1, 3),
}


@pytest.mark.parametrize("layout", LAYOUTS)
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_every_layout_of_positions_gives_the_same_contacts(dtype, layout):
    vertices_t0, vertices_t1 = PIERCING_T0.astype(dtype), PIERCING_T1.astype(dtype)
    expected = contacts_of(vertices_t0, PIERCING_TRIANGLES, vertices_t1)
    assert len(expected) == 1
    laid_out = LAYOUTS[layout]
    assert np.array_equal(contacts_of(laid_out(vertices_t0), PIERCING_TRIANGLES, laid_out(vertices_t1)), expected)


@pytest.mark.parametrize("dtype", ["u2", "i2", "u4", "i4", "u8", "i8"])
def test_every_type_of_integers_makes_triangles(dtype):
    expected = contacts_of(PIERCING_T0, PIERCING_TRIANGLES, PIERCING_T1)
    for triangles in (
        PIERCING_TRIANGLES.astype(dtype),
        np.asfortranarray(PIERCING_TRIANGLES.astype(dtype)),
        OnlyDlpack(PIERCING_TRIANGLES.astype(dtype)),
        PIERCING_TRIANGLES.astype(dtype).tolist(),
    ):
        assert np.array_equal(contacts_of(PIERCING_T0, triangles, PIERCING_T1), expected)


def test_other_numbers_are_positions():
    touching = np.array([[0, 0, 0], [4, 0, 0], [0, 4, 0], [1, 1, 0], [1, 2, 1], [2, 1, 1]])
    expected = contacts_of(touching.astype(np.float64), PIERCING_TRIANGLES)
    assert len(expected) > 0
    for dtype in (int, np.uint8, np.int16, np.float16):
        assert np.array_equal(contacts_of(touching.astype(dtype), PIERCING_TRIANGLES), expected)


def test_what_is_copied_is_read_at_once():
    scene, body = scene_of(PIERCING_TRIANGLES, 6)
    vertices_t1 = np.asfortranarray(PIERCING_T1)
    scene.set_positions(body, np.asfortranarray(PIERCING_T0), vertices_t1)
    vertices_t1[:] = PIERCING_T0
    assert len(softcd.Query(scene, detection=softcd.Detection.ccd).detect()) == 1


def test_positions_are_read_when_a_detection_starts():
    scene, body = scene_of(PIERCING_TRIANGLES, 6)
    vertices_t0, vertices_t1 = PIERCING_T0.copy(), PIERCING_T0.copy()
    scene.set_positions(body, vertices_t0, vertices_t1)
    vertices_t1[:] = PIERCING_T1
    query = softcd.Query(scene, detection=softcd.Detection.ccd)
    ticket = query.start()
    vertices_t1[:] = PIERCING_T0  # too late to have an effect
    assert len(ticket.wait()) == 1
    assert len(query.detect()) == 1


def test_arrays_live_until_they_are_read_and_no_longer():
    scene, body = scene_of(PIERCING_TRIANGLES, 6)
    query = softcd.Query(scene, detection=softcd.Detection.ccd)
    arrays = [PIERCING_T0.copy(), PIERCING_T1.copy()]
    watched = [weakref.ref(array) for array in arrays]
    scene.set_positions(body, *arrays)
    del arrays
    gc.collect()
    assert all(array() is not None for array in watched)
    assert len(query.detect()) == 1
    assert all(array() is None for array in watched)


def test_arrays_that_were_replaced_or_refused_are_let_go():
    scene, body = scene_of(PIERCING_TRIANGLES, 6)
    first, refused = PIERCING_T0.copy(), PIERCING_T0[:5].copy()
    watched = [weakref.ref(first), weakref.ref(refused)]
    scene.set_positions(body, first)
    with pytest.raises(softcd.InvalidInput):
        scene.set_positions(body, refused)
    del refused
    assert watched[0]() is not None and watched[1]() is None
    scene.set_positions(body, PIERCING_T1)
    del first
    assert watched[0]() is None


def test_contacts_outlive_detections_query_and_scene():
    vertices, triangles = soup(3)
    scene, body = scene_of(triangles, len(vertices), margin=0.05)
    query = softcd.Query(scene)
    scene.set_positions(body, vertices)
    contacts = query.detect()
    expected = contacts.copy()
    assert len(expected) > 10
    for step in range(4):
        scene.set_positions(body, vertices * (1 + 0.1 * step))
        assert not np.shares_memory(query.detect(), contacts)
    normals = contacts["normal"]
    scene.set_positions(body, vertices, vertices)
    query.options = softcd.QueryOptions(detection=softcd.Detection.ccd)
    query.detect()
    del scene, query
    gc.collect()
    assert np.array_equal(contacts, expected)
    del contacts
    gc.collect()
    assert np.array_equal(normals, expected["normal"])


def test_a_loop_takes_turns_with_two_memories():
    vertices, triangles = soup(3)
    scene, body = scene_of(triangles, len(vertices), margin=0.05)
    scene.set_positions(body, vertices)
    query = softcd.Query(scene)
    places = set()
    for _ in range(8):
        contacts = query.detect()
        places.add(contacts.ctypes.data)
    assert len(places) == 2


def test_gpu_arrays_are_refused_where_there_is_no_gpu():
    scene = softcd.Scene(backend=softcd.Backend.cpu)
    body = scene.add_body(PIERCING_TRIANGLES, 6)
    with pytest.raises(softcd.InvalidInput, match="one end in the host's memory"):
        scene.set_positions(body, PIERCING_T0.astype(np.float32), OnGpu(6))
    with pytest.raises(softcd.BackendError, match="CUDA device's memory"):
        scene.set_positions(body, OnGpu(6))
    with pytest.raises(softcd.BackendError, match="CUDA device's memory"):
        scene.set_positions(body, OnlyCudaInterface("<f4", (6, 3)))
    with pytest.raises(TypeError, match="triangles: .*CPU.*device 1"):
        scene.add_body(OnGpu(2), 6)
    with pytest.raises(softcd.BackendError, match="contacts_on_device"):
        softcd.Query(scene, contacts_on_device=True).detect()


@pytest.mark.parametrize(
    ("typestr", "shape", "strides", "error", "message"),
    [
        ("<i4", (6, 3), None, TypeError, "vertices_t0: .*OnlyCudaInterface"),
        ("<f4", (6, 2), None, softcd.InvalidInput, r"vertices_t0: .*\(6, 2\)"),
        ("<f4", (6, 3), (12,), TypeError, "vertices_t0"),
        ("<f4", (6, 3), (13, 4), TypeError, "vertices_t0"),
        ("<f4", (6, 3), (4, 24), softcd.InvalidInput, "vertices_t0: .*side by side"),
        ("<f8", (6, 3), (-24, 8), softcd.InvalidInput, "vertices_t0: rows"),
    ],
)
def test_cuda_interfaces_are_checked(typestr, shape, strides, error, message):
    scene, body = scene_of(PIERCING_TRIANGLES, 6)
    with pytest.raises(error, match=message):
        scene.set_positions(body, OnlyCudaInterface(typestr, shape, strides))


def test_an_array_that_does_not_export_says_why():
    class Refusing:
        def __dlpack__(self, **arguments):
            raise BufferError("requires grad")

    scene, body = scene_of(PIERCING_TRIANGLES, 6)
    with pytest.raises(TypeError, match="vertices_t0: .*Refusing.*requires grad"):
        scene.set_positions(body, Refusing())
