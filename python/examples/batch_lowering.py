"""Lowers many cloths onto spheres of different heights at once, each by steps that its own collisions bound."""

import numpy as np

import softcd

ENVIRONMENTS, STEPS, SIDE, RADIUS, MARGIN = 64, 40, 17, 0.4, 0.002

corner = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
a, b, c, d = (corner[i : SIDE - 1 + i, j : SIDE - 1 + j].ravel() for i in (0, 1) for j in (0, 1))
cloth = np.concatenate([np.stack([a, c, b], axis=1), np.stack([b, c, d], axis=1)])
u, v = (axis.ravel() for axis in np.meshgrid(*[np.linspace(-1, 1, SIDE)] * 2, indexing="ij"))

# A dome over a grid: the upper half of a sphere.
away = np.hypot(u, v).clip(1e-9)
flat = np.stack([u, v], axis=1) * (np.maximum(np.abs(u), np.abs(v)) / away)[:, None]
dome = RADIUS * np.column_stack([flat, np.sqrt(np.maximum(0, 1 - (flat**2).sum(axis=1)))])

random = np.random.default_rng(0)
heights = random.uniform(0, 0.3, ENVIRONMENTS)
spheres = np.repeat(dome[None], ENVIRONMENTS, axis=0)
spheres[:, :, 2] += heights[:, None]
x = np.repeat(np.column_stack([0.6 * u, 0.6 * v, np.full_like(u, 0.8)])[None], ENVIRONMENTS, axis=0)
x[:, :, :2] += random.uniform(-0.1, 0.1, (ENVIRONMENTS, 1, 2))

scene = softcd.BatchScene(ENVIRONMENTS)
soft = scene.add_body(cloth, SIDE * SIDE, margin=MARGIN)
rigid = scene.add_body(cloth, SIDE * SIDE, margin=MARGIN, kinematic=True)
query = softcd.BatchQuery(scene, detection="ccd")
scene.set_positions(rigid, spheres)
free = np.ones((ENVIRONMENTS, SIDE * SIDE))  # how freely each vertex falls
touching = 0
for _ in range(STEPS):
    fall = np.zeros_like(x)
    fall[:, :, 2] = -0.05 * free
    scene.set_positions(soft, x, x + fall)
    contacts = query.detect()
    touching = len(contacts.all)
    environment = np.repeat(np.arange(ENVIRONMENTS), np.diff(contacts.begins))
    step = np.ones(ENVIRONMENTS)
    np.minimum.at(step, environment, contacts.all["time_of_impact"])
    x += 0.9 * step[:, None, None] * fall
    # Vertices of the cloth that would touch do not fall any further; their neighbours do.
    for side in (0, 1):
        of_cloth = contacts.all["body_a" if side == 0 else "body_b"] == soft
        is_edge = contacts.all["kind"] == softcd.ContactKind.edge_edge
        for i in range(4):
            on_side = np.where(is_edge, i // 2 == side, (i > 0) == (side == 1)) & of_cloth
            free[environment[on_side], contacts.all["vertices"][on_side, i]] = 0

crossings = sum(
    len(softcd.self_intersections(np.concatenate([x[k], spheres[k]]), np.concatenate([cloth, cloth + SIDE * SIDE])))
    for k in range(ENVIRONMENTS)
)
gap = x[:, corner[SIDE // 2, SIDE // 2], 2] - heights - RADIUS
print(f"{ENVIRONMENTS} cloths, {touching} contacts in the last step, {crossings} crossings,", end=" ")
print(f"middles {gap.min():.3f} to {gap.max():.3f} above the tops of the spheres")
