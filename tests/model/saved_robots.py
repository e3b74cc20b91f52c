"""Robots with meshes that tests write, save and compare."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh

from humanoid_rail import Robot, load_robot

FIELDS = (
    "name",
    "joint_names",
    "hands",
    "self_collision_pairs",
    "left_out",
    "unchecked_pairs",
    "links_without_body",
    "pair_distances",
    "postures",
    "locked",
    "assumed",
    "model",
)
ARRAYS = ("lower", "upper", "velocity_limit", "acceleration_limit", "jerk_limit", "initial", "coupling", "offset")

SRDF = """<robot name="meshy"><group_state name="bent" group="g"><joint name="j1" value="0.5"/></group_state>
<disable_collisions link1="b0" link2="b2" reason="Never"/></robot>"""


def write_robot(folder: Path) -> Path:
    """Write an arm of five joints and a finger whose bodies are STL, OBJ with a material, DAE and primitives."""
    folder.mkdir(parents=True)
    parts = [trimesh.creation.box((0.3, 0.06, 0.05)), trimesh.creation.icosphere(1, radius=0.06)]
    parts[0].apply_translation((0.15, 0.0, 0.0))
    parts[0].export(folder / "bar.stl")
    parts[1].export(folder / "ball.dae")
    parts[1].visual = trimesh.visual.TextureVisuals(
        uv=np.zeros((len(parts[1].vertices), 2)), material=trimesh.visual.material.SimpleMaterial(name="red stuff")
    )
    (folder / "looks").mkdir()
    parts[1].export(folder / "looks" / "ball.obj")
    mesh = {
        "b0": '<mesh filename="bar.stl"/>',
        "b1": '<mesh filename="bar.stl" scale="1 0.7 -1"/>',
        "b2": '<mesh filename="ball.dae"/>',
        "b3": '<cylinder radius="0.03" length="0.1"/>',
        "b4": '<mesh filename="looks/ball.obj" scale="0.5 0.5 0.5"/>',
        "finger": '<box size="0.02 0.02 0.02"/>',
    }
    links = '<link name="base"/>' + "".join(
        f'<link name="{name}"><visual><geometry>{shape}</geometry></visual>'
        f'<collision name="c"><origin xyz="0 0 0.01" rpy="0.1 0 0"/><geometry>{shape}</geometry></collision></link>'
        for name, shape in mesh.items()
    )
    limit = '<limit lower="-1.5" upper="1.5" velocity="2" effort="9"/>'
    names = ["base", *list(mesh)[:5]]
    joints = "".join(
        f'<joint name="j{i}" type="{"continuous" if i == 4 else "revolute"}"><parent link="{names[i]}"/>'
        f'<child link="b{i}"/><origin xyz="{0.3 if i else 0} 0 0"/><axis xyz="0 {i % 2} {1 - i % 2}"/>{limit}</joint>'
        for i in range(5)
    )
    finger = (
        '<joint name="grip" type="prismatic"><parent link="b4"/><child link="finger"/><origin xyz="0.1 0 0"/>'
        '<axis xyz="1 0 0"/><limit lower="0.01" upper="0.04" velocity="1" effort="1"/></joint>'
    )
    urdf = folder / "meshy.urdf"
    urdf.write_text(f'<robot name="meshy">{links}{joints}{finger}</robot>', encoding="utf-8")
    (folder / "meshy.srdf").write_text(SRDF, encoding="utf-8")
    return urdf


def load(urdf: Path) -> Robot:
    """Load the robot that was written, with its finger locked and its base moved."""
    hand = {"frame": "b4", "arm": ["j0", "j1", "j2", "j3", "j4"], "pointing": [0.0, 0.0, 1.0]}
    return load_robot(
        urdf,
        srdf=urdf.with_suffix(".srdf"),
        hands={"tool": hand},
        locked={"grip": 0.02},
        base={"xyz": [0.1, 0.2, 0.3], "rpy": [0.0, 0.0, 0.4]},
    )


def assert_same(robot: Robot, other: Robot, *, names: bool = True) -> None:
    """Check that two robots are the same, bit for bit."""
    for name in FIELDS:
        assert getattr(robot, name) == getattr(other, name), name
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(robot, name), getattr(other, name), err_msg=name)
    one, two = robot.collision_model.geometryObjects, other.collision_model.geometryObjects
    assert len(one) == len(two)
    for body, again in zip(one, two, strict=True):
        assert not names or body.name == again.name
        assert (body.parentJoint, body.parentFrame) == (again.parentJoint, again.parentFrame)
        assert body.placement == again.placement
        assert _numbers(body.geometry) == _numbers(again.geometry)


def _numbers(shape: object) -> object:
    """Return what a shape of coal consists of."""
    if hasattr(shape, "num_points"):
        return [tuple(np.asarray(shape.point(i)).tolist()) for i in range(shape.num_points)]
    sizes = [getattr(shape, name, None) for name in ("radius", "halfLength", "halfSide")]
    return type(shape), [size.tolist() if isinstance(size, np.ndarray) else size for size in sizes]
