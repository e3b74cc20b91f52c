"""The URDF in other people's tools: forward kinematics equal to the DH table."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from conftest import LINKS, ROOT
from test_robot import all_frames

from humanoid_rail import Robot

URDF = ROOT / "robots" / "humanoid_rail.urdf"
TOLERANCE = 1e-9


def configurations(robot: Robot, rng: np.random.Generator) -> list[np.ndarray]:
    return [robot.initial, *(rng.uniform(robot.lower, robot.upper) for _ in range(20))]


def assert_frames(poses: dict[str, np.ndarray], q: np.ndarray) -> None:
    expected = all_frames(q)
    for link, frame in LINKS.items():
        np.testing.assert_allclose(poses[link], expected[frame], atol=TOLERANCE, err_msg=link)


def passive(q: np.ndarray) -> list[float]:
    """Return what the two passive joints follow."""
    return [np.pi / 2 - q[2], -q[3]]


@pytest.mark.parametrize("mimic", [False, True])
def test_pinocchio(mimic: bool, robot: Robot, rng: np.random.Generator) -> None:
    model = pin.buildModelFromUrdf(str(URDF), mimic=mimic)
    assert model.nq == (12 if mimic else 14)
    data = model.createData()
    for q in configurations(robot, rng):
        full = q if mimic else np.array([*q[:4], *passive(q), *q[4:]])
        pin.framesForwardKinematics(model, data, full)
        assert_frames({link: data.oMf[model.getFrameId(link)].homogeneous for link in LINKS}, q)


def test_yourdfpy(robot: Robot, rng: np.random.Generator) -> None:
    yourdfpy = pytest.importorskip("yourdfpy")
    urdf = yourdfpy.URDF.load(str(URDF))
    assert tuple(urdf.actuated_joint_names) == robot.joint_names
    for q in configurations(robot, rng):
        urdf.update_cfg(q)
        assert_frames({link: urdf.get_transform(link) for link in LINKS}, q)


def test_mujoco(robot: Robot, rng: np.random.Generator) -> None:
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_path(str(URDF))
    data = mujoco.MjData(model)
    addresses = [model.joint(name).qposadr[0] for name in robot.joint_names]
    equalities = range(model.neq)
    assert len(equalities) == 2
    for q in configurations(robot, rng):
        data.qpos[addresses] = q
        for i in equalities:  # follower = a0 + a1 leader: how MuJoCo reads mimic
            follower, leader = (model.jnt_qposadr[j] for j in (model.eq_obj1id[i], model.eq_obj2id[i]))
            data.qpos[follower] = model.eq_data[i, 0] + model.eq_data[i, 1] * data.qpos[leader]
        mujoco.mj_kinematics(model, data)
        poses = {}
        for link in LINKS:
            if link != "base_link":  # MuJoCo makes the root its world
                body = data.body(link)
                poses[link] = np.vstack([np.column_stack([body.xmat.reshape(3, 3), body.xpos]), [0, 0, 0, 1]])
        assert_frames({"base_link": np.eye(4), **poses}, q)


def test_mujoco_simulates_it(robot: Robot) -> None:
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_path(str(URDF))
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT  # bones that share an end point touch
    data = mujoco.MjData(model)
    for name, value in zip(robot.joint_names, robot.initial, strict=True):
        data.joint(name).qpos = value
    data.joint("chest_level_waist").qpos, data.joint("chest_level_spine").qpos = passive(robot.initial)
    for _ in range(100):
        mujoco.mj_step(model, data)
    q = np.array([data.joint(name).qpos[0] for name in robot.joint_names])
    assert np.isfinite(data.qpos).all()
    assert abs(q - robot.initial).max() > 1e-3  # it falls, and its chest stays upright
    assert [data.joint(f"chest_level_{j}").qpos[0] for j in ("waist", "spine")] == pytest.approx(passive(q), abs=0.02)
    assert not data.warning.number.any()


def test_drake(robot: Robot, rng: np.random.Generator) -> None:
    plant_module = pytest.importorskip("pydrake.multibody.plant")
    from pydrake.multibody.parsing import Parser

    plant = plant_module.MultibodyPlant(time_step=1e-3)  # couplers need a discrete plant
    plant.set_discrete_contact_approximation(plant_module.DiscreteContactApproximation.kSap)
    Parser(plant).AddModels(str(URDF))
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("base_link"))
    plant.Finalize()
    assert plant.num_constraints() == 2  # one coupler for each mimic
    context = plant.CreateDefaultContext()
    for q in configurations(robot, rng):
        full = dict(zip((*robot.joint_names, "chest_level_waist", "chest_level_spine"), [*q, *passive(q)], strict=True))
        for name, value in full.items():
            plant.SetPositions(context, _one_joint(plant, context, name, value))
        poses = {link: plant.GetBodyByName(link).EvalPoseInWorld(context).GetAsMatrix4() for link in LINKS}
        assert_frames(poses, q)
    for name, limit in zip(robot.joint_names, robot.acceleration_limit, strict=True):
        assert plant.GetJointByName(name).acceleration_upper_limits() == [limit]


def _one_joint(plant: object, context: object, name: str, value: float) -> np.ndarray:
    positions = plant.GetPositions(context)
    positions[plant.GetJointByName(name).position_start()] = value
    return positions


@pytest.mark.skipif(shutil.which("check_urdf") is None, reason="check_urdf (Debian: liburdfdom-tools) is not installed")
def test_check_urdf() -> None:
    result = subprocess.run(["check_urdf", str(URDF)], capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    assert "Successfully Parsed XML" in result.stdout


def test_the_urdf_stands_alone() -> None:
    """No mesh or package path to resolve: one file is all that another tool needs."""
    assert "filename=" not in Path(URDF).read_text(encoding="utf-8")
