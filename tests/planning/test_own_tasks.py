"""Tasks as users write them: what they return is checked, and what comes of them is said truly."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from humanoid_rail import (
    Auto,
    ConfigurationTask,
    DirectionTask,
    GradientProjection,
    InvalidInput,
    Kinematics,
    NativeKinematics,
    PointTask,
    Problem,
    RelativeTask,
    Robot,
    SafeVelocity,
    Scene,
    State,
    Status,
    Task,
    solve,
)
from humanoid_rail.kinematics.task_stack import stack_error

EMPTY = Scene(name="empty", targets={"left": None, "right": None})
METHODS = [Auto(), SafeVelocity(dt=0.05), GradientProjection(dt=0.05), GradientProjection(dt=0.05, engine="python")]
IDS = ["auto", "qp", "gradient-projection", "in Python"]
POINT = PointTask("left", (-1.8, 2.0, 3.0))


@dataclass(eq=False)
class Returns:
    """A task that returns what it is given, by default what a point asks for."""

    rows: Any = 3
    error_of: Callable[[State], Any] = POINT.error
    jacobian_of: Callable[[State], Any] = POINT.jacobian

    def error(self, state: State) -> Any:
        return self.error_of(state)

    def jacobian(self, state: State) -> Any:
        return self.jacobian_of(state)

    def drift(self, state: State, velocity: np.ndarray) -> np.ndarray:
        return np.zeros(3)


def problem(robot: Robot, *tasks: Any) -> Problem:
    return Problem(robot, EMPTY, tasks, robot.initial)


WRONG: list[Any] = [None, 0.1, np.zeros(2), np.zeros((3, 1)), [0.0, np.nan, 0.0], ["0.5"] * 3, [0.1j] * 3]


@pytest.mark.parametrize("method", METHODS, ids=IDS)
def test_what_a_task_returns_is_checked_by_name(robot: Robot, method: Any) -> None:
    for value in WRONG:
        with pytest.raises(InvalidInput) as caught:
            solve(problem(robot, POINT, Returns(error_of=lambda _, value=value: value)), method)
        assert caught.value.field == "tasks[1].error(state)"
    for value in (None, np.zeros(12), np.zeros((3, 11)), np.full((3, 12), np.inf)):
        with pytest.raises(InvalidInput) as caught:
            solve(problem(robot, Returns(jacobian_of=lambda _, value=value: value)), method)
        assert caught.value.field == "tasks[0].jacobian(state)"


@pytest.mark.parametrize("rows", [-1, 0, True, 1.0, "1", None, 10**9])
def test_rows_are_a_whole_number(robot: Robot, rows: Any) -> None:
    with pytest.raises(InvalidInput) as caught:
        problem(robot, POINT, Returns(rows=rows))
    assert caught.value.field == "tasks[1].rows"


@pytest.mark.parametrize(
    ("task", "field"),
    [
        (PointTask("lft", (0.0, 0.0, 0.0)), "tasks[1].hand"),
        (DirectionTask("", (0.0, 0.0, 1.0)), "tasks[1].hand"),
        (RelativeTask("left", "rigth", (0.0, 0.0, 0.0)), "tasks[1].hand"),
        (ConfigurationTask(("rial",), (0.0,)), "tasks[1].joints"),
        (PointTask, "tasks[1]"),
        (3, "tasks[1]"),
    ],
)
def test_tasks_that_do_not_suit_the_robot_are_named(robot: Robot, task: Any, field: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        problem(robot, POINT, task)
    assert caught.value.field == field


@pytest.mark.parametrize(
    ("make", "field"),
    [
        (lambda: DirectionTask("left", (1e-200, 0.0, 0.0)), "direction"),
        (lambda: DirectionTask("left", (1e200, 0.0, 0.0)), "direction"),
        (lambda: DirectionTask("left", (1.0, 0.0, 0.0), pointing=(0.0, 0.0, 1e-9)), "pointing"),
        (lambda: PointTask("left", (1e308, 0.0, 0.0)), "target"),
        (lambda: PointTask("left", ("1", "2", "3")), "target"),  # type: ignore[arg-type]
        (lambda: ConfigurationTask("rail", (1.0,)), "joints"),  # type: ignore[arg-type]
        (lambda: ConfigurationTask(("rail",), 1.0), "target"),  # type: ignore[arg-type]
        (lambda: ConfigurationTask(("rail", "waist_yaw"), (1.0,)), "target"),
        (lambda: ConfigurationTask((3,), (1.0,)), "joints"),  # type: ignore[arg-type]
    ],
)
def test_vectors_and_joints_of_tasks_are_checked(make: Callable[[], Task], field: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        make()
    assert caught.value.field == field


def test_lists_become_tuples() -> None:
    task = ConfigurationTask(["rail"], [0.5])  # type: ignore[arg-type]
    assert task == ConfigurationTask(("rail",), (0.5,))
    assert hash(task) == hash(ConfigurationTask(("rail",), (0.5,)))


@dataclass(frozen=True)
class Place:
    """A dataclass that holds an array, which has no truth value when it is compared."""

    target: np.ndarray
    rows: int = 3

    def error(self, state: State) -> np.ndarray:
        return state.hands[0] - self.target

    def jacobian(self, state: State) -> np.ndarray:
        return state.jacobian[:3]

    def drift(self, state: State, velocity: np.ndarray) -> np.ndarray:
        return np.zeros(3)


@pytest.mark.parametrize("method", METHODS[:2], ids=IDS[:2])
def test_tasks_are_told_apart_by_identity(robot: Robot, method: Any) -> None:
    place = np.array([-1.8, 2.0, 3.0])
    reached = solve(problem(robot, Place(place), Place(place)), method)
    assert reached.status is Status.REACHED, reached.reason
    apart = solve(problem(robot, Place(place), Place(place + 0.3)), Auto())
    assert apart.status is Status.TARGET_OUT_OF_REACH
    assert "not all at once" in apart.reason


@pytest.mark.parametrize("method", METHODS, ids=IDS)
def test_a_direction_alone_is_reached(robot: Robot, method: Any) -> None:
    """One of its three rows always depends on the others, and is no singularity that holds the arm."""
    task = DirectionTask("left", (-1.0, 0.0, 0.0))
    motion = solve(problem(robot, task), method)
    assert motion.status is Status.REACHED, motion.reason
    assert np.linalg.norm(task.error(Kinematics(robot).state(motion.q[-1]))) <= 0.01 + 1e-9


def test_an_arm_that_is_stretched_is_still_said_to_be(robot: Robot) -> None:
    motion = solve(problem(robot, PointTask("left", (0.0, 0.0, 9.0))), GradientProjection(dt=0.05))
    assert motion.status is Status.SINGULAR, motion.reason


@pytest.mark.parametrize(
    ("tasks", "said"),
    [
        ((POINT, DirectionTask("left", (1.0, 0.0, 0.0))), "the left hand is"),
        ((POINT, PointTask("right", (-1.8, 3.0, 3.0)), DirectionTask("left", (1.0, 0.0, 0.0))), "the left hand is"),
        ((POINT, DirectionTask("left", (-1.0, 0.0, 0.0)), DirectionTask("left", (1.0, 0.0, 0.0))), "the left hand is"),
        ((POINT, PointTask("left", (-1.8, 2.3, 3.0))), "each task can be done, but not all at once"),
        (
            (PointTask("left", (-2.0, -1.0, 3.0)), PointTask("right", (-2.0, 9.0, 3.0))),
            "each target is in reach of its hand, but not both at once",
        ),
    ],
)
def test_what_cannot_be_reached_is_said_of_the_right_hand(robot: Robot, tasks: tuple[Task, ...], said: str) -> None:
    motion = solve(problem(robot, *tasks), Auto())
    assert motion.status is Status.TARGET_OUT_OF_REACH, motion.reason
    assert said in motion.reason
    if said.startswith("the left hand"):
        assert "deg from how it has to be turned" in motion.reason
        assert "right hand" not in motion.reason


class Rising:
    """A point that rises while the hand moves to it."""

    rows = 3

    def error(self, state: State) -> np.ndarray:
        return state.hands[0] - np.array([-1.8, 2.0, 3.0 + 0.1 * min(state.t, 3.0)])

    def jacobian(self, state: State) -> np.ndarray:
        return state.jacobian[:3]

    def drift(self, state: State, velocity: np.ndarray) -> np.ndarray:
        return np.zeros(3)


def test_tasks_that_depend_on_time(robot: Robot) -> None:
    """Both engines measure them at the time; auto, which looks for goals at t = 0, says that it missed."""
    native, by_python = (
        solve(problem(robot, Rising()), GradientProjection(dt=0.05, engine=engine)) for engine in ("native", "python")
    )
    assert native.status is by_python.status is Status.REACHED
    assert native.duration == pytest.approx(by_python.duration, abs=1e-4)
    end = NativeKinematics(robot).state(native.q[-1], native.duration)
    assert np.linalg.norm(stack_error(end, [Rising()])) <= 0.01 + 1e-6
    missed = solve(problem(robot, Rising()), Auto())
    assert missed.status is Status.STUCK
    assert "depend on time" in missed.reason


@pytest.mark.parametrize("make", [Kinematics, NativeKinematics])
def test_configurations_and_times_are_checked(robot: Robot, make: Any) -> None:
    kinematics = make(robot)
    for call in (kinematics.state, kinematics.measure):
        for q in (np.zeros(11), np.zeros((1, 12)), np.full(12, np.nan), "q"):
            with pytest.raises(InvalidInput, match=r"^q is"):
                call(q)
        with pytest.raises(InvalidInput, match=r"^t is"):
            call(robot.initial, t=np.nan)
    with pytest.raises(InvalidInput, match=r"^q is"):
        kinematics.along(robot.initial)
    with pytest.raises(InvalidInput, match=r"^t is"):
        kinematics.along([robot.initial], t=[np.nan])


@pytest.mark.parametrize("options", [{"tolerance": 1e-9}, {"max_planning_time": np.array([0.5, 0.5])}])
def test_auto_refuses_what_it_cannot_keep(options: dict[str, Any]) -> None:
    with pytest.raises(InvalidInput) as caught:
        Auto(**options)
    assert caught.value.field == next(iter(options))
