#!/usr/bin/env python3
"""Measures softcd.BatchScene beside NVIDIA Warp's mesh queries, and Newton's detector: pip install warp-lang newton.

    python benchmarks/batches_beside_warp.py --environments 1 16 256
    python benchmarks/batches_beside_warp.py --device cuda:0

All find the pairs of a vertex and a triangle of one cloth that are at most 0.02 apart, without those that share a
vertex: discrete, in float32, for folded cloths of 1,000 triangles, one in each environment. With Warp, one mesh has all
environments, as groups of faces. Each step refits its tree, and a kernel tests the faces in a box around each vertex.
Newton's is the detector of its VBD solver (1.8.0, no public part of it), with a world for each environment. softcd's
contacts also have normals, weights, distances and an order; the others' are pairs of numbers, at most 32 of a vertex.
Numbers of pairs are compared. Positions are on the device before a step, and results stay there. Warp's kernels use one
thread on the CPU, and so does softcd here; --threads 0 is for all processors.
"""

import argparse
import importlib.util
import pathlib
import sys
import time

import numpy as np
import warp as wp

import batches
import softcd

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "python/examples"))
from audit_warp import to_triangle  # noqa: E402

REACH = 0.02
MOST_FACES = 32  # of a vertex


@wp.kernel
def near_faces(
    mesh: wp.uint64, vertices: int, reach: float, counts: wp.array[wp.int32], found: wp.array2d[wp.int32]
):
    vertex = wp.tid()
    m = wp.mesh_get(mesh)
    p = m.points[vertex]
    root = wp.mesh_get_group_root(mesh, vertex / vertices)
    query = wp.bvh_query_aabb(wp.mesh_get_bvh(mesh), p - wp.vec3(reach), p + wp.vec3(reach), root)
    face = int(0)
    count = int(0)
    while wp.bvh_query_next(query, face):
        i, j, k = m.indices[3 * face], m.indices[3 * face + 1], m.indices[3 * face + 2]
        if vertex != i and vertex != j and vertex != k:
            if to_triangle(p, m.points[i], m.points[j], m.points[k]) <= reach:
                if count < found.shape[1]:
                    found[vertex, count] = face
                count += 1
    counts[vertex] = count


class Warp:
    """A mesh of all environments, and the kernel above."""

    def __init__(self, environments, x, triangles, device):
        first = len(x) * np.arange(environments)[:, None, None]
        self.points = wp.array(np.tile(x, (environments, 1)), dtype=wp.vec3, device=device)
        indices = wp.array((triangles[None].astype(np.int64) + first).ravel(), dtype=wp.int32, device=device)
        groups = wp.array(np.repeat(np.arange(environments), len(triangles)), dtype=wp.int32, device=device)
        self.mesh = wp.Mesh(self.points, indices, groups=groups)
        self.vertices = len(x)
        self.counts = wp.zeros(len(self.points), dtype=wp.int32, device=device)
        self.found = wp.zeros((len(self.points), MOST_FACES), dtype=wp.int32, device=device)
        self.device = device

    def detect(self, x):
        wp.copy(self.points, x)
        self.mesh.refit()
        arguments = [self.mesh.id, self.vertices, REACH, self.counts, self.found]
        wp.launch(near_faces, len(self.points), arguments, device=self.device)
        wp.synchronize_device(self.device)
        return self.counts


class Newton:
    """Newton's detector, with a world for each environment."""

    def __init__(self, environments, x, triangles, device):
        import newton
        from newton._src.geometry.tri_mesh_collision import TriMeshCollisionDetector

        world, builder = newton.ModelBuilder(), newton.ModelBuilder()
        world.add_cloth_mesh(
            pos=wp.vec3(), rot=wp.quat_identity(), scale=1.0, vel=wp.vec3(), vertices=[wp.vec3(*each) for each in x],
            indices=triangles.ravel().tolist(), density=1.0, tri_ke=0.0, tri_ka=0.0, tri_kd=0.0)  # fmt: skip
        for _ in range(environments):
            builder.add_world(world)
        self.model = builder.finalize(device=device)
        self.detector = TriMeshCollisionDetector(
            self.model, init_collision_info=True, vertex_collision_buffer_pre_alloc=MOST_FACES
        )
        self.device = device

    def detect(self, x):
        wp.copy(self.model.particle_q, x)
        self.detector.refit_triangles()
        self.detector.vertex_triangle_collision_detection(REACH)
        wp.synchronize_device(self.device)
        return self.detector.vertex_colliding_triangles_count


