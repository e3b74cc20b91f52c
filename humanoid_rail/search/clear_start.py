"""Where a path begins whose start is too near to something: where the safe velocity has led away from it."""

from __future__ import annotations

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.kinematics.native_kinematics import NativeKinematics
from humanoid_rail.model.pair_distances import own_distances

SPARE = 8e-4
"""The corners of a path keep this much more than the safety distance, so that there is room to round them, m."""
RETREAT_SHARE = 0.95
"""A path that begins too near to something keeps this share of the largest clearance of its beginning."""


def first_clear(kinematics: NativeKinematics, motion: Array, distance: float) -> tuple[int, float, float]:
    """Return where a motion (N, n) first keeps a distance in m from everything, that distance, and the least before.

    A start that is nearer to something is led away by the safe velocity. Where it never gets so far, the place where it
    is farthest is returned, and a little less than how far that is.
    """
    clearances: list[float] = []
    for q in motion:
        clearance = clearance_at(kinematics, q)
        if clearance >= distance:
            return len(clearances), distance, min(clearances, default=np.inf)
        clearances.append(clearance)
    place = int(np.argmax(clearances))
    kept = max(RETREAT_SHARE * clearances[place], min(clearances[place], distance - SPARE))
    return place, kept, min(clearances[:place], default=np.inf)


def clearance_at(kinematics: NativeKinematics, q: Array) -> float:
    """Return the least clearance at a configuration (n,), m."""
    there = kinematics.measure(q, 0.0)
    # Links that are as far apart as they themselves have to be do not hold up the others.
    lacking = there.self_clearance[there.self_clearance < own_distances(kinematics.robot)]
    return float(min(there.clearance.min(initial=np.inf), lacking.min(initial=np.inf)))
