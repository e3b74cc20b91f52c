"""Section 5 of the paper: its three cases and what it says of them."""

from __future__ import annotations

import numpy as np
import pytest

from humanoid_rail import InvalidInput, Robot, Scene, Status, Trajectory, load_robot, paper_scene, plan_case
from humanoid_rail.paper import dh_table as dh
from humanoid_rail.paper.cases import CASES, bisect_claims, claims, closed_form_duration, sweep_point


@pytest.fixture(scope="module")
def cases(robot: Robot, engine: str) -> dict[int, Trajectory]:
    return {i: plan_case(robot, i, engine=engine) for i in CASES}


def test_every_claim_holds(robot: Robot, cases: dict[int, Trajectory]) -> None:
    table = claims(robot, cases)
    assert len(table) == 11
    assert [claim.statement for claim in table if not claim.holds] == []


@pytest.mark.parametrize("case", [1, 2, 3])
def test_the_error_decays_as_the_closed_form_says(scene: Scene, cases: dict[int, Trajectory], case: int) -> None:
    """|e(t)| = |e(0)| exp(-t) for K = I, whatever the secondary objectives do; the hands by the DH table."""
    trajectory = cases[case]
    targets = np.array([scene.targets["left"], scene.targets["right"]])
    e = np.array([np.linalg.norm(dh.hands(q) - targets) for q in trajectory.q])
    # The integrator keeps q to 1e-6 a step; e follows to a few times that.
    np.testing.assert_allclose(e, e[0] * np.exp(-trajectory.t), rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("case", [1, 2, 3])
def test_duration(robot: Robot, cases: dict[int, Trajectory], case: int) -> None:
    assert cases[case].status is Status.REACHED
    assert cases[case].duration == pytest.approx(6.3355, abs=1e-3)
    assert closed_form_duration(robot, paper_scene()) == pytest.approx(6.3355, abs=1e-4)


def test_case_1_penetrates_both_spheres(cases: dict[int, Trajectory]) -> None:
    assert (cases[1].clearance.min(axis=0) < 0).all()
    assert not cases[1].collision_free


def test_case_2_clears_both_with_a_smaller_manipulability_than_case_1(cases: dict[int, Trajectory]) -> None:
    assert cases[2].collision_free
    assert cases[2].manipulability[-1] < cases[1].manipulability[-1]


def test_case_3_clears_both_with_the_highest_manipulability(cases: dict[int, Trajectory]) -> None:
    assert cases[3].collision_free
    assert cases[3].manipulability[-1] > max(cases[1].manipulability[-1], cases[2].manipulability[-1])


def test_all_cases_start_faster_than_the_nominal_limits(cases: dict[int, Trajectory]) -> None:
    for trajectory in cases.values():
        assert not trajectory.limits_ok
        assert {v.quantity for v in trajectory.violations if v.t == 0.0} == {"velocity"}


def test_the_clearances_are_those_of_the_dh_bones(scene: Scene, cases: dict[int, Trajectory]) -> None:
    for trajectory in cases.values():
        for q, clearance in zip(trajectory.q[::40], trajectory.clearance[::40], strict=True):
            for obstacle, psi in zip(scene.obstacles, clearance, strict=True):
                distances = []
                for a, b in dh.bones(q).values():
                    s = np.clip((obstacle.center - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
                    distances.append(np.linalg.norm(a + s * (b - a) - obstacle.center))
                assert psi == pytest.approx(min(distances) - obstacle.radius - 0.05, abs=1e-9)


@pytest.mark.parametrize("radius", [0.05, 0.0])
def test_the_claims_hold_in_a_range_with_two_ends(radius: float) -> None:
    robot = load_robot(link_radius=radius)
    inside = sweep_point(robot, 1.0, dt=0.02)
    assert inside.broken_claims == ()
    low, below = bisect_claims(robot, 1.0, 0.5, width=0.05)
    high, above = bisect_claims(robot, 1.0, 3.0, width=0.2)
    assert 0.75 < low < 0.95
    assert 1.6 < high < 2.1
    assert below.broken_claims
    assert above.broken_claims == ("mu(3) is the highest",)


def test_there_are_three_cases(robot: Robot) -> None:
    with pytest.raises(InvalidInput, match="case"):
        plan_case(robot, 4)
