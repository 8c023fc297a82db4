"""Tests arrays on a GPU: positions that are read from it, contacts that stay on it."""

import gc
import pathlib
import re

import numpy as np
import pytest

import softcd
from meshes import sheet, soup, write_ply

ROOT = pathlib.Path(__file__).resolve().parents[2]

try:
    softcd.Scene(backend=softcd.Backend.cuda)
except softcd.BackendError as error:
    pytest.skip(f"no CUDA device: {error}", allow_module_level=True)

torch = pytest.importorskip("torch")


def torch_array(values):
    return torch.tensor(values, device="cuda")


def cupy_array(values):
    return pytest.importorskip("cupy").asarray(values)


def jax_array(values):
    jax = pytest.importorskip("jax")
    with jax.enable_x64(True):
        return jax.device_put(values, jax.devices("gpu")[0])


def numba_array(values):
    return pytest.importorskip("numba.cuda").to_device(values)


def step_of(seed, dtype):
    vertices, triangles = soup(seed, 400, 0.1)
    random = np.random.default_rng(seed)
    return vertices.astype(dtype), (vertices + 0.05 * random.normal(size=vertices.shape)).astype(dtype), triangles


def query_of(triangles, vertex_count, **options):
    scene = softcd.Scene(backend=softcd.Backend.cuda)
    body = scene.add_body(triangles, vertex_count, self_collision=True, edge_edge=True, margin=0.001)
    return scene, body, softcd.Query(scene, detection=softcd.Detection.ccd, **options)


@pytest.mark.parametrize("dtype", [np.float32, np.float64])
@pytest.mark.parametrize("on_gpu", [torch_array, cupy_array, jax_array, numba_array])
def test_contacts_are_those_of_the_cpu_s_arrays(on_gpu, dtype):
    t0, t1, triangles = step_of(1, dtype)
    scene, body, query = query_of(triangles, len(t0))
    scene.set_positions(body, t0, t1)
    expected = query.detect().tobytes()
    assert len(expected) > 0
    scene.set_positions(body, on_gpu(t0), on_gpu(t1))
    gc.collect()
    assert query.detect().tobytes() == expected
    assert query.statistics.backend == softcd.Backend.cuda


def test_rows_may_lie_apart():
    t0, t1, triangles = step_of(2, np.float32)
    scene, body, query = query_of(triangles, len(t0))
    scene.set_positions(body, t0, t1)
    expected = query.detect().tobytes()
    wide = [torch.zeros((len(t0), 4), device="cuda") for _ in range(2)]
    for rows, values in zip(wide, (t0, t1)):
        rows[:, :3] = torch_array(values)
    scene.set_positions(body, wide[0][:, :3], wide[1][:, :3])
    assert query.detect().tobytes() == expected


def test_arrays_stay_alive_until_they_are_replaced():
    t0, t1, triangles = step_of(3, np.float32)
    scene, body, query = query_of(triangles, len(t0))
    scene.set_positions(body, torch_array(t0), torch_array(t1))
    expected = query.detect().tobytes()
    gc.collect()
    filler = [torch.full((len(t0), 3), float("nan"), device="cuda") for _ in range(8)]
    second = softcd.Query(scene, detection=softcd.Detection.dcd)  # reads positions that the first one has not read
    second.detect()
    assert query.detect().tobytes() == expected
    before = torch.cuda.memory_allocated()
    for _ in range(4):
        scene.set_positions(body, torch_array(t0), torch_array(t1))
        query.detect()
    assert torch.cuda.memory_allocated() <= before + 2 * filler[0].nbytes


def test_contacts_stay_on_the_gpu():
    t0, t1, triangles = step_of(4, np.float32)
    scene, body, query = query_of(triangles, len(t0))
    scene.set_positions(body, t0, t1)
    expected = query.detect()
    on_device = softcd.Query(
        scene, detection=softcd.Detection.ccd, contacts_on_device=True
    )
    scene.set_positions(body, torch_array(t0), torch_array(t1))
    contacts = on_device.detect()
    assert isinstance(contacts, softcd.DeviceContacts)
    assert len(contacts) == len(expected) > 0
    assert "CUDA device 0" in repr(contacts)
    columns = {name: torch.from_dlpack(contacts[name]) for name in softcd.contact_dtype.names}
    for name, column in columns.items():
        assert column.device.type == "cuda"
        np.testing.assert_array_equal(column.cpu().numpy(), expected[name].view(column.cpu().numpy().dtype))
    first = columns["kind"].data_ptr()
    for name, (_, offset) in softcd.contact_dtype.fields.items():
        assert columns[name].data_ptr() == first + offset, "columns of one array, none of them copied"
    assert torch.from_dlpack(contacts["distance"]).data_ptr() == columns["distance"].data_ptr()
    cupy = pytest.importorskip("cupy")
    assert cupy.from_dlpack(contacts["distance"]).data.ptr == columns["distance"].data_ptr()
    # Detections use other memory while a column is alive.
    del contacts
    gc.collect()
    distances = columns["distance"].clone()
    scene.set_positions(body, torch_array(t0 + 100), torch_array(t1[::-1].copy()))
    on_device.detect()
    on_device.detect()
    assert torch.equal(distances, columns["distance"])


