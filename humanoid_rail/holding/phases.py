"""The phases of a motion along which hands grasp and release objects: in each, the bodies to be checked are others."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from humanoid_rail._arrays import Array
from humanoid_rail.collision.certificate import Certificate, combined
from humanoid_rail.collision.certifier import certify
from humanoid_rail.events import Event, EventKind
from humanoid_rail.holding.holding import (
    Contacts,
    Holding,
    after_grasp,
    after_release,
    allowed,
    among_moving,
    at_the_start,
    robot_among,
)
from humanoid_rail.kinematics.state import Course
from humanoid_rail.model.pairs import UncheckedPair
from humanoid_rail.model.robot import Robot
from humanoid_rail.resampling import evaluate
from humanoid_rail.result import Method, Motion, Timing
from humanoid_rail.samples import Samples, samples_along
from humanoid_rail.scene.obstacles import Obstacle, is_moving, name_of
from humanoid_rail.scene.scene import Scene


@dataclass(frozen=True, eq=False)
class Phase:
    """A part of a motion in which the same hands hold the same objects."""

    begin: float
    """When it begins, s."""
    end: float
    """When it ends, s."""
    robot: Robot
    """The robot with the objects as links."""
    obstacles: tuple[Obstacle, ...]
    """What is an obstacle then."""
    holding: Holding
    """Where the objects are."""
    contacts: Contacts
    """What each of them may touch."""


def phases_of(robot: Robot, scene: Scene, motion: Motion) -> tuple[Phase, ...]:
    """Return the phases of a motion in turn.

    Args:
        robot: The robot, without objects.
        scene: The scene.
        motion: The motion of the robot, with what happens along it.
    """
    holding, contacts = at_the_start(scene), dict[str, frozenset[str]]()
    found, begin = list[Phase](), float(motion.t[0])
    for t, together in groupby(motion.events, key=lambda event: event.t):
        if t > begin:
            found.append(Phase(begin, t, *robot_among(robot, scene, holding, contacts), holding, contacts))
            begin = t
        holding, contacts = _after(robot, holding, contacts, list(together), evaluate(motion, np.array([t]))[0][0])
    found.append(Phase(begin, float(motion.t[-1]), *robot_among(robot, scene, holding, contacts), holding, contacts))
    return tuple(found)


def _after(
    robot: Robot, holding: Holding, contacts: Contacts, events: Sequence[Event], q: Array
) -> tuple[Holding, dict[str, frozenset[str]]]:
    """Return where objects are after events at a configuration (n,), and what they may touch."""
    released = [event.object for event in events if event.kind == EventKind.RELEASE]
    grasped = {event.object: event.hands for event in events if event.kind == EventKind.GRASP}
    holding = after_grasp(robot, after_release(robot, holding, released, q), grasped, q)
    return holding, {**contacts, **{event.object: allowed(robot, event.contacts) for event in events}}


def certify_motion(robot: Robot, scene: Scene, motion: Motion, max_checks: int | None = None) -> Certificate:
    """Return what can be proven of a motion among the obstacles and objects of a scene; see :func:`certify`.

    Args:
        robot: The robot, without objects.
        scene: The scene.
        motion: The motion, with what happens along it.
        max_checks: How many distances may be measured in each phase.
    """
    phases, parts = phases_of(robot, scene, motion), list[Certificate]()
    for phase in phases:
        t, q, velocity = part_of(motion, phase.begin, phase.end)
        looks = _looks(robot, scene, phase)
        parts.append(combined([certify(*among, t, q, velocity, max_checks=max_checks) for among in looks]))
    whole = combined(parts)
    return whole if len(phases) == 1 else replace(whole, unchecked_pairs=_unchecked(phases, parts))


def _looks(robot: Robot, scene: Scene, phase: Phase) -> list[tuple[Robot, tuple[Obstacle, ...]]]:
    """Return robots and what each is among in a phase: obstacles that are links are not among those that move."""
    moving = [is_moving(one) for one in phase.obstacles]
    if len(phase.obstacles) == len(scene.obstacles) or not any(moving):
        return [(phase.robot, phase.obstacles)]
    still = tuple(one for one, moves in zip(phase.obstacles, moving, strict=True) if not moves)
    return [(phase.robot, still), among_moving(robot, scene, phase.holding, phase.contacts)]


def _unchecked(phases: Sequence[Phase], parts: Sequence[Certificate]) -> tuple[UncheckedPair, ...]:
    """Return the pairs that were left out in some phases, with when that was if it was not in all of them."""
    when: dict[UncheckedPair, list[tuple[float, float]]] = {}
    for phase, part in zip(phases, parts, strict=True):
        for pair in part.unchecked_pairs:
            times = when.setdefault(pair, [])
            if times and times[-1][1] == phase.begin:
                times[-1] = (times[-1][0], phase.end)
            else:
                times.append((phase.begin, phase.end))
    return tuple(_said(pair, times, (phases[0].begin, phases[-1].end)) for pair, times in when.items())


def _said(pair: UncheckedPair, times: Sequence[tuple[float, float]], whole: tuple[float, float]) -> UncheckedPair:
    if list(times) == [whole]:
        return pair
    return replace(pair, why=f"{pair.why}, {' and '.join(f'{a:.4g} to {b:.4g} s' for a, b in times)}")


def in_phases(phases: Sequence[Phase], t: Array) -> Iterator[tuple[Phase, NDArray[np.bool_]]]:
    """Yield phases with which of some times (K,) in s are in them; where one begins it is no longer the one before."""
    for number, phase in enumerate(phases):
        inside = (t >= phase.begin) | (number == 0)
        if number + 1 < len(phases):
            inside &= t < phase.end
        if inside.any():
            yield phase, inside


def part_of(motion: Motion, begin: float, end: float) -> tuple[Array, Array, Array | None]:
    """Return times (K,), configurations (K, n) and velocities (K, n), if any, of a motion between two times in s."""
    first, last = motion.t[0], motion.t[-1]
    if begin <= first and end >= last:
        return motion.t, motion.q, None if motion.timing is None else motion.timing.velocity
    inside = (motion.t > begin) & (motion.t < end)
    t = np.concatenate([[begin], motion.t[inside], [end] if end > begin else []])
    q, velocity, _ = evaluate(motion, t)
    return t, q, None if motion.timing is None else velocity


def sampled_motion(robot: Robot, t: Array, q: Array, velocity: Array | None, events: tuple[Event, ...] = ()) -> Motion:
    """Return a motion from its samples: linear between them, or the cubic spline if there are velocities (N, n)."""
    timing = None if velocity is None else Timing(velocity, np.zeros_like(velocity), ())
    return Motion(t, q, robot.joint_names, timing, events)


def samples_of(
    robot: Robot,
    scene: Scene,
    motion: Motion,
    method: Method,
    engine: str = "native",
    chosen: NDArray[np.bool_] | None = None,
) -> Samples:
    """Return the samples of a motion among the obstacles and objects of a scene; see :func:`samples_along`.

    What a hand holds counts as a link. Where it may touch an obstacle, the robot alone counts for that one.

    Args:
        robot: The robot, with all its hands and without objects.
        scene: The scene.
        motion: The motion.
        method: What planned it.
        engine: What computes them.
        chosen: Which of the samples of the motion (N,) to look at; all if not given.
    """
    times, configurations = (motion.t, motion.q) if chosen is None else (motion.t[chosen], motion.q[chosen])
    if not scene.objects:
        return samples_along(robot, scene.obstacles, times, configurations, method, engine)

    def compute() -> Course:
        parts = list[Course]()
        for phase, inside in in_phases(phases_of(robot, scene, motion), times):
            t, q = times[inside], configurations[inside]
            bare = samples_along(robot, scene.obstacles, t, q, method, engine).course
            held = samples_along(phase.robot, phase.obstacles, t, q, method, engine).course
            clearance = bare.clearance.copy()
            left = {name_of(phase.obstacles, i) for i in range(len(phase.obstacles))}
            is_left = [name_of(scene.obstacles, i) in left for i in range(len(scene.obstacles))]
            clearance[:, is_left] = held.clearance
            parts.append(bare._replace(clearance=clearance))
        return Course(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))

    return Samples(robot.hand_names, compute, robot)
