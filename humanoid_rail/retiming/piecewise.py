"""Retimed motions along which hands hold objects or something is kept: piece by piece, from one rest to the next."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.collision.certificate import Certificate
from humanoid_rail.collision.certifier import certify
from humanoid_rail.holding.phases import Phase, certify_motion, phases_of, sampled_motion
from humanoid_rail.kinematics.deviation_bounds import deviations
from humanoid_rail.kinematics.task import Task
from humanoid_rail.model.robot import Robot
from humanoid_rail.planning.kept import Kept, allowed_by, deviations_of
from humanoid_rail.planning.moves import moves_of
from humanoid_rail.resampling import SAME_TIME
from humanoid_rail.retiming.passing import Retimed
from humanoid_rail.scene.scene import Scene
from humanoid_rail.search.kept_path import FINE, on_constraints
from humanoid_rail.timing.time_optimal import Limits
from humanoid_rail.timing.timed_motion import TimedMotion, along_path, joined_motion, wanted_bound
from humanoid_rail.trajectory import Trajectory

WHY_REST = "something is held or kept along the motion"
"""Why a motion rests at targets that it was to pass."""


def rests_of(trajectory: Trajectory, kept: Sequence[Kept]) -> list[float]:
    """Return when a motion begins, rests and ends, s: at targets, where something happens, and where a move ends."""
    known = [0.0, *trajectory.motion.ends, *trajectory.arrivals, trajectory.duration]
    known += [event.t for event in trajectory.events]
    known += [bound for part in kept for bound in (part.begin, part.end)]
    rests = list[float]()
    for rest in sorted(known):
        if not rests or rest - rests[-1] > SAME_TIME:
            rests.append(rest)
    return rests


def along_pieces(
    trajectory: Trajectory,
    robot: Robot,
    scene: Scene,
    kept: Sequence[Kept],
    rests: Sequence[float],
    pieces: Sequence[Array],
    limits: Limits,
    dt: float,
    dwell: float,
) -> Retimed:
    """Return the motion that follows the pieces of a plan between its rests, each among what there is then.

    Args:
        trajectory: The plan.
        robot: The robot, without objects.
        scene: The scene.
        kept: What is kept, and when.
        rests: When the plan begins, rests and ends, s.
        pieces: Its paths (K, n) from one rest to the next, m and rad.
        limits: What joints can do.
        dt: Time between samples, s.
        dwell: How long to rest at each target before the next, s.
    """
    phases, motions, times = phases_of(robot, scene, trajectory.motion), list[TimedMotion](), [0.0]
    wanted = wanted_bound(trajectory.certificate, trajectory.method.kept_distance)
    waits = {_place(rests, arrival) for arrival in trajectory.arrivals} if dwell > 0.0 else set[int]()
    for number, (piece, (begin, end)) in enumerate(zip(pieces, pairwise(rests), strict=True), start=1):
        phase = next(phase for phase in phases if phase.end >= (begin + end) / 2.0)
        constraints = tuple(
            task for part in kept if part.begin < (begin + end) / 2.0 < part.end for task in part.constraints
        )
        motions.append(_piece(trajectory, phase, constraints, piece, limits, dt, wanted))
        times.append(times[-1] + motions[-1].duration)
        if number in waits and number < len(pieces):
            motions.append(_standing(phase, piece[-1], dwell))
            times[-1] += dwell
    return _joined(trajectory, robot, scene, kept, rests, times, waits, motions, dwell)


def _joined(
    trajectory: Trajectory,
    robot: Robot,
    scene: Scene,
    kept: Sequence[Kept],
    rests: Sequence[float],
    times: Sequence[float],
    waits: set[int],
    motions: Sequence[TimedMotion],
    dwell: float,
) -> Retimed:
    """Return the motions of the pieces as one, at whose rests it is at other times (R,), s, than the plan."""
    last = len(rests) - 1

    def at(rest: float) -> float:
        """Return when the motion comes to a rest of the plan, s."""
        place = _place(rests, rest)
        return times[place] - (dwell if place in waits and place < last else 0.0)

    events = tuple(replace(event, t=at(event.t)) for event in trajectory.events)
    there = [Kept(part.constraints, times[_place(rests, part.begin)], at(part.end)) for part in kept]

    def proof(t: Array, q: Array, velocity: Array) -> Certificate:
        certificate = certify_motion(robot, scene, sampled_motion(robot, t, q, velocity, events))
        return replace(certificate, deviations=deviations_of(robot, there, t, q, velocity))

    motion = joined_motion(motions, proof)
    if len(motions) == 1:
        motion = motion._replace(certificate=proof(motion.t, motion.q, motion.velocity))
    passed = any(move.passes or move.has_to_rest for move in moves_of(scene))
    return Retimed(
        motion,
        tuple(at(arrival) for arrival in trajectory.arrivals),
        WHY_REST if passed else "",
        events,
        tuple(at(end) for end in trajectory.motion.ends),
    )


def _place(rests: Sequence[float], at: float) -> int:
    """Return the number of the rest at a time in s."""
    return int(np.argmin(abs(np.array(rests) - at)))


def _piece(
    trajectory: Trajectory,
    phase: Phase,
    constraints: tuple[Task, ...],
    path: Array,
    limits: Limits,
    dt: float,
    wanted: float,
) -> TimedMotion:
    """Return the motion along one piece, which keeps constraints."""
    allowed, robot = allowed_by(trajectory.method), phase.robot
    if constraints:
        path = on_constraints(robot, constraints, path, FINE)

    def fits(found: TimedMotion) -> bool:
        return all(map(allowed.allow, deviations(robot, constraints, found.t, found.q, found.velocity)))

    return along_path(robot, phase.obstacles, [path], limits, dt, 0.0, wanted, fits)


def _standing(phase: Phase, q: Array, seconds: float) -> TimedMotion:
    """Return the motion that rests at a configuration (n,)."""
    began, t, still = time.perf_counter(), np.array([0.0, seconds]), np.zeros((2, q.size))
    certificate = certify(phase.robot, phase.obstacles, t, np.array([q, q]), still)
    return TimedMotion(t, np.array([q, q]), still, still, [1], certificate, time.perf_counter() - began)
