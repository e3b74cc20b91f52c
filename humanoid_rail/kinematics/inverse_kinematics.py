"""Configurations with the hands at their targets, clear of everything and within the limits.

This is the reference; `engine/inverse_kinematics.cpp` has the same in C++.

Of the errors r = (w (x_f - f(q)), d - psi_i(q)), the second for every pair that is nearer than the distance d it has to
keep, the sum of squares is brought to 0 by the method of Levenberg and Marquardt with a damping that shrinks with what
is left of it (Sugihara 2011). Steps are the shortest in joint coordinates in units of the speed limits, so that what is
found is near where the search began. A joint whose step leads beyond a limit is held there.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.kinematics.kinematics import Kinematics
from humanoid_rail.scene.obstacles import Obstacle
from humanoid_rail.model.robot import Robot

MAX_ITERATIONS = 60
ARRIVED = 1e-7
"""What the hands are brought to their targets to, m."""
SPARE = 2e-3
"""How much farther apart than they have to be pairs are brought, m."""
DAMPING_SHARE = 0.1
"""The damping is this share of what is left of the squared errors, and ..."""
LEAST_DAMPING = 1e-6
"""... this much, m^2."""
LONGEST_STEP = 0.3
"""The longest step of a joint, at its speed limit, s."""
WORTHWHILE = 0.03
"""The share of what was left that a step has to take away ..."""
PATIENCE = 12
"""... or the search ends after so many in a row that did not."""
HOLDS = 4
"""How often a step is solved again with joints held at their limits."""


class Posture(NamedTuple):
    """A configuration that was found, and how good it is."""

    q: Array
    """Configuration (n,) within the limits, m and rad."""
    error: float
    """Of the hands, weighted, m."""
    clearance: float
    """The smallest of all pairs nearer than asked for, m; infinite where there are none."""

    def reaches(self, distance: float) -> bool:
        """Return whether the hands are at their targets and every pair keeps a distance in m."""
        return self.error <= ARRIVED and self.clearance >= distance


class InverseKinematics:
    """A robot among obstacles where they are at t = 0. Not to be shared between threads."""

    def __init__(self, robot: Robot, obstacles: tuple[Obstacle, ...]) -> None:
        self.robot = robot
        self._kinematics = Kinematics(robot, obstacles)

    def solve(self, start: Array, targets: Array, weights: Array, distance: float) -> Posture:
        """Look, from a configuration, for one near it that reaches.

        Args:
            start: Configuration (n,), m and rad.
            targets: x_f (3h,), m.
            weights: Of the coordinates of the hands (3h,); those of weight 0 are free.
            distance: What pairs keep, m; minus infinity to leave them alone.
        """
        robot = self.robot
        q = np.clip(start, robot.lower, robot.upper)
        best, least, waited = Posture(q, np.inf, np.inf), np.inf, 0
        for _ in range(MAX_ITERATIONS):
            state = self._kinematics.state(q)
            error = weights * (targets - state.hands.ravel())
            jacobian = weights[:, None] * state.jacobian
            clearance = np.inf
            if distance > -np.inf:
                near = np.concatenate([state.pieces.distance.ravel(), state.links.distance])
                gradients = np.vstack([state.pieces.gradient.reshape(-1, robot.n), state.links.gradient])
                some = near <= distance + SPARE
                clearance = float(near[some].min(initial=np.inf))
                error = np.concatenate([error, distance + SPARE - near[some]])
                jacobian = np.vstack([jacobian, gradients[some]])
            here = Posture(q, float(np.linalg.norm(error[: targets.size])), clearance)
            if here.reaches(distance):
                return here
            left = float(error @ error)
            waited = 0 if left < (1.0 - WORTHWHILE) * least else waited + 1
            if left < least:
                best, least = here, left
            if waited > PATIENCE:
                break
            q = self._step(q, jacobian, error, DAMPING_SHARE * left + LEAST_DAMPING)
        return best

    def _step(self, q: Array, jacobian: Array, error: Array, damping: float) -> Array:
        robot = self.robot
        # Joints without a speed limit count as if it were 1; those whose limit is 0 stay.
        scale = np.where(np.isfinite(robot.velocity_limit), robot.velocity_limit, 1.0)
        J = jacobian * scale
        square, right = J.T @ J + damping * np.eye(robot.n), J.T @ error
        for _ in range(HOLDS):
            x = np.linalg.solve(square, right)
            x *= min(1.0, LONGEST_STEP / max(abs(x).max(), 1e-300))
            after = q + x * scale
            beyond = np.flatnonzero((after < robot.lower) | (after > robot.upper))
            for i in beyond:
                moved = ((robot.upper[i] if after[i] > robot.upper[i] else robot.lower[i]) - q[i]) / scale[i]
                right = right - moved * square[:, i]
                square[i], square[:, i], square[i, i], right[i] = 0.0, 0.0, 1.0, moved
            if not beyond.size:
                break
        return np.clip(after, robot.lower, robot.upper)
