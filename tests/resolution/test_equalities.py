"""Linear equalities A q_dot = b beside the constraints of the safe velocity."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from conftest import points, random_q

import humanoid_rail
from humanoid_rail import (
    Box,
    Gains,
    InvalidInput,
    Kinematics,
    NativeKinematics,
    Robot,
    Safety,
    SafeVelocity,
    Scene,
    State,
    Status,
)
from humanoid_rail.resolution.native_velocity import constrained_velocity
from humanoid_rail.resolution.qp import Equalities, safe_velocity


def still(joint: int) -> Any:
    """Return an equality that keeps a joint still."""

    def equality(state: State) -> tuple[np.ndarray, np.ndarray]:
        return np.eye(state.q.size)[[joint]], np.zeros(1)

    return equality


def test_an_equality_is_kept_all_along(robot: Robot) -> None:
    """The rail and the left elbow stay where they are; the hands get there all the same."""
    hands = Kinematics(robot).hand_positions(robot.initial)
    targets = dict(zip(robot.hand_names, map(tuple, (hands + np.array([-0.1, 0.1, 0.1])).tolist()), strict=True))
    scene = Scene(name="still", targets=targets)
    free = humanoid_rail.plan(robot, scene, SafeVelocity(dt=0.02))
    kept = humanoid_rail.plan(robot, scene, SafeVelocity(dt=0.02, equalities=[still(0), still(7)]))
    assert (free.status, kept.status) == (Status.REACHED, Status.REACHED)
    assert np.ptp(free.q[:, [0, 7]], axis=0).min() > 1e-3
    assert np.ptp(kept.q[:, [0, 7]], axis=0).max() < 1e-9
    assert kept.certified


def slanted(state: State) -> tuple[np.ndarray, np.ndarray]:
    """The left hand rises at 0.1 m/s, and the rail moves at 0.02 m/s."""
    return np.vstack([state.jacobian[2], np.eye(state.q.size)[0]]), np.array([0.1, 0.02])


def velocities(robot: Robot, scene: Scene, q: np.ndarray, safety: Safety) -> tuple[State, np.ndarray, np.ndarray]:
    """Return the state at a configuration and the safe velocity by Python and by C++."""
    tasks = points([scene.targets[name] for name in robot.hand_names])
    state = Kinematics(robot, scene.obstacles).state(q)
    by_python = safe_velocity(robot, state, tasks, Gains(), safety, 0.01)
    native = NativeKinematics(robot, scene.obstacles)
    return state, by_python, constrained_velocity(native, tasks, Gains(), safety, 0.01)(q)


def test_both_engines_keep_them(robot: Robot, scene: Scene, rng: np.random.Generator) -> None:
    """To 1e-9, by velocities that agree to 1e-8."""
    compared = 0
    while compared < 20:
        q = random_q(robot, rng)
        state, by_python, by_engine = velocities(robot, scene, q, Safety(equalities=[slanted]))
        if min(state.pieces.distance.min(), state.links.distance.min()) < 0.05 or not by_python.any():
            continue
        A, b = slanted(state)
        for velocity in (by_python, by_engine):
            np.testing.assert_allclose(A @ velocity, b, atol=1e-9)
        np.testing.assert_allclose(by_engine, by_python, atol=1e-8)
        compared += 1


def test_several_add_up(robot: Robot, scene: Scene) -> None:
    """Rows of one's own kind too, and none at all."""
    none = Equalities(np.zeros((0, robot.n)), np.zeros(0))
    safety = Safety(equalities=[slanted, lambda _: none, lambda state: Equalities(np.eye(state.q.size)[[7]], [0.03])])
    state, by_python, by_engine = velocities(robot, scene, robot.initial, safety)
    A, b = slanted(state)
    for velocity in (by_python, by_engine):
        np.testing.assert_allclose([*(A @ velocity), velocity[7]], [*b, 0.03], atol=1e-9)
    free = velocities(robot, scene, robot.initial, Safety(equalities=[lambda _: none]))
    plain = velocities(robot, scene, robot.initial, Safety())
    np.testing.assert_array_equal(free[1], plain[1])
    np.testing.assert_array_equal(free[2], plain[2])


@pytest.mark.parametrize("scale", [1e-170, 1e-9, 1.0, 1e9, 1e170])
def test_rows_of_any_length_mean_the_same(robot: Robot, scene: Scene, scale: float) -> None:
    def scaled(state: State) -> tuple[np.ndarray, np.ndarray]:
        return scale * np.eye(state.q.size)[[2]], np.array([scale * 0.05])

    for velocity in velocities(robot, scene, robot.initial, Safety(equalities=[scaled]))[1:]:
        assert velocity[2] == pytest.approx(0.05, abs=1e-9)


