"""Profiles of bounded jerk along a smooth path: ruckig's, between the places where the speed is least."""

from __future__ import annotations

from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import BSpline
from scipy.optimize import brentq

from humanoid_rail._arrays import Array
from humanoid_rail.timing.time_optimal import Limits, Profile, Progress

DIP = 0.1
"""Ruckig's profile is divided where the speed falls and rises again by this much, in units of the largest speed."""
CHECKS = 33
"""Each part of ruckig's profile is held against the limits at this many points."""
ROUNDS = 60
"""The parts of ruckig's profile are slowed down at most this often where they exceed limits."""
NEAR = 0.9
"""A speed that is at least this share of the largest is lowered with it."""
END_SHARE = 0.25
"""Where limits are exceeded within this share of a part from one of its ends, the speed at that end is lowered."""
WITHIN = 1.0 + 1e-3
"""A smaller excess than this factor is left to the slowing down of the motion as a whole."""


class _Part(NamedTuple):
    """A part of a path between two places at which s_ddot is 0."""

    begin: float
    end: float
    rates: Array
    """The largest s_dot, s_ddot and s_dddot on it."""


def with_bounded_jerk(path: BSpline, profile: Profile, limits: Limits) -> Progress:
    """Return ruckig's profiles between the places where the speed is least, slowed down where joints exceed limits.

    Args:
        path: q(s) (n,), m and rad, three times differentiable but for its knots.
        profile: The fastest of it (:func:`fastest_profile`), whose s_ddot jumps.
        limits: Of velocity, acceleration and jerk, finite for the joints that move.

    Raises:
        RuntimeError: If ruckig has no answer.
    """
    # Imported here: it takes longer than all the rest together.
    from scipy.signal import find_peaks

    grid, speed = profile.grid, profile.speed
    dips, _ = find_peaks(-speed, prominence=DIP * speed.max())
    places = [0, *dips.tolist(), len(grid) - 1]
    parts = [_part(path, grid[a : b + 1], speed[a : b + 1], limits) for a, b in pairwise(places)]
    knots = speed[places]
    for _ in range(ROUNDS):
        knots = _attainable(parts, knots)
        profiles = [
            _ruckig(part, a, b) for part, a, b in zip(parts, knots[:-1].tolist(), knots[1:].tolist(), strict=True)
        ]
        excess = [_worst_excess(path, profile, limits) for profile in profiles]
        if max(factor for factor, _, _ in excess) <= WITHIN:
            break
        for i, (factor, moment, v) in enumerate(excess):
            if factor > 1.0:
                # Only what matters where the limits are exceeded most: elsewhere the part may stay as fast as it is.
                top = factor if v > NEAR * parts[i].rates[0] else 1.0
                parts[i] = parts[i]._replace(rates=parts[i].rates / np.array([top, factor**2, factor**3]))
                knots[i] /= factor if moment < END_SHARE else 1.0
                knots[i + 1] /= factor if moment > 1.0 - END_SHARE else 1.0
    arrival = np.concatenate([[0.0], np.cumsum([profile.duration for profile in profiles])])

    def position(t: Array) -> Array:
        k = np.clip(np.searchsorted(arrival, t, side="right") - 1, 0, len(profiles) - 1)
        since = np.clip(t - arrival[k], 0.0, np.diff(arrival)[k])
        return np.array([profiles[i].at_time(x)[0][0] for i, x in zip(k.tolist(), since.tolist(), strict=True)])

    return Progress(float(arrival[-1]), position)


def _part(path: BSpline, grid: Array, speed: Array, limits: Limits) -> _Part:
    """Return a part of the path with the rates that its straightest place allows, or more."""
    slope = abs(path(grid, 1)).max(axis=0)
    acceleration, jerk = (
        float(np.divide(limit, slope, out=np.full_like(slope, np.inf), where=slope > 0).min())
        for limit in (limits.acceleration, limits.jerk)
    )
    return _Part(float(grid[0]), float(grid[-1]), np.array([speed.max(), acceleration, jerk]))


def _attainable(parts: list[_Part], knots: Array) -> Array:
    """Return speeds at the knots, lowered so far that each part is long enough to get from one to the next."""
    knots = knots.copy()
    for i, part in enumerate(parts):
        knots[i : i + 2] = np.minimum(knots[i : i + 2], part.rates[0])
    for order in (range(len(parts)), reversed(range(len(parts)))):
        for i in order:
            part = parts[i]
            slow, fast = sorted((i, i + 1), key=lambda k: knots[k])
            if _run(part, float(knots[slow]), float(knots[fast])) > part.end - part.begin:
                knots[fast] = _reachable(part, float(knots[slow]), float(knots[fast]))
    return knots


def _reachable(part: _Part, slow: float, fast: float) -> float:
    """Return the largest speed, not more than `fast`, to which a part is long enough to get from a slow one."""
    length = part.end - part.begin
    return slow + 0.999 * (float(brentq(lambda v: _run(part, slow, v) - length, slow, fast)) - slow)


def _run(part: _Part, slow: float, fast: float) -> float:
    """Return how far it takes to change the speed, s_ddot 0 at both ends."""
    _, acceleration, jerk = part.rates
    change = fast - slow
    short = change <= acceleration**2 / jerk
    duration = 2.0 * np.sqrt(change / jerk) if short else change / acceleration + acceleration / jerk
    return float(0.5 * (slow + fast) * duration)


def _ruckig(part: _Part, begin: float, end: float) -> Any:
    """Return the fastest profile from one speed to another (Berscheid and Kroeger 2021)."""
    from ruckig import InputParameter, Result, Ruckig, RuckigError, Trajectory

    asked = InputParameter(1)
    asked.current_position, asked.target_position = [part.begin], [part.end]
    asked.current_velocity, asked.target_velocity = [begin], [end]
    asked.current_acceleration = asked.target_acceleration = [0.0]
    asked.max_velocity, asked.max_acceleration, asked.max_jerk = ([float(rate)] for rate in part.rates)
    profile = Trajectory(1)
    try:
        result = Ruckig(1).calculate(asked, profile)
    except RuckigError as error:
        raise RuntimeError(f"ruckig found no profile: {error}") from error
    if result not in (Result.Working, Result.Finished):
        raise RuntimeError(f"ruckig found no profile: {result}")
    return profile


def _worst_excess(path: BSpline, profile: Any, limits: Limits) -> tuple[float, float, float]:
    """Return by which factor a profile has to be slowed down for the joints to keep within their limits.

    And when that factor is needed, in units of its duration, and its speed then.
    """
    times = np.linspace(0.0, profile.duration, CHECKS)
    s, v, a = np.array([[x[0] for x in profile.at_time(t)] for t in times]).T[:, :, None]
    j = np.gradient(a[:, 0], times)[:, None]  # it jumps: its mean around each look
    d1, d2, d3 = path(s[:, 0], 1), path(s[:, 0], 2), path(s[:, 0], 3)
    rates = d1 * v, d1 * a + d2 * v**2, d1 * j + 3.0 * d2 * v * a + d3 * v**3
    # What does not move may have a limit of 0.
    shares = [
        np.divide(abs(rate), limit, out=np.zeros_like(rate), where=rate != 0)
        for rate, limit in zip(rates, limits, strict=True)
    ]
    factors = np.max([share ** (1.0 / order) for order, share in enumerate(shares, start=1)], axis=(0, 2))
    worst = int(factors.argmax())
    return float(factors[worst]), worst / (CHECKS - 1), float(v[worst, 0])
