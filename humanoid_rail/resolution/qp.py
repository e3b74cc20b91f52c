"""The velocity closest to eq. 4.9's that keeps clear of everything and within the limits.

This is the reference; `engine/safety.cpp` has the same in C++.

At a configuration q, with r the q_dot of eq. 4.9, slowed down as a whole to the speed limits,

    minimise    |q_dot - r|^2 + w |J (q_dot - r)|^2
    subject to  d psi/dq q_dot + d psi/dt >= -k (psi - d_s)     every clearance, and every distance of two links
                k_q (q_min - q) <= q_dot <= k_q (q_max - q)     position limits
                -q_dot_max <= q_dot <= q_dot_max                speed limits

The rows are the velocity dampers of Faverjon and Tournassoud (1987), linear in the clearance, which makes them control
barrier functions (Ames et al. 2019): a clearance decays to the safety distance d_s no faster than exp(-k t). With the
weight w the hands deviate only where the redundancy does not suffice. Among obstacles at rest q_dot = 0 is feasible
from every configuration with clearances of d_s and more. Where a clearance is smaller, its row asks for it to grow, for
half of what the joints allow at the most, and where all such rows cannot be had at once, for a half, a quarter, ... of
that.

Sources: B. Faverjon and P. Tournassoud, "A local based approach for path planning of manipulators with a high number of
degrees of freedom", ICRA 1987. A. Ames et al., "Control barrier functions: theory and applications", ECC 2019.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import daqp
import numpy as np
from numpy.typing import ArrayLike

from humanoid_rail._arrays import Array
from humanoid_rail.errors import checked_number
from humanoid_rail.kinematics.kinematics import Clearances, State
from humanoid_rail.resolution.velocity import LARGEST, Gains, gradient_projection
from humanoid_rail.model.robot import Robot

FREE_SPEED, INFLUENCE = 2.0, 0.5
"""How far beyond the safety distance pairs are looked at: so far that their damper would allow this speed, m/s, but at
least so far, m."""
LIMIT_GAIN = 10.0
"""k_q: how fast a joint may approach its position limit, 1/s."""
TASK_WEIGHT = 1000.0
"""w: weight of the hands' deviation from eq. 4.9 against that of the joints."""
SHARE, LEAST_MARGIN = 0.1, 1e-3
"""The dampers keep to the safety distance and a little more, this share of it but at least so much (m), so that what a
step bends towards an obstacle is made good before the distance itself is reached."""
LEAST_RATE = 1e-6
"""A distance that no velocity changes faster than this is left alone, m/s."""
SHARES = (1.0, 0.5, 0.25, 0.125, 0.0)
"""How much of the speed away from what is too near is asked for, until as much can be had at once."""
FASTEST = 1e4
"""A speed limit that is none, m/s or rad/s."""
PRECISION = 1e-9
"""What constraints are precise to, m/s and rad/s."""


@dataclass(frozen=True)
class Safety:
    """Parameters of the constraints.

    Raises:
        InvalidInput: If one of them is not valid.
    """

    safety_distance: float = 0.01
    """d_s: clearances are kept from falling below it, m; 0 or more."""
    damper_gain: float = 1.4
    """k: how fast a clearance may fall to the safety distance, 1/s."""

    def __post_init__(self) -> None:
        distance = checked_number("safety_distance", self.safety_distance, least=0.0, most=LARGEST)
        object.__setattr__(self, "safety_distance", distance)
        object.__setattr__(
            self, "damper_gain", checked_number("damper_gain", self.damper_gain, above=0.0, most=LARGEST)
        )

    @property
    def horizon(self) -> float:
        """Pairs farther apart are left out of the constraints, m."""
        return self.safety_distance + max(INFLUENCE, FREE_SPEED / self.damper_gain)

    @property
    def target(self) -> float:
        """The distance that the dampers keep to, m."""
        return self.safety_distance + max(SHARE * self.safety_distance, LEAST_MARGIN)


@dataclass(frozen=True, eq=False)
class Constraints:
    """lower <= q_dot <= upper and rows q_dot >= sides."""

    lower: Array
    """(n,), m/s and rad/s."""
    upper: Array
    """(n,), m/s and rad/s."""
    rows: Array
    """(m, n)."""
    sides: Array
    """(m,)."""


