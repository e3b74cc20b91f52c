"""Secondary objectives of one's own: where they act, where they do not, and what is said of bad ones."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import assert_gradient, plan, points, random_q

from humanoid_rail import (
    Gains,
    InvalidInput,
    Kinematics,
    NativeKinematics,
    Robot,
    Safety,
    Scene,
    State,
    plan_case,
    read_trajectory,
    write_trajectory,
)
from humanoid_rail.paper.cases import closed_form_duration
from humanoid_rail.planning.options import ENGINES
from humanoid_rail.resolution.native_velocity import constrained_velocity, projected_velocity
from humanoid_rail.resolution.qp import safe_velocity
from humanoid_rail.resolution.velocity import gradient_projection, null_space_projector, secondary_velocity

Objective = Callable[[State], np.ndarray]


def off_centre(robot: Robot, q: np.ndarray) -> float:
    """Return how far the joints are from the middle of their ranges: 0 there, n with all of them at a limit."""
    return float(np.sum(((2 * q - robot.lower - robot.upper) / (robot.upper - robot.lower)) ** 2))


@pytest.fixture(scope="module")
def centring(robot: Robot) -> Objective:
    middle, width = (robot.lower + robot.upper) / 2, robot.upper - robot.lower

    def centring(state: State) -> np.ndarray:
        return -8 * (state.q - middle) / width**2

    return centring


def on_the_rail(state: State) -> np.ndarray:
    return np.eye(state.q.size)[0]


def ask(robot: Robot, scene: Scene, objective: object) -> None:
    plan(robot, scene, "gradient-projection", engine="python", dt=1.0, max_time=1.0, objectives=(objective,))


def test_the_example_is_the_gradient_of_what_it_raises(
    robot: Robot, rng: np.random.Generator, centring: Objective
) -> None:
    kinematics = Kinematics(robot)
    for _ in range(10):
        q = random_q(robot, rng)
        assert_gradient(lambda q: -off_centre(robot, q), centring(kinematics.state(q)), q)


def test_an_objective_moves_the_null_space_alone(
    robot: Robot, scene: Scene, rng: np.random.Generator, centring: Objective
) -> None:
    kinematics, targets = Kinematics(robot, scene.obstacles), points(np.array(list(scene.targets.values())))
    for _ in range(20):
        state = kinematics.state(random_q(robot, rng))
        without = gradient_projection(state, targets, Gains())
        added = gradient_projection(state, targets, Gains(objectives=(centring,))) - without
        assert np.linalg.norm(added) > 1e-3
        np.testing.assert_allclose(state.jacobian @ added, 0.0, atol=1e-9)
        np.testing.assert_allclose(added, null_space_projector(state.jacobian) @ centring(state), atol=1e-9)


def test_objectives_add_up(robot: Robot, scene: Scene, centring: Objective) -> None:
    state = Kinematics(robot, scene.obstacles).state(robot.initial)
    found = secondary_velocity(state, Gains(objectives=[centring, on_the_rail, on_the_rail]))
    expected = secondary_velocity(state, Gains()) + centring(state) + 2 * np.eye(robot.n)[0]
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_the_hands_of_case_3_do_not_notice_one(robot: Robot, scene: Scene, centring: Objective) -> None:
    """e(t) = e(0) exp(-t) all the way, and the joints end nearer to the middle of their ranges than without."""
    settings: dict[str, Any] = {"engine": "python", "dt": 0.05}
    without, trajectory = plan_case(robot, 3, **settings), plan_case(robot, 3, objectives=(centring,), **settings)
    assert trajectory.duration == pytest.approx(closed_form_duration(robot, scene), abs=1e-3)
    e = trajectory.hands - np.array([scene.targets[name] for name in robot.hand_names])
    np.testing.assert_allclose(e, e[0] * np.exp(-trajectory.t)[:, None, None], atol=1e-4)
    assert off_centre(robot, trajectory.q[-1]) < off_centre(robot, without.q[-1]) - 0.1


def test_qp_stays_certified_whatever_is_asked_for(robot: Robot, scene: Scene, centring: Objective) -> None:
    settings: dict[str, Any] = {"dt": 0.05, "max_time": 10.0}
    without = plan(robot, scene, "qp", **settings)
    for objective in (centring, lambda state: -20.0 * state.clearance_gradient[-1].sum(axis=0)):
        trajectory = plan(robot, scene, "qp", objectives=(objective,), **settings)
        assert trajectory.certified
        assert trajectory.limits_ok
        assert trajectory.clearance_bound is not None
        assert trajectory.clearance_bound > 0.01 - 1e-5
        assert abs(trajectory.configuration(1.0) - without.configuration(1.0)).max() > 0.01


def test_the_names_are_kept(robot: Robot, scene: Scene, centring: Objective, tmp_path: Path) -> None:
    objectives = (centring, partial(on_the_rail))
    trajectory = plan(robot, scene, "qp", dt=0.5, max_time=0.5, objectives=objectives)
    write_trajectory(trajectory, tmp_path)
    assert trajectory.method.options()["objectives"] == ["centring", "partial"]
    assert json.loads((tmp_path / "summary.json").read_text())["method"]["objectives"] == ["centring", "partial"]
    # Functions cannot be read back.
    assert read_trajectory(tmp_path).method.options()["objectives"] == []


@pytest.mark.parametrize(
    "answer",
    [
        0.0,
        np.zeros(11),
        np.zeros((1, 12)),
        np.full(12, np.nan),
        [*(11 * [0.0]), np.inf],
        np.zeros(12, complex),
        12 * ["fast"],
        [[0.0], 11 * [0.0]],
        None,
    ],
)
def test_an_answer_that_is_no_velocity_is_named(robot: Robot, scene: Scene, answer: Any) -> None:
    def strange(_state: State) -> Any:
        return answer

    with pytest.raises(InvalidInput, match="12 finite numbers from strange") as caught:
        ask(robot, scene, strange)
    assert caught.value.field == "objectives[0](state)"
    assert caught.value.value is answer


def test_whole_numbers_and_lists_are_velocities(robot: Robot, scene: Scene) -> None:
    state = Kinematics(robot, scene.obstacles).state(robot.initial)
    for answer in (np.eye(robot.n, dtype=int)[0], [1.0, *((robot.n - 1) * [0.0])]):
        found = secondary_velocity(state, Gains(objectives=(lambda _state, answer=answer: answer,)))
        np.testing.assert_array_equal(found, secondary_velocity(state, Gains(objectives=(on_the_rail,))))


@pytest.mark.parametrize(
    ("objectives", "field"),
    [
        (on_the_rail, "objectives"),
        ("centring", "objectives"),
        (None, "objectives"),
        ((on_the_rail, 1.0), "objectives[1]"),
        (("centring",), "objectives[0]"),
    ],
)
def test_what_is_no_objective_is_named(robot: Robot, scene: Scene, objectives: Any, field: str) -> None:
    with pytest.raises(InvalidInput, match="State") as caught:
        plan(robot, scene, "qp", objectives=objectives)
    assert caught.value.field == field


METHODS = ("auto", "qp", "gradient-projection")


def test_both_engines_ask_them(robot: Robot, scene: Scene, centring: Objective) -> None:
    """The same motion by eq. 4.9, and the same velocity at any configuration."""
    settings: dict[str, Any] = {"dt": 0.05, "rtol": 1e-9, "atol": 1e-9, "max_time": 2.0, "objectives": (centring,)}
    one, two = (plan(robot, scene, "gradient-projection", engine=engine, **settings) for engine in ENGINES)
    np.testing.assert_allclose(one.q, two.q, atol=1e-6)
    asked = Gains(objectives=(centring, on_the_rail))
    native, tasks = NativeKinematics(robot, scene.obstacles), points(np.array(list(scene.targets.values())))
    for q in one.q[::10]:
        state = Kinematics(robot, scene.obstacles).state(q)
        expected = gradient_projection(state, tasks, asked)
        np.testing.assert_allclose(projected_velocity(native, tasks, asked)(q), expected, rtol=1e-7, atol=1e-9)
        expected = safe_velocity(robot, state, tasks, asked, Safety(), 0.01)
        found = constrained_velocity(native, tasks, asked, Safety(), 0.01)(q)
        np.testing.assert_allclose(found, expected, atol=2e-6)


def test_auto_asks_them_too(robot: Robot, scene: Scene) -> None:
    asked: list[State] = []

    def listening(state: State) -> np.ndarray:
        asked.append(state)
        return np.zeros(state.q.size)

    trajectory = plan(robot, scene, "auto", objectives=(listening,))
    silent = plan(robot, scene, "auto", objectives=(lambda state: np.zeros(state.q.size),))
    np.testing.assert_array_equal(trajectory.q, silent.q)
    assert len(asked) >= trajectory.evaluations > 0


@pytest.mark.parametrize("method", METHODS)
def test_errors_of_an_objective_come_through_from_every_method(robot: Robot, scene: Scene, method: str) -> None:
    def broken(_state: State) -> np.ndarray:
        raise ZeroDivisionError("of the objective")

    with pytest.raises(ZeroDivisionError, match="of the objective"):
        plan(robot, scene, method, objectives=(broken,))


def test_an_objective_that_uses_what_calls_it_is_told(robot: Robot, scene: Scene) -> None:
    """Instead of waiting for itself for ever."""
    native = NativeKinematics(robot, scene.obstacles)
    tasks = points(np.array(list(scene.targets.values())))

    def entangled(state: State) -> np.ndarray:
        return native.state(state.q).manipulability_gradient

    with pytest.raises(RuntimeError, match="must not use the object that calls it"):
        projected_velocity(native, tasks, Gains(objectives=(entangled,)))(robot.initial)


def test_an_objective_cannot_change_the_state(robot: Robot, scene: Scene) -> None:
    def careless(state: State) -> np.ndarray:
        values = state.q
        values -= 1.0
        return values

    with pytest.raises(ValueError, match="read-only"):
        ask(robot, scene, careless)


def test_errors_of_an_objective_come_through(robot: Robot, scene: Scene) -> None:
    def broken(_state: State) -> np.ndarray:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        ask(robot, scene, broken)