def test_contacts_of_each_body_are_a_range():
    """For many simulations in one scene: each body is in a separate batch, and contacts stay on the device."""
    scene = softcd.Scene(backend=softcd.Backend.cuda)
    bodies = []
    for batch in range(5):
        t0, t1, triangles = step_of(batch, np.float32)
        bodies.append(scene.add_body(triangles, len(t0), self_collision=True, edge_edge=True, margin=0.001, batch=batch))
        scene.set_positions(bodies[-1], torch_array(t0), torch_array(t1))
    query = softcd.Query(scene, detection=softcd.Detection.ccd, contacts_on_device=True)
    contacts = query.detect()
    begin = torch.from_dlpack(contacts.body_begin)
    assert begin.dtype == torch.int64 and begin.shape == (11,)
    counts = begin.diff().reshape(2, 5)
    kind = torch.from_dlpack(contacts["kind"]).long()
    body = torch.from_dlpack(contacts["body_a"]).long()
    expected = torch.zeros(10, dtype=torch.int64, device="cuda").index_add_(0, 5 * kind + body, torch.ones_like(kind))
    assert torch.equal(counts.flatten(), expected)
    assert (counts.sum(dim=0) > 0).all()
    times = torch.from_dlpack(contacts["time_of_impact"])
    earliest = torch.segment_reduce(times, "min", lengths=counts.flatten()).reshape(2, 5).amin(dim=0)
    assert (earliest < 1).all(), "a step size for each"


def test_contacts_of_environments_are_those_of_the_cpu():
    """A BatchScene on the GPU has the CPU's bytes. Contacts that stay there are numbered by body and environment."""
    environments, (_, _, triangles) = 5, step_of(0, np.float32)
    t0, t1 = (np.stack(ends) for ends in zip(*(step_of(i, np.float32)[:2] for i in range(environments))))
    found = []
    for backend, array in (("cpu", np.asarray), ("cuda", np.asarray), ("cuda", torch_array)):
        scene = softcd.BatchScene(environments, backend=backend)
        body = scene.add_body(triangles, t0.shape[1], margin=0.001)
        query = softcd.BatchQuery(scene, detection=softcd.Detection.ccd)
        for _ in range(3):  # the later ones use predicted positions
            scene.set_positions(body, array(t0), array(t1))
            found.append(query.detect())
        assert found[-1].all.tobytes() == found[0].all.tobytes() and found[-1].begins.tolist() == found[0].begins.tolist()
    assert min(map(len, found[0])) > 0
    query.options = query.options.replace(contacts_on_device=True)
    contacts = query.detect()
    environment = torch.from_dlpack(contacts["body_a"]).long() % environments
    assert torch.bincount(environment, minlength=environments).tolist() == np.diff(found[0].begins).tolist()
    order = torch.argsort(environment, stable=True)
    times = torch.from_dlpack(contacts["time_of_impact"])[order].cpu().numpy()
    assert times.tobytes() == found[0].all["time_of_impact"].tobytes()
    begin, end = torch.from_dlpack(contacts.environment_begin), torch.from_dlpack(contacts.environment_end)
    assert begin.shape == end.shape == (2, 1, environments)
    assert begin.data_ptr() == torch.from_dlpack(contacts.body_begin).data_ptr(), "not a copy"
    assert (end - begin).sum(dim=(0, 1)).tolist() == np.diff(found[0].begins).tolist()
    for k in range(environments):
        rows = torch.cat([torch.arange(b, e) for b, e in zip(begin[:, 0, k].tolist(), end[:, 0, k].tolist())])
        times = torch.from_dlpack(contacts["time_of_impact"])[rows.cuda()].cpu().numpy()
        assert times.tobytes() == np.ascontiguousarray(found[0][k]["time_of_impact"]).tobytes()
    ticket = query.start()
    pending = ticket.on_device()
    assert torch.equal(torch.from_dlpack(pending.environment_end), end)
    assert pending.capacity >= len(contacts) == len(ticket.wait())