class Softcd:
    def __init__(self, environments, x, triangles, arguments):
        self.shape = environments, len(x), 3
        on_device = arguments.device != "cpu"
        backend = "cuda" if on_device else "cpu"
        self.scene = softcd.BatchScene(environments, backend=backend, max_threads=arguments.threads)
        self.body = self.scene.add_body(triangles, len(x), margin=REACH / 2, edge_edge=False)
        self.query = softcd.BatchQuery(
            self.scene, detection="dcd", accuracy=arguments.accuracy, contacts_on_device=on_device
        )

    def detect(self, x):
        self.scene.set_positions(self.body, x.view(wp.float32).reshape(self.shape))
        return self.query.detect()


def counts_of(found):
    """Returns numbers of pairs: Warp's and Newton's of each vertex, softcd's of all environments."""
    if isinstance(found, wp.array):
        counts = found.numpy()
        assert counts.max() <= MOST_FACES, "a list is too short"
        return counts
    return len(found if isinstance(found, softcd.DeviceContacts) else found.all)


def measure(environments, arguments):
    x, _, triangles = batches.cloth()
    x = x.astype(np.float32)
    engines = [Softcd(environments, x, triangles, arguments)]
    engines += [engine(environments, x, triangles, arguments.device) for engine in arguments.engines]
    seconds, pairs = [], []
    for _, ends in batches.steps_of(environments, arguments.steps + 2):
        ends = wp.array(ends.reshape(-1, 3), dtype=wp.vec3, device=arguments.device)
        wp.synchronize_device(arguments.device)
        times, counts = [], []
        for engine in engines:
            begin = time.perf_counter()
            found = engine.detect(ends)
            times.append(time.perf_counter() - begin)
            counts.append(int(np.sum(counts_of(found))))
            del found
        seconds.append(times)
        pairs.append(counts)
    medians = np.median(seconds[2:], axis=0)  # the first two fill lists
    least = np.min(seconds[2:], axis=0)
    difference = np.abs(np.array(pairs) - np.array(pairs)[:, :1]).max()
    row = f"{environments:>12} {np.mean(pairs[2:], axis=0)[0]:>8.0f}" + "".join(f" {1e3 * each:>10.2f}" for each in medians)
    row += "".join(f" {each / medians[0]:>5.2f} ({low / least[0]:.2f})" for each, low in zip(medians[1:], least[1:]))
    print(f"{row} {difference:>10}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--environments", type=int, nargs="+", default=[4**i for i in range(7)])
    parser.add_argument("--steps", type=int, default=7, help="the number of steps that are measured")
    parser.add_argument("--threads", type=int, default=1, help="the most threads of softcd on the CPU; 0 for all")
    parser.add_argument("--accuracy", default="fast", choices=["fast", "precise", "conservative"])
    parser.add_argument("--device", default="cpu", help="Warp's name of the device, for example cuda:0")
    arguments = parser.parse_args()
    wp.config.quiet = True
    arguments.engines = [Warp] + ([Newton] if importlib.util.find_spec("newton") else [])
    names = [engine.__name__ for engine in arguments.engines]
    print(f"softcd {softcd.__version__}, {arguments.accuracy}, Warp {wp.__version__}, on {arguments.device}")
    print("environments    pairs" + "".join(f" {name + ' ms':>10}" for name in ["softcd", *names]), end="")
    print("".join(f" {name + ' / softcd':>12}" for name in names) + " differences, at most")
    for environments in arguments.environments:
        measure(environments, arguments)


if __name__ == "__main__":
    main()
