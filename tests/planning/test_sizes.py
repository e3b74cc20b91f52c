"""Robots of other sizes: a scene that is scaled with its robot is solved, or refused by name."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import AHEAD

from humanoid_rail import Auto, Box, InvalidInput, Robot, SafeVelocity, Scene, Sphere, load_robot, plan

LENGTHS = {"l_t1": 2.0, "l_t2": 0.5, "l_t3": 0.5, "link_radius": 0.05}
LENGTHS |= {f"l_{side}{i}": 1.0 for side in "lr" for i in (1, 2, 3)}
LENGTHS |= {"rail_lower": -1.0, "rail_upper": 9.0, "rail_velocity": 2.0, "rail_acceleration": 4.0}


def scaled_robot(scale: float) -> Robot:
    return load_robot(**{name: scale * length for name, length in LENGTHS.items()})


def scaled_scene(scale: float) -> Scene:
    def at(*point: float) -> tuple[float, ...]:
        return tuple(scale * np.array(point))

    obstacles = (
        Sphere(center=at(-1.0, 2.0, 2.6), radius=0.25 * scale),
        Box(center=at(-1.9, 1.4, 2.9), size=at(0.4, 3.0, 0.04)),
    )
    return Scene(name="scaled", targets={hand: at(*point) for hand, point in AHEAD.items()}, obstacles=obstacles)


@pytest.mark.parametrize("scale", [0.06, 0.1, 1.0, 10.0, 400.0])
def test_scaled_scenes_are_solved(scale: float) -> None:
    trajectory = plan(scaled_robot(scale), scaled_scene(scale))
    assert trajectory.status == "reached"
    assert trajectory.certified
    assert trajectory.limits_ok
    targets = scale * np.array([AHEAD["left"], AHEAD["right"]])
    assert np.linalg.norm(trajectory.hands[-1] - targets, axis=1).max() <= 1e-6 * max(1.0, scale)


@pytest.mark.parametrize("method", [Auto(), SafeVelocity(), Auto(tolerance=1e-6, safety_distance=1e-6)])
@pytest.mark.parametrize("scale", [1e-4, 1e-3, 1e-2, 700.0])
def test_sizes_beyond_the_range_are_refused_by_name(scale: float, method: Auto | SafeVelocity) -> None:
    with pytest.raises(InvalidInput, match=r"the reach of the arm of hands.left.*0\.1 to 1000 m"):
        plan(scaled_robot(scale), scaled_scene(scale), method)


@pytest.mark.parametrize(("option", "most"), [("tolerance", 0.05), ("safety_distance", 0.2)])
def test_options_too_large_for_the_arms_are_refused(option: str, most: float) -> None:
    robot, scene = scaled_robot(0.1), scaled_scene(0.1)
    with pytest.raises(InvalidInput, match=f"{option} is .*at most {most:g} m"):
        plan(robot, scene, Auto(**{option: 1.01 * most}))
    with pytest.raises(InvalidInput, match=f"{option} is .*at most {most:g}"):
        plan(robot, scene, Auto(**{option: most * (1 + 1e-12)}))


def test_large_arms_are_told_that_manipulability_outweighs_the_task() -> None:
    robot, scene = scaled_robot(10.0), scaled_scene(10.0)
    stalled = plan(robot, scene, SafeVelocity(tolerance=0.1, epsilon=10.0, c_mu=1.0))
    assert stalled.status == "stalled"
    assert "c_mu = 1 is much for arms that reach 20 m" in stalled.reason
    assert plan(robot, scene, SafeVelocity(tolerance=0.1, c_mu=0.0, c_kappa=0.0)).status == "reached"


def test_the_reach_of_an_arm_is_the_length_of_its_bones(robot: Robot) -> None:
    assert robot.arm_reaches == (2.0, 2.0)
