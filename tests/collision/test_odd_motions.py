"""Certificates of odd robots, among odd obstacles, over odd spans; and the budget of checks."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from humanoid_rail import Certificate, InvalidInput, Kinematics, Robot, Scene, verify
from validation.odd_motions import OddMotion, odd_motion

COAL = 4e-6
"""Distances of the library are this precise, m, and in m per m of distance."""


def certificate_of(motion: OddMotion, max_checks: int | None = None) -> Certificate:
    timing = None if motion.velocity is None else SimpleNamespace(velocity=motion.velocity)
    scene = Scene(name="odd", targets={}, obstacles=motion.obstacles)
    sampled = SimpleNamespace(t=motion.t, q=motion.q, timing=timing)
    return verify(motion.robot, scene, sampled, max_checks=max_checks)


def least_clearance(motion: OddMotion, finer: int = 60) -> float:
    """Return the smallest clearance at many moments, m, by the reference in Python."""
    u = np.linspace(0, len(motion.t) - 1, finer * (len(motion.t) - 1) + 1)
    t = np.interp(u, np.arange(len(motion.t)), motion.t)
    if motion.velocity is None:
        q = np.array([np.interp(t, motion.t, column) for column in motion.q.T]).T
    else:
        q = CubicHermiteSpline(motion.t, motion.q, motion.velocity)(t)
    kinematics = Kinematics(motion.robot, motion.obstacles)
    measured = [kinematics.measure(row, t=time) for row, time in zip(q, t, strict=True)]
    return min(min(m.clearance.min(initial=np.inf), m.self_clearance.min(initial=np.inf)) for m in measured)


# Those of the numbers above 100 are free, and so fast that their samples say little.
@pytest.mark.parametrize("seed", [*range(12), 127, 258, 400, 405, 416, 500, 509, 518, 665, 788])
@pytest.mark.parametrize("spline", [False, True])
def test_the_bound_holds_and_what_is_free_is_certified(seed: int, spline: bool) -> None:
    motion = odd_motion(seed, spline=spline)
    certificate, least = certificate_of(motion), least_clearance(motion)
    assert certificate.reason is None
    assert certificate.clearance_bound is not None
    assert certificate.clearance_bound <= least + COAL * (1.0 + abs(least))
    found = [certificate.min_clearance_obstacles, certificate.min_clearance_self]
    nearest = min(clearance for clearance in found if clearance is not None)
    if nearest > 1e-3:
        assert certificate.certified
        assert certificate.clearance_bound >= nearest - 1.1e-3
    else:
        assert least < 1e-2 or not certificate.certified


def test_a_budget_that_is_used_up_says_so(robot: Robot) -> None:
    motion = next(m for m in map(_linear, range(20)) if certificate_of(m).certified)
    certificate = certificate_of(motion, max_checks=1)
    assert not certificate
    assert certificate.clearance_bound is None
    assert certificate.contact is None
    assert certificate.reason is not None
    assert certificate.reason.startswith("budget of 1 checks used up at t = ")
    # The least budget that suffices gives the very certificate, and one check fewer does not.
    enough = next(n for n in range(1, 100_000) if certificate_of(motion, max_checks=n).certified)
    assert certificate_of(motion, max_checks=enough) == certificate_of(motion)
    assert certificate_of(motion, max_checks=enough - 1).reason is not None


def _linear(seed: int) -> OddMotion:
    return odd_motion(seed, spline=False)


@pytest.mark.parametrize("budget", [0, -1, 1.5, True, "many", 10**30])
def test_budgets_that_are_none(robot: Robot, scene: Scene, budget: object) -> None:
    still = SimpleNamespace(t=np.zeros(1), q=robot.initial[None, :])
    with pytest.raises(InvalidInput, match="max_checks"):
        verify(robot, scene, still, max_checks=budget)  # type: ignore[arg-type]
