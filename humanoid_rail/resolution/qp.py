"""The velocity closest to eq. 4.9's that keeps clear of everything and within the limits.

The Python here is the reference, to be read; `engine/resolution/qp.cpp` has the same in C++ for planning.

At a configuration q, with r the q_dot of eq. 4.9, slowed down as a whole to the speed limits,

    minimise    |q_dot - r|^2 + w |J (q_dot - r)|^2
    subject to  d psi/dq q_dot + d psi/dt >= -k (psi - d_s)     every clearance, and every distance of two links
                A q_dot = b                                     equalities, if the user gives any
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

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput, checked_number
from humanoid_rail.kinematics.state import Clearances, State
from humanoid_rail.kinematics.task import Task
from humanoid_rail.kinematics.task_stack import stack_jacobian
from humanoid_rail.model.pair_distances import own_distances
from humanoid_rail.model.robot import Robot
from humanoid_rail.resolution.velocity import LARGEST, Gains, gradient_projection

FREE_SPEED = 2.0
"""Pairs are looked at from where their damper would still allow this speed, m/s."""
INFLUENCE = 0.5
"""Pairs are looked at within this distance beyond the safety distance in any case, m."""
LIMIT_GAIN = 10.0
"""The gain k_q says how fast a joint may approach its position limit, 1/s."""
TASK_WEIGHT = 1000.0
"""The weight w of the tasks' deviation from eq. 4.9 is relative to that of the joints."""
MARGIN_SHARE = 0.1
"""The dampers keep to the safety distance and this share of it more, so that what a step bends towards an obstacle is
made good before the distance itself is reached."""
LEAST_MARGIN = 1e-3
"""The dampers keep at least this much more than the safety distance, m."""
LEAST_RATE = 1e-6
"""A distance that no velocity changes faster than this is left alone, m/s."""
SHARES = (1.0, 0.5, 0.25, 0.125, 0.0)
"""Of the speed away from what is too near these shares are asked for in turn, until one can be had."""
FASTEST = 1e4
"""A joint without a speed limit is given this one, m/s or rad/s."""
PRECISION = 1e-9
"""Constraints are precise to this, m/s and rad/s."""
DEPENDENT = 1e-6
"""A row of length 1 follows from others if they come this near to it."""
UNBOUNDED = 1e30
"""The QP solver takes a bound of this size for none."""


class Equalities(NamedTuple):
    """Rows A q_dot = b that q_dot has to satisfy."""

    rows: Array
    """A (k, n)."""
    sides: Array
    """b (k,)."""


class Reachable(NamedTuple):
    """Velocities that can be had within a cycle, for example from the one before it by limits of acceleration."""

    lower: Array
    """(n,), m/s and rad/s."""
    upper: Array
    """(n,), m/s and rad/s."""
    fallback: Array
    """One between the two that always may be chosen (n,), m/s and rad/s: that of braking. Rows ask for more than it
    gives only as far as can be had."""


Equality = Callable[[State], tuple[Any, Any]]
"""A linear equality maps a state to rows A (k, n) and sides b (k,) of A q_dot = b, such as :class:`Equalities`."""


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
    equalities: Sequence[Equality] = ()
    """Linear equalities A q_dot = b. Kept as a tuple."""

    def __post_init__(self) -> None:
        distance = checked_number("safety_distance", self.safety_distance, least=0.0, most=LARGEST)
        object.__setattr__(self, "safety_distance", distance)
        object.__setattr__(
            self, "damper_gain", checked_number("damper_gain", self.damper_gain, above=0.0, most=LARGEST)
        )
        if isinstance(self.equalities, str) or not isinstance(self.equalities, Sequence):
            raise InvalidInput("equalities", self.equalities, "a sequence of functions from a State to (A, b)")
        for i, equality in enumerate(self.equalities):
            if not callable(equality):
                raise InvalidInput(f"equalities[{i}]", equality, "a function from a State to (A, b)")
        object.__setattr__(self, "equalities", tuple(self.equalities))

    @property
    def horizon(self) -> float:
        """Pairs farther apart are left out of the constraints, m."""
        return self.safety_distance + max(INFLUENCE, FREE_SPEED / self.damper_gain)

    @property
    def target(self) -> float:
        """The distance that the dampers keep to, m."""
        return self.safety_distance + max(MARGIN_SHARE * self.safety_distance, LEAST_MARGIN)

    def targets_of(self, own: Array) -> Array:
        """Return the distances (P,) that the dampers of pairs of links keep to, m.

        Args:
            own: What pairs keep where that is less than the safety distance (P,), m; infinite where nothing is said.
        """
        near: Array = np.minimum(own + MARGIN_SHARE * own, self.target)
        targets: Array = np.where(own < self.safety_distance, near, self.target)
        return targets


