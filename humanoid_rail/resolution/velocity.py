"""Redundancy resolution at the velocity level: eq. 4.6 to 4.9.

This is the reference, to be read; `engine/resolution/` has the same in C++ for planning.

Two misprints of the paper are corrected: J# is J^T (J J^T)^-1, and the null-space projector is I - J# J.
Shapes: n actuated joints, m rows of all tasks (3 for each hand at a point), L links, O obstacles.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from humanoid_rail._arrays import Array, checked_array
from humanoid_rail.errors import InvalidInput, checked_number
from humanoid_rail.kinematics.state import State
from humanoid_rail.kinematics.task import Task
from humanoid_rail.kinematics.task_stack import stack_error, stack_jacobian
from humanoid_rail.model.robot import Robot
from humanoid_rail.model.scale import manipulability_gain, relative_reach

SINGULAR_VALUE = 0.1
"""The pseudo-inverse is damped where the smallest singular value of J is below this; elsewhere eq. 4.9 is exact. It is
that of the paper's robot, m/rad; for others it is the same share of what the shortest arm reaches."""
MAX_DAMPING = SINGULAR_VALUE / 2**0.5
"""The damping at a singularity bounds the norm of J# by 1 / SINGULAR_VALUE."""

Objective = Callable[[State], ArrayLike]
"""A secondary objective maps a state to a velocity (n,), m/s and rad/s, mostly the gradient of what is to grow."""

LARGEST = 1e4
"""Gains and distances may be at most this: beyond it nothing but rounding is left of a motion."""
REDUNDANT = 1e-12
"""Singular values of J below this share of the largest belong to the null space."""
LOST = 1e-3
"""A direction is lost where damping leaves less than this share of the velocity that is asked for along it."""


@dataclass(frozen=True)
class Gains:
    """Parameters of eq. 4.9.

    Raises:
        InvalidInput: If one of them is not valid.
    """

    gain: float | Sequence[float] | Array = 1.0
    """Diagonal of K in 1/s: one number for all rows of the tasks, or one for each. Kept as a tuple."""
    c_mu: float | None = None
    """Gain of the manipulability's gradient, 0 or more. If not given it is 1 for the paper's robot, and has the same
    weight for other robots: it is the product of (2 m / reach)^3 over the arms."""
    c_kappa: float = 1.0
    """Gain of the penalties' gradient, 0 or more."""
    epsilon: float = 1.0
    """Activation distance of the penalty kappa in m, 0 or more. The paper does not give it."""
    objectives: Sequence[Objective] = ()
    """Further secondary objectives, whose velocities eq. 4.8 adds. Kept as a tuple."""

    def __post_init__(self) -> None:
        gains = np.ravel(np.asarray(self.gain, dtype=object))
        if not gains.size:
            raise InvalidInput("gain", self.gain, "a number greater than 0, or one for each row of the tasks")
        diagonal = tuple(checked_number("gain", gain, above=0.0, most=LARGEST) for gain in gains)
        object.__setattr__(self, "gain", diagonal)
        for name in ("c_mu", "c_kappa", "epsilon"):
            if name == "c_mu" and self.c_mu is None:
                continue
            object.__setattr__(self, name, checked_number(name, getattr(self, name), least=0.0, most=LARGEST))
        if isinstance(self.objectives, str) or not isinstance(self.objectives, Sequence):
            raise InvalidInput("objectives", self.objectives, "a sequence of functions from a State to a velocity (n,)")
        for i, objective in enumerate(self.objectives):
            if not callable(objective):
                raise InvalidInput(f"objectives[{i}]", objective, "a function from a State to a velocity (n,)")
        object.__setattr__(self, "objectives", tuple(self.objectives))

    @property
    def objective_names(self) -> tuple[str, ...]:
        """The names of the further secondary objectives; where one has no name, that of its class."""
        return tuple(getattr(objective, "__name__", type(objective).__name__) for objective in self.objectives)

    def c_mu_of(self, robot: Robot) -> float:
        """Return the gain of the manipulability's gradient for a robot."""
        return manipulability_gain(robot) if self.c_mu is None else self.c_mu

    def diagonal(self, size: int) -> Array:
        """Return the diagonal of K (size,).

        Raises:
            InvalidInput: If it was given with another size.
        """
        diagonal = np.ravel(np.asarray(self.gain, float))
        if diagonal.size not in (1, size):
            raise InvalidInput("gain", self.gain, f"1 or {size} numbers greater than 0")
        return np.broadcast_to(diagonal, (size,)).copy()


def singular_value(robot: Robot) -> float:
    """Return the smallest singular value of J from which on eq. 4.9 is exact, m/rad."""
    return SINGULAR_VALUE * relative_reach(robot)


def damping(smallest_singular_value: float, threshold: float = SINGULAR_VALUE) -> float:
    """Return the damping lambda: 0 except next to a singularity (the cases of the paper stay above 0.3).

    lambda^2 = lambda_max^2 (1 - (sigma_min / sigma_0)^2) below sigma_0, as Nakamura and Hanafusa (1986) vary it for the
    damped least squares of Wampler (1986).
    """
    ratio = smallest_singular_value / threshold
    return threshold / 2**0.5 * float(np.sqrt(1.0 - ratio**2)) if ratio < 1.0 else 0.0


