"""A hand lays a rope around a post in PyBullet and lets go: the rope holds itself.

The rope is a tube of springs that hangs over a horizontal post. A hand takes its long end around the post. Prints how
many pairs of triangles intersect in the worst of the steps looked at, how far the short end sinks in 4 s after the hand
has let go, how often the rope is around the post, and the force of the post on the rope beside the weight.
"""

import numpy as np
import pybullet
import softcd.bullet

from pybullet_common import HAND_MASS, Video, load_mesh, make_hand, tube

STEP, GRAVITY, MASS = 1 / 240, 10, 0.1
RADIUS, POST, SPACING, AROUND = 0.012, 0.03, 0.02, 4  # m, and nodes in a ring
SHORT, LONG, OVER = 0.6, 1.2, POST + RADIUS + 0.008  # the ends' lengths, and the radius of the rope's way over the post
SPEED, PAUSE = 0.4, 0.5  # m/s, s


def rope_over_post():
    """Returns the rope's rings: their centres, and the directions away from the post."""
    s = np.arange(0, SHORT + np.pi * OVER + LONG, SPACING)
    angle = np.clip((s - SHORT) / OVER, 0, np.pi)
    down = np.maximum(SHORT - s, 0) + np.maximum(s - SHORT - np.pi * OVER, 0)
    away = np.stack([-np.cos(angle), 0 * s, np.sin(angle)], axis=1)
    return OVER * away - down[:, None] * [0, 0, 1], away


LINE, AWAY = rope_over_post()
angle = np.linspace(0, 2 * np.pi, 17)
FRONT = -0.03 - 0.04 * angle / (2 * np.pi) - 0.2 * np.sin(angle / 2) ** 2  # clear of the short end
TURNS = np.stack([0.2 * np.cos(angle), FRONT, -0.2 * np.sin(angle)], axis=1)
WAY = np.concatenate([[LINE[-1], [0.3, 0, -0.5]], TURNS, [[0.05, -0.4, -0.4]]])
TIMES = PAUSE + np.append(0, np.cumsum(np.linalg.norm(np.diff(WAY, axis=0), axis=1))) / SPEED


def run(preset, video):
    """Ties the rope and lets go. Without a preset PyBullet detects alone."""
    pybullet.resetSimulation()
    pybullet.setGravity(0, 0, -GRAVITY)
    pybullet.setPhysicsEngineParameter(fixedTimeStep=STEP)
    cylinder = pybullet.createCollisionShape(pybullet.GEOM_CYLINDER, radius=POST, height=0.6)
    post = pybullet.createMultiBody(0, cylinder, useMaximalCoordinates=1,
                                    baseOrientation=pybullet.getQuaternionFromEuler([np.pi / 2, 0, 0]))  # fmt: skip
    pybullet.changeDynamics(post, -1, lateralFriction=1)
    vertices, triangles = tube(LINE, AWAY, RADIUS, AROUND)
    rope = load_mesh(vertices, triangles, mass=MASS, springElasticStiffness=40, collisionMargin=0.004, frictionCoeff=1)
    hand = make_hand(rope, range(len(vertices) - AROUND, len(vertices)), LINE[-1].tolist())
    settings = {"preset": preset, "self_collision": "all", "read_out": "impulses"}
    attachment = None if preset is None else softcd.bullet.attach(**settings)
    bodies, worst, lifts, height = softcd.bullet.SoftBodies(), 0, [], 0.0
    released = round((TIMES[-1] + PAUSE) / STEP)
    for step in range(1, released + 961):
        if step <= released:
            place = [np.interp(step * STEP, TIMES, each) for each in WAY.T]
            pybullet.resetBasePositionAndOrientation(hand, place, [0, 0, 0, 1])
        pybullet.stepSimulation()
        if attachment is not None:
            lifts.append(attachment.contacts().force_on(rope, by=post)[2])
        if step % 12 == 0:
            worst = max(worst, len(softcd.self_intersections(bodies.nodes(rope)["position"], triangles)))
        if step == released:
            height = bodies.nodes(rope)["position"][0, 2]
        if preset == "safe":
            video.add(step * STEP)
    x = bodies.nodes(rope)["position"].reshape(-1, AROUND, 3).mean(axis=1)
    angle = np.unwrap(np.arctan2(x[:, 2], x[:, 0]))
    print(f"{preset or 'PyBullet alone'}: {worst} pairs of triangles intersect in the worst step; the short", end=" ")
    print(f"end sinks by {1000 * (height - x[0, 2]):.0f} mm; {abs(angle[-1] - angle[0]) / 2 / np.pi:.2f} turns", end="")
    if lifts:
        weight = (MASS + HAND_MASS) * GRAVITY
        print(f"; the post carries {np.mean(lifts[-240:]):.4f} N, rope and hand weigh {weight:.4f} N", end="")
    print(".")


video = Video.of_arguments(__doc__, target=[0, -0.1, -0.3], distance=1.8, yaw=20, pitch=-15)
pybullet.connect(pybullet.DIRECT)
for preset in (None, "safe"):
    run(preset, video)
video.save()