def test_rows_that_follow_from_others_change_nothing(robot: Robot, scene: Scene) -> None:
    """Twice the same, sums, rows of zeros, and in all more of them than joints."""

    def redundant(state: State) -> tuple[np.ndarray, np.ndarray]:
        A, b = slanted(state)
        mixed = np.random.default_rng(1).normal(size=(20, 2))
        return np.vstack([A, np.zeros((1, state.q.size)), mixed @ A]), np.concatenate([b, [0.0], mixed @ b])

    once = velocities(robot, scene, robot.initial, Safety(equalities=[slanted]))
    again = velocities(robot, scene, robot.initial, Safety(equalities=[slanted, slanted, redundant]))
    for one, other in zip(once[1:], again[1:], strict=True):
        assert one.any()
        np.testing.assert_allclose(other, one, atol=1e-9)


@pytest.mark.parametrize(
    ("rows", "sides"), [(np.eye(12)[[1, 1]], [0.0, 1.0]), (np.zeros((1, 12)), [1.0]), (np.eye(12)[[1]], [0.2])]
)
def test_contradictions_are_named(robot: Robot, scene: Scene, rows: np.ndarray, sides: list[float]) -> None:
    method = SafeVelocity(equalities=[still(1), lambda _: (rows, np.array(sides))])
    with pytest.raises(InvalidInput, match=r"equalities\[1\]\(state\).*contradict"):
        humanoid_rail.plan(robot, scene, method)


def test_a_rate_is_kept_in_every_step(robot: Robot) -> None:
    """A step that would come too near is not slowed down, as that would break it: the motion ends, and says why."""
    hands = Kinematics(robot).hand_positions(robot.initial)
    targets = dict(zip(robot.hand_names, map(tuple, (hands + np.array([-1.0, 0.0, 0.5])).tolist()), strict=True))
    wall = Box(center=tuple((hands[1] + np.array([-0.3, 0.0, 0.2])).tolist()), size=(0.1, 2.0, 2.0))
    scene = Scene(name="wall", targets=targets, obstacles=(wall,))
    method = SafeVelocity(dt=0.1, equalities=[lambda state: (np.eye(state.q.size)[[1]], [-0.05])])
    motion = humanoid_rail.plan(robot, scene, method)
    assert motion.status is Status.STALLED
    assert "equalities" in motion.reason
    assert len(motion.t) > 5
    np.testing.assert_allclose(np.diff(motion.q[:, 1]) / np.diff(motion.t), -0.05, atol=1e-6)
    assert motion.certified


def test_what_cannot_be_kept_is_standing_still(robot: Robot, scene: Scene) -> None:
    """Faster than the rail is: no velocity satisfies that, and both engines return 0."""
    fast = Safety(equalities=[lambda state: (np.eye(state.q.size)[[0]], np.array([100.0]))])
    _, by_python, by_engine = velocities(robot, scene, robot.initial, fast)
    np.testing.assert_array_equal(by_python, np.zeros(robot.n))
    np.testing.assert_array_equal(by_engine, np.zeros(robot.n))


@pytest.mark.parametrize(
    "answer",
    [
        None,
        3.0,
        np.zeros(12),
        "ab",
        (np.zeros((1, 11)), np.zeros(1)),
        (np.eye(12), np.zeros(3)),
        (np.zeros(12), np.zeros(1)),
        (np.zeros((1, 12)), 0.0),
        (np.full((1, 12), np.nan), np.zeros(1)),
        (np.zeros((1, 12)), np.array([np.inf])),
        (np.zeros((1, 12), complex), np.zeros(1)),
        ([["a"] * 12], [0.0]),
    ],
)
def test_what_is_no_equality_is_named(robot: Robot, scene: Scene, answer: Any) -> None:
    with pytest.raises(InvalidInput, match=r"A \(k, 12\) and b \(k,\), finite numbers") as caught:
        humanoid_rail.plan(robot, scene, SafeVelocity(equalities=[slanted, lambda state: answer]))
    assert caught.value.field == "equalities[1](state)"
    with pytest.raises(InvalidInput, match=r"equalities\[0\]"):
        velocities(robot, scene, robot.initial, Safety(equalities=[lambda state: answer]))


@pytest.mark.parametrize(
    ("equalities", "field"),
    [([3], "equalities[0]"), (slanted, "equalities"), ("ab", "equalities"), (None, "equalities")],
)
def test_what_is_no_function_is_named(equalities: Any, field: str) -> None:
    with pytest.raises(InvalidInput, match="State") as caught:
        SafeVelocity(equalities=equalities)
    assert caught.value.field == field


class Odd(Exception):
    """An error of the user's own."""


def test_errors_of_an_equality_come_through(robot: Robot, scene: Scene) -> None:
    error = Odd("of the equality")

    def broken(_state: State) -> Equalities:
        raise error

    with pytest.raises(Odd) as caught:
        humanoid_rail.plan(robot, scene, SafeVelocity(equalities=[broken]))
    assert caught.value is error
    error.__traceback__ = None  # it would keep what called back alive, and that keeps `broken`
