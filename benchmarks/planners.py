"""The methods that are compared, behind one interface: this package's, Pink and what a textbook has."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from importlib.util import find_spec
from typing import NamedTuple

from humanoid_rail._arrays import Array
from humanoid_rail.collision.certificate import Certificate
from humanoid_rail.errors import InvalidInput
from humanoid_rail.kinematics.joint_limits import Violation, limit_violations, sampled
from humanoid_rail.kinematics.path_metric import PathQuality
from humanoid_rail.model.robot import Robot
from humanoid_rail.planning.methods import METHODS
from humanoid_rail.planning.planner import plan
from humanoid_rail.planning.verification import verify
from humanoid_rail.resolution.native_options import PROGRESS_TIME
from humanoid_rail.resolution.qp import Safety
from humanoid_rail.scene.scene import Scene

PINK = "pink"
"""The method of `pink_baseline.py`."""
RRT_CONNECT = "ik + rrt-connect"
"""The method of `rrt_connect_baseline.py`."""
EVERY = (*METHODS, PINK, RRT_CONNECT)
"""All methods."""
NOTHING_PROVEN = Certificate(False, None, None, None, None)
"""This is known of a motion that could not be looked at."""
FAILED = "failed"
"""The status where there is no plan: the start touches something, or Pink has no next step."""


class Motion(NamedTuple):
    """A motion by any method, and what is known of it."""

    t: Array
    """Times (N,), s."""
    q: Array
    """Configurations (N, n), m and rad."""
    status: str
    """A :class:`humanoid_rail.Status`, or `failed`."""
    reason: str
    """The status in a sentence."""
    certificate: Certificate
    violations: tuple[Violation, ...]
    planning_time: float
    """Time that planning took, the certificate included, s."""
    sampled: PathQuality | None = None
    """The path as a sampling planner found it first."""


Planner = Callable[[Robot, Scene], Motion]


def make_planner(method: str) -> Planner:
    """Return what plans by a method.

    Raises:
        InvalidInput: If there is no such method, or it is not installed.
    """
    if method not in EVERY:
        raise InvalidInput("method", method, f"one of {', '.join(EVERY)}")
    if method == PINK:
        if find_spec("pink") is None:
            raise InvalidInput("method", method, "an installed one; for Pink: pip install 'humanoid_rail[compare]'")
        return plan_by_pink
    if method == RRT_CONNECT:
        return plan_by_rrt_connect
    return partial(plan_by_planner, method=method)


def plan_by_planner(robot: Robot, scene: Scene, method: str) -> Motion:
    """Plan by a method of this package."""
    found = plan(robot, scene, method)
    assert found.certificate is not None  # there is an engine
    return Motion(
        found.t,
        found.q,
        found.status,
        found.reason,
        found.certificate,
        found.violations,
        found.planning_time,
        found.search.raw if found.search else None,
    )


def plan_by_pink(robot: Robot, scene: Scene) -> Motion:
    """Roll out Pink within the limits, as far from everything as `qp` keeps, and give up where `qp` does."""
    from benchmarks.pink_baseline import Pink

    started = time.perf_counter()
    found = Pink(robot, scene, safety_distance=Safety().safety_distance).rollout(patience=PROGRESS_TIME)
    certificate = verify(robot, scene, found)
    violations = limit_violations(robot, sampled(found.t, found.q))
    planning_time = time.perf_counter() - started
    return Motion(found.t, found.q, found.status, found.reason, certificate, violations, planning_time)


def plan_by_rrt_connect(robot: Robot, scene: Scene) -> Motion:
    """Plan by inverse kinematics and RRT-Connect as they come."""
    from benchmarks.rrt_connect_baseline import plan_by_rrt_connect

    started = time.perf_counter()
    found = plan_by_rrt_connect(robot, scene)
    certificate = verify(robot, scene, found)
    violations = limit_violations(robot, sampled(found.t, found.q))
    planning_time = time.perf_counter() - started
    return Motion(found.t, found.q, found.status, found.reason, certificate, violations, planning_time, found.sampled)
