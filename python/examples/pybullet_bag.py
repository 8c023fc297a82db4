"""A bag holds balls in PyBullet: balls smaller than the cloth's faces fall into a cloth that hangs by its border.

Bullet's soft world tests only nodes against balls, which pass between them. The preset "safe" has contacts of faces and
edges, too. Prints how many balls are in the bag after four seconds, and the force on them beside their weight.
"""

import numpy as np
import pybullet
import softcd.bullet

from pybullet_common import Video, grid, load_mesh

STEP, GRAVITY = 1 / 240, 10
BALLS, MASS, RADIUS = 8, 0.1, 0.03
SIDE, WIDTH = 11, 0.8


def load_bag():
    """Loads a bowl-shaped cloth whose border is held."""
    vertices, triangles = grid(SIDE, WIDTH)
    x, y = vertices[:, :2].T / (WIDTH / 2)
    vertices[:, 2] = -0.3 * (1 - x * x) * (1 - y * y)
    bag = load_mesh(vertices, triangles, mass=0.2, springElasticStiffness=100, collisionMargin=0.005, frictionCoeff=0.5)
    for node in np.flatnonzero(np.maximum(abs(x), abs(y)) > 0.99):
        pybullet.createSoftBodyAnchor(bag, int(node), -1, -1)
    return bag


def run(preset, video):
    """Lets the balls fall into the bag. Without a preset PyBullet detects alone."""
    pybullet.resetSimulation()
    pybullet.setGravity(0, 0, -GRAVITY)
    pybullet.setPhysicsEngineParameter(fixedTimeStep=STEP)
    bag = load_bag()
    ball = pybullet.createCollisionShape(pybullet.GEOM_SPHERE, radius=RADIUS)
    places = [[0.1 * (i % 2) - 0.05, 0.1 * (i // 2 % 2) - 0.05, 0.1 + 0.08 * (i // 4)] for i in range(BALLS)]
    balls = [pybullet.createMultiBody(MASS, ball, basePosition=place, useMaximalCoordinates=1) for place in places]
    attachment = None if preset is None else softcd.bullet.attach(preset=preset, read_out="impulses")
    lifts = []
    for step in range(960):
        pybullet.stepSimulation()
        if attachment is not None:
            contacts = attachment.contacts()
            lifts.append(sum(contacts.force_on(each, by=bag)[2] for each in balls))
        if preset == "safe":
            video.add(step * STEP)
    inside = sum(pybullet.getBasePositionAndOrientation(each)[0][2] > -1 for each in balls)
    print(f"{preset or 'PyBullet alone'}: {inside} of {BALLS} balls are in the bag", end="")
    if inside and lifts:
        print(f"; it holds them with {np.mean(lifts[-240:]):.3f} N, they weigh {inside * MASS * GRAVITY:.3f} N", end="")
    print(".")


video = Video.of_arguments(__doc__, target=[0, 0, -0.2], distance=1.3, pitch=-35)
pybullet.connect(pybullet.DIRECT)
for preset in (None, "balanced", "safe"):
    run(preset, video)
video.save()
