"""Section 5 of the paper: its three cases, what it claims of them, and when the claims hold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from humanoid_rail._resources import resource
from humanoid_rail.errors import InvalidInput
from humanoid_rail.kinematics.kinematics import Kinematics
from humanoid_rail.model.robot import Robot
from humanoid_rail.planning.methods import METHODS, GradientProjection, SafeVelocity, as_method
from humanoid_rail.planning.options import PlanningMethod
from humanoid_rail.planning.planner import plan
from humanoid_rail.scene.scene import Scene, load_scene, start_of_scene, target_points
from humanoid_rail.trajectory import Trajectory

CASES: Mapping[int, Mapping[str, float]] = {
    1: {"c_mu": 0.0, "c_kappa": 0.0},
    2: {"c_mu": 0.0, "c_kappa": 1.0},
    3: {"c_mu": 1.0, "c_kappa": 1.0},
}
"""The three cases have these gains; K = I in all of them."""

OPTIONS: Mapping[str, Any] = {
    "gain": 1.0,
    "epsilon": 1.0,
    "tolerance": 0.01,
    "dt": 0.01,
    "max_time": 60.0,
    # Section 5 shows them.
    "far_clearances": True,
}
"""The cases share these options. The paper does not give epsilon, the activation distance in m; see docs/method.md."""

START = {"left": (0.12, -2.23, 3.05), "right": (0.12, 2.23, 3.05)}
"""The paper prints these positions of the hands at q(0), m."""

DURATION = 6.4
"""The paper prints this duration T of all cases, s."""


@dataclass(frozen=True)
class Claim:
    """Something section 5 says, beside what was computed."""

    statement: str
    paper: str
    computed: str
    holds: bool


def paper_scene() -> Scene:
    """Return the scene of section 5, `scenes/paper.yaml`."""
    return load_scene(resource("scenes", "paper.yaml"))


def case_method(case: int, method: str = GradientProjection.name, **options: Any) -> PlanningMethod:
    """Return a planning method with the options of a case of section 5.

    Args:
        case: 1, 2 or 3.
        method: Name of the method; the paper's is gradient projection.
        **options: Options of the method to use instead of the paper's, for example ``epsilon=0.8``.

    Raises:
        InvalidInput: If there is no such case, method or option, or an option is not valid.
    """
    if isinstance(case, bool) or case not in CASES:
        raise InvalidInput("case", case, f"one of {', '.join(map(str, CASES))}")
    if method not in METHODS:
        as_method(method)  # says what there is
    return METHODS[method](**{**OPTIONS, **CASES[case], **options})


def plan_case(robot: Robot, case: int, method: str = GradientProjection.name, **options: Any) -> Trajectory:
    """Plan a case of section 5.

    Args:
        robot: The robot.
        case: 1, 2 or 3.
        method: As for :func:`case_method`.
        **options: As for :func:`case_method`.

    Raises:
        InvalidInput: As :func:`case_method` and :func:`plan` do.
    """
    return plan(robot, paper_scene(), case_method(case, method, **options))


def closed_form_duration(robot: Robot, scene: Scene, tolerance: float = 0.01) -> float:
    """Return T = ln(|e(0)| / tolerance) in s: with K = I eq. 4.3 has the solution e(t) = e(0) exp(-t).

    Args:
        robot: The robot.
        scene: One with a point for each hand; what is in the way does not count.
        tolerance: |e| at the end, m.

    Raises:
        InvalidInput: If the scene asks for something else of the hands.
    """
    start = start_of_scene(robot, scene)
    error = Kinematics(robot).hand_positions(start) - target_points(robot, scene)
    return float(np.log(np.linalg.norm(error) / tolerance))


def claims(robot: Robot, cases: Mapping[int, Trajectory]) -> list[Claim]:
    """Return what section 5 says of the start and of its three cases, beside what was computed.

    Args:
        robot: The robot the cases were planned for.
        cases: The trajectories of the cases 1, 2 and 3.
    """
    first, second, third = (cases[i] for i in (1, 2, 3))
    holds = _claims_that_hold(cases)
    mus = ", ".join(f"mu({i}) = {cases[i].manipulability[-1]:.3f}" for i in CASES)
    start = dict(zip(first.hand_names, first.hands[0], strict=True))
    result = [
        Claim(
            f"{name} hand at q(0)",
            _point(printed),
            _point(start[name], 4),
            bool(np.allclose(start[name], printed, atol=0.005)),
        )
        for name, printed in START.items()
    ]
    result.append(
        Claim(
            "q(0) is nonsingular and free of collision",
            "yes",
            f"mu = {first.manipulability[0]:.3f}, clearance {_clearances(first.clearance[0])}",
            bool(first.manipulability[0] > 0 and (first.clearance[0] >= 0).all()),
        )
    )
    result += [
        Claim(
            f"T of case {i}",
            f"{DURATION} s",
            f"{cases[i].duration:.4f} s (closed form {closed_form_duration(robot, paper_scene()):.4f} s)",
            abs(cases[i].duration - DURATION) < 0.1,
        )
        for i in CASES
    ]
    result += [
        Claim("case 1 may collide with both spheres", "yes", _least(first), holds["case 1 hits both spheres"]),
        Claim("case 2 clears both spheres", "yes", _least(second), holds["case 2 clears both spheres"]),
        Claim("case 2 ends with a smaller manipulability than case 1", "yes", mus, holds["mu(2) < mu(1)"]),
        Claim("case 3 clears both spheres", "yes", _least(third), holds["case 3 clears both spheres"]),
        Claim("case 3 ends with the highest manipulability", "yes", mus, holds["mu(3) is the highest"]),
    ]
    return result


def _claims_that_hold(cases: Mapping[int, Trajectory]) -> dict[str, bool]:
    """Return which of the paper's claims of its cases hold."""
    first, second, third = (cases[i] for i in (1, 2, 3))
    mu = {i: float(cases[i].manipulability[-1]) for i in CASES}
    return {
        "case 1 hits both spheres": bool((first.clearance.min(axis=0) < 0).all()),
        "case 2 clears both spheres": second.collision_free,
        "mu(2) < mu(1)": mu[2] < mu[1],
        "case 3 clears both spheres": third.collision_free,
        "mu(3) is the highest": mu[3] > max(mu[1], mu[2]),
    }


