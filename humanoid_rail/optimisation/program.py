r"""The quadratic program of one step of the optimisation.

Its unknowns are the changes D of the free control points, the change x of the interval h between knots as a share of
it, and a slack s:

$$\min_{D, x, s} \; x + \tfrac{1}{2} w_a |a(D)|^2 + \tfrac{1}{2} w_t |D / \tau|^2 + w_s s$$

subject to

- $|\Delta^k (P + D)| \le l_k h^k (1 + k x)$ for the limit $l_k$ of the derivative of order k,
- $\psi_i + \nabla \psi_i \cdot (W_i D) \ge -s$ for each row i of clearances,
- $e + J D_g = 0$ for the tasks at the goal, $|D| \le \tau$, $q^- \le P + D \le q^+$ and $s \ge 0$,
- $e_w + J_w (W_w D + q'(u_w) \, \delta u_w) = 0$ for the tasks at each waypoint, which is passed at a moment $u_w$ that
  may change: $\delta u_w$ are unknowns too.

a(D) are the accelerations as shares of their limits. The right sides of the limits are tangents of $l_k (h + dh)^k$,
which is convex: what keeps them keeps the limits. Joint coordinates are in units of their speed limits, so that control
points and the trust region $\tau$ are in s.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy import sparse

from humanoid_rail._arrays import Array
from humanoid_rail.optimisation.rows import Clearances, Goal, Indices, Pass, Step

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
    passed: int = 0
    """The number of waypoints, P."""

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

    @property
    def unknowns(self) -> int:
        """The number of unknowns: D, x, s, and the shifts of moments."""
        return self.changes + 2 + self.passed

    def step(
        self,
        control: Array,
        interval: float,
        clearances: Clearances,
        goal: Goal | None,
        trust: float,
        passes: Sequence[Pass] = (),
    ) -> Step | None:
        """Return the best step; None if the solver has none.

        Args:
            control: Control points P (M + d, m), s, which keep the limits with the interval.
            interval: h, s.
            clearances: Their rows.
            goal: The tasks at the goal; None if it stays.
            trust: No control point moves farther in any coordinate, s.
            passes: The tasks at the waypoints (P,).
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
            *_equalities(self, goal, passes),
            matrix,
            nothing,
            upper,
            *_bounds(self, control, trust, passes),
        )
        status = solver.solve()
        x = solver.result.x
        if status not in (piqp.PIQP_SOLVED, piqp.PIQP_MAX_ITER_REACHED) or not np.isfinite(x).all():
            return None
        change, (share, slack), shift = np.split(x, [self.changes, self.changes + 2])
        merit = 1.0 + float(share) + PENALTY * max(0.0, float(slack))
        return Step(self.free @ change.reshape(-1, self.joints), merit, shift)


def program(
    degree: int,
    intervals: int,
    limits: tuple[Array, ...],
    box: tuple[Array, Array],
    is_goal_free: bool,
    passed: int = 0,
) -> Program:
    """Return the programs of one problem; see :class:`Program` for the arguments."""
    pattern = _pattern(degree, intervals, limits[0].size, is_goal_free)
    shares = np.tile(1.0 / limits[1] ** 2, intervals + degree - 2)
    curvature = pattern.curvature
    others = sparse.eye_array(2 + passed)
    calm = sparse.block_diag([curvature.T @ curvature.multiply(shares[:, None]), others], format="csc")
    calm.sort_indices()
    return Program(degree, intervals, limits, box, is_goal_free, pattern, calm, passed)


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
        shape=(count + size, form.unknowns),
    )
    return matrix, np.concatenate([1.0 - share[kept], clearances.spare])


def _objective(form: Program, control: Array, interval: float, trust: float) -> tuple[sparse.csc_matrix, Array]:
    """Return the matrix and the vector of the objective."""
    calm, curvature = form.calm, form.pattern.curvature
    weight = CALM / curvature.shape[0] / interval**4
    columns = np.repeat(np.arange(calm.shape[1]), np.diff(calm.indptr))
    steady = np.full(calm.shape[1], STEADY)
    steady[: form.changes] /= form.changes * trust**2
    values = weight * calm.data
    diagonal = calm.indices == columns
    # The others have nothing but that.
    values[diagonal] = np.where(columns[diagonal] < form.changes, values[diagonal], 0.0) + steady
    turning = (np.diff(control, 2, axis=0) / form.limits[1] ** 2).ravel()
    linear = np.concatenate([weight * (curvature.T @ turning), [1.0, PENALTY], np.zeros(form.passed)])
    return sparse.csc_matrix((values, calm.indices, calm.indptr), shape=calm.shape), linear


def _equalities(form: Program, goal: Goal | None, passes: Sequence[Pass]) -> tuple[sparse.csc_matrix, Array]:
    """Return the rows of the tasks at the waypoints and at the goal, and their right sides."""
    errors = [one.error for one in passes] + ([] if goal is None else [goal.error])
    matrix, row = np.zeros((sum(error.size for error in errors), form.unknowns)), 0
    for number, one in enumerate(passes):
        rows, row = slice(row, row + one.error.size), row + one.error.size
        matrix[rows, : form.changes] = np.kron(one.weights, one.jacobian)
        matrix[rows, form.changes + 2 + number] = one.rate
    if goal is not None:
        matrix[row:, form.changes - form.joints : form.changes] = goal.jacobian
    return sparse.csc_matrix(matrix), -np.concatenate([*errors, np.zeros(0)])


def _bounds(form: Program, control: Array, trust: float, passes: Sequence[Pass] = ()) -> tuple[Array, Array]:
    """Return the bounds of the unknowns."""
    movable = control[form.free.argmax(axis=0)]
    # What is beyond a limit by rounding may stay there.
    lower = np.clip(np.minimum(form.box[0] - movable, 0.0), -trust, None).ravel()
    upper = np.clip(np.maximum(form.box[1] - movable, 0.0), None, trust).ravel()
    return (
        np.concatenate([lower, [-LARGEST_CHANGE, 0.0], [one.earlier for one in passes]]),
        np.concatenate([upper, [LARGEST_CHANGE, np.inf], [one.later for one in passes]]),
    )
