"""Wrong units are loud: what can only be one is refused, what may be one is warned of; robots of any scale are fine."""

from __future__ import annotations

import warnings

import pytest

from humanoid_rail import Box, HalfSpace, InvalidInput, Robot, Scene, Sphere, load_robot, make_scene, plan
from humanoid_rail.model.robot_file import make_robot_file

NEAR = {"left": (-1.6, 0.6, 3.4), "right": (-1.6, 2.2, 3.4)}


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"elbow_upper": 90}, "elbow_upper is 90.0; valid: at most 6.28319 in size, rad; 90 degrees would be 1.5708"),
        ({"beta": 60}, "60 degrees would be 1.0472"),
        ({"waist_yaw_lower": -180.0}, "-180 degrees would be -3.14159"),
        (
            {"l_l3": 800},
            "at most 100 in size, m, as other links are about as long; 800 millimetres would be 0.8",
        ),
        ({"link_radius": 50}, "50 millimetres would be 0.05"),
        ({"rail_upper": 9000}, "9000 millimetres would be 9"),
    ],
)
def test_what_can_only_be_another_unit_is_refused(arguments: dict[str, float], said: str) -> None:
    with pytest.raises(InvalidInput) as raised:
        load_robot(**arguments)
    assert said in str(raised.value)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"revolute_velocity": 180}, "180 deg/s would be 3.142 rad/s"),
        ({"rail_velocity": 2000}, "2000 mm/s would be 2 m/s"),
    ],
)
def test_what_may_be_another_unit_is_warned_of(arguments: dict[str, float], said: str) -> None:
    with pytest.warns(UserWarning, match=said):
        load_robot(**arguments)


@pytest.mark.parametrize("scale", [0.06, 1.0, 400.0])
def test_robots_of_any_scale_and_without_speed_limits_are_fine(scale: float) -> None:
    lengths = {"l_t1": 2.0, "l_t2": 0.5, "l_t3": 0.5, **{f"l_{side}{i}": 1.0 for side in "lr" for i in (1, 2, 3)}}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        load_robot(
            **{name: scale * length for name, length in lengths.items()},
            rail_upper=9.0 * scale,
            rail_velocity=2.0 * scale,
            revolute_velocity=1e9,
        )


@pytest.mark.parametrize(
    ("scene", "named"),
    [
        (
            Scene(targets=NEAR, obstacles=(Sphere(center=(-1000, 2000, 2600), radius=250),)),
            r"obstacles\[0\] \(sphere\)",
        ),
        (Scene(targets=NEAR, obstacles=(HalfSpace(normal=(0, 0, 1), offset=-800),)), r"obstacles\[0\] \(halfspace\)"),
        (Scene(targets={"left": (-1600, 600, 3400), "right": None}), "targets.left"),
    ],
)
def test_scenes_in_millimetres_are_warned_of(robot: Robot, scene: Scene, named: str) -> None:
    with pytest.warns(UserWarning, match=f"{named}: more than .* these look like millimetres"):
        plan(robot, scene)


def test_scenes_in_metres_are_not(robot: Robot) -> None:
    obstacles = (Sphere(center=(-30, 20, 26), radius=2.5), Box(center=(0, 4, -1), size=(900, 900, 1)))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        plan(robot, Scene(targets=NEAR, obstacles=obstacles), "qp")


def test_angles_of_files_are_not_in_degrees() -> None:
    with pytest.raises(InvalidInput, match=r"base.rpy\[2\] is 90.0; .* rad; given in degrees"):
        make_robot_file({"urdf": "a.urdf", "base": {"rpy": [0.0, 0.0, 90.0]}})
    with pytest.raises(InvalidInput, match=r"locked.j1 is 45.0; .*45 degrees would be 0.785398"):
        load_robot(TWO_JOINTS, hands={"tool": {"frame": "tool", "arm": ["j0", "j2", "j3"]}}, locked={"j1": 45.0})


def test_keys_that_are_misspelt_are_suggested_with_the_page_that_describes_them() -> None:
    with pytest.raises(InvalidInput, match=r"acceleration_tme .*did you mean acceleration_time\?.*docs/robots.md"):
        make_robot_file({"urdf": "a.urdf", "acceleration_tme": 1.0})
    with pytest.raises(InvalidInput, match=r"obstacle .*did you mean obstacles\?.*docs/scenes.md"):
        make_scene({"targets": {}, "obstacle": []})


_CAPSULE = (
    '<collision><origin xyz="0.15 0 0" rpy="0 1.5708 0"/><geometry><cylinder length="0.1" radius="0.02"/></geometry>'
    "</collision>"
)
TWO_JOINTS = (
    '<robot name="arm"><link name="b"/>'
    + "".join(
        f'<link name="l{i}">{_CAPSULE}</link><joint name="j{i}" type="revolute">'
        f'<parent link="{f"l{i - 1}" if i else "b"}"/>'
        f'<child link="l{i}"/><origin xyz="0.3 0 0"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="1" velocity="1" effort="1"/></joint>'
        for i in range(4)
    )
    + '<link name="tool"/><joint name="fix" type="fixed"><parent link="l3"/><child link="tool"/></joint></robot>'
)
