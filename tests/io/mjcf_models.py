"""Robots, motions and models that the tests of the export to MuJoCo share."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from conftest import changed

from humanoid_rail import Hand, Kinematics, Robot, Scene, Timing, Trajectory, robot_from_urdf
from humanoid_rail.io.mujoco.actuators import position_actuators
from humanoid_rail.io.mujoco.mjcf import mjcf

mujoco = pytest.importorskip("mujoco")


def text_of(robot: Robot, scene: Scene, motion: Trajectory) -> str:
    return mjcf(robot, scene, motion, position_actuators(robot, motion.q), motion.q[0])


def compiled(robot: Robot, scene: Scene, motion: Trajectory) -> Any:
    return mujoco.MjModel.from_xml_string(text_of(robot, scene, motion))


def placed(model: Any, q_full: np.ndarray) -> Any:
    data = mujoco.MjData(model)
    data.qpos[:] = q_full
    mujoco.mj_forward(model, data)
    return data


# A tool on an arm whose frames are turned in every way, with a passive finger, without an SRDF.
OTHER = """
<robot name="other">
  <material name="green"><color rgba="0 1 0 1"/></material>
  <link name="world"/>
  <joint name="stand" type="fixed"><parent link="world"/><child link="base"/>
    <origin xyz="0.1 0.2 0.3" rpy="0.1 0.2 0.3"/></joint>
  <link name="base">
    <visual><geometry><mesh filename="package://nowhere/base.stl" scale="1 1 1"/></geometry></visual>
    <visual><origin xyz="0 0 -0.1"/><geometry><box size="0.2 0.2 0.2"/></geometry><material name="green"/></visual>
    <collision><geometry><box size="0.1 0.1 0.1"/></geometry></collision>
  </link>
  {joints}
  <joint name="flange" type="fixed"><parent link="l3"/><child link="tool"/><origin xyz="0 0 0.1" rpy="1 2 3"/></joint>
  <link name="tool">{inertial}<collision><geometry><sphere radius="0.02"/></geometry></collision></link>
  <joint name="finger" type="revolute"><parent link="tool"/><child link="f"/><origin xyz="0 0.05 0" rpy="0 1 0"/>
    <axis xyz="0 1 1"/><limit lower="-2" upper="2" velocity="1" effort="0"/>
    <mimic joint="j2" multiplier="0.5" offset="0.1"/></joint>
  <link name="f">{inertial}</link>
</robot>
"""
JOINT = """
  <joint name="j{i}" type="{kind}"><parent link="{parent}"/><child link="l{i}"/>
    <origin xyz="0.1 0 0.3" rpy="0.{i} -0.4 0.5"/><axis xyz="{axis}"/>
    <limit lower="-1" upper="1.5" velocity="1" effort="0"/></joint>
  <link name="l{i}">{inertial}<collision><origin xyz="0 0 0.1" rpy="0.3 0 0"/>
    <geometry><cylinder radius="0.03" length="0.2"/></geometry></collision></link>
"""
INERTIAL = """<inertial><origin xyz="0.01 0.02 0.03" rpy="0.4 0.5 0.6"/><mass value="1.5"/>
  <inertia ixx="0.02" iyy="0.03" izz="0.04" ixy="0.001" ixz="0.002" iyz="-0.003"/></inertial>"""


@cache
def other_robot() -> Robot:
    """The robot of `OTHER`."""
    kinds = [
        ("base", "prismatic", "0 1 0"),
        ("l0", "revolute", "0 0 1"),
        ("l1", "revolute", "1 2 2"),
        ("l2", "revolute", "1 0 0"),
    ]
    joints = "".join(
        JOINT.format(i=i, parent=parent, kind=kind, axis=axis, inertial=INERTIAL)
        for i, (parent, kind, axis) in enumerate(kinds)
    )
    urdf = OTHER.format(joints=joints, inertial=INERTIAL)
    return robot_from_urdf(urdf, None, [Hand("tip", "flange", ("j1", "j2", "j3"))])


def still(robot: Robot, motion: Trajectory, q: np.ndarray) -> Trajectory:
    """A motion of any robot that stays where it is."""
    zeros = np.zeros((3, robot.n))
    hands = np.tile(Kinematics(robot).hand_positions(q).reshape(-1, 3), (3, 1, 1))
    return changed(
        motion,
        t=np.array([0.0, 0.1, 0.2]),
        q=zeros + q,
        hands=hands,
        timing=Timing(zeros, zeros, ()),
        joint_names=robot.joint_names,
        hand_names=robot.hand_names,
    )


def nothing(robot: Robot) -> Scene:
    return Scene(name="nothing", targets=dict.fromkeys(robot.hand_names, (0.0, 0.0, 0.0)))