def constraints(robot: Robot, state: State, safety: Safety, dt: float) -> Constraints:
    """Return what q_dot has to satisfy at a state, to be held for dt.

    Rows that no q_dot within the bounds can break are left out.

    Args:
        robot: The robot.
        state: The robot among its obstacles.
        safety: Safety distance and gain of the dampers.
        dt: How long q_dot will be held, s: a gain beyond 1/dt would overshoot.
    """
    k, k_q = min(safety.damper_gain, 1.0 / dt), min(LIMIT_GAIN, 1.0 / dt)
    fastest = np.minimum(robot.velocity_limit, FASTEST)
    upper = np.maximum(np.minimum(fastest, k_q * (robot.upper - state.q)), 0.0)
    lower = np.minimum(np.maximum(-fastest, k_q * (robot.lower - state.q)), 0.0)
    dampers = [_dampers(pairs, safety, k) for pairs in (state.pieces, state.links)]
    rows = np.vstack([rows for rows, _ in dampers])
    sides = np.concatenate([sides for _, sides in dampers])
    slowest = np.maximum(rows, 0.0) @ lower + np.minimum(rows, 0.0) @ upper
    fastest = np.maximum(rows, 0.0) @ upper + np.minimum(rows, 0.0) @ lower
    # Of speed away from an obstacle, no more than half of what the joints allow is asked for.
    sides = np.minimum(sides, 0.5 * fastest)
    can_bind = (slowest < sides) & (fastest - slowest >= LEAST_RATE)
    return Constraints(lower, upper, rows[can_bind], sides[can_bind])


def _dampers(pairs: Clearances, safety: Safety, k: float) -> tuple[Array, Array]:
    near = pairs.distance <= safety.horizon
    sides = -k * (pairs.distance[near] - safety.target) - pairs.rate[near]
    return pairs.gradient[near], sides


def safe_velocity(robot: Robot, state: State, targets: ArrayLike, gains: Gains, safety: Safety, dt: float) -> Array:
    """Return q_dot (n,) closest to eq. 4.9's that the constraints allow, m/s and rad/s.

    Args:
        robot: The robot.
        state: The robot among its obstacles at q.
        targets: x_f (h, 3), m.
        gains: K, c_mu, c_kappa and the activation distance.
        safety: Safety distance and gain of the dampers.
        dt: How long q_dot will be held, s.
    """
    r = gradient_projection(state, targets, gains)
    # Slowed down as a whole, eq. 4.9 stays on its path.
    too_fast = abs(r) > robot.velocity_limit
    r = r * float(min([1.0, *(robot.velocity_limit[too_fast] / abs(r[too_fast]))]))
    limits = constraints(robot, state, safety, dt)
    if _holds(r, limits):
        return r
    hessian: Array = TASK_WEIGHT * state.jacobian.T @ state.jacobian + np.eye(r.size)
    for share in SHARES:
        sides = np.where(limits.sides > 0, share * limits.sides, limits.sides)
        solution = _solve(hessian, -hessian @ r, replace(limits, sides=sides))
        if solution is not None:
            return np.clip(solution, limits.lower, limits.upper)
    return np.zeros(r.size)


def _holds(velocity: Array, limits: Constraints) -> bool:
    within = (velocity <= limits.upper + PRECISION) & (velocity >= limits.lower - PRECISION)
    return bool(within.all() and (limits.rows @ velocity >= limits.sides - PRECISION).all())


def _solve(hessian: Array, linear: Array, limits: Constraints) -> Array | None:
    """Return the x of least x^T H x / 2 + f^T x that the constraints allow, if they allow any."""
    upper = np.concatenate([limits.upper, np.full(len(limits.rows), 1e30)])
    lower = np.concatenate([limits.lower, limits.sides])
    rows = np.ascontiguousarray(limits.rows).reshape(len(limits.rows), len(linear))
    x, _, flag, _ = daqp.solve(hessian, linear, rows, upper, lower, primal_tol=PRECISION)
    return np.array(x) if flag == 1 else None
