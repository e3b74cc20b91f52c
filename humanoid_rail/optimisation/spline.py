"""Uniform B-splines from rest to rest, as what the optimisation changes.

A spline of degree d on M intervals has M + d control points. The first d are the start and the last d the goal, so that
its derivatives up to the order d - 1 are 0 at both ends. Its derivative of order k lies in the convex hull of the k-th
differences of its control points, divided by the k-th power of the length of an interval (de Boor 1978).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from scipy.interpolate import BSpline

from humanoid_rail._arrays import Array

ROUNDING = 1e-9
"""Intervals are this share longer than limits ask for."""


def weights(degree: int, intervals: int, times: Array) -> Array:
    """Return the weights (S, M + d) of the control points in a spline at times (S,) in intervals, from 0 to M."""
    knots = np.arange(-degree, intervals + degree + 1.0)
    found: Array = BSpline.design_matrix(np.clip(times, 0.0, intervals), knots, degree).toarray()
    return found


def shortest_interval(control: Array, limits: Sequence[Array]) -> float:
    """Return how long the intervals of a spline are at least, s.

    Args:
        control: Control points (M + d, n), m and rad.
        limits: Of the derivatives (n,) of order 1, 2 and so on, in SI units; may be infinite.
    """
    shortest = 0.0
    for order, limit in enumerate(limits, start=1):
        largest = abs(np.diff(control, order, axis=0)).max(axis=0)
        # What does not move may have a limit of 0.
        share = np.divide(largest, limit, out=np.zeros_like(largest), where=largest > 0.0)
        shortest = max(shortest, float(share.max() ** (1.0 / order)))
    return shortest


def knots(control: Array, limits: Sequence[Array], dt: float) -> tuple[float, int]:
    """Return how long the intervals of a motion are, s, and into how many parts of at most dt in s they are divided.

    See :func:`shortest_interval` for the arguments.
    """
    interval = shortest_interval(control, limits) * (1.0 + ROUNDING)
    return interval, max(1, int(np.ceil(interval / dt)))


def refined(control: Array, degree: int, parts: int) -> Array:
    """Return the control points (M parts + d, n) of the same spline with each interval divided into equal parts."""
    intervals = len(control) - degree
    mask = np.ones(1)
    for _ in range(degree + 1):
        mask = np.convolve(mask, np.ones(parts))
    mask /= float(parts) ** degree
    # Written as deviations, so that what does not move stays where it is to the last bit.
    sparse = np.zeros((len(control) * parts, control.shape[1]))
    sparse[::parts] = control - control[0]
    first = (parts - 1) * degree
    fine = np.column_stack([np.convolve(column, mask) for column in sparse.T])[
        first : first + intervals * parts + degree
    ]
    fine += control[0]
    fine[:degree], fine[-degree:] = control[0], control[-1]
    return fine


@lru_cache(maxsize=64)
def ramp(degree: int, intervals: int) -> Array:
    """Return how a spline (M + d,) of one joint goes smoothly from 0 to 1, for shifts of its goal."""
    # At the averages of the knots, where control points act most.
    at = np.clip((np.arange(intervals + degree) - (degree - 1) / 2.0) / intervals, 0.0, 1.0)
    at[:degree], at[-degree:] = 0.0, 1.0
    smooth: Array = at**2 * (3.0 - 2.0 * at)
    return smooth


def as_cubic(control: Array, degree: int) -> Array:
    """Return the control points of a cubic spline that keeps the limits of a spline (N, n) of degree 2 or 3.

    The control points of a quadratic one are taken for those of a cubic one. That is the quadratic one averaged over
    the time between knots: it keeps the same limits, and its accelerations are continuous and 0 at both ends. It is
    an interval longer, and half of one behind.
    """
    return np.vstack([control[:1], control, control[-1:]]) if degree == 2 else control
