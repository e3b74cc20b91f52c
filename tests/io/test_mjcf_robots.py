"""The export to MuJoCo of robots as people have them: it loads, or is refused by name."""

from __future__ import annotations

import re

import numpy as np
import pinocchio as pin
import pytest
from mjcf_models import compiled, nothing, other_robot, placed, still, text_of
from scipy.spatial.transform import Rotation

from humanoid_rail import InvalidInput, Robot, Trajectory, paper_scene, plan_case, retime, robot_from_urdf


@pytest.fixture(scope="module")
def motion(robot: Robot) -> Trajectory:
    return retime(plan_case(robot, 3), robot, paper_scene())


def changed_robot(pattern: str, replacement: str, count: int = 0) -> Robot:
    other = other_robot()
    urdf, changes = re.subn(pattern, replacement, other.urdf, count=count)
    assert changes
    return robot_from_urdf(urdf, None, other.hands)


def quaternion(rpy: re.Match[str]) -> str:
    x, y, z, w = Rotation.from_euler("xyz", [float(angle) for angle in rpy[1].split()]).as_quat().tolist()
    return f'quat_xyzw="{x!r} {y!r} {z!r} {w!r}"'


def test_origins_by_quaternion_are_those_by_angles(motion: Trajectory, rng: np.random.Generator) -> None:
    """Of joints, bodies and inertias: the same robot in MuJoCo and in Pinocchio."""
    other = other_robot()
    urdf = re.sub(r'rpy="([^"]*)"', quaternion, other.urdf).replace('name="other"', 'name="other" version="1.1"')
    assert "rpy" not in urdf
    robot = robot_from_urdf(urdf, None, other.hands)
    models = [compiled(r, nothing(r), still(r, motion, r.initial)) for r in (other, robot)]
    data = robot.model.createData()
    for _ in range(5):
        q = robot.full_configuration(rng.uniform(robot.lower, robot.upper))
        pin.framesForwardKinematics(robot.model, data, q)
        angles, quaternions = (placed(model, q) for model in models)
        for index, frame in enumerate(robot.model.frames):
            if frame.type == pin.FrameType.BODY:
                np.testing.assert_allclose(quaternions.body(frame.name).xpos, data.oMf[index].translation, atol=1e-9)
        np.testing.assert_allclose(quaternions.geom_xpos, angles.geom_xpos, atol=1e-9)
        np.testing.assert_allclose(quaternions.geom_xmat, angles.geom_xmat, atol=1e-9)
        np.testing.assert_allclose(quaternions.qfrc_bias, angles.qfrc_bias, atol=1e-9)


INERTIA = r"<inertia ixx[^>]*/>"
DIAGONAL = '<inertia ixx="{}" iyy="{}" izz="{}" ixy="0" ixz="0" iyz="0"/>'


@pytest.mark.parametrize(
    ("pattern", "replacement", "count"),
    [
        (INERTIA, DIAGONAL.format(0.1, 0.3, 0.4), 0),  # flat
        (INERTIA, DIAGONAL.format(0.1, 0.3, 0.40000001), 0),  # flat, rounded
        (INERTIA, DIAGONAL.format(1e-13, 1e-13, 1e-13), 1),
        (r'(<link name="tool">)<inertial>.*?</inertial>', r"\1", 1),
        (r'axis xyz="1 2 2"', 'axis xyz="1e-5 2e-5 2e-5"', 1),
        (r'lower="-1" upper="1.5"', 'lower="0.5" upper="0.5"', 1),
    ],
)
def test_what_mujoco_can_have_it_loads(motion: Trajectory, pattern: str, replacement: str, count: int) -> None:
    robot = changed_robot(f"(?s){pattern}", replacement, count)
    model = compiled(robot, nothing(robot), still(robot, motion, robot.initial))
    assert model.njnt == robot.model.njoints - 1
    moved = sum(inertia.mass for inertia in robot.model.inertias)
    assert model.body_mass.sum() == pytest.approx(moved, rel=1e-9)


@pytest.mark.parametrize(
    ("pattern", "replacement", "count", "field"),
    [
        (INERTIA, DIAGONAL.format(0.1, 0.3, 0.41), 1, "link l0.inertial"),
        (INERTIA, DIAGONAL.format(0.1, 0.3, -0.4), 1, "inertial of what j0 moves"),
        (INERTIA, DIAGONAL.format(1e-16, 1e-16, 1e-16), 1, "link l0.inertial"),
        ('<mass value="1.5"/>', '<mass value="0"/>', 1, "inertial of what j0 moves"),
        (r'("tool"><inertial>.*?)<mass value="1.5"/>', r'\1<mass value="0"/>', 1, "link tool.inertial"),
        ('<mass value="1.5"/>', '<mass value="1e-16"/>', 1, "link l0.inertial"),
        (r'(<link name="f">)<inertial>.*?</inertial>', r"\1", 1, "inertial of what finger moves"),
    ],
)
def test_what_mujoco_cannot_have_is_named(
    motion: Trajectory, pattern: str, replacement: str, count: int, field: str
) -> None:
    robot = changed_robot(f"(?s){pattern}", replacement, count)
    with pytest.raises(InvalidInput) as caught:
        text_of(robot, nothing(robot), still(robot, motion, robot.initial))
    assert caught.value.field == field


def test_a_link_called_world_is_the_root(motion: Trajectory) -> None:
    other = other_robot()
    urdf = other.urdf.replace('"world"', '"floor"').replace('"l3"', '"world"')
    robot = robot_from_urdf(urdf, None, other.hands)
    with pytest.raises(InvalidInput, match="link world is 'moved by joint j3'"):
        text_of(robot, nothing(robot), still(robot, motion, robot.initial))