def lost_direction(J: ArrayLike, threshold: float = SINGULAR_VALUE) -> Array | None:
    """Return the unit vector (m,) along which the hands can hardly move; None away from singularities."""
    U, sigma, _ = np.linalg.svd(np.asarray(J, float), full_matrices=False)
    share = sigma[-1] ** 2 / (sigma[-1] ** 2 + damping(sigma[-1], threshold) ** 2)
    lost: Array | None = U[:, -1] if share < LOST else None
    return lost


def pseudoinverse(J: ArrayLike, threshold: float = SINGULAR_VALUE) -> Array:
    """Return J# = J^T (J J^T + lambda^2 I)^-1 (n, m), with lambda = 0 except next to a singularity.

    Computed from J = U diag(sigma) V^T as V diag(sigma / (sigma^2 + lambda^2)) U^T, which keeps full precision where
    J J^T would lose half of it.
    """
    U, sigma, Vt = np.linalg.svd(np.asarray(J, float), full_matrices=False)
    inverse = sigma / (sigma**2 + damping(sigma[-1], threshold) ** 2)
    result: Array = (Vt.T * inverse) @ U.T
    return result


def null_space_projector(J: ArrayLike) -> Array:
    """Return I - J# J (n, n), the orthogonal projector on the null space of J.

    Here J# is never damped, so that J (I - J# J) = 0 also next to a singularity: I - V V^T with the right singular
    vectors V of J's range.
    """
    _, sigma, Vt = np.linalg.svd(np.asarray(J, float), full_matrices=False)
    V = Vt[sigma > REDUNDANT * sigma[0]].T
    projector: Array = np.eye(V.shape[0]) - V @ V.T
    return projector


def primary_velocity(J: ArrayLike, K: ArrayLike, e: ArrayLike, threshold: float = SINGULAR_VALUE) -> Array:
    """Return q_dot = -J# K e (n,), eq. 4.6.

    Args:
        J: Jacobian (m, n).
        K: Diagonal of the gain matrix (m,), 1/s.
        e: Error of the tasks (m,), m.
        threshold: Smaller singular values of J are damped, m/rad.
    """
    velocity: Array = -pseudoinverse(J, threshold) @ (np.asarray(K) * np.asarray(e))
    return velocity


def redundant_velocity(primary: ArrayLike, J: ArrayLike, secondary: ArrayLike) -> Array:
    """Return q_dot = q_dot* + (I - J# J) q_dot_0 (n,), eq. 4.7.

    Args:
        primary: q_dot* (n,), a solution of the primary task.
        J: Jacobian (m, n).
        secondary: q_dot_0 (n,), any velocity.
    """
    velocity: Array = np.asarray(primary) + null_space_projector(J) @ np.asarray(secondary)
    return velocity


def penalty(psi: ArrayLike, epsilon: float) -> Array:
    """Return kappa(psi) = (psi - epsilon)^2 where psi <= epsilon, else 0, in m^2."""
    kappa: Array = np.square(np.minimum(np.asarray(psi, float) - epsilon, 0.0))
    return kappa


def penalty_derivative(psi: ArrayLike, epsilon: float) -> Array:
    """Return d kappa / d psi = 2 (psi - epsilon) where psi <= epsilon, else 0, in m."""
    derivative: Array = 2.0 * np.minimum(np.asarray(psi, float) - epsilon, 0.0)
    return derivative


def secondary_velocity(state: State, gains: Gains) -> Array:
    """Return q_dot_0 = c_mu (d mu/dq)^T - c_kappa sum_i (d kappa(psi_i)/dq)^T (n,), eq. 4.8, and further objectives.

    The sum runs over every pair of a link and an obstacle. To it the velocities of `gains.objectives` are added.

    Raises:
        InvalidInput: If one of these is not n finite numbers.
    """
    slope = penalty_derivative(state.clearance, gains.epsilon)
    penalty_gradient = np.einsum("lo,lon->n", slope, state.clearance_gradient)
    velocity: Array = gains.c_mu_of(state.robot) * state.manipulability_gradient - gains.c_kappa * penalty_gradient
    return velocity + objective_velocity(state, gains) if gains.objectives else velocity


def objective_velocity(state: State, gains: Gains) -> Array:
    """Return the sum (n,) of the velocities of `gains.objectives`, m/s and rad/s.

    Raises:
        InvalidInput: If one of these is not n finite numbers.
    """
    velocity = np.zeros(state.q.size)
    for i, objective in enumerate(gains.objectives):
        valid = f"an array of {state.q.size} finite numbers from {gains.objective_names[i]}"
        velocity += checked_array(f"objectives[{i}](state)", objective(state), state.q.shape, valid, most=LARGEST)
    return velocity


def gradient_projection(state: State, tasks: Sequence[Task], gains: Gains) -> Array:
    """Return q_dot (n,) of eq. 4.9, m/s and rad/s.

    Args:
        state: The robot among its obstacles at q.
        tasks: What is to be reached; for the paper a point for each hand.
        gains: K, c_mu, c_kappa and the activation distance.
    """
    e, J = stack_error(state, tasks), stack_jacobian(state, tasks)
    primary = primary_velocity(J, gains.diagonal(e.size), e, singular_value(state.robot))
    return redundant_velocity(primary, J, secondary_velocity(state, gains))
