"""A cloth is folded by two of its corners in PyBullet: hands carry them over to the opposite corners and let go.

Prints how many pairs of triangles intersect in the worst step and at the end, exactly decided, how far the corners are
from those that they were brought to, and the force of the table on the cloth beside the cloth's weight.
"""

import numpy as np
import pybullet
import softcd.bullet

from pybullet_common import HAND_MASS, Video, grid, load_mesh, make_hand

STEP, GRAVITY, MASS = 1 / 240, 10, 0.2
SIDE, WIDTH = 17, 0.6
CORNERS, OPPOSITE = [0, SIDE - 1], [SIDE * (SIDE - 1), SIDE * SIDE - 1]  # nodes


def carry(hands, time):
    """Moves the hands on half a circle over the middle of the cloth, in 2 s from 0.5 s on."""
    angle = np.pi * np.clip((time - 0.5) / 2, 0, 1)
    for hand, y in zip(hands, (-WIDTH / 2, WIDTH / 2)):
        place = [-WIDTH / 2 * np.cos(angle), y, 0.03 + 0.48 * WIDTH * np.sin(angle)]
        pybullet.resetBasePositionAndOrientation(hand, place, [0, 0, 0, 1])


def run(preset, video):
    """Folds the cloth. Without a preset PyBullet detects alone."""
    pybullet.resetSimulation()
    pybullet.setGravity(0, 0, -GRAVITY)
    pybullet.setPhysicsEngineParameter(fixedTimeStep=STEP)
    slab = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.5, 0.5, 0.05])
    table = pybullet.createMultiBody(0, slab, basePosition=[0, 0, -0.05], useMaximalCoordinates=1)
    vertices, triangles = grid(SIDE, WIDTH)
    cloth = load_mesh(vertices, triangles, basePosition=[0, 0, 0.01], mass=MASS, springElasticStiffness=40,
                      collisionMargin=0.006, frictionCoeff=0.5)  # fmt: skip
    places = [[*vertices[node, :2], 0.01] for node in CORNERS]
    hands = [make_hand(cloth, [node], place) for node, place in zip(CORNERS, places)]
    settings = {"preset": preset, "self_collision": "all", "read_out": "impulses"}
    attachment = None if preset is None else softcd.bullet.attach(**settings)
    bodies, worst, lifts, pairs, apart = softcd.bullet.SoftBodies(), 0, [], np.empty((0, 2)), []
    for step in range(1, 961):
        if step < 660:  # then they let go
            carry(hands, step * STEP)
        pybullet.stepSimulation()
        if attachment is not None:
            lifts.append(attachment.contacts().force_on(cloth, by=table)[2])
        if step % 12 == 0:
            pairs = softcd.self_intersections(bodies.nodes(cloth)["position"], bodies.faces(cloth))
            worst = max(worst, len(pairs))
        if step in (659, 960):
            x = bodies.nodes(cloth)["position"]
            apart.append(1000 * np.linalg.norm(x[CORNERS] - x[OPPOSITE], axis=1).max())
        if preset == "safe":
            video.add(step * STEP)
    print(f"{preset or 'PyBullet alone'}: {worst} pairs of triangles intersect in the worst step,", end=" ")
    print(f"{len(pairs)} at the end; corners are {apart[0]:.0f} mm apart when the hands let go, {apart[1]:.0f} mm later", end="")
    if lifts:
        print(f"; the table carries {np.mean(lifts[-120:]):.4f} N,", end=" ")
        print(f"the cloth and what holds it weigh {(MASS + 2 * HAND_MASS) * GRAVITY:.4f} N", end="")
    print(".")


video = Video.of_arguments(__doc__, target=[0, 0, 0.05], distance=1.2, pitch=-30)
pybullet.connect(pybullet.DIRECT)
for preset in (None, "safe"):
    run(preset, video)
video.save()