@dataclass(frozen=True)
class SweepPoint:
    """The three cases at one activation distance."""

    epsilon: float
    """Activation distance, m."""
    clearance: tuple[float, ...]
    """Smallest clearance of the cases 1, 2 and 3, m."""
    manipulability: tuple[float, ...]
    """Final manipulability of the cases 1, 2 and 3."""
    broken_claims: tuple[str, ...]
    """The claims that do not hold at this activation distance."""
    safe: Trajectory
    """Case 2 by `method="qp"`."""


def sweep_point(robot: Robot, epsilon: float, dt: float = 0.01, first: Trajectory | None = None) -> SweepPoint:
    """Plan the cases at an activation distance.

    Args:
        robot: The robot.
        epsilon: Activation distance, m.
        dt: Time between samples, s.
        first: Case 1, which does not depend on the activation distance, if it has been planned already.
    """
    cases = {1: first or plan_case(robot, 1, dt=dt)}
    cases |= {i: plan_case(robot, i, epsilon=epsilon, dt=dt) for i in (2, 3)}
    return SweepPoint(
        epsilon,
        tuple(float(trajectory.clearance.min()) for trajectory in cases.values()),
        tuple(float(trajectory.manipulability[-1]) for trajectory in cases.values()),
        tuple(claim for claim, holds in _claims_that_hold(cases).items() if not holds),
        plan_case(robot, 2, SafeVelocity.name, epsilon=epsilon, dt=dt),
    )


def bisect_claims(robot: Robot, good: float, bad: float, width: float = 1e-3) -> tuple[float, SweepPoint]:
    """Return an end of the range in which all claims hold, and what breaks just beyond it.

    Args:
        robot: The robot.
        good: Activation distance at which all claims hold, m.
        bad: One at which not all do, m.
        width: How near to bring the two, m.
    """
    first = plan_case(robot, 1)
    beyond = sweep_point(robot, bad, first=first)
    while abs(good - bad) > width:
        middle = (good + bad) / 2
        point = sweep_point(robot, middle, first=first)
        if point.broken_claims:
            bad, beyond = middle, point
        else:
            good = middle
    return good, beyond


def _point(values: object, digits: int = 2) -> str:
    return "(" + ", ".join(f"{x:.{digits}f}" for x in np.asarray(values, float)) + ")"


def _clearances(values: object) -> str:
    return ", ".join(f"{x:.3f} m" for x in np.asarray(values, float))


def _least(trajectory: Trajectory) -> str:
    return f"least clearance {_clearances(trajectory.clearance.min(axis=0))}"
