"""The export to MuJoCo of robots as people have them: it loads, or is refused by name."""

from __future__ import annotations

import re

import numpy as np
import pinocchio as pin
import pytest
from mjcf_models import compiled, mujoco, nothing, other_robot, placed, still, text_of
from scipy.spatial.transform import Rotation

from humanoid_rail import InvalidInput, Robot, Trajectory, robot_from_urdf


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
    ("pattern", "replacement", "count", "assumed"),
    [
        (INERTIA, DIAGONAL.format(0.1, 0.3, 0.41), 1, "what j0 moves; assumed are moments .* greater by 0.01 "),
        (INERTIA, DIAGONAL.format(1e-16, 1e-16, 1e-16), 1, "what j0 moves; assumed are moments .* at least 0.00015 "),
        ('<mass value="1.5"/>', '<mass value="0"/>', 1, "what j0 moves; assumed are a mass of 0.001 kg$"),
        ('<mass value="1.5"/>', '<mass value="1e-16"/>', 1, "what j0 moves; assumed are a mass of 0.001 kg$"),
        (
            r'(<link name="f">)<inertial>.*?</inertial>',
            r"\1",
            1,
            "what finger moves; .* 0.001 kg and moments .* 1e-07 ",
        ),
    ],
)
def test_what_mujoco_cannot_have_is_mended_and_said(
    motion: Trajectory, pattern: str, replacement: str, count: int, assumed: str
) -> None:
    robot = changed_robot(f"(?s){pattern}", replacement, count)
    with pytest.warns(UserWarning, match=assumed):
        model = compiled(robot, nothing(robot), still(robot, motion, robot.initial))
    assert model.nu == robot.n
    # No less than in the URDF, so that the actuators are strong enough for both.
    total, wanted = model.body_mass.sum(), sum(inertia.mass for inertia in robot.model.inertias)
    assert wanted - 1e-12 <= total <= wanted + 1.1e-3


def test_a_link_without_an_inertia_of_its_own_moves_with_its_joint(motion: Trajectory) -> None:
    """Where a fixed link cannot have its inertia, what the joint moves has all of it, as in Pinocchio."""
    robot = changed_robot(r'(?s)("tool"><inertial>.*?)<mass value="1.5"/>', r'\1<mass value="0"/>', 1)
    model = compiled(robot, nothing(robot), still(robot, motion, robot.initial))  # without a warning
    q = robot.full_configuration(robot.initial)
    upper = np.triu(pin.crba(robot.model, robot.model.createData(), q))
    found, data = np.zeros((model.nv, model.nv)), placed(model, q)
    for column, unit in zip(found, np.eye(model.nv), strict=True):
        mujoco.mj_mulM(model, data, column, unit)
    np.testing.assert_allclose(found, upper + np.triu(upper, 1).T, atol=1e-12)


def test_negative_inertias_are_refused(motion: Trajectory) -> None:
    robot = changed_robot(f"(?s){INERTIA}", DIAGONAL.format(0.1, 0.3, -0.4), 1)
    with pytest.raises(InvalidInput) as caught:
        text_of(robot, nothing(robot), still(robot, motion, robot.initial))
    assert caught.value.field == "inertial of what j0 moves"


def test_a_link_called_world_that_moves_has_another_name(motion: Trajectory, rng: np.random.Generator) -> None:
    """MuJoCo calls the ground so."""
    other = other_robot()
    urdf = other.urdf.replace('"world"', '"floor"').replace('"l3"', '"world"')
    robot = robot_from_urdf(urdf, None, other.hands)
    model = compiled(robot, nothing(robot), still(robot, motion, robot.initial))
    q = robot.full_configuration(rng.uniform(robot.lower, robot.upper))
    data = robot.model.createData()
    pin.framesForwardKinematics(robot.model, data, q)
    at = data.oMf[robot.model.getFrameId("world", pin.FrameType.BODY)]
    np.testing.assert_allclose(placed(model, q).body("world_").xpos, at.translation, atol=1e-9)