@dataclass(frozen=True, eq=False)
class Constraints:
    """lower <= q_dot <= upper, rows q_dot >= sides and the equalities."""

    lower: Array
    """(n,), m/s and rad/s."""
    upper: Array
    """(n,), m/s and rad/s."""
    rows: Array
    """(m, n)."""
    sides: Array
    """(m,)."""
    equalities: Equalities
    """Rows A q_dot = b."""


def equality_rows(state: State, safety: Safety) -> Equalities:
    """Return the rows of all equalities at a state, of length 1; those that follow from others are left out.

    Raises:
        InvalidInput: If an equality returns anything else than finite A (k, n) and b (k,), or contradicts those before.
    """
    n = state.q.size
    kept = Equalities(np.zeros((0, n)), np.zeros(0))
    for i, equality in enumerate(safety.equalities):
        found = equality(state)
        try:
            A, b = (np.asarray(part).astype(float, casting="same_kind") for part in found)
        except (TypeError, ValueError):  # not two of them, no numbers, or rows of different lengths
            A, b = np.empty(0), np.empty(0)
        if A.ndim != 2 or A.shape != (b.size, n) or b.ndim != 1 or not (np.isfinite(A).all() and np.isfinite(b).all()):
            raise InvalidInput(f"equalities[{i}](state)", found, f"A (k, {n}) and b (k,), finite numbers")
        for row, side in zip(A, b, strict=True):
            if not (largest := abs(row).max(initial=0.0)) and not side:
                continue
            scale = largest * float(np.linalg.norm(row / largest)) if largest else 1.0
            added = _with_row(kept, row / scale, side / scale)
            if added is None:
                raise InvalidInput(f"equalities[{i}](state)", found, "rows that do not contradict each other or others")
            kept = added
    return kept


def _with_row(equalities: Equalities, row: Array, side: float) -> Equalities | None:
    """Return equalities with one more of length 1, unless it follows from them; None if it contradicts them."""
    A, b = equalities
    weights = np.linalg.lstsq(A.T, row, rcond=None)[0]
    if np.linalg.norm(row - weights @ A) > DEPENDENT:
        return Equalities(np.vstack([A, row]), np.append(b, side))
    return equalities if abs(side - weights @ b) <= PRECISION else None


def constraints(
    robot: Robot, state: State, safety: Safety, dt: float, reachable: Reachable | None = None
) -> Constraints:
    """Return what q_dot has to satisfy at a state, to be held for dt.

    Rows that no q_dot within the bounds can break are left out.

    Args:
        robot: The robot.
        state: The robot among its obstacles.
        safety: Safety distance and gain of the dampers.
        dt: How long q_dot will be held, s: a gain beyond 1/dt would overshoot.
        reachable: What q_dot can be; anything within the limits, with 0 to fall back on, if not given.
    """
    k, k_q = min(safety.damper_gain, 1.0 / dt), min(LIMIT_GAIN, 1.0 / dt)
    fastest = np.minimum(robot.velocity_limit, FASTEST)
    upper = np.maximum(np.minimum(fastest, k_q * (robot.upper - state.q)), 0.0)
    lower = np.minimum(np.maximum(-fastest, k_q * (robot.lower - state.q)), 0.0)
    fallback = np.zeros(state.q.size)
    if reachable is not None:
        fallback = reachable.fallback
        upper = np.maximum(np.minimum(upper, reachable.upper), fallback)
        lower = np.minimum(np.maximum(lower, reachable.lower), fallback)
    targets = np.full(state.pieces.distance.shape, safety.target), safety.targets_of(own_distances(robot))
    dampers = [
        _dampers(pairs, target, safety, k) for pairs, target in zip((state.pieces, state.links), targets, strict=True)
    ]
    rows = np.vstack([rows for rows, _ in dampers])
    sides = np.concatenate([sides for _, sides in dampers])
    slowest = np.maximum(rows, 0.0) @ lower + np.minimum(rows, 0.0) @ upper
    fastest = np.maximum(rows, 0.0) @ upper + np.minimum(rows, 0.0) @ lower
    # Of speed away from an obstacle, beyond the fallback's, no more than half of what the joints allow is asked for.
    base = rows @ fallback
    sides = np.minimum(sides, base + 0.5 * (fastest - base))
    can_bind = (slowest < sides) & (fastest - slowest >= LEAST_RATE)
    return Constraints(lower, upper, rows[can_bind], sides[can_bind], equality_rows(state, safety))


