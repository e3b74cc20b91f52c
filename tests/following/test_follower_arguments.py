"""What a follower cannot use or follow is named."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from conftest import AHEAD

from humanoid_rail import (
    Follower,
    Gains,
    HalfSpace,
    InvalidInput,
    Kinematics,
    PointTask,
    Robot,
    Safety,
    Scene,
    Sphere,
    State,
)


def test_a_start_in_contact_is_refused(robot: Robot, folded_q: np.ndarray) -> None:
    hand = tuple(Kinematics(robot).hand_positions(robot.initial).reshape(-1, 3)[0].tolist())
    with pytest.raises(InvalidInput, match=r"start is .* nothing touches: .* is inside obstacles\[0\] \(sphere\)"):
        Follower(robot, Scene(targets=AHEAD, obstacles=(Sphere(center=hand, radius=0.1),)))
    with pytest.raises(InvalidInput, match=r"start is .* nothing touches"):
        Follower(robot, Scene(targets=AHEAD), start=folded_q)


def objective(state: State) -> np.ndarray:
    return np.zeros(state.q.size)


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        ({"dt": 0.0}, "dt"),
        ({"dt": 1.0}, "dt"),
        ({"tolerance": 0.0}, "tolerance"),
        ({"start": [0.0]}, "start"),
        ({"start": np.full(12, 100.0)}, "start[0] (rail)"),
        ({"acceleration_limit": -1.0}, "acceleration_limit (rail)"),
        ({"acceleration_limit": [1.0, 2.0]}, "acceleration_limit"),
        ({"obstacle_speed": -1.0}, "obstacle_speed"),
        ({"obstacle_speed": 0.1}, "obstacle_speed"),
        ({"obstacle_speed": [1.0, 1.0]}, "obstacle_speed"),
        ({"obstacle_latency": -1.0}, "obstacle_latency"),
        ({"gains": Gains(objectives=[objective])}, "gains.objectives"),
        ({"safety": Safety(equalities=[lambda state: (state.jacobian, np.zeros(6))])}, "safety.equalities"),
    ],
)
def test_what_cannot_be_used_is_named(robot: Robot, arguments: dict[str, object], field: str) -> None:
    ball = Sphere(center=(3.0, 8.0, 3.0), radius=0.2, velocity=(0.2, 0.0, 0.0))
    with pytest.raises(InvalidInput) as raised:
        Follower(robot, Scene(targets=AHEAD, obstacles=(ball,)), **arguments)  # type: ignore[arg-type]
    assert raised.value.field == field


def test_what_cannot_be_followed_is_named(robot: Robot) -> None:
    class Own(PointTask):
        pass

    floor = HalfSpace(normal=(0.0, 0.0, 1.0), offset=-0.5)
    follower = Follower(robot, Scene(targets=AHEAD, obstacles=(floor,)))
    for call, field in (
        (lambda: follower.set_targets({"left": (1.0, 2.0, 3.0)}), "targets.right"),
        (lambda: follower.set_targets({"left": None, "right": None}), "targets"),
        (lambda: follower.set_tasks([]), "tasks"),
        (lambda: follower.set_tasks([Own("left", (1.0, 2.0, 3.0))]), "tasks[0]"),
        (lambda: follower.move_obstacle(1, (0.0, 0.0, 0.0)), "obstacle"),
        (lambda: follower.move_obstacle(0, (0.0, 0.0, 0.0)), "obstacle"),
        (lambda: follower.move_obstacle("ball", (0.0, 0.0, 0.0)), "obstacle"),
    ):
        with pytest.raises(InvalidInput) as raised:
            call()
        assert raised.value.field == field


def test_limits_that_are_missing_are_named(robot: Robot) -> None:
    without = replace(robot, acceleration_limit=np.full(robot.n, np.inf))
    with pytest.raises(InvalidInput, match=r"acceleration_limit \(rail\) is inf"):
        Follower(without, Scene(targets=AHEAD))
    assert Follower(without, Scene(targets=AHEAD), acceleration_limit=2.0).step().proven


def test_what_looks_like_millimetres_is_warned_of(robot: Robot) -> None:
    ball = Sphere(center=(-1600.0, 600.0, 3400.0), radius=100.0)
    with pytest.warns(UserWarning, match=r"obstacles\[0\] \(sphere\).*look like millimetres") as warned:
        Follower(robot, Scene(targets=AHEAD, obstacles=(ball,)))
    assert warned[0].filename == __file__
