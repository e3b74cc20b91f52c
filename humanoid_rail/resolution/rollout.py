"""Moves by the safe velocity, step by step, each step proven free of contact before it is made.

This is the reference; `engine/rollout.cpp` has the same in C++.

The velocity of `safety.py` is held for dt, as by the controller of a robot: the motion is linear in q between its
samples, and what is proven of it is proven of the very motion that a robot makes.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from enum import Enum
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from humanoid_rail._arrays import Array
from humanoid_rail.collision.certificate import Contact
from humanoid_rail.collision.certifier import CONTACT, certify
from humanoid_rail.resolution.integrate import PATIENCE, Integration, Settings, explain, is_held_by_singularity
from humanoid_rail.kinematics.kinematics import Kinematics, State
from humanoid_rail.kinematics.joint_limits import Motion
from humanoid_rail.scene.obstacles import at_rest
from humanoid_rail.resolution.velocity import Gains
from humanoid_rail.resolution.qp import Safety, safe_velocity
from humanoid_rail.collision.swept_distance import Nearest, Pair, Snapshot, Sweep
from humanoid_rail.trajectory import Status

HALVINGS = 6
"""How often a step that is not safe is halved before the robot stands still."""
APART = 2 * CONTACT
"""What a step has to keep between all pairs on its way, m: twice what coal's distances are precise to."""
SHORTEST = 1e-3
"""The shortest last step, as a share of one: a shorter one would have a speed of rounding errors."""
ROUNDING = 1e-9
"""What rounding may take from a distance in a step, m."""
PROGRESS = 0.01
"""Of |e|: less than this is no progress, ..."""
PROGRESS_TIME = 2.0
"""... and so long without any a motion among obstacles at rest has stalled, in time constants 1 / min(K)."""


class _Step(Enum):
    SAFE = "safe"
    FREE = "free"
    """Free of contact, but a pair has come nearer than the safety distance."""
    BLOCKED = "blocked"


class _Place(NamedTuple):
    """A robot at the end of a step."""

    state: State
    snapshot: Snapshot
    nearest: Sequence[Nearest]
    """Of all pairs."""


def rollout(
    kinematics: Kinematics, start: Array, targets: Array, gains: Gains, safety: Safety, settings: Settings
) -> Integration:
    """Move from the start until |e| falls to the tolerance or nothing more can come of it.

    Args:
        kinematics: The robot among its obstacles.
        start: Configuration (n,) at t = 0.
        targets: x_f (h, 3), m.
        gains: Parameters of eq. 4.9.
        safety: Parameters of the constraints.
        settings: When to end, and how long a step is; the integrator's tolerances do not matter.
    """
    robot, obstacles = kinematics.robot, kinematics.obstacles
    moving = not at_rest(obstacles)
    walk = _Walk(kinematics, safety)
    K = gains.diagonal(targets.size)
    times, places = [0.0], [start]
    velocities: list[Array] = []
    here = walk.look(0.0, start)
    evaluations = 0

    def distance(q: Array) -> float:
        return float(np.linalg.norm(kinematics.hand_positions(q) - targets))

    def excess(q: Array, way: Array, share: float) -> float:
        return distance(q + share * way) - settings.tolerance

    def ended(status: Status, velocity: Array | None = None, contact: Contact | None = None) -> Integration:
        visited = [*velocities, np.zeros(start.size) if velocity is None else velocity]
        count = min(len(visited), len(places))
        reason = explain_step(status, times[-1], distance(places[-1]), evaluations, settings, contact)
        motion = Motion(np.array(times[:count]), np.array(places[:count]), np.array(visited[:count]))
        return Integration(np.array(times), np.array(places), status, reason, evaluations, motion)

    left = distance(start)
    if left <= settings.tolerance:
        return ended(Status.REACHED)
    best, best_t, singular_since = left, 0.0, np.inf
    began = time.perf_counter()
    while True:
        t, q = times[-1], places[-1]
        duration = min(settings.dt, settings.max_time - t)
        velocity = safe_velocity(robot, here.state, targets, gains, safety, settings.dt)
        evaluations += 1
        held = is_held_by_singularity(here.state, targets, settings.tolerance)
        singular_since = min(singular_since, t) if held else np.inf
        if t - singular_since > PATIENCE / K.min():
            return ended(Status.SINGULAR)
        # The largest step that is safe; with obstacles on the move at least one without contact.
        judged: list[tuple[_Step, float, Array, _Place]] = []
        for share in [*(0.5**i for i in range(HALVINGS + 1)), 0.0]:
            after = np.clip(q + share * duration * velocity, robot.lower, robot.upper)
            if not moving and np.array_equal(after, q):
                break
            there = walk.look(t + duration, after)
            judged.append((walk.judge(here, there), share, after, there))
            if judged[-1][0] is _Step.SAFE:
                break
        wanted = {_Step.SAFE, _Step.FREE} if moving else {_Step.SAFE}
        steps = sorted((step for step in judged if step[0] in wanted), key=lambda step: step[0] is not _Step.SAFE)
        if not steps:
            if not moving:
                return ended(Status.STALLED)
            # What fast obstacles do in a step may take a closer look to tell.
            still = certify(robot, obstacles, np.array([t, t + duration]), np.array([q, q]))
            if not still.certified:
                return ended(Status.OVERRUN, contact=still.contact)
            steps = [(_Step.FREE, 0.0, q, walk.look(t + duration, q))]
        _, share, after, there = steps[0]
        velocities.append(share * velocity)
        left = distance(after)
        if left <= settings.tolerance:
            s = max(_arrival(partial(excess, q, after - q)), SHORTEST)
            times.append(t + s * duration)
            places.append(q + s * (after - q))
            return ended(Status.REACHED)
        times.append(min(settings.dt * len(times), settings.max_time))
        places.append(after)
        here = there
        if left < (1.0 - PROGRESS) * best:
            best, best_t = left, times[-1]
        if not moving and times[-1] - best_t > PROGRESS_TIME / K.min():
            return ended(Status.STALLED)
        if times[-1] > settings.max_time - SHORTEST * settings.dt:
            return ended(Status.TIME_LIMIT)
        if time.perf_counter() - began > settings.max_planning_time:
            return ended(Status.STUCK)