@pytest.mark.parametrize("detection", ["dcd", "ccd"])
def test_contacts_of_an_environment_do_not_depend_on_their_number(detection):
    (_, _, triangles), ends = step_of(0, np.float32), [step_of(i, np.float32)[:2] for i in range(20)]
    expected = None
    for environments in (20, 1, 7):
        scene = softcd.BatchScene(environments, backend="cuda")
        body = scene.add_body(triangles, len(ends[0][0]), margin=0.001)
        scene.set_positions(body, *(torch_array(np.stack(each)) for each in zip(*ends[:environments])))
        found = [own.tobytes() for own in softcd.BatchQuery(scene, detection=detection).detect()]
        expected = expected or found
        assert found == expected[:environments] and min(map(len, found)) > 0


@pytest.mark.parametrize("package", ["torch", "cupy", "jax", "warp"])
def test_ranges_of_environments_are_read_in_place(package):
    """Each package reads the device's memory without a copy, and a column with the same memory."""
    pytest.importorskip(package)
    environments, (_, _, triangles) = 6, step_of(0, np.float32)
    ends = [step_of(i, np.float32)[:2] for i in range(environments)]
    scene = softcd.BatchScene(environments, backend="cuda")
    body = scene.add_body(triangles, len(ends[0][0]), margin=0.001)
    scene.set_positions(body, *(torch_array(np.stack(each)) for each in zip(*ends)))
    contacts = softcd.BatchQuery(scene, detection="ccd", contacts_on_device=True).detect()
    ranges = contacts.environment_begin, contacts.environment_end
    expected = [torch.from_dlpack(array) for array in ranges]
    if package == "torch":
        read = [(array.data_ptr(), array.cpu().numpy()) for array in expected]
    elif package == "cupy":
        import cupy

        read = [(array.data.ptr, array.get()) for array in map(cupy.from_dlpack, ranges)]
    elif package == "jax":
        import jax

        with jax.enable_x64(True):
            read = [(each.unsafe_buffer_pointer(), np.asarray(each)) for each in map(jax.dlpack.from_dlpack, ranges)]
    else:
        import warp

        read = [(array.ptr, array.numpy()) for array in map(warp.from_dlpack, ranges)]
    for (pointer, values), array in zip(read, expected):
        assert pointer == array.data_ptr()
        np.testing.assert_array_equal(values, array.cpu().numpy())
    assert (expected[1] - expected[0]).sum().item() == len(contacts) > 0


def test_contacts_are_told_of_before_anybody_waits():
    """A stream of torch's reads contacts as soon as they are there. The host waits later, to compare."""
    t0, t1, triangles = step_of(6, np.float32)
    scene, body, query = query_of(triangles, len(t0), contacts_on_device=True)
    scene.set_positions(body, torch_array(t0), torch_array(t1))
    query.detect()  # the lists have grown
    stream = torch.cuda.Stream()
    for step in range(4):
        moved = t1 + np.float32(1e-4 * step) * (t1.mean(axis=0) - t1)  # inwards: stays within the predicted box
        scene.set_positions(body, torch_array(t0), torch_array(moved))
        ticket = query.start()
        pending = ticket.on_device()
        assert "on CUDA device 0" in repr(pending) and pending.ready != 0
        with torch.cuda.stream(stream):
            times = torch.from_dlpack(pending["time_of_impact"])
            count = torch.from_dlpack(pending.count)
            begin = torch.from_dlpack(pending.body_begin).clone()
            is_there = torch.arange(pending.capacity, device="cuda") < count
            earliest = torch.where(is_there, times, 1).min()
            told = torch.from_dlpack(pending.is_complete).clone(), count.clone()
        contacts = ticket.wait()
        stream.synchronize()
        assert [one.tolist() for one in told] == [[1], [len(contacts)]]
        assert len(contacts) <= pending.capacity == len(times)
        assert begin.tolist() == torch.from_dlpack(contacts.body_begin).tolist()
        waited_for = torch.from_dlpack(contacts["time_of_impact"])
        assert waited_for.data_ptr() == times.data_ptr(), "not a copy"
        assert earliest == waited_for.min() < 1
        with pytest.raises(softcd.Error, match="waited for"):
            ticket.on_device()


def test_contacts_that_were_told_of_stay_as_they_are():
    t0, t1, triangles = step_of(7, np.float32)
    scene, body, query = query_of(triangles, len(t0), contacts_on_device=True)
    scene.set_positions(body, torch_array(t0), torch_array(t1))
    expected = torch.from_dlpack(query.detect()["distance"]).clone()
    scene.set_positions(body, torch_array(t0), torch_array(t1))
    distances = torch.from_dlpack(query.start().on_device()["distance"])
    gc.collect()
    for _ in range(3):
        scene.set_positions(body, torch_array(t0 + 100), torch_array(t1[::-1].copy()))
        query.detect()
    del scene, query
    gc.collect()
    assert torch.equal(distances[: len(expected)], expected)


