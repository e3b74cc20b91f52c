"""How near a robot is to everything at moments of a spline, linear in its control points."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from humanoid_rail._arrays import Array
from humanoid_rail.optimisation.program import Program
from humanoid_rail.optimisation.rows import Clearances, Indices
from humanoid_rail.optimisation.spline import weights

if TYPE_CHECKING:
    from humanoid_rail import _engine

NEAR, FARTHER = 0.05, 0.6
"""Pairs are looked at that are not farther apart than the distance that they keep, NEAR in m, and FARTHER in m/s times
the trust region."""
LIKELY = 0.6
"""Rows are left out that no step within this share of the trust region brings too near."""
SPARSER = 0.02
"""Of pairs with this much to spare there are rows at every other moment, and at every fourth with twice as much, m."""
MOST_ROWS = 5
"""Each moment has at most so many rows."""


@dataclass(frozen=True, eq=False)
class Looks:
    """Moments at which a spline is looked at. S moments."""

    weights: Array
    """Of the control points (S, M + d)."""
    first: Indices
    """The first free control point that a moment depends on (S,)."""
    free: Array
    """How much it depends on that one and those after it (S, d + 1)."""


def looks_at(form: Program, times: Array) -> Looks:
    """Return moments at times (S,) in intervals."""
    every = weights(form.degree, form.intervals, times)
    dependent = every @ form.free
    first = np.minimum((dependent > 0.0).argmax(axis=1), max(0, dependent.shape[1] - form.degree - 1))
    columns = first[:, None] + np.arange(form.degree + 1)
    return Looks(every, first, np.take_along_axis(dependent, columns, axis=1))


def clearances(
    clearance: _engine.MotionClearance,
    looks: Looks,
    q: Array,
    units: Array,
    moving: NDArray[np.bool_],
    distance: float,
    trust: float,
) -> tuple[Clearances, Array]:
    """Return rows for what a step may bring too near, and at each moment (S,) how much there is to spare, m.

    Args:
        clearance: The robot among obstacles.
        looks: The moments.
        q: Configurations at them (S, n), m and rad.
        units: Of the joint coordinates (n,): their speed limits.
        moving: Which of the joints move (n,).
        distance: What pairs keep, m.
        trust: How far control points move, s.
    """
    found = clearance.rows(
        q, distance, distance + NEAR + FARTHER * trust, np.where(moving, LIKELY * trust * units, 0.0)
    )
    kept = np.flatnonzero(found.sample % 2 ** np.clip(found.spare // SPARSER, 0, 2).astype(int) == 0)
    # Of each moment those with the least to spare.
    order = kept[np.lexsort((found.spare[kept], found.sample[kept]))]
    place = np.arange(len(order)) - np.searchsorted(found.sample[order], found.sample[order])
    kept = order[place < MOST_ROWS]
    sample = found.sample[kept]
    gradient = found.gradient[kept][:, moving] * units[moving]
    return Clearances(looks.first[sample], looks.free[sample], found.spare[kept], gradient), found.least


def within(rows: Clearances, trust: float) -> Clearances:
    """Return the rows that matter in a smaller trust region."""
    kept = rows.spare <= LIKELY * trust * abs(rows.gradient).sum(axis=1)
    return Clearances(*(part[kept] for part in rows))
