"""What is plotted of a motion: clearance, manipulability, joints in shares of their limits, speeds of hands."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from humanoid_rail._arrays import Array, FrozenArrays
from humanoid_rail.errors import EngineMissing
from humanoid_rail.model.robot import Robot
from humanoid_rail.resampling import evaluate
from humanoid_rail.scene.scene import Scene
from humanoid_rail.trajectory import Trajectory
from humanoid_rail.viewer.closest_pairs import ClosestPairs, closest_pairs

RATE = 30.0
"""There are about this many moments a second, 1/s."""
MOST = 2000
"""There are about this many moments at most, however long the motion is."""


@dataclass(frozen=True, eq=False)
class Series(FrozenArrays):
    """What is true at some moments of a motion. K moments, n actuated joints, h hands."""

    t: Array
    """The moments (K,), s: samples of the motion, and others between samples that are far apart."""
    q: Array
    """Configurations (K, n), m and rad."""
    pairs: ClosestPairs
    """The closest pairs at each moment; none without the native engine, which finds them."""
    clearance: Array | None
    """The least clearance from obstacles (K,), m; None without obstacles."""
    manipulability: Array
    """mu of eq. 3.4 (K,)."""
    speed: Array
    """Speeds of the joints in shares of their limits (K, n); 0 where there is no limit."""
    acceleration: Array | None
    """Accelerations of the joints in shares of their limits (K, n), of a retimed motion; 0 where there is no limit."""
    hand_speed: Array
    """Speeds of the hands (K, h), m/s."""


def series(robot: Robot, scene: Scene, trajectory: Trajectory) -> Series:
    """Return what is plotted of a motion.

    At its samples it is what the trajectory says. A motion that was not retimed is linear between its samples: it has
    no accelerations, and a sample has the velocity of the interval that begins there.

    Args:
        robot: The robot.
        scene: The scene the motion was planned in.
        trajectory: The motion.
    """
    columns = [_shares(evaluate(trajectory.motion, trajectory.t)[1], robot.velocity_limit)]
    if trajectory.timing is not None:
        columns.append(_shares(trajectory.timing.acceleration, robot.acceleration_limit))
    t, acceleration = moments(trajectory, *columns), None
    if trajectory.timing is not None:
        acceleration = np.stack([np.interp(t, trajectory.t, column) for column in columns[1].T], axis=-1)
    pairs = _closest(robot, scene, trajectory, t)
    q, velocity, _ = evaluate(trajectory.motion, t)
    return Series(
        t=t,
        q=q,
        pairs=pairs,
        clearance=_clearance(trajectory, pairs, t),
        manipulability=np.interp(t, trajectory.t, trajectory.manipulability),
        speed=_shares(velocity, robot.velocity_limit),
        acceleration=acceleration,
        hand_speed=hand_speeds(robot, q, velocity),
    )


def moments(trajectory: Trajectory, *columns: Array) -> Array:
    """Return the moments (K,) at which a motion is looked at, s.

    These are every so many samples, those with the least clearance, the least manipulability and the largest value of
    each of the columns (N, n), arrivals, and moments in between where samples are farther apart.
    """
    t = trajectory.t
    rate = min(RATE, MOST / max(trajectory.duration, 1e-9))
    even = np.linspace(0.0, trajectory.duration, int(np.ceil(trajectory.duration * rate)) + 1)
    sample = np.searchsorted(t, even).clip(0, len(t) - 1)
    kept = [0, len(t) - 1, int(trajectory.manipulability.argmin()), *sample.tolist()]
    if trajectory.clearance.size:
        kept.append(int(trajectory.clearance.min(axis=1).argmin()))
    kept += [int(i) for values in columns for i in values.argmax(axis=0)]
    samples = t[np.unique(kept)]
    gaps = np.diff(samples)
    between = [
        np.linspace(begin, begin + gap, int(np.ceil(gap * rate)), endpoint=False)[1:]
        for begin, gap in zip(samples[:-1], gaps, strict=True)
        if gap > 1.5 / rate
    ]
    arrivals = [arrival for arrival in trajectory.arrivals if arrival <= trajectory.duration]
    return np.unique(np.concatenate([samples, arrivals, *between]))


def hand_speeds(robot: Robot, q: ArrayLike, velocity: ArrayLike) -> Array:
    """Return the speeds of the hands (K, h), m/s.

    Args:
        robot: The robot.
        q: Configurations (K, n), m and rad.
        velocity: Velocities of the actuated joints (K, n), m/s and rad/s.
    """
    data, frames = robot.model.createData(), [robot.model.getFrameId(hand.frame) for hand in robot.hands]
    speeds = np.zeros((len(np.asarray(q)), len(frames)))
    for row, at, moving in zip(speeds, np.asarray(q, float), np.asarray(velocity, float), strict=True):
        pin.forwardKinematics(robot.model, data, robot.full_configuration(at), robot.coupling @ moving)
        for i, frame in enumerate(frames):
            row[i] = np.linalg.norm(pin.getFrameVelocity(robot.model, data, frame, pin.LOCAL).linear)
    return speeds


def _shares(values: Array, limit: Array) -> Array:
    """Return the sizes of values (N, n) in shares of their limits (n,); 0 where there is no limit, or one of 0."""
    return abs(values) / np.where((limit > 0) & np.isfinite(limit), limit, np.inf)


def _closest(robot: Robot, scene: Scene, trajectory: Trajectory, t: Array) -> ClosestPairs:
    try:
        return closest_pairs(robot, scene, trajectory, t)
    except EngineMissing:
        return ClosestPairs()


def _clearance(trajectory: Trajectory, pairs: ClosestPairs, t: Array) -> Array | None:
    """Return the least clearance from obstacles at some moments (K,), m; between samples linear without the engine."""
    if not trajectory.clearance.size:
        return None
    nearest: Array = np.interp(t, trajectory.t, trajectory.clearance.min(axis=1))
    if pairs.obstacles:
        between = ~np.isin(t, trajectory.t)
        nearest[between] = [
            pair.distance for pair, is_between in zip(pairs.obstacles, between, strict=True) if is_between
        ]
    return nearest
