"""Robots from a URDF and hands that are given: joints that follow others, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import assert_gradient, plan

from humanoid_rail import Hand, InvalidInput, Kinematics, Scene, Sphere, robot_from_urdf

LIMIT = '<limit lower="-1" upper="2" velocity="1" effort="1"/>'
ARM = f"""<robot name="r"><link name="a"/><link name="b"/><link name="c"/><link name="d"/><link name="e"/>
  <link name="f"><collision name="x"><geometry><sphere radius="0.1"/></geometry></collision></link>
  <joint name="one" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>{LIMIT}</joint>
  <joint name="two" type="revolute"><parent link="b"/><child link="c"/><origin xyz="1 0 0"/><axis xyz="0 1 0"/>{LIMIT}
    <mimic joint="one" multiplier="2" offset="0.5"/></joint>
  <joint name="three" type="revolute"><parent link="c"/><child link="d"/><origin xyz="1 0 0"/><axis xyz="0 0 1"/>{LIMIT}
    <mimic joint="two" multiplier="-1"/></joint>
  <joint name="four" type="revolute"><parent link="d"/><child link="e"/><origin xyz="1 0 0"/><axis xyz="1 0 0"/>
    {LIMIT}</joint>
  <joint name="five" type="prismatic"><parent link="e"/><child link="f"/><origin xyz="1 0 0"/><axis xyz="0 1 0"/>
    {LIMIT}</joint>
  <transmission name="t"><joint name="two"/></transmission></robot>"""
MESH = "link f.collision[0].geometry"
TIP = [Hand("tip", "f", ("one", "four", "five"))]


def test_any_robot_with_a_linear_coupling(rng: np.random.Generator) -> None:
    robot = robot_from_urdf(ARM, None, TIP)
    assert robot.joint_names == ("one", "four", "five")
    np.testing.assert_allclose(robot.full_configuration([0.3, 1.0, 2.0]), [0.3, 1.1, -1.1, 1.0, 2.0])
    np.testing.assert_array_equal(robot.lower, [-0.75, -1.0, -1.0])  # where "two" and "three" keep their limits too
    np.testing.assert_array_equal(robot.upper, [0.25, 2.0, 2.0])
    np.testing.assert_array_equal(robot.initial, [-0.25, 0.5, 0.5])
    assert np.isinf(robot.acceleration_limit).all()
    kinematics = Kinematics(robot, (Sphere(center=(1, 1, 1), radius=0.2),))
    for _ in range(10):
        q = rng.uniform(robot.lower, robot.upper)
        state = kinematics.state(q)
        assert_gradient(lambda q: kinematics.hand_positions(q).ravel(), state.jacobian, q)
        assert_gradient(lambda q: kinematics.measure(q).manipulability, state.manipulability_gradient, q)
        assert_gradient(lambda q: kinematics.measure(q).clearance, state.clearance_gradient, q)
    target = kinematics.hand_positions([0.2, 0.6, 0.7])[0]
    assert plan(robot, Scene(name="one hand", targets={"tip": target}), c_mu=0.0).status == "reached"


@pytest.mark.parametrize(
    ("urdf", "srdf", "hands", "initial", "field"),
    [
        ("<robot", None, TIP, None, "urdf"),
        (ARM.replace(LIMIT, ""), None, TIP, None, "joint one.limit"),
        (ARM.replace('"revolute"', '"continuous"', 1), None, TIP, None, "joint one"),
        (ARM.replace("collision", "visual"), None, TIP, None, "urdf"),
        (ARM.replace('<sphere radius="0.1"/>', '<mesh filename="CUBE"/>'), None, TIP, None, MESH),
        (ARM.replace('<sphere radius="0.1"/>', '<mesh filename="package://x/y.stl"/>'), None, TIP, None, MESH),
        (ARM, None, [], None, "hands"),
        (ARM, None, TIP * 2, None, "hands"),
        (ARM, None, [Hand("tip", "nowhere", TIP[0].arm)], None, "hands.tip.frame"),
        (ARM, None, [Hand("tip", "f", ("one", "two", "four"))], None, "hands.tip.arm"),
        (ARM, None, [Hand("tip", "f", ("one", "four"))], None, "hands.tip.arm"),
        (ARM, None, [Hand("tip", "f", ("one", "one", "four"))], None, "hands.tip.arm"),
        (ARM, None, TIP, [0.0, 0.0], "initial"),
        (ARM, None, TIP, [0.0, 0.0, np.nan], "initial"),
        (ARM, "no xml", TIP, None, "srdf"),
        (ARM, '<robot><disable_collisions link1="a"/></robot>', TIP, None, "srdf"),
        (ARM, '<robot><disable_collisions link1="a" link2="z"/></robot>', TIP, None, "srdf.disable_collisions"),
    ],
)
def test_what_a_robot_cannot_have(
    urdf: str, srdf: str | None, hands: list[Hand], initial: list[float] | None, field: str, cube_file: str
) -> None:
    with pytest.raises(InvalidInput) as caught:
        robot_from_urdf(urdf.replace("CUBE", cube_file), srdf, hands, initial)
    assert caught.value.field == field
