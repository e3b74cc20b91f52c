r"""The quadratic program of one step of the optimisation.

Its unknowns are the changes D of the free control points, the change x of the interval h between knots as a share of
it, and a slack s:

$$\min_{D, x, s} \; x + \tfrac{1}{2} w_a |a(D)|^2 + \tfrac{1}{2} w_t |D / \tau|^2 + w_s s$$

subject to

- $|\Delta^k (P + D)| \le l_k h^k (1 + k x)$ for the limit $l_k$ of the derivative of order k,
- $\psi_i + \nabla \psi_i \cdot (W_i D) \ge -s$ for each row i of clearances,
- $e + J D_g = 0$ for the tasks at the goal, $|D| \le \tau$, $q^- \le P + D \le q^+$ and $s \ge 0$.

a(D) are the accelerations as shares of their limits. The right sides of the limits are tangents of $l_k (h + dh)^k$,
which is convex: what keeps them keeps the limits. Joint coordinates are in units of their speed limits, so that control
points and the trust region $\tau$ are in s.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from humanoid_rail._arrays import Array

CALM = 1e-3
"""Weight of the mean squared acceleration, in shares of the limits: of motions equally fast the calmest is taken."""
STEADY = 1e-4
"""Weight of the mean squared change, in shares of the trust region: it makes the program strictly convex."""
PENALTY = 6.0
"""Weight of the slack, 1/m: a clearance that lacks 1 cm costs as much as a duration that is 6 % longer."""
LARGEST_CHANGE = 0.5
"""The interval changes by at most this share of it."""
TOLERANCE = 5e-4
"""The program is solved to this accuracy, s and shares of the interval."""
MAX_ITERATIONS = 60
"""The interior-point method takes at most this many steps."""
MANY_ROWS = 100
"""With more rows of clearances the solver is quicker with dense blocks, one for each control point."""

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


class Step(NamedTuple):
    """What the program proposes."""

    change: Array
    """Of all control points (M + d, m), s."""
    merit: float
    """To first order: the duration after it as a share of what it was, and the penalty of what clearances lack."""


class _Pattern(NamedTuple):
    """What programs of one size have in common. L rows of limits."""

    free: Array
    """E (M + d, F): control points change by E D."""
    rows: Indices
    """The rows of the entries of the limits' matrix, as triples."""
    columns: Indices
    values: Array
    order: Indices
    """The order of the derivative that a row limits (L,)."""
    curvature: sparse.csr_array
    """Second differences of E D."""


@lru_cache(maxsize=64)
def _pattern(degree: int, intervals: int, joints: int, is_goal_free: bool) -> _Pattern:
    count = intervals + degree
    free = np.zeros((count, intervals - degree + is_goal_free))
    free[np.arange(degree, intervals), np.arange(intervals - degree)] = 1.0
    if is_goal_free:
        free[intervals:, -1] = 1.0
    blocks, orders = [], []
    for order in range(1, degree + 1):
        differences = sparse.kron(np.diff(np.eye(count), order, axis=0) @ free, np.eye(joints))
        blocks += [differences, -differences]
        orders += [np.full(differences.shape[0], order)] * 2
    entries = sparse.coo_array(sparse.vstack(blocks))
    curvature = sparse.kron(np.diff(np.eye(count), 2, axis=0) @ free, np.eye(joints))
    rows, columns = entries.coords
    return _Pattern(
        free,
        rows,
        columns,
        entries.data,
        np.concatenate(orders),
        sparse.csr_array(curvature),
    )


@dataclass(frozen=True, eq=False)
class Program:
    """The programs of one problem, for splines of one size."""

    degree: int
    intervals: int
    """M, at least as many as the degree and one more."""
    limits: tuple[Array, ...]
    """Of the derivatives of order 1, 2 and so on (m,); may be infinite, but not of order 2."""
    box: tuple[Array, Array]
    """Lower and upper position limits (m,)."""
    is_goal_free: bool
    """Whether the goal may move."""
    pattern: _Pattern
    calm: sparse.csc_array
    """The matrix of the squared accelerations, in shares of the limits, for an interval of 1 s."""

    @property
    def free(self) -> Array:
        """E (M + d, F): control points change by E D."""
        return self.pattern.free

    @property
    def joints(self) -> int:
        """The number of joints that move, m."""
        return self.limits[0].size

    @property
    def changes(self) -> int:
        """The number of coordinates of D."""
        return int(self.free.shape[1]) * self.joints

    def step(
        self, control: Array, interval: float, clearances: Clearances, goal: Goal | None, trust: float
    ) -> Step | None:
        """Return the best step; None if the solver has none.

        Args:
            control: Control points P (M + d, m), s, which keep the limits with the interval.
            interval: h, s.
            clearances: Their rows.
            goal: The tasks at the goal; None if it stays.
            trust: No control point moves farther in any coordinate, s.
        """
        import piqp

        solver = piqp.SparseSolver()
        settings = solver.settings
        settings.eps_abs = settings.eps_rel = TOLERANCE
        settings.eps_duality_gap_abs = settings.eps_duality_gap_rel = TOLERANCE
        settings.max_iter = MAX_ITERATIONS
        settings.preconditioner_iter = 0  # in the units here numbers are neither large nor small
        if len(clearances.spare) > MANY_ROWS:
            settings.kkt_solver = piqp.KKTSolver.sparse_multistage
        matrix, upper = _inequalities(self, control, interval, clearances, trust)
        nothing = np.full(len(upper), -np.inf)
        solver.setup(
            *_objective(self, control, interval, trust),
            *_equalities(self, goal),
            matrix,
            nothing,
            upper,
            *_bounds(self, control, trust),
        )
        status = solver.solve()
        x = solver.result.x
        if status not in (piqp.PIQP_SOLVED, piqp.PIQP_MAX_ITER_REACHED) or not np.isfinite(x).all():
            return None
        change, share, slack = x[:-2].reshape(-1, self.joints), float(x[-2]), max(0.0, float(x[-1]))
        return Step(self.free @ change, 1.0 + share + PENALTY * slack)


