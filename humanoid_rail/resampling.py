"""A motion at other times. It stays the motion that it is.

That is linear between its samples, or the cubic spline through positions and velocities if it was retimed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from humanoid_rail._arrays import Array, frozen
from humanoid_rail.errors import InvalidInput, checked_number
from humanoid_rail.kinematics.cubic import hermite
from humanoid_rail.result import MAX_SAMPLES, Motion, Timing

SAME_TIME = 1e-6
"""Times that are nearer to each other than this share of the time between samples are the same."""


def evaluate(motion: Motion, t: Array) -> tuple[Array, Array, Array]:
    """Return positions, velocities and accelerations (M, n) at times (M,) in s; beyond its ends those there.

    At the motion's own samples the positions are those of the samples, to the last bit. Where a motion that was not
    retimed turns, its velocity is that of what follows, and its acceleration is 0 elsewhere.
    """
    if len(motion.t) == 1:
        still = np.zeros((len(t), motion.q.shape[1]))
        return still + motion.q, still, still.copy()
    at = np.clip(t, motion.t[0], motion.t[-1])
    i = np.clip(np.searchsorted(motion.t, at, side="right") - 1, 0, len(motion.t) - 2)
    h = (motion.t[i + 1] - motion.t[i])[:, None]
    u = (at - motion.t[i])[:, None] / h
    first, last = motion.q[i], motion.q[i + 1]
    step = last - first
    if motion.timing is None:
        q, velocity, acceleration = first + u * step, step / h, np.zeros_like(step)
    else:
        ends = motion.timing.velocity[i], motion.timing.velocity[i + 1]
        q, velocity, acceleration = hermite(first, last, *ends, h, u)
    positions: Array = np.where(u == 1.0, last, q)
    return positions, velocity, acceleration


def resampled(motion: Motion, dt: float) -> tuple[Motion, NDArray[np.bool_]]:
    """Return the same motion with samples every dt in s, and which of its samples (M,) are those it had before.

    No sample is left out, since between its samples a motion would be another one without it. So they are evenly spaced
    where the time between the motion's own samples is a multiple of dt; else there are others between them.

    Raises:
        InvalidInput: If dt is no number greater than 0, or there would be more than `MAX_SAMPLES`.
    """
    step = checked_number("dt", dt, above=0.0)
    if (motion.t[-1] - motion.t[0]) / step + len(motion.t) > MAX_SAMPLES:
        least = (motion.t[-1] - motion.t[0]) / MAX_SAMPLES
        raise InvalidInput("dt", dt, f"more than {least:.3g} s: a trajectory has at most {MAX_SAMPLES} samples")
    grid = motion.t[0] + step * np.arange(np.floor((motion.t[-1] - motion.t[0]) / step) + 1.0)
    after = np.searchsorted(motion.t, grid)
    neighbours = (motion.t[np.clip(i, 0, len(motion.t) - 1)] for i in (after - 1, after))
    away = np.minimum(*(abs(grid - t) for t in neighbours))
    t = np.sort(np.concatenate([motion.t, grid[away > SAME_TIME * step]]))
    own = np.isin(t, motion.t)
    q, velocity, acceleration = evaluate(motion, t)
    timing = motion.timing
    if timing is not None:
        velocity[own], acceleration[own] = timing.velocity, timing.acceleration
        timing = Timing(frozen(velocity), frozen(acceleration), timing.peaks)
    return Motion(frozen(t), frozen(q), motion.joint_names, timing, motion.events, motion.ends), own


def is_evenly_spaced(t: Array) -> bool:
    """Return whether times (N,) in s are evenly spaced, to a share `SAME_TIME` of the time between them."""
    steps = np.diff(t)
    return len(steps) < 2 or bool(np.ptp(steps) <= SAME_TIME * steps.max())
