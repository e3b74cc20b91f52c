"""A follower keeps all limits, touches nothing while it moves, and has a stop that is what it says."""

from __future__ import annotations

import numpy as np
import pytest
from conftest import AHEAD
from hulls import hulled
from wandering import DT, SPEED, around, tell, wandering

from humanoid_rail import ConfigurationTask, Follower, FollowerStatus, Gains, Kinematics, Robot, Safety, Scene

ROBOTS = {"capsules": lambda robot: robot, "hulls": hulled}


@pytest.fixture(scope="module", params=ROBOTS)
def some_robot(request: pytest.FixtureRequest, robot: Robot) -> Robot:
    found: Robot = ROBOTS[request.param](robot)
    return found


@pytest.mark.parametrize("seed", [0, 1])
def test_limits_hold_and_nothing_touches_while_it_moves(some_robot: Robot, seed: int) -> None:
    """In every cycle; contact is looked for by the Python kinematics, at three moments of it."""
    robot, seen = some_robot, set[FollowerStatus]()
    q, v, moved = robot.initial, np.zeros(robot.n), 0.0
    for follower, state, there in wandering(robot, seed, 250):
        seen.add(state.status)
        assert state.jumped is None
        assert state.proven
        np.testing.assert_allclose(state.q, q + DT * state.velocity, atol=1e-12)
        assert (abs(state.velocity) <= robot.velocity_limit * (1 + 1e-9)).all()
        assert (abs(state.velocity - v) <= follower.acceleration_limit * DT * (1 + 1e-6) + 1e-12).all()
        assert (state.q >= robot.lower).all()
        assert (state.q <= robot.upper).all()
        assert (state.stop >= robot.lower - 1e-9).all()
        assert (state.stop <= robot.upper + 1e-9).all()
        if state.velocity.any():
            for share in (0.0, 0.5, 1.0):
                clear = Kinematics(robot, there).measure(q + share * DT * state.velocity)
                assert clear.clearance.min() > share * DT * SPEED  # obstacles get so far in that time
                assert clear.self_clearance.min() > 0.0
        moved += float(abs(state.q - q).max())
        q, v = state.q, state.velocity
    assert moved > 1.0
    assert seen >= {FollowerStatus.FOLLOWING, FollowerStatus.BRAKING}


def test_a_stop_is_what_it_says(some_robot: Robot) -> None:
    """Wherever it is told to, a robot brakes along the line that was proven, to where it was said, in the time said."""
    robot, tried = some_robot, 0
    for cycles in range(20, 200, 30):
        *_, (follower, state, there) = wandering(robot, cycles, cycles)
        if state.time_to_rest < 3 * DT:
            continue
        tried += 1
        promised, v, first = state, state.velocity, state
        for _ in range(round(promised.time_to_rest / DT)):
            assert state.velocity.any()
            tell(follower, there)
            q = state.q
            state = follower.step(brake=True)
            assert (abs(state.velocity - v) <= follower.acceleration_limit * DT * (1 + 1e-6) + 1e-12).all()
            left, whole = promised.stop - state.q, promised.stop - first.q
            np.testing.assert_allclose(left, (left @ whole) / (whole @ whole) * whole, atol=1e-9)
            np.testing.assert_allclose(state.stop, promised.stop, atol=1e-9)
            assert Kinematics(robot, there).measure(0.5 * (q + state.q)).clearance.min() > 0.0
            v = state.velocity
        assert not state.velocity.any()
        assert state.status is FollowerStatus.STOPPED or state.error <= 0.01
        np.testing.assert_allclose(state.q, promised.stop, atol=1e-9)
    assert tried >= 2


def test_the_safety_distance_is_kept_from_what_rests(robot: Robot, rng: np.random.Generator) -> None:
    for _ in range(3):
        obstacles = around(robot, rng)
        follower = Follower(robot, Scene(targets=AHEAD, obstacles=obstacles), dt=DT, safety=Safety(0.05))
        for _ in range(250):
            state = follower.step()
            assert Kinematics(robot, obstacles).measure(state.q).clearance.min() > 0.05 - 1e-6


def test_a_joint_speeds_up_as_its_limit_allows(robot: Robot) -> None:
    """Analytically: a dt more in each cycle until K e is less, then exponentially to the target."""
    follower = Follower(robot, Scene(targets=AHEAD), dt=DT, gains=Gains(c_mu=0.0), tolerance=1e-3)
    target = float(robot.initial[0]) + 0.3
    others = [name for name in robot.joint_names if name != "rail"]
    rest = [float(x) for name, x in zip(robot.joint_names, robot.initial, strict=True) if name != "rail"]
    follower.set_tasks([ConfigurationTask(("rail",), (target,)), ConfigurationTask(tuple(others), tuple(rest))])
    rail, expected, q = robot.joint_names.index("rail"), 0.0, float(robot.initial[0])
    assert rail == 0
    for _ in range(700):
        state = follower.step()
        expected = min(expected + DT * float(follower.acceleration_limit[0]), target - q, robot.velocity_limit[0])
        assert state.velocity[0] == pytest.approx(expected, abs=2e-6)
        q = float(state.q[0])
        expected = float(state.velocity[0])
        assert q < target
    assert state.status is FollowerStatus.REACHED
    assert "|e| is" in state.reason


def test_two_runs_are_the_same(some_robot: Robot) -> None:
    one, other = ([state for _, state, _ in wandering(some_robot, 5, 80)] for _ in range(2))
    for a, b in zip(one, other, strict=True):
        assert a.q.tobytes() == b.q.tobytes()
        assert a.velocity.tobytes() == b.velocity.tobytes()
        assert a.reason == b.reason


def test_out_of_reach_it_comes_to_rest(robot: Robot) -> None:
    """Stretched out, where small moves of the hands take large ones of the joints."""
    scene = Scene(targets={"left": (0.0, 2.0, 9.0), "right": (0.0, 2.2, 9.0)})
    follower = Follower(robot, scene, dt=0.002, gains=Gains(c_mu=0.0))
    speeds = []
    for _ in range(4000):
        state = follower.step()
        assert state.proven
        speeds.append(float((abs(state.velocity) / robot.velocity_limit).max()))
    assert max(speeds) > 0.3
    assert max(speeds[-100:]) < 0.05
    assert state.error > 1.0