def program(
    degree: int, intervals: int, limits: tuple[Array, ...], box: tuple[Array, Array], is_goal_free: bool
) -> Program:
    """Return the programs of one problem; see :class:`Program` for the arguments."""
    pattern = _pattern(degree, intervals, limits[0].size, is_goal_free)
    shares = np.tile(1.0 / limits[1] ** 2, intervals + degree - 2)
    curvature = pattern.curvature
    calm = sparse.block_diag([curvature.T @ curvature.multiply(shares[:, None]), sparse.eye_array(2)], format="csc")
    calm.sort_indices()
    return Program(degree, intervals, limits, box, is_goal_free, pattern, calm)


def _inequalities(
    form: Program, control: Array, interval: float, clearances: Clearances, trust: float
) -> tuple[sparse.csc_matrix, Array]:
    """Return the rows of the limits, each in units of its limit, and those of the clearances, with their bounds."""
    pattern, scales, shares = form.pattern, [], []
    for order, limit in enumerate(form.limits[: form.degree], start=1):
        scale = np.tile(1.0 / (limit * interval**order), len(control) - order)
        share = scale * np.diff(control, order, axis=0).ravel()
        scales += [scale, scale]
        shares += [share, -share]
    scale, share = np.concatenate(scales), np.concatenate(shares)
    # Rows without a limit, and those that keep it whatever the step is, are left out.
    reach = trust * scale * 2.0**pattern.order
    kept = (share + reach > 1.0 - LARGEST_CHANGE * pattern.order) & (scale > 0.0)
    numbers = np.cumsum(kept) - 1
    entries = kept[pattern.rows]
    rows = pattern.rows[entries]
    count, (size, spread) = int(numbers[-1]) + 1, (len(clearances.spare), form.degree + 1)
    near = (clearances.weights[:, :, None] * clearances.gradient[:, None, :]).ravel()
    near_rows = count + np.arange(size)
    near_columns = clearances.first[:, None] * form.joints + np.arange(spread * form.joints)
    matrix = sparse.csc_matrix(
        (
            np.concatenate([pattern.values[entries] * scale[rows], -pattern.order[kept], -near, np.full(size, -1.0)]),
            (
                np.concatenate(
                    [numbers[rows], np.arange(count), np.repeat(near_rows, spread * form.joints), near_rows]
                ),
                np.concatenate(
                    [
                        pattern.columns[entries],
                        np.full(count, form.changes),
                        near_columns.ravel(),
                        np.full(size, form.changes + 1),
                    ]
                ),
            ),
        ),
        shape=(count + size, form.changes + 2),
    )
    return matrix, np.concatenate([1.0 - share[kept], clearances.spare])


def _objective(form: Program, control: Array, interval: float, trust: float) -> tuple[sparse.csc_matrix, Array]:
    """Return the matrix and the vector of the objective."""
    calm, curvature = form.calm, form.pattern.curvature
    weight = CALM / curvature.shape[0] / interval**4
    columns = np.repeat(np.arange(calm.shape[1]), np.diff(calm.indptr))
    steady = np.full(calm.shape[1], STEADY)
    steady[:-2] /= form.changes * trust**2
    values = weight * calm.data
    diagonal = calm.indices == columns
    # The two last have nothing but that.
    values[diagonal] = np.where(columns[diagonal] < form.changes, values[diagonal], 0.0) + steady
    turning = (np.diff(control, 2, axis=0) / form.limits[1] ** 2).ravel()
    linear = np.concatenate([weight * (curvature.T @ turning), [1.0, PENALTY]])
    return sparse.csc_matrix((values, calm.indices, calm.indptr), shape=calm.shape), linear


def _equalities(form: Program, goal: Goal | None) -> tuple[sparse.csc_matrix, Array]:
    """Return the rows of the tasks at the goal, and their right sides."""
    if goal is None:
        return sparse.csc_matrix((0, form.changes + 2)), np.zeros(0)
    matrix = np.zeros((len(goal.error), form.changes + 2))
    matrix[:, form.changes - form.joints : form.changes] = goal.jacobian
    return sparse.csc_matrix(matrix), -goal.error


def _bounds(form: Program, control: Array, trust: float) -> tuple[Array, Array]:
    """Return the bounds of the unknowns."""
    movable = control[form.free.argmax(axis=0)]
    # What is beyond a limit by rounding may stay there.
    lower = np.clip(np.minimum(form.box[0] - movable, 0.0), -trust, None).ravel()
    upper = np.clip(np.maximum(form.box[1] - movable, 0.0), None, trust).ravel()
    return np.append(lower, [-LARGEST_CHANGE, 0.0]), np.append(upper, [LARGEST_CHANGE, np.inf])
