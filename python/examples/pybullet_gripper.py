"""A gripper picks up a cloth in PyBullet, and knows what it holds: prints forces beside Newton's second law.

Two fingers lift a cloth by its border. Each line has means of a quarter second: the force of all contacts on the cloth,
its mass times (acceleration - gravity), the part that comes from the fingers; the force of the cloth on the lower
finger, and what the finger's mass, acceleration, weight and motor leave for it.
"""

import pathlib
import tempfile

import numpy as np
import pybullet
import softcd.bullet

STEP, GRAVITY = 1 / 240, np.array([0, 0, -10])
CLOTH_MASS, FINGER_MASS, GRIP = 0.2, 0.05, 5  # kg, kg, N
CARRIAGE, UPPER, LOWER = range(3)  # links of the gripper


def load_cloth(side=13):
    """Loads a square cloth of side * side nodes, 0.6 m wide, 2 cm above the table."""
    lines = [f"v {x} {y} 0" for x in np.linspace(-0.3, 0.3, side) for y in np.linspace(-0.3, 0.3, side)]
    for a in (side * i + j + 1 for i in range(side - 1) for j in range(side - 1)):
        lines += [f"f {a} {a + side} {a + 1}", f"f {a + 1} {a + side} {a + side + 1}"]
    with tempfile.TemporaryDirectory() as folder:
        (pathlib.Path(folder) / "cloth.obj").write_text("\n".join(lines) + "\n")
        return pybullet.loadSoftBody(
            f"{folder}/cloth.obj", basePosition=[0, 0, 0.02], mass=CLOTH_MASS, useMassSpring=1, useBendingSprings=1,
            springElasticStiffness=40, springDampingStiffness=0.2, collisionMargin=0.01, frictionCoeff=1,
            useFaceContact=1)  # fmt: skip


def make_gripper():
    """Makes a carriage that slides up, and two fingers that slide towards each other on it."""
    box = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.06, 0.1, 0.01])
    places, turns, up = [[0, 0, 0], [0, 0, 0.05], [0, 0, -0.05]], [[0, 0, 0, 1]] * 3, [[0, 0, 1]] * 3
    gripper = pybullet.createMultiBody(
        0, basePosition=[0.24, 0, 0.02], linkMasses=[1, FINGER_MASS, FINGER_MASS],
        linkCollisionShapeIndices=[-1, box, box], linkVisualShapeIndices=[-1] * 3, linkPositions=places,
        linkOrientations=turns, linkInertialFramePositions=[[0, 0, 0]] * 3, linkInertialFrameOrientations=turns,
        linkParentIndices=[0, 1, 1], linkJointTypes=[pybullet.JOINT_PRISMATIC] * 3, linkJointAxis=up)  # fmt: skip
    pybullet.changeDynamics(gripper, UPPER, lateralFriction=2)
    pybullet.changeDynamics(gripper, LOWER, lateralFriction=2)
    return gripper


def move(gripper, time):
    """Closes the fingers from 0.5 s on, with at most GRIP, and lifts them from 1 s on."""
    closed = np.clip(0.175 * (time - 0.5), 0, 0.07)
    for finger, place in (UPPER, -closed), (LOWER, closed):
        pybullet.setJointMotorControl2(gripper, finger, pybullet.POSITION_CONTROL, place, force=GRIP, positionGain=0.3)
    speed = np.clip(time - 1, 0, 0.3)
    pybullet.setJointMotorControl2(gripper, CARRIAGE, pybullet.VELOCITY_CONTROL, targetVelocity=speed, force=500)


pybullet.connect(pybullet.DIRECT)
pybullet.resetSimulation(pybullet.RESET_USE_DEFORMABLE_WORLD)
pybullet.setPhysicsEngineParameter(fixedTimeStep=STEP)
pybullet.setGravity(*GRAVITY)
table = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.2, 0.35, 0.1])
pybullet.createMultiBody(0, table, basePosition=[-0.04, 0, -0.1])
cloth, gripper = load_cloth(), make_gripper()
attachment, bodies = softcd.bullet.attach(read_out="impulses"), softcd.bullet.SoftBodies()

before, means = np.zeros((2, 3)), np.zeros(5)
print("time | on the cloth   m (a - g)   by fingers | on the lower finger   m (a - g) - motor")
for step in range(1, 721):
    move(gripper, step * STEP)
    pybullet.stepSimulation()
    contacts, nodes = attachment.contacts(), bodies.nodes(cloth)
    finger_velocity = np.array(pybullet.getLinkState(gripper, LOWER, computeLinkVelocity=1)[6])
    momentum = np.array([nodes["mass"] @ nodes["velocity"], FINGER_MASS * finger_velocity])
    of_cloth, of_finger = (momentum - before) / STEP - np.outer([CLOTH_MASS, FINGER_MASS], GRAVITY)
    before = momentum
    on_cloth, by_fingers = contacts.force_on(cloth), contacts.force_on(cloth, by=gripper)
    on_finger, motor = contacts.force_on(gripper, link=LOWER), pybullet.getJointState(gripper, LOWER)[3]
    means += np.array([on_cloth[2], of_cloth[2], by_fingers[2], on_finger[2], of_finger[2] - motor]) / 60
    if step % 60 == 0:
        print("{:4.2f} | {:10.4f} N {:9.4f} N {:10.4f} N | {:17.4f} N {:17.4f} N".format(step * STEP, *means))
        means[:] = 0
