"""Numbers that suit robots of other sizes, and are the paper's for the paper's robot."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from arms import long_arm
from conftest import assert_gradient, central_difference, plan, points

from humanoid_rail import DirectionTask, Gains, Kinematics, NativeKinematics, PointTask, Robot, Scene, load_robot
from humanoid_rail.io.trajectory_files import read_trajectory, write_trajectory
from humanoid_rail.kinematics.task import LEVER, orientation_lever
from humanoid_rail.model.scale import manipulability_gain, relative_reach
from humanoid_rail.resolution.native_velocity import projected_velocity
from humanoid_rail.resolution.velocity import (
    SINGULAR_VALUE,
    damping,
    gradient_projection,
    pseudoinverse,
    secondary_velocity,
    singular_value,
)


def test_for_the_papers_robot_nothing_changes(robot: Robot) -> None:
    assert manipulability_gain(robot) == 1.0
    assert relative_reach(robot) == 1.0
    assert singular_value(robot) == SINGULAR_VALUE
    assert [orientation_lever(robot, hand) for hand in robot.hand_names] == [LEVER, LEVER]
    assert Gains().c_mu_of(robot) == 1.0
    one = replace(robot, hands=robot.hands[:1])
    assert Gains().c_mu_of(one) == 1.0


def test_what_is_given_stays(robot: Robot) -> None:
    small = smaller(robot, 0.25)
    assert Gains(c_mu=0.7).c_mu_of(small) == 0.7
    assert DirectionTask("left", (1.0, 0.0, 0.0), lever=0.2).lever_of(small) == 0.2


def smaller(robot: Robot, scale: float) -> Robot:
    """Return a robot all of whose lengths are so many times as large; the rail is as long as before."""
    model = robot.model.copy()
    for joint in range(1, model.njoints):
        placement = model.jointPlacements[joint]
        placement.translation = scale * placement.translation
        model.jointPlacements[joint] = placement
    for i, frame in enumerate(model.frames):
        placement = frame.placement
        placement.translation = scale * placement.translation
        model.frames[i].placement = placement
    return replace(robot, model=model, self_collision_pairs=())


@pytest.mark.parametrize("scale", [0.125, 0.5, 4.0])
def test_manipulability_moves_robots_of_all_sizes_alike(robot: Robot, rng: np.random.Generator, scale: float) -> None:
    other = smaller(robot, scale)
    assert other.arm_reaches == pytest.approx([2.0 * scale] * 2)
    for _ in range(5):
        q = rng.uniform(robot.lower, robot.upper)
        expected = Gains().c_mu_of(robot) * Kinematics(robot).state(q).manipulability_gradient
        found = Gains().c_mu_of(other) * Kinematics(other).state(q).manipulability_gradient
        np.testing.assert_allclose(found[1:], expected[1:], atol=1e-9)  # the rail is not a joint of an arm
        # Both engines have the same numbers.
        hands = Kinematics(other).state(q).hands
        targets = points(hands + 0.1 * scale)
        native = projected_velocity(NativeKinematics(other), targets, Gains())(q)
        python = gradient_projection(Kinematics(other).state(q), targets, Gains())
        np.testing.assert_allclose(native, python, rtol=1e-6, atol=1e-6 * abs(python).max())


@pytest.mark.parametrize("scale", [0.125, 0.5, 4.0])
@pytest.mark.parametrize("bend", [0.0, 0.02, 0.1, 1.0])
def test_stretched_arms_of_all_sizes_move_alike(rng: np.random.Generator, scale: float, bend: float) -> None:
    """Without a rail J and errors scale as the arm does, so velocities are the same; next to a singularity as well."""
    arm = load_robot(long_arm(), hands={"hand": {"frame": "l5"}})
    other = smaller(arm, scale)
    q = bend * rng.uniform(0.5, 1.0, arm.n)
    state = Kinematics(arm).state(q)
    smallest = np.linalg.svd(state.jacobian, compute_uv=False)[-1]
    assert (smallest < singular_value(arm)) == (bend < 1.0)  # damped, or not
    step = np.array([0.3, 0.1, -0.05])
    near, far = (
        (PointTask("hand", Kinematics(r).state(q).hands[0] + k * step),) for r, k in ((arm, 1.0), (other, scale))
    )
    expected = gradient_projection(state, near, Gains())
    python = gradient_projection(Kinematics(other).state(q), far, Gains())
    native = projected_velocity(NativeKinematics(other), far, Gains())(q)
    np.testing.assert_allclose(python, expected, rtol=1e-6, atol=1e-8 * abs(expected).max())
    np.testing.assert_allclose(native, expected, rtol=1e-6, atol=1e-6 * abs(expected).max())
    if 0.0 < bend < 1.0:  # with the threshold of another size they would not
        error = scale * step
        assert not np.allclose(
            pseudoinverse(scale * state.jacobian, singular_value(arm)) @ error,
            pseudoinverse(state.jacobian, singular_value(arm)) @ step,
            rtol=1e-2,
        )


@pytest.mark.parametrize("scale", [0.125, 4.0])
def test_the_manipulability_of_other_sizes_is_climbed_along_its_gradient(
    robot: Robot, rng: np.random.Generator, Kinematics: type, scale: float
) -> None:
    """c_mu, that of the size, times mu: every column against central differences."""
    other = smaller(robot, scale)
    at, c_mu = Kinematics(other), (1.0 / scale) ** 6
    for _ in range(5):
        q = rng.uniform(robot.lower, robot.upper)
        slope = secondary_velocity(at.state(q), Gains(c_kappa=0.0))
        assert_gradient(lambda x: c_mu * at.measure(x).manipulability, slope, q)


@pytest.mark.parametrize("scale", [0.125, 1.0, 4.0])
@pytest.mark.parametrize("bend", [0.02, 0.1])
def test_damped_velocities_are_least_squares(rng: np.random.Generator, scale: float, bend: float) -> None:
    """Next to a singularity q_dot has the least |J q_dot + K e|^2 + lambda^2 |q_dot|^2, whatever the size."""
    arm = smaller(load_robot(long_arm(), hands={"hand": {"frame": "l5"}}), scale)
    q = bend * rng.uniform(0.5, 1.0, arm.n)
    state = Kinematics(arm).state(q)
    J, target = state.jacobian, state.hands[0] + scale * np.array([0.3, 0.1, -0.05])
    task, gains = (PointTask("hand", target),), Gains(gain=2.0, c_mu=0.0, c_kappa=0.0)
    factor = damping(np.linalg.svd(J, compute_uv=False)[-1], singular_value(arm))
    assert factor > 0.0

    def cost(velocity: np.ndarray) -> float:
        left = J @ velocity + 2.0 * (state.hands[0] - target)
        return float(left @ left + factor**2 * velocity @ velocity) / scale**2

    for found in (gradient_projection(state, task, gains), projected_velocity(NativeKinematics(arm), task, gains)(q)):
        assert abs(found).max() > 0.1
        np.testing.assert_allclose(central_difference(cost, found, 1e-4), 0.0, atol=1e-8)


def test_the_summary_says_what_was_used(tmp_path: Path, free: Scene) -> None:
    robot = load_robot()
    found = plan(robot, free, "gradient-projection", dt=0.05)
    assert found.summary()["c_mu"] == 1.0
    write_trajectory(found, tmp_path)
    back = read_trajectory(tmp_path)
    assert back.method == found.method
    assert back.summary()["c_mu"] == 1.0
