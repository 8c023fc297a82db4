"""Prints a digest of contacts that are found beside another package: its name, and which of the two comes first, are arguments."""

import hashlib
import sys

import numpy as np

from meshes import sheet


def detect():
    import softcd

    vertices, triangles = sheet(60)
    wave = np.sin(np.arange(len(vertices), dtype=np.float32))
    found = softcd.detect(vertices, triangles, vertices + np.stack([wave, wave, 3 * wave], axis=1), margin=0.5)
    assert len(found) > 0
    return hashlib.sha256(found.tobytes()).hexdigest()


def use_torch():
    import torch

    assert torch.ones(500, 500).matmul(torch.ones(500, 500)).sum() > 0


def use_scipy():
    import scipy.linalg

    assert scipy.linalg.det(np.eye(300)) == 1


def use_numba():
    import numba

    @numba.njit(parallel=True)  # by another oneTBB, where there is one
    def total(numbers):
        found = 0.0
        for i in numba.prange(len(numbers)):
            found += numbers[i]
        return found

    assert total(np.ones(100_000)) == 100_000


def use_open3d():
    import open3d

    ball = open3d.t.geometry.TriangleMesh.from_legacy(open3d.geometry.TriangleMesh.create_sphere())
    scene = open3d.t.geometry.RaycastingScene()  # Embree's, with another oneTBB
    scene.add_triangles(ball)
    assert np.isfinite(scene.cast_rays(open3d.core.Tensor([[0, 0, 9, 0, 0, -1]], open3d.core.float32))["t_hit"].numpy()).all()


if __name__ == "__main__":
    use = globals()["use_" + sys.argv[1]]
    if sys.argv[2] == "first":
        use()
    digest = detect()
    use()
    assert detect() == digest
    print(digest)
