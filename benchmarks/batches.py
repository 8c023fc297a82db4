#!/usr/bin/env python3
"""Measures softcd.BatchScene: contacts per second for many folded cloths of 1,000 triangles at once.

    python benchmarks/batches.py --backend cpu --environments 1 16 256
    python benchmarks/batches.py --backend cuda --tensors torch --on-device

Each environment is a cloth whose folds move through each other within the step. All are different. The time is that of
set_positions and detect, the median of several steps. --tensors torch keeps positions on the GPU; with --on-device
contacts stay there, too.
"""

import argparse
import statistics
import time

import numpy as np

import softcd

COLUMNS, ROWS = 25, 20  # 1,000 triangles


def cloth():
    """Returns positions at both ends of a step, and the triangles."""
    u, v = (axis.ravel() for axis in np.meshgrid(np.arange(COLUMNS + 1.0), np.arange(ROWS + 1.0), indexing="ij"))
    corner = np.arange(len(u)).reshape(COLUMNS + 1, ROWS + 1)
    a, b, c, d = (corner[i : COLUMNS + i, j : ROWS + j].ravel() for i in (0, 1) for j in (0, 1))
    triangles = np.concatenate([np.stack([a, c, b], axis=1), np.stack([b, c, d], axis=1)]).astype(np.uint32)
    # Two layers, which are joined at one side. The upper one falls through the lower one's middle.
    x = np.stack([np.abs(u - COLUMNS / 2), v, np.where(u < COLUMNS / 2, 0.0, 0.8)], axis=1)
    fall = np.where(u < COLUMNS / 2, 0.0, -1.2 * np.exp(-(((v - ROWS / 2) / 3) ** 2)))
    return x, x + fall[:, None] * [0, 0, 1], triangles


def steps_of(environments, count):
    """Yields both ends of `count` steps of all environments: float32 of shape (environments, vertices, 3)."""
    random = np.random.default_rng(0)
    t0, t1, _ = cloth()
    for _ in range(count):
        noise = 0.05 * random.standard_normal((environments, len(t0), 3), np.float32)
        yield (t0 + noise).astype(np.float32), (t1 + noise).astype(np.float32)


def measure(environments, arguments):
    _, _, triangles = cloth()
    scene = softcd.BatchScene(environments, backend=arguments.backend, max_threads=arguments.threads)
    begin = time.perf_counter()
    body = scene.add_body(triangles, (COLUMNS + 1) * (ROWS + 1), margin=0.001)
    added = time.perf_counter() - begin
    query = softcd.BatchQuery(scene, detection=arguments.detection, contacts_on_device=arguments.on_device)
    seconds, counts = [], []
    for t0, t1 in steps_of(environments, arguments.steps + 2):
        if arguments.tensors == "torch":
            import torch

            t0, t1 = (torch.from_numpy(end).to("cuda") for end in (t0, t1))
            torch.cuda.synchronize()
        begin = time.perf_counter()
        scene.set_positions(body, t0, t1)
        contacts = query.detect()
        seconds.append(time.perf_counter() - begin)
        counts.append(len(contacts if arguments.on_device else contacts.all))
        del contacts
    median, count = statistics.median(seconds[2:]), statistics.mean(counts[2:])  # the first two fill lists
    print(
        f"{environments:>12} {environments * len(triangles):>10} {count:>10.0f} {1e3 * added:>9.1f} {1e3 * median:>9.2f}"
        f" {count / median:>12.3g} {environments / median:>14.3g}",
        flush=True,
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--environments", type=int, nargs="+", default=[4**i for i in range(7)])
    parser.add_argument("--backend", default="cpu", choices=["cpu", "cuda", "automatic"])
    parser.add_argument("--detection", default="ccd", choices=["dcd", "ccd"])
    parser.add_argument("--steps", type=int, default=7, help="the number of steps that are measured")
    parser.add_argument("--threads", type=int, default=0, help="the most threads on the CPU; 0 for all")
    parser.add_argument("--tensors", default="numpy", choices=["numpy", "torch"], help="torch: positions on the GPU")
    parser.add_argument("--on-device", action="store_true", help="contacts stay on the GPU; needs --backend cuda")
    arguments = parser.parse_args()
    print(f"softcd {softcd.__version__}, {arguments.backend}, {arguments.detection}, medians of {arguments.steps} steps")
    print("environments  triangles   contacts    add ms        ms   contacts/s environments/s")
    for environments in arguments.environments:
        measure(environments, arguments)


if __name__ == "__main__":
    main()
