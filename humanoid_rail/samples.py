"""What is true of a robot at each sample of a motion. It is computed when it is first asked for."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from humanoid_rail._arrays import Array
from humanoid_rail._native import why_no_engine
from humanoid_rail.kinematics.kinematics import Kinematics
from humanoid_rail.kinematics.native_kinematics import NativeKinematics
from humanoid_rail.kinematics.state import Course
from humanoid_rail.model.robot import Robot
from humanoid_rail.result import Method
from humanoid_rail.scene.obstacles import Obstacle


@dataclass(frozen=True, eq=False)
class Samples:
    """What is true of the robot at each sample. N samples, h hands, O obstacles.

    It is computed once, when it is first asked for by any thread, or when it is pickled.
    """

    hand_names: tuple[str, ...]
    """The second axis of hands."""
    _compute: Callable[[], Course] = field(repr=False)
    robot: Robot | None = field(default=None, repr=False)
    """The robot that they are computed for; None where they are known without it."""
    _computed: list[Course] = field(default_factory=list, init=False, repr=False)
    _lock: threading.Lock = field(default_factory=threading.Lock, init=False, repr=False)

    @property
    def course(self) -> Course:
        """All of it."""
        with self._lock:
            if not self._computed:
                course = self._compute()
                for array in course:
                    array.flags.writeable = False
                self._computed.append(course)
            return self._computed[0]

    @property
    def hands(self) -> Array:
        """Positions of the hands (N, h, 3), m, in the base frame."""
        return self.course.hands

    @property
    def clearance(self) -> Array:
        """Signed distance of the nearest link from each obstacle (N, O), m.

        Infinite where it is beyond the activation distance and was not asked for (`far_clearances`); the smallest of
        each sample is always there.
        """
        return self.course.clearance

    @property
    def manipulability(self) -> Array:
        """Mu of eq. 3.4 (N,)."""
        return self.course.manipulability

    def __reduce__(self) -> tuple[Any, ...]:
        return known_samples, (self.hand_names, self.course)


def known_samples(hand_names: tuple[str, ...], course: Course) -> Samples:
    """Return samples that are known already."""
    return Samples(hand_names, lambda: course)


def samples_along(
    robot: Robot, obstacles: tuple[Obstacle, ...], t: Array, q: Array, method: Method, engine: str = "native"
) -> Samples:
    """Return the samples of a motion.

    Args:
        robot: The robot, with all its hands.
        obstacles: The obstacles; those that move start at t = 0.
        t: Times (N,), s.
        q: Configurations (N, n), m and rad.
        method: What planned the motion: it says up to where clearances are measured.
        engine: What computes them, `native` or `python`, which also stands in where there is no native engine.
    """
    horizon = np.inf if method.far_clearances else method.epsilon

    def compute() -> Course:
        # An object of their own: whoever asks waits for no plan, and may ask in the midst of one.
        kinematics = Kinematics if engine == "python" or why_no_engine() else NativeKinematics
        return kinematics(robot, obstacles).along(q, horizon, t)

    return Samples(robot.hand_names, compute, robot)


def interleaved(own: NDArray[np.bool_], before: Samples, between: Samples) -> Samples:
    """Return the samples of a motion that had some of them (N,) before, and has others between them."""

    def rows(old: Array, new: Array) -> Array:
        merged = np.empty((len(own), *old.shape[1:]))
        merged[own], merged[~own] = old, new
        return merged

    def compute() -> Course:
        if own.all():
            return before.course
        return Course(*(rows(*pair) for pair in zip(before.course, between.course, strict=True)))

    return Samples(before.hand_names, compute, before.robot)