def _dampers(pairs: Clearances, target: Array, safety: Safety, k: float) -> tuple[Array, Array]:
    near = pairs.distance <= safety.horizon
    sides = -k * (pairs.distance[near] - target[near]) - pairs.rate[near]
    return pairs.gradient[near], sides


def safe_velocity(
    robot: Robot,
    state: State,
    tasks: Sequence[Task],
    gains: Gains,
    safety: Safety,
    dt: float,
    reachable: Reachable | None = None,
) -> Array:
    """Return q_dot (n,) closest to eq. 4.9's that the constraints allow, m/s and rad/s; the fallback if none.

    Args:
        robot: The robot.
        state: The robot among its obstacles at q.
        tasks: What is to be reached.
        gains: K, c_mu, c_kappa and the activation distance.
        safety: Safety distance, gain of the dampers, equalities.
        dt: How long q_dot will be held, s.
        reachable: What q_dot can be; anything within the limits, with 0 to fall back on, if not given.
    """
    r = gradient_projection(state, tasks, gains)
    # Slowed down as a whole, eq. 4.9 stays on its path.
    too_fast = abs(r) > robot.velocity_limit
    r = r * float(min([1.0, *(robot.velocity_limit[too_fast] / abs(r[too_fast]))]))
    limits = constraints(robot, state, safety, dt, reachable)
    if _holds(r, limits):
        return r
    J = stack_jacobian(state, tasks)
    hessian: Array = TASK_WEIGHT * J.T @ J + np.eye(r.size)
    fallback = np.zeros(r.size) if reachable is None else reachable.fallback
    base = limits.rows @ fallback
    for share in SHARES:
        sides = np.where(limits.sides > base, base + share * (limits.sides - base), limits.sides)
        solution = _solve(hessian, -hessian @ r, replace(limits, sides=sides))
        if solution is not None:
            return np.clip(solution, limits.lower, limits.upper)
    return fallback


def _holds(velocity: Array, limits: Constraints) -> bool:
    within = (velocity <= limits.upper + PRECISION) & (velocity >= limits.lower - PRECISION)
    A, b = limits.equalities
    kept = (limits.rows @ velocity >= limits.sides - PRECISION).all() and (abs(A @ velocity - b) <= PRECISION).all()
    return bool(within.all() and kept)


def _solve(hessian: Array, linear: Array, limits: Constraints) -> Array | None:
    """Return the x of least x^T H x / 2 + f^T x that the constraints allow, if they allow any."""
    # Imported here: the native engine has a solver of its own.
    import daqp

    A, b = limits.equalities
    upper = np.concatenate([limits.upper, np.full(len(limits.rows), UNBOUNDED), b])
    lower = np.concatenate([limits.lower, limits.sides, b])
    rows = np.ascontiguousarray(np.vstack([limits.rows, A])).reshape(-1, len(linear))
    x, _, flag, _ = daqp.solve(hessian, linear, rows, upper, lower, primal_tol=PRECISION)
    return np.array(x) if flag == 1 else None
