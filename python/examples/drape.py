"""Drapes a cloth over a sphere: minimizes weight, stretching and IPC's barrier, with steps that cross nothing."""

import numpy as np
import softcd.torch
import torch

ITERATIONS, SIDE, RADIUS = 150, 17, 0.4
NEAR = 0.02  # the distance from which the barrier pushes
torch.set_default_dtype(torch.float64)
torch.set_num_threads(1)  # all is small

corner = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
a, b, c, d = (corner[i : SIDE - 1 + i, j : SIDE - 1 + j].ravel() for i in (0, 1) for j in (0, 1))
cloth = np.concatenate([np.stack([a, c, b], axis=1), np.stack([b, c, d], axis=1)])
u, v = (axis.ravel() for axis in np.meshgrid(*[np.linspace(-1, 1, SIDE)] * 2, indexing="ij"))
x = torch.tensor(np.stack([0.6 * u, 0.55 * v, np.full_like(u, RADIUS + 2 * NEAR)], axis=1))

# A sphere: the six faces of a cube, each a grid, whose points are moved to one distance from the centre.
faces = [np.roll(np.stack([s * u, v, np.full_like(u, s)], axis=1), axis, axis=1) for axis in range(3) for s in (1, -1)]
points, place = np.unique(np.round(np.concatenate(faces), 9), axis=0, return_inverse=True)
sphere = RADIUS * points / np.linalg.norm(points, axis=1, keepdims=True)
triangles = [cloth, place.ravel()[np.concatenate([cloth + i * SIDE * SIDE for i in range(6)])]]

edges = np.unique(np.sort(cloth[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)), axis=0)
difference = torch.eye(len(x))[edges[:, 0]] - torch.eye(len(x))[edges[:, 1]]  # of the ends of each edge
rest = (difference @ x).norm(dim=1)
metric = torch.linalg.cholesky(difference.T @ difference + 0.1 * torch.eye(len(x)))


def distances(x):
    contacts = softcd.detect([x.detach().numpy(), sphere], triangles, margin=NEAR / 2)
    of_cloth = (contacts["body_a"] == 0) | (contacts["body_b"] == 0)
    return softcd.torch.distances([x, torch.tensor(sphere)], contacts[of_cloth])


def energy(x):
    found = distances(x)
    near = found.distance.clamp(max=NEAR) / NEAR
    barrier = -((near - 1) ** 2) * torch.log(near) * found.mollifier
    stretch = (difference @ x).norm(dim=1) - rest
    return 0.5 * (stretch**2).sum() + 1e-3 * x[:, 2].sum() + 1e-4 * barrier.sum()


# Nonlinear conjugate gradients (Polak, Ribiere), in the metric of the edges.
direction, old_gradient, old_descent = torch.zeros_like(x), torch.zeros_like(x), torch.ones_like(x)
for _ in range(ITERATIONS):
    (gradient,) = torch.autograd.grad(value := energy(x.requires_grad_()), x)
    x, descent = x.detach(), torch.cholesky_solve(gradient, metric)
    share = (descent * (gradient - old_gradient)).sum() / (old_descent * old_gradient).sum()
    direction = share.nan_to_num(0, 0, 0).clamp(min=0) * direction - descent
    if (direction * gradient).sum() >= 0:
        direction = -descent
    step = 0.9 * softcd.collision_free_step([x.numpy(), sphere], triangles, [(x + direction).numpy(), sphere])
    while energy(x + step * direction) > value + 1e-4 * step * (gradient * direction).sum():
        step /= 2
    x, old_gradient, old_descent = x + step * direction, gradient, descent
both = np.concatenate([x.numpy(), sphere]), np.concatenate([cloth, triangles[1] + len(x)])
print(f"{ITERATIONS} iterations, energy {energy(x):.4f}, {len(softcd.self_intersections(*both))} crossings,", end=" ")
print(f"smallest gap {distances(x).distance.min():.4f}, lowest point {x[:, 2].min():.3f}")
