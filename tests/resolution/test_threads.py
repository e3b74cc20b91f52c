"""Threads that share a robot among obstacles: they get what one thread gets, and nothing waits for itself."""

from __future__ import annotations

import sys
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from conftest import AHEAD, KINEMATICS, plan, points, random_q

from humanoid_rail import Gains, NativeKinematics, PointTask, Robot, Safety, Scene, Sphere, State
from humanoid_rail.collision.edge_checker import EdgeChecker
from humanoid_rail.kinematics.inverse_kinematics import InverseKinematics
from humanoid_rail.resolution.integrate import Integration, Settings, integrate
from humanoid_rail.resolution.native_velocity import constrained_velocity, integrate_natively, projected_velocity
from humanoid_rail.resolution.rollout import rollout

TASKS = points(np.array([AHEAD["left"], AHEAD["right"]]))
SETTINGS = Settings(tolerance=0.01, dt=0.05, max_time=0.5, rtol=1e-6, atol=1e-6)
MOST = 1000
"""The most tries until another thread has had its turn."""


def uphill(state: State) -> np.ndarray:
    return 0.3 * state.manipulability_gradient + np.eye(state.q.size)[0]


def starts(robot: Robot, count: int) -> list[np.ndarray]:
    return [robot.initial + 0.02 * i * np.eye(robot.n)[0] for i in range(count)]


def at_once(work: Callable[[int], list[np.ndarray]], threads: int = 2) -> list[list[np.ndarray]]:
    """Return what a function returns in each of some threads that begin together."""
    gate = threading.Barrier(threads)

    def begin(i: int) -> list[np.ndarray]:
        gate.wait()
        return work(i)

    with ThreadPoolExecutor(threads) as pool:
        return list(pool.map(begin, range(threads)))


def test_the_interpreter_goes_on_while_the_engine_computes(robot: Robot, scene: Scene) -> None:
    """Another thread gets its turn although nobody would take it from this one: the engine lets go by itself."""
    native, path, turns = NativeKinematics(robot, scene.obstacles), np.tile(robot.initial, (1000, 1)), list[int]()
    ready, gate = threading.Event(), threading.Lock()

    def wait_for_turn() -> None:
        ready.set()
        with gate:
            turns.append(1)

    interval = sys.getswitchinterval()
    gate.acquire()
    other = threading.Thread(target=wait_for_turn)
    other.start()
    ready.wait()
    sys.setswitchinterval(1000.0)
    try:
        gate.release()
        tries = next((i for i in range(MOST) if native.along(path) and turns), None)
    finally:
        sys.setswitchinterval(interval)
    other.join()
    assert tries is not None


def test_plans_in_threads_are_those_of_one(robot: Robot, scene: Scene) -> None:
    expected = plan(robot, scene, "gradient-projection").q
    for (found,) in at_once(lambda _: [plan(robot, scene, "gradient-projection").q], threads=8):
        np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("objectives", [(), (uphill,)], ids=["native", "called back"])
def test_two_threads_move_one_robot(robot: Robot, scene: Scene, objectives: tuple[object, ...]) -> None:
    """A hundred motions each, by eq. 4.9 and by the program in turn."""
    shared, gains = NativeKinematics(robot, scene.obstacles), Gains(objectives=objectives)
    begins = starts(robot, 10)

    def motion(i: int) -> Integration:
        start = begins[i % 10]
        if i // 10 % 2:
            return rollout(shared, start, TASKS, gains, Safety(), SETTINGS)
        return integrate_natively(shared, start, TASKS, gains, SETTINGS)

    serial = [motion(i).q for i in range(20)]
    for thread, found in enumerate(at_once(lambda thread: [motion(i + 7 * thread).q for i in range(100)])):
        assert len(found) == 100
        for i, q in enumerate(found):
            np.testing.assert_array_equal(q, serial[(i + 7 * thread) % 20])


