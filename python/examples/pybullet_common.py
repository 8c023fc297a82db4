"""What the examples for PyBullet share: meshes as soft bodies, a gripper, and videos without a window or a GPU."""

import argparse
import pathlib
import tempfile

import numpy as np
import pybullet

CARRIAGE, UPPER, LOWER = range(3)  # links of the gripper
FINGER_MASS, HAND_MASS = 0.05, 0.001  # kg


def grid(side, width):
    """Returns side * side vertices in a square around the origin, row by row along x, and triangles."""
    x, y = (axis.ravel() for axis in np.meshgrid(*[np.linspace(-width / 2, width / 2, side)] * 2, indexing="ij"))
    corner = np.arange(side * side).reshape(side, side)
    a, b, c, d = (corner[i : side - 1 + i, j : side - 1 + j].ravel() for i in (0, 1) for j in (0, 1))
    triangles = np.concatenate([np.stack([a, c, b], axis=1), np.stack([b, c, d], axis=1)])
    return np.stack([x, y, np.zeros_like(x)], axis=1), triangles


def tube(line, up, radius, around=4):
    """Returns the vertices of a tube along a line in the x-z plane, ring by ring, and its triangles, without caps.

    `up` has the unit vectors across the line and y."""
    angle = 2 * np.pi * (np.arange(around) + 0.5) / around
    rings = radius * (np.cos(angle)[:, None] * [[[0, 1, 0]]] + np.sin(angle)[:, None] * up[:, None])
    a = np.arange(len(line) * around).reshape(-1, around)[:-1]
    b = np.roll(a, -1, axis=1)
    sides = [np.stack(each, axis=-1).reshape(-1, 3) for each in ((a, a + around, b), (b, a + around, b + around))]
    return (line[:, None] + rings).reshape(-1, 3), np.concatenate(sides)


def load_mesh(vertices, triangles, **options):
    """Loads a mesh as a soft body of springs, as loadSoftBody does from a file, and returns its id."""
    lines = [f"v {x} {y} {z}" for x, y, z in vertices] + [f"f {a} {b} {c}" for a, b, c in triangles + 1]
    with tempfile.TemporaryDirectory() as folder:
        (pathlib.Path(folder) / "mesh.obj").write_text("\n".join(lines) + "\n")
        return pybullet.loadSoftBody(
            f"{folder}/mesh.obj", useMassSpring=1, useBendingSprings=1, springDampingStiffness=0.2, useFaceContact=1,
            **options)  # fmt: skip


def make_gripper(place):
    """Makes a carriage that slides up, and two fingers that slide towards each other on it."""
    box = pybullet.createCollisionShape(pybullet.GEOM_BOX, halfExtents=[0.06, 0.1, 0.01])
    places, turns, up = [[0, 0, 0], [0, 0, 0.05], [0, 0, -0.05]], [[0, 0, 0, 1]] * 3, [[0, 0, 1]] * 3
    gripper = pybullet.createMultiBody(
        0, basePosition=place, linkMasses=[1, FINGER_MASS, FINGER_MASS],
        linkCollisionShapeIndices=[-1, box, box], linkVisualShapeIndices=[-1] * 3, linkPositions=places,
        linkOrientations=turns, linkInertialFramePositions=[[0, 0, 0]] * 3, linkInertialFrameOrientations=turns,
        linkParentIndices=[0, 1, 1], linkJointTypes=[pybullet.JOINT_PRISMATIC] * 3, linkJointAxis=up)  # fmt: skip
    pybullet.changeDynamics(gripper, UPPER, lateralFriction=2)
    pybullet.changeDynamics(gripper, LOWER, lateralFriction=2)
    return gripper


def move_gripper(gripper, time, grip):
    """Closes the fingers from 0.5 s on, with at most `grip` N, and lifts them from 1 s on."""
    closed = np.clip(0.175 * (time - 0.5), 0, 0.07)
    for finger, place in (UPPER, -closed), (LOWER, closed):
        pybullet.setJointMotorControl2(gripper, finger, pybullet.POSITION_CONTROL, place, force=grip, positionGain=0.3)
    speed = np.clip(time - 1, 0, 0.3)
    pybullet.setJointMotorControl2(gripper, CARRIAGE, pybullet.VELOCITY_CONTROL, targetVelocity=speed, force=500)


def make_hand(body, nodes, place):
    """Makes a body without a shape that holds nodes of a soft body in PyBullet's soft world.

    PyBullet never releases such nodes there: removeConstraint() does nothing to them. So a hand weighs 1 g. Set its place
    in each step to move it, and leave it alone to let go. It then stays on the nodes."""
    hand = pybullet.createMultiBody(HAND_MASS, basePosition=place, useMaximalCoordinates=1)
    for node in nodes:
        pybullet.createSoftBodyAnchor(body, int(node), hand, -1)
    return hand


class Video:
    """Pictures of PyBullet's renderer on the CPU, in a GIF (pip install pillow) or a film (imageio imageio-ffmpeg)."""

    def __init__(self, path, target, distance, yaw=40, pitch=-25, size=(480, 352), rate=24):
        self._path, self._size, self._rate, self._frames, self._next = path, size, rate, [], 0.0
        self._view = pybullet.computeViewMatrixFromYawPitchRoll(target, distance, yaw, pitch, 0, 2)
        self._projection = pybullet.computeProjectionMatrixFOV(45, size[0] / size[1], 0.05, 10)

    @classmethod
    def of_arguments(cls, description, **camera):
        """Reads the program's arguments: --video FILE."""
        parser = argparse.ArgumentParser(description=description)
        parser.add_argument("--video", metavar="FILE", help="write a film (.mp4) or a GIF (.gif), too")
        return cls(parser.parse_args().video, **camera)

    def add(self, time):
        """Takes a picture where the last one is old enough. Does nothing without a file."""
        if self._path is None or time < self._next:
            return
        self._next = time + 1 / self._rate - 1e-9
        picture = pybullet.getCameraImage(*self._size, self._view, self._projection, shadow=1,
                                          lightDirection=[1, -1, 3], renderer=pybullet.ER_TINY_RENDERER)  # fmt: skip
        self._frames.append(np.reshape(picture[2], (self._size[1], self._size[0], 4))[:, :, :3].astype(np.uint8))

    def save(self):
        """Writes the file."""
        if self._path is None:
            return
        if str(self._path).endswith(".gif"):
            from PIL import Image  # pyright: ignore[reportMissingImports]

            first, *others = [Image.fromarray(frame).quantize(64) for frame in self._frames]
            first.save(self._path, save_all=True, append_images=others, duration=1000 // self._rate, loop=0)
        else:
            import imageio.v2  # pyright: ignore[reportMissingImports]

            imageio.v2.mimwrite(self._path, self._frames, fps=self._rate)
        print(f"{len(self._frames)} pictures in {self._path}")