def test_nothing_is_told_of_where_no_bodies_are_compared():
    query = softcd.Query(softcd.Scene(backend=softcd.Backend.cuda), contacts_on_device=True)
    pending = query.start().on_device()
    assert pending.capacity == 0 and pending.count.shape == pending.is_complete.shape == (0,)
    assert pending.environment_begin.shape == pending.environment_end.shape == (2, 0, 1)
    assert torch.from_dlpack(pending["vertices"]).shape == (0, 4)


def test_arrays_on_the_gpu_speak_cuda_s_array_interface():
    cupy = pytest.importorskip("cupy")
    t0, t1, triangles = step_of(8, np.float32)
    scene, body, query = query_of(triangles, len(t0), contacts_on_device=True)
    for step in range(2):
        scene.set_positions(body, torch_array(t0), torch_array(t1))
        ticket = query.start()
        pending = ticket.on_device()
        contacts = ticket.wait() if step == 0 else pending
        vertices, kind = cupy.asarray(contacts["vertices"]), cupy.asarray(contacts["kind"])
        interface = contacts["vertices"].__cuda_array_interface__
        assert interface["version"] == 3 and interface["stream"] == (None if step == 0 else 1)
        assert vertices.dtype == np.uint32 and vertices.data.ptr == interface["data"][0], "not a copy"
        assert kind.dtype == np.uint8 and vertices.strides == interface["strides"] == (72, 4)
        if step == 0:
            expected = vertices.copy()
    assert len(expected) > 0 and (vertices[: len(expected)] == expected).all()
    assert contacts["weights"].__dlpack_device__() == (2, 0)
    assert repr(contacts["distance"]).startswith("<softcd.DeviceArray of shape (")


def test_arguments_are_checked():
    t0, t1, triangles = step_of(5, np.float32)
    scene, body, query = query_of(triangles, len(t0))
    with pytest.raises(TypeError, match="vertices_t0.*int"):
        scene.set_positions(body, torch.zeros((len(t0), 3), dtype=torch.int32, device="cuda"))
    with pytest.raises(softcd.InvalidInput, match="side by side"):
        scene.set_positions(body, torch.zeros((3, len(t0)), device="cuda").T)
    with pytest.raises(softcd.InvalidInput, match="1 positions"):
        scene.set_positions(body, torch.zeros((1, 3), device="cuda"))
    with pytest.raises(softcd.InvalidInput, match="one end"):
        scene.set_positions(body, t0, torch_array(t0))
    with pytest.raises(KeyError, match="speed"):
        scene.set_positions(body, torch_array(t0), torch_array(t1))
        query.options = query.options.replace(contacts_on_device=True)
        query.detect()["speed"]
    with pytest.warns(RuntimeWarning, match="not finite"):
        scene.set_positions(body, torch_array(t0).fill_(float("nan")))
        assert len(query.detect()) == 0


def test_the_documented_example_runs(tmp_path, monkeypatch):
    text = (ROOT / "docs" / "use" / "python.md").read_text()
    (code,) = re.findall(r"^```python cuda\n(.*?)^```", text, re.MULTILINE | re.DOTALL)
    vertices, triangles = sheet(16)
    vertices[:, 2] = 0.05 * np.cos(np.arange(len(vertices)))
    vertices[:, 0] = np.abs(vertices[:, 0] - 7.5)  # folded, so that there are contacts
    monkeypatch.chdir(tmp_path)
    write_ply(tmp_path / "t0.ply", vertices, triangles)
    names = {}
    exec(compile(code, "example", "exec"), names)
    assert len(names["contacts"]) > 0
    assert names["velocity"].isfinite().all()


def test_a_simulation_on_the_gpu():
    """Detections wait for torch's work on the default stream without a request."""
    vertices, triangles = sheet(64)
    scene, body, query = query_of(
        triangles, len(vertices), contacts_on_device=True, accuracy=softcd.Accuracy.conservative
    )
    x = torch_array(vertices.astype(np.float32))
    rough = torch.linspace(0, 6, len(vertices), device="cuda").sin()
    for step in range(8):
        moved = x.clone()
        for _ in range(50):
            moved[:, 2] += 0.01 * rough
        moved[:, 0] *= 0.9
        scene.set_positions(body, x, moved)
        contacts = query.detect()
        expected = softcd.detect(
            x.cpu().numpy(), triangles, moved.cpu().numpy(), margin=0.001, backend=softcd.Backend.cpu
        )
        assert len(contacts) == len(expected), f"step {step}"
        x = moved