def test_two_threads_share_the_python_kinematics(robot: Robot, scene: Scene) -> None:
    shared, begins = KINEMATICS["python"](robot, scene.obstacles), starts(robot, 4)
    serial = [integrate(shared, start, TASKS, Gains(), SETTINGS).q for start in begins]
    found = at_once(lambda i: [integrate(shared, start, TASKS, Gains(), SETTINGS).q for start in begins[2 * i :][:2]])
    for q, expected in zip([*found[0], *found[1]], serial, strict=True):
        np.testing.assert_array_equal(q, expected)


@pytest.mark.parametrize("kind", ["native", "python"])
def test_threads_measure_one_robot(robot: Robot, scene: Scene, kind: str) -> None:
    shared = KINEMATICS[kind](robot, scene.obstacles)
    paths = [np.linspace(robot.initial, random_q(robot, np.random.default_rng(i)), 8) for i in range(4)]
    serial = [shared.along(path) for path in paths]

    def work(i: int) -> list[np.ndarray]:
        return [value for _ in range(100 if kind == "native" else 10) for value in shared.along(paths[i])]

    for i, found in enumerate(at_once(work, threads=4)):
        for k, value in enumerate(found):
            np.testing.assert_array_equal(value, serial[i][k % 3])


def test_threads_share_a_solver_and_a_checker(robot: Robot, scene: Scene) -> None:
    """Each with targets of its own: one thread's tasks never answer another's question."""
    solver, checker = InverseKinematics(robot, scene.obstacles), EdgeChecker(robot, scene.obstacles, 0.01)
    tasks = [points(np.array([AHEAD["left"], AHEAD["right"]]) + 0.05 * i) for i in range(4)]

    def work(i: int) -> list[np.ndarray]:
        postures = [solver.solve(robot.initial, tasks[i], 0.01).q for _ in range(50)]
        return [*postures, np.array([checker.is_edge_valid(robot.initial, q) for q in postures])]

    serial = [work(i) for i in range(4)]
    for expected, found in zip(serial, at_once(work, threads=4), strict=True):
        for a, b in zip(found, expected, strict=True):
            np.testing.assert_array_equal(a, b)


class Entangled:
    """A task that asks the robot which asks it."""

    rows = 3

    def __init__(self, native: NativeKinematics) -> None:
        self._native, self._task = native, PointTask("left", AHEAD["left"])

    def error(self, state: State) -> np.ndarray:
        return self._task.error(self._native.state(state.q))

    def jacobian(self, state: State) -> np.ndarray:
        return self._task.jacobian(state)

    def drift(self, state: State, velocity: np.ndarray) -> np.ndarray:
        return self._task.drift(state, velocity)


def test_what_is_called_back_must_not_use_what_calls_it(robot: Robot, scene: Scene) -> None:
    """An objective, an equality and a task are told instead of waiting for themselves for ever."""
    native = NativeKinematics(robot, scene.obstacles)
    objective = Gains(objectives=(lambda state: native.state(state.q).manipulability_gradient,))
    equality = Safety(equalities=[lambda state: (native.state(state.q).jacobian[:1], np.zeros(1))])
    for ask in (
        lambda: projected_velocity(native, TASKS, objective)(robot.initial),
        lambda: constrained_velocity(native, TASKS, objective, Safety(), 0.01)(robot.initial),
        lambda: constrained_velocity(native, TASKS, Gains(), equality, 0.01)(robot.initial),
        lambda: projected_velocity(native, [Entangled(native)], Gains())(robot.initial),
        lambda: integrate_natively(native, robot.initial, TASKS, objective, SETTINGS),
        lambda: rollout(native, robot.initial, TASKS, objective, Safety(), SETTINGS),
    ):
        with pytest.raises(RuntimeError, match="must not use the object that calls it"):
            ask()
    # It can be used again, and another object may be asked meanwhile.
    other = NativeKinematics(robot, (Sphere(center=(3.0, 0.0, 3.0), radius=0.2),))
    asking = Gains(objectives=(lambda state: other.state(state.q).manipulability_gradient,))
    plain = projected_velocity(native, TASKS, Gains(c_mu=2.0))(robot.initial)
    np.testing.assert_allclose(projected_velocity(native, TASKS, asking)(robot.initial), plain, atol=1e-9)
