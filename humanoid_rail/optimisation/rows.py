"""What the quadratic program of a step is made of, linear in the control points, and what it proposes."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from humanoid_rail._arrays import Array

Indices = NDArray[np.integer]


class Clearances(NamedTuple):
    """Rows of clearances. R rows, m joints, d the spline's degree."""

    first: Indices
    """The first free control point that a row depends on (R,)."""
    weights: Array
    """How much it depends on that one and those after it (R, d + 1)."""
    spare: Array
    """How much farther apart a pair is than it has to be (R,), m."""
    gradient: Array
    """Of that, with respect to the joints (R, m), m/s."""


class Goal(NamedTuple):
    """The tasks at the goal."""

    error: Array
    """(r,), m."""
    jacobian: Array
    """(r, m), m/s."""


class Pass(NamedTuple):
    """The tasks at a waypoint, and the moment at which the spline is there."""

    weights: Array
    """How much the spline depends on the free control points at that moment (F,)."""
    error: Array
    """(r,), m."""
    jacobian: Array
    """(r, m), m/s."""
    rate: Array
    """How fast the error changes with the moment (r,), m for an interval."""
    earlier: float
    """The moment may become so much earlier, in intervals, 0 or less."""
    later: float
    """The moment may become so much later, in intervals."""


class Step(NamedTuple):
    """What the program proposes."""

    change: Array
    """Of all control points (M + d, m), s."""
    merit: float
    """To first order: the duration after it as a share of what it was, and the penalty of what clearances lack."""
    shift: Array
    """Of the moments at which waypoints are passed (P,), in intervals."""
