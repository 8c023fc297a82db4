"""A bag holds balls in PyBullet: balls smaller than the cloth's faces fall into a cloth that hangs by its border.

Bullet's soft world tests only nodes against balls, which pass between them. The preset "safe" has contacts of faces and
edges, too. Prints how many balls are in the bag after four seconds, and the force on them beside their weight.
"""

import pathlib
import tempfile

import numpy as np
import pybullet
import softcd.bullet

STEP, GRAVITY = 1 / 240, 10
BALLS, MASS, RADIUS = 8, 0.1, 0.03
SIDE, WIDTH = 11, 0.8


def load_bag():
    """Loads a bowl-shaped cloth whose border is held."""
    grid = np.linspace(-1, 1, SIDE)
    lines = [f"v {x * WIDTH / 2} {y * WIDTH / 2} {-0.3 * (1 - x * x) * (1 - y * y)}" for x in grid for y in grid]
    for a in (SIDE * i + j + 1 for i in range(SIDE - 1) for j in range(SIDE - 1)):
        lines += [f"f {a} {a + SIDE} {a + 1}", f"f {a + 1} {a + SIDE} {a + SIDE + 1}"]
    with tempfile.TemporaryDirectory() as folder:
        (pathlib.Path(folder) / "bag.obj").write_text("\n".join(lines) + "\n")
        bag = pybullet.loadSoftBody(
            f"{folder}/bag.obj", mass=0.2, useMassSpring=1, useBendingSprings=1, springElasticStiffness=100,
            springDampingStiffness=0.2, collisionMargin=0.005, frictionCoeff=0.5, useFaceContact=1)  # fmt: skip
    for i in range(SIDE * SIDE):
        if i // SIDE in (0, SIDE - 1) or i % SIDE in (0, SIDE - 1):
            pybullet.createSoftBodyAnchor(bag, i, -1, -1)
    return bag


def run(preset):
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
    for _ in range(960):
        pybullet.stepSimulation()
        if attachment is not None:
            contacts = attachment.contacts()
            lifts.append(sum(contacts.force_on(each, by=bag)[2] for each in balls))
    inside = sum(pybullet.getBasePositionAndOrientation(each)[0][2] > -1 for each in balls)
    print(f"{preset or 'PyBullet alone'}: {inside} of {BALLS} balls are in the bag", end="")
    if inside and lifts:
        print(f"; it holds them with {np.mean(lifts[-240:]):.3f} N, they weigh {inside * MASS * GRAVITY:.3f} N", end="")
    print(".")


pybullet.connect(pybullet.DIRECT)
for preset in (None, "balanced", "safe"):
    run(preset)
