"""Options of eq. 4.9, of its constraints and of a motion, as the native engine has them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail._native import engine
from humanoid_rail.kinematics.native_tasks import StateAt
from humanoid_rail.model.robot import Robot
from humanoid_rail.resolution import integrate, qp
from humanoid_rail.resolution.integrate import SINGULAR_TIME, Settings
from humanoid_rail.resolution.qp import Safety, equality_rows
from humanoid_rail.resolution.velocity import Gains, objective_velocity, singular_value
from humanoid_rail.result import Status

if TYPE_CHECKING:
    from humanoid_rail import _engine

PROGRESS_TIME = 2.0
"""Among obstacles at rest a rollout has stalled after this long without progress, in time constants 1 / min(K)."""


def native_gains(robot: Robot, gains: Gains, rows: int, state_at: StateAt) -> _engine.Gains:
    """Return gains as the native engine has them; secondary objectives are called back.

    Args:
        robot: The robot that they are for.
        gains: The gains.
        rows: The number of rows of the tasks.
        state_at: What an objective is given.

    Raises:
        InvalidInput: If K has another size.
    """
    objective: Callable[[Array, float], Array] | None = None
    if gains.objectives:

        def objective(q: Array, t: float) -> Array:
            return objective_velocity(state_at(q, t), gains)

    native: _engine.Gains = engine().Gains(
        gain=gains.diagonal(rows),
        c_mu=gains.c_mu_of(robot),
        c_kappa=gains.c_kappa,
        epsilon=gains.epsilon,
        singular_value=singular_value(robot),
        objective=objective,
    )
    return native


def native_safety(safety: Safety, state_at: StateAt, constraints: _engine.TaskStack | None = None) -> _engine.Safety:
    """Return the options of the constraints as the native engine has them; equalities are called back.

    Args:
        safety: The options.
        state_at: What an equality is given.
        constraints: Tasks that hold and go on to; none if not given.
    """
    equality: Callable[[Array, float], tuple[Array, Array]] | None = None
    if safety.equalities:

        def equality(q: Array, t: float) -> tuple[Array, Array]:
            rows = equality_rows(state_at(q, t), safety)
            return rows.rows, rows.sides

    native: _engine.Safety = engine().Safety(
        distance=safety.safety_distance,
        gain=safety.damper_gain,
        horizon=safety.horizon,
        margin_share=qp.MARGIN_SHARE,
        least_margin=qp.LEAST_MARGIN,
        limit_gain=qp.LIMIT_GAIN,
        task_weight=qp.TASK_WEIGHT,
        least_rate=qp.LEAST_RATE,
        fastest=qp.FASTEST,
        precision=qp.PRECISION,
        shares=list(qp.SHARES),
        equality=equality,
        constraints=constraints,
    )
    return native


def native_settings(settings: Settings, K: Array) -> _engine.Settings:
    """Return when a motion ends and how it is sampled, as the native engine has it.

    Args:
        settings: The same for Python.
        K: Diagonal of the gain matrix (m,), 1/s.
    """
    native: _engine.Settings = engine().Settings(
        tolerance=settings.tolerance,
        dt=settings.dt,
        max_time=settings.max_time,
        rtol=settings.rtol,
        atol=settings.atol,
        max_evaluations=integrate.MAX_EVALUATIONS,
        patience=SINGULAR_TIME / K.min(),
        progress=PROGRESS_TIME / K.min(),
        planning_time=min(settings.max_planning_time, np.finfo(float).max),
    )
    return native


def status_of(status: _engine.Status) -> Status:
    """Return what became of the tasks, by the engine's own word for it."""
    native = engine().Status
    return {
        native.REACHED: Status.REACHED,
        native.STALLED: Status.STALLED,
        native.TIME_LIMIT: Status.TIME_LIMIT,
        native.SINGULAR: Status.SINGULAR,
        native.OVERRUN: Status.OVERRUN,
        native.OUT_OF_TIME: Status.PLANNING_TIMEOUT,
    }[status]
