"""What can be given to `retime`, and what is said of the rest."""

from __future__ import annotations

from dataclasses import replace

import conftest
import numpy as np
import pytest
from conftest import changed
from motions import EXCESS, rates, straight

from humanoid_rail import InvalidInput, Robot, Scene, Trajectory, retime


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        ({"dt": 0.0}, "dt"),
        ({"dwell": -1.0}, "dwell"),
        ({"dwell": 1e6}, "dwell"),
        ({"dwell": 10_001.0, "dt": 0.01}, "dwell"),
        ({"dt": 1e5}, "dt"),
        ({"max_time": 0.0}, "max_time"),
        ({"velocity_limit": 1e-300}, "velocity_limit"),
        ({"velocity_limit": "3"}, "velocity_limit"),
        ({"velocity_limit": True}, "velocity_limit"),
        ({"velocity_limit": [1.0, [2.0]]}, "velocity_limit"),
        ({"dt": 1e-8}, "duration"),
        ({"velocity_limit": 0.0}, "velocity_limit"),
        ({"velocity_limit": [1.0, 2.0]}, "velocity_limit"),
        ({"acceleration_limit": "fast"}, "acceleration_limit"),
        ({"jerk_limit": float("nan")}, "jerk_limit"),
        ({"acceleration_limit": np.inf}, "acceleration_limit (rail)"),
    ],
)
def test_bad_arguments(
    robot: Robot, planned: Trajectory, free: Scene, arguments: dict[str, object], field: str
) -> None:
    with pytest.raises(InvalidInput) as caught:
        retime(planned, robot, free, **arguments)  # type: ignore[arg-type]
    assert caught.value.field == field


def test_what_is_not_a_trajectory_of_the_robot(robot: Robot, planned: Trajectory, free: Scene) -> None:
    for arguments, field in (
        ((planned.q, robot, free), "trajectory"),
        ((planned, "robot", free), "robot"),
        ((planned, robot, "free"), "scene"),
        ((changed(planned, joint_names=("a",) * robot.n), robot, free), "trajectory.joint_names"),
    ):
        with pytest.raises(InvalidInput) as caught:
            retime(*arguments)  # type: ignore[arg-type]
        assert caught.value.field == field


def test_a_joint_that_does_not_move_needs_no_limits(robot: Robot, planned: Trajectory, free: Scene) -> None:
    """The rail is locked: a limit of 0."""
    free_rail = np.arange(robot.n) > 0
    locked = replace(
        robot,
        velocity_limit=robot.velocity_limit * free_rail,
        acceleration_limit=robot.acceleration_limit * free_rail,
    )
    plan = conftest.plan(locked, free)
    motion = retime(plan, locked, free)
    assert motion.certified
    assert np.ptp(motion.q[:, 0]) == 0.0
    assert (rates(motion, 1) <= locked.velocity_limit * EXCESS).all()
    assert (rates(motion, 2) <= locked.acceleration_limit * EXCESS).all()
    smooth = retime(plan, locked, free, jerk_limit=100.0)
    assert (rates(smooth, 3) <= 100.0 * EXCESS).all()
    assert smooth.duration < 1.5 * motion.duration
    with pytest.raises(InvalidInput, match=r"velocity_limit \(rail\)"):
        retime(straight(planned, locked, "rail", 1.0), locked, free)


def test_the_robot_s_jerk_limits_are_kept(robot: Robot, planned: Trajectory, free: Scene) -> None:
    """Those of a URDF, of some joints alone, unless others are given."""
    jerk = np.where(np.arange(robot.n) < 4, 60.0, np.inf)
    smooth = replace(robot, jerk_limit=jerk)
    motion = retime(planned, smooth, free)
    np.testing.assert_array_equal(motion.q, retime(planned, robot, free, jerk_limit=jerk).q)
    assert (rates(motion, 3) <= jerk * EXCESS).all()
    assert not (rates(retime(planned, smooth, free, jerk_limit=np.inf), 3) <= jerk * EXCESS).all()
    with pytest.raises(InvalidInput, match="jerk_limit"):
        retime(planned, replace(robot, jerk_limit=1e-9 * np.ones(robot.n)), free)
