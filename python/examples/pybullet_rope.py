"""A gripper carries a rope in PyBullet, and weighs it: prints forces beside Newton's second law.

The rope is a tube of springs. Two fingers close on one of its ends and lift it from a table until it hangs. Each line
has means of a quarter second: the force of all contacts on the rope, its mass times (acceleration - gravity), the part
that comes from the fingers, and the height of the rope's lowest node.
"""

import numpy as np
import pybullet
import softcd.bullet

from pybullet_common import Video, load_mesh, make_gripper, move_gripper, tube

STEP, GRAVITY = 1 / 240, np.array([0, 0, -10])
MASS, LENGTH, RADIUS, GRIP = 0.1, 0.6, 0.015, 5  # kg, m, m, N
RINGS = 25

video = Video.of_arguments(__doc__, target=[0.1, 0, 0.2], distance=1.5)
pybullet.connect(pybullet.DIRECT)
pybullet.resetSimulation(pybullet.RESET_USE_DEFORMABLE_WORLD)
pybullet.setPhysicsEngineParameter(fixedTimeStep=STEP)
pybullet.setGravity(*GRAVITY)
table = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.2, 0.35, 0.1])
pybullet.createMultiBody(0, table, basePosition=[-0.04, 0, -0.1])
line = np.linspace([-LENGTH / 2, 0, 0], [LENGTH / 2, 0, 0], RINGS)
rope = load_mesh(*tube(line, np.array([[0, 0, 1]]), RADIUS), basePosition=[0, 0, 0.025], mass=MASS,
                 springElasticStiffness=100, collisionMargin=0.01, frictionCoeff=1)  # fmt: skip
gripper = make_gripper([0.24, 0, 0.025])
attachment, bodies = softcd.bullet.attach(read_out="impulses"), softcd.bullet.SoftBodies()
before, means = np.zeros(3), np.zeros(3)
print("time | on the rope   m (a - g)   by fingers | lowest node")
for step in range(1, 841):
    move_gripper(gripper, step * STEP, GRIP)
    pybullet.stepSimulation()
    contacts, nodes = attachment.contacts(), bodies.nodes(rope)
    momentum = nodes["mass"] @ nodes["velocity"]
    expected = (momentum - before) / STEP - MASS * GRAVITY
    before = momentum
    means += np.array([contacts.force_on(rope)[2], expected[2], contacts.force_on(rope, by=gripper)[2]]) / 60
    video.add(step * STEP)
    if step % 60 == 0:
        low = nodes["position"][:, 2].min()
        print("{:4.2f} | {:9.4f} N {:9.4f} N {:10.4f} N | {:9.3f} m".format(step * STEP, *means, low))
        means[:] = 0
video.save()