def explain_step(
    status: Status, end: float, left: float, evaluations: int, settings: Settings, contact: Contact | None
) -> str:
    """Return a status in a sentence, with numbers.

    Args:
        status: What became of the targets.
        end: T, s.
        left: |e| there, m.
        evaluations: Number of steps.
        settings: Tolerance and longest motion.
        contact: What runs into the robot and when, if something does.
    """
    where = f"|e| is {left:.4g} m at t = {end:.4g} s"
    match status:
        case Status.STALLED:
            return f"{where}: no velocity that keeps clear and within the limits brings the hands nearer"
        case Status.STUCK:
            return f"{where}, and the time to plan is over"
        case Status.OVERRUN if contact is not None:
            return f"{where}, and even standing still {contact}"
        case Status.OVERRUN:
            return f"{where}, and neither a step nor standing still can be shown to be free of contact"
    return explain(status, end, left, evaluations, settings)


def _arrival(excess: Callable[[float], float]) -> float:
    """Return at which share of a step the distance has fallen to the tolerance."""
    return float(brentq(excess, 0.0, 1.0, xtol=1e-12)) if excess(1.0) < 0 else 1.0


class _Walk:
    """Steps of a robot among obstacles."""

    def __init__(self, kinematics: Kinematics, safety: Safety) -> None:
        self._kinematics, self._safety = kinematics, safety
        self._sweep = Sweep(kinematics.robot, kinematics.obstacles)
        self._pairs: list[Pair] = [*self._sweep.obstacle_pairs, *self._sweep.link_pairs]

    def look(self, t: float, q: Array) -> _Place:
        """Return the robot at a configuration (n,)."""
        snapshot = self._sweep.take(t, q)
        nearest = [self._sweep.measure(pair, snapshot) for pair in self._pairs]
        return _Place(self._kinematics.state(q, t), snapshot, nearest)

    def judge(self, a: _Place, b: _Place) -> _Step:
        """Return whether the way from a to b is free of contact and safe.

        It is safe if at its end no pair is below the safety distance or, where it was below already, nearer.
        """
        links, pairs = self._sweep.ways(a.snapshot.q, b.snapshot.q)
        step = _Step.SAFE
        for pair, here, there in zip(self._pairs, a.nearest, b.nearest, strict=True):
            ways, column = (pairs, pair.number) if pair.piece is None else (links, pair.link)
            travel = ways.travel[column] + self._sweep.speed(pair) * (b.snapshot.t - a.snapshot.t)
            way = travel, ways.curvature[column]
            if self._sweep.least(pair, here, a.snapshot, there, b.snapshot, *way, APART) < APART:
                return _Step.BLOCKED
            if there.distance < min(self._safety.safety_distance, here.distance) - ROUNDING:
                step = _Step.FREE
        return step
