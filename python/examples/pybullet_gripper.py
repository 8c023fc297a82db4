"""A gripper picks up a cloth in PyBullet, and knows what it holds: prints forces beside Newton's second law.

Two fingers lift a cloth by its border. Each line has means of a quarter second: the force of all contacts on the cloth,
its mass times (acceleration - gravity), the part that comes from the fingers; the force of the cloth on the lower
finger, and what the finger's mass, acceleration, weight and motor leave for it.
"""

import numpy as np
import pybullet
import softcd.bullet

from pybullet_common import FINGER_MASS, LOWER, Video, grid, load_mesh, make_gripper, move_gripper

STEP, GRAVITY = 1 / 240, np.array([0, 0, -10])
CLOTH_MASS, GRIP = 0.2, 5  # kg, N

video = Video.of_arguments(__doc__, target=[0.1, 0, 0.15], distance=1.3)
pybullet.connect(pybullet.DIRECT)
pybullet.resetSimulation(pybullet.RESET_USE_DEFORMABLE_WORLD)
pybullet.setPhysicsEngineParameter(fixedTimeStep=STEP)
pybullet.setGravity(*GRAVITY)
table = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.2, 0.35, 0.1])
pybullet.createMultiBody(0, table, basePosition=[-0.04, 0, -0.1])
cloth = load_mesh(*grid(13, 0.6), basePosition=[0, 0, 0.02], mass=CLOTH_MASS, springElasticStiffness=40,
                  collisionMargin=0.01, frictionCoeff=1)  # fmt: skip
gripper = make_gripper([0.24, 0, 0.02])
attachment, bodies = softcd.bullet.attach(read_out="impulses"), softcd.bullet.SoftBodies()

before, means = np.zeros((2, 3)), np.zeros(5)
print("time | on the cloth   m (a - g)   by fingers | on the lower finger   m (a - g) - motor")
for step in range(1, 721):
    move_gripper(gripper, step * STEP, GRIP)
    pybullet.stepSimulation()
    contacts, nodes = attachment.contacts(), bodies.nodes(cloth)
    finger_velocity = np.array(pybullet.getLinkState(gripper, LOWER, computeLinkVelocity=1)[6])
    momentum = np.array([nodes["mass"] @ nodes["velocity"], FINGER_MASS * finger_velocity])
    of_cloth, of_finger = (momentum - before) / STEP - np.outer([CLOTH_MASS, FINGER_MASS], GRAVITY)
    before = momentum
    on_cloth, by_fingers = contacts.force_on(cloth), contacts.force_on(cloth, by=gripper)
    on_finger, motor = contacts.force_on(gripper, link=LOWER), pybullet.getJointState(gripper, LOWER)[3]
    means += np.array([on_cloth[2], of_cloth[2], by_fingers[2], on_finger[2], of_finger[2] - motor]) / 60
    video.add(step * STEP)
    if step % 60 == 0:
        print("{:4.2f} | {:10.4f} N {:9.4f} N {:10.4f} N | {:17.4f} N {:17.4f} N".format(step * STEP, *means))
        means[:] = 0
video.save()
