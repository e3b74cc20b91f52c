"""Threads in the engine: they outlive the interpreter without harm, and do not wait for one another for ever."""

from __future__ import annotations

import subprocess
import sys
import textwrap
import threading
from typing import Any

import numpy as np

from humanoid_rail import PointTask, Problem, Robot, Scene, State, solve

EMPTY = Scene(name="empty", targets={"left": None, "right": None})


def test_a_process_ends_well_while_its_threads_plan() -> None:
    """Also where they are in a function that the engine calls back."""
    code = """
        import itertools, threading, time
        import numpy as np
        from humanoid_rail import SafeVelocity, load_robot, paper_scene, plan

        robot, scene, started = load_robot(), paper_scene(), threading.Event()

        def objective(state):
            started.set()
            return np.zeros(state.q.size)

        def work(method):
            for _ in itertools.count():
                plan(robot, scene, method)

        for method in (SafeVelocity(), SafeVelocity(objectives=[objective]), SafeVelocity(objectives=[objective])):
            threading.Thread(target=work, args=(method,), daemon=True).start()
        started.wait()
    """
    for _ in range(2):
        done = subprocess.run(
            [sys.executable, "-c", textwrap.dedent(code)], capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr
        assert not done.stderr


class UsesAnother(PointTask):
    """A task that asks the problem of another thread, whose task asks this one's."""

    def error(self, state: State) -> np.ndarray:
        self.other.native.measure(state.q)  # type: ignore[attr-defined]
        return super().error(state)


def test_threads_that_wait_for_one_another_are_told(robot: Robot) -> None:
    tasks = [UsesAnother("left", (-1.8, 2.0, 3.0)) for _ in range(2)]
    problems = [Problem(robot, EMPTY, [task], robot.initial) for task in tasks]
    for task, other in zip(tasks, reversed(problems), strict=True):
        object.__setattr__(task, "other", other)
    outcomes: list[Any] = []

    def run(problem: Problem) -> None:
        try:
            outcomes.append(solve(problem, "qp"))
        except RuntimeError as error:
            outcomes.append(error)

    threads = [threading.Thread(target=run, args=(problem,)) for problem in problems]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(outcomes) == 2
    errors = [outcome for outcome in outcomes if isinstance(outcome, RuntimeError)]
    assert all("wait for one another" in str(error) for error in errors)
