"""URDFs of the kinds that people bring: each loads with hands and a free start, or is refused by name."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from humanoid_rail import InvalidInput, Robot, load_robot
from humanoid_rail.model.lost_postures import Lost

LIMIT = '<limit lower="-2" upper="2" velocity="2" effort="9"/>'
LENGTH = 0.25


def link(name: str, shape: str = '<box size="0.03 0.03 0.15"/>', at: float = LENGTH / 2) -> str:
    return (
        f'<link name="{name}"><collision><origin xyz="0 0 {at}"/><geometry>{shape}</geometry></collision></link>'
        if shape
        else f'<link name="{name}"/>'
    )


def joint(name: str, kind: str, parent: str, child: str, at: str, axis: str, more: str = LIMIT) -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{at}"/><axis xyz="{axis}"/>{more}</joint>'
    )


def arm(prefix: str = "", base: str = "base", at: str = "0 0 0.1", shape: str = '<box size="0.03 0.03 0.15"/>') -> str:
    """Return six joints in a row, each with a link along z."""
    parts, before = [], base
    for i in range(6):
        name = f"{prefix}l{i + 1}"
        parts.append(link(name, shape))
        where = at if i == 0 else f"0 0 {LENGTH}"
        parts.append(joint(f"{prefix}j{i + 1}", "revolute", before, name, where, "0 0 1" if i % 2 == 0 else "0 1 0"))
        before = name
    return "".join(parts)


def gripper(prefix: str, axis: str = "x") -> str:
    """Return two fingers along an axis of the last link, one of which follows the other."""
    parts = []
    for side, y in (("left", 0.02), ("right", -0.02)):
        box = '<box size="0.08 0.01 0.01"/>' if axis == "x" else '<box size="0.01 0.01 0.08"/>'
        ahead = "0.06 0 0" if axis == "x" else "0 0 0.04"
        parts.append(
            f'<link name="{prefix}{side}_finger"><collision><origin xyz="{ahead}"/><geometry>{box}</geometry>'
            "</collision></link>"
        )
        follows = f'<mimic joint="{prefix}left_finger_joint" multiplier="-1"/>' if side == "right" else ""
        low, high = (0.0, 0.03) if side == "left" else (-0.03, 0.0)
        limit = f'<limit lower="{low}" upper="{high}" velocity="1" effort="1"/>'
        parts.append(
            joint(
                f"{prefix}{side}_finger_joint",
                "prismatic",
                f"{prefix}l6",
                f"{prefix}{side}_finger",
                f"0 {y} {LENGTH}",
                "0 1 0",
                limit + follows,
            )
        )
    tool = "0.1 0 0.25" if axis == "x" else "0 0 0.33"
    parts.append(
        f'<link name="{prefix}tool"/><joint name="{prefix}tool_joint" type="fixed"><parent link="{prefix}l6"/>'
        f'<child link="{prefix}tool"/><origin xyz="{tool}"/></joint>'
    )
    return "".join(parts)


def robot(*parts: str) -> str:
    return f'<robot name="own">{"".join(parts)}</robot>'


BASE = link("base", '<box size="0.1 0.1 0.05"/>', 0.0)


def loaded(urdf: str | Path, **more: Any) -> Robot:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        robot: Robot = load_robot(urdf, **more)
        return robot


def test_six_joints_without_anything_else() -> None:
    found = loaded(robot(BASE, arm()))
    assert found.hand_names == ("hand",)
    assert found.hands[0].frame == "l6"
    assert found.n == 6


@pytest.mark.parametrize(("axis", "pointing"), [("x", (1.0, 0.0, 0.0)), ("z", (0.0, 0.0, 1.0))])
def test_two_arms_with_grippers_point_as_their_fingers_do(axis: str, pointing: tuple[float, ...]) -> None:
    arms = (
        arm(f"{side}_", at=f"0 {y} 0.1") + gripper(f"{side}_", axis) for side, y in (("left", 0.3), ("right", -0.3))
    )
    found = loaded(robot(BASE, *arms))
    assert found.hand_names == ("left", "right")
    assert [hand.pointing for hand in found.hands] == [pointing, pointing]
    assert [hand.frame for hand in found.hands] == ["left_tool", "right_tool"]
    assert found.locked["left_right_finger_joint"] == -found.locked["left_left_finger_joint"]
    assert any("as its fingers do" in said for said in found.assumed)


def test_meshes_in_millimetres_and_of_packages(tmp_path: Path) -> None:
    bar = trimesh.creation.box((30.0, 30.0, 150.0))
    (tmp_path / "share" / "cell" / "meshes").mkdir(parents=True)
    bar.export(tmp_path / "share" / "cell" / "meshes" / "bar.stl")
    bar.export(tmp_path / "bar.stl")
    for name, more in (("bar.stl", {}), ("package://cell/meshes/bar.stl", {"packages": [tmp_path / "share"]})):
        mesh = f'<mesh filename="{name}" scale="0.001 0.001 0.001"/>'
        (tmp_path / "own.urdf").write_text(robot(BASE, arm(shape=mesh)))
        found = loaded(tmp_path / "own.urdf", **more)
        shape = found.collision_model.geometryObjects[1].geometry
        points = np.array([shape.point(i) for i in range(shape.num_points)])
        np.testing.assert_allclose(np.ptp(points, axis=0), (0.03, 0.03, 0.15), atol=1e-8)


def test_xacro_with_arguments(tmp_path: Path) -> None:
    head = '<robot name="own" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:arg name="height" default="0.1"/>'
    text = head + BASE + arm(at="0 0 $(arg height)") + "</robot>"
    (tmp_path / "own.urdf.xacro").write_text(text)
    found = loaded(tmp_path / "own.urdf.xacro", xacro={"height": 0.7})
    assert found.model.jointPlacements[1].translation[2] == 0.7
    (tmp_path / "macros.xacro").write_text(
        head + '<xacro:macro name="m" params="p"><link name="l"/></xacro:macro></robot>'
    )
    with pytest.raises(InvalidInput, match="one with macros alone"):
        load_robot(tmp_path / "macros.xacro")


def test_planar_bases_move_only_as_joints_of_their_own() -> None:
    ground = link("ground", "") + joint("drive", "planar", "ground", "base", "0 0 0", "0 0 1", "")
    with pytest.raises(InvalidInput, match=r"locked: {drive: 0}"):
        loaded(robot(ground, BASE, arm()))
    assert loaded(robot(ground, BASE, arm()), locked={"drive": 0.0}).n == 6
    limit = '<limit lower="-1" upper="1" velocity="1" effort="1"/>'
    slides = "".join(
        link(b, "") + joint(f"to_{b}", kind, a, b, "0 0 0", axis, limit)
        for a, b, kind, axis in (("ground", "x", "prismatic", "1 0 0"), ("x", "y", "prismatic", "0 1 0"))
    )
    turn = joint("turn", "continuous", "y", "base", "0 0 0", "0 0 1", '<limit velocity="1" effort="1"/>')
    assert loaded(robot(link("ground", ""), slides, BASE, turn, arm())).n == 9


def test_joints_without_a_range_are_locked_and_said_to_be() -> None:
    wheel = link("wheel", "") + joint(
        "axle", "revolute", "base", "wheel", "0 0 0", "0 1 0", '<limit velocity="1" effort="1"/>'
    )
    held = arm().replace(LIMIT, '<limit velocity="1" effort="1"/>', 1)
    found = loaded(robot(BASE, wheel, held))
    assert found.locked["axle"] == 0.0
    assert found.joint_names == ("j2", "j3", "j4", "j5", "j6")
    assert any("no range: axle at 0, j1 at 0" in said for said in found.assumed)


def test_what_changes_nothing_is_warned_of_and_what_might_is_refused() -> None:
    with pytest.warns(UserWarning, match="command_effort of <limit> is not read"):
        assert load_robot(robot(BASE, arm().replace("effort=", 'command_effort="3" effort='))).n == 6
    for wrong in ("efort", "uper", "velocty"):
        with pytest.raises(InvalidInput, match=f"limit.{wrong}"):
            loaded(robot(BASE, arm().replace("effort=", f'{wrong}="3" effort=', 1)))
    with pytest.raises(InvalidInput, match="radus"):
        loaded(robot(link("base", '<sphere radius="0.1" radus="0.1"/>'), arm()))
    material = '<material name="m"><color rgba="0 0 0 0 1"/></material>'
    colour = f'<visual><geometry><box size="1 1 1"/></geometry>{material}</visual>'
    with pytest.warns(UserWarning, match="shown without"):
        assert load_robot(robot(BASE.replace("<collision>", colour + "<collision>"), arm())).n == 6


def test_a_share_that_is_lost_is_bounded_for_other_postures(rng: np.random.Generator) -> None:
    """Of robots that lose as much as is just allowed, few lose more in other postures."""
    limit, free, wrong, taken = 0.05, 250, 0, 0
    for share in rng.uniform(0.0, 0.1, 4000):
        seen = Lost(free, int(rng.binomial(free, share)), 400, {})
        if seen.most <= limit:
            taken += 1
            wrong += rng.binomial(free, share) > limit * free
    assert taken > 500
    assert wrong < 0.05 * taken
    assert Lost(400, 0, 400, {}).most < 0.01
    assert Lost(4 * free, 4 * 5, 1600, {}).most < Lost(free, 5, 400, {}).most
