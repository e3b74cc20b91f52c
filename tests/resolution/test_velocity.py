"""Eq. 4.6 to 4.9: the identities they rest on, and every term by itself."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from conftest import assert_gradient, points, random_q

from humanoid_rail import Gains, InvalidInput, Robot, Scene
from humanoid_rail.kinematics.task_stack import stack_error
from humanoid_rail.resolution.velocity import (
    MAX_DAMPING,
    SINGULAR_VALUE,
    damping,
    gradient_projection,
    lost_direction,
    null_space_projector,
    penalty,
    penalty_derivative,
    primary_velocity,
    pseudoinverse,
    redundant_velocity,
    secondary_velocity,
)

TARGETS = np.array([[-2.0, 2.0, 4.0], [-2.0, 4.0, 4.0]])


def regular_jacobians(robot: Robot, rng: np.random.Generator, Kinematics: type, n: int = 100) -> list[np.ndarray]:
    jacobians = [Kinematics(robot).state(random_q(robot, rng)).jacobian for _ in range(n)]
    return [J for J in jacobians if np.linalg.svd(J, compute_uv=False)[-1] > SINGULAR_VALUE]


def test_the_identities_of_section_4(robot: Robot, rng: np.random.Generator, Kinematics: type) -> None:
    jacobians = regular_jacobians(robot, rng, Kinematics)
    assert len(jacobians) > 50
    for J in jacobians:
        inverse, projector = pseudoinverse(J), null_space_projector(J)
        np.testing.assert_allclose(J @ inverse, np.eye(6), atol=1e-12)
        np.testing.assert_allclose(J @ projector, 0.0, atol=1e-12)
        np.testing.assert_allclose(projector, np.eye(12) - inverse @ J, atol=1e-12)
        np.testing.assert_allclose(projector @ projector, projector, atol=1e-12)
        np.testing.assert_allclose(inverse, J.T @ np.linalg.inv(J @ J.T), rtol=1e-7, atol=1e-9)


def test_the_printed_forms_are_misprints(robot: Robot, Kinematics: type) -> None:
    """J^T (J J^T) is no right inverse, and I - J J# is 6 x 6 and zero."""
    J = Kinematics(robot).state(robot.initial).jacobian
    assert abs(J @ J.T @ (J @ J.T) - np.eye(6)).max() > 1.0
    np.testing.assert_allclose(np.eye(6) - J @ pseudoinverse(J), 0.0, atol=1e-12)


def test_4_6_is_the_shortest_solution_of_4_4(robot: Robot, rng: np.random.Generator, Kinematics: type) -> None:
    for J in regular_jacobians(robot, rng, Kinematics, 20):
        K, e = rng.uniform(0.5, 2.0, 6), rng.normal(size=6)
        velocity = primary_velocity(J, K, e)
        np.testing.assert_allclose(J @ velocity + K * e, 0.0, atol=1e-11)
        np.testing.assert_allclose(velocity, np.linalg.lstsq(J, -K * e, rcond=None)[0], atol=1e-10)


def test_4_7_leaves_the_hands_alone(robot: Robot, rng: np.random.Generator, Kinematics: type) -> None:
    for J in regular_jacobians(robot, rng, Kinematics, 20):
        primary, secondary = rng.normal(size=12), rng.normal(size=12)
        np.testing.assert_allclose(J @ redundant_velocity(primary, J, secondary), J @ primary, atol=1e-11)


def test_4_8_is_the_gradient_of_the_secondary_objectives(
    robot: Robot, scene: Scene, rng: np.random.Generator, Kinematics: type
) -> None:
    kinematics = Kinematics(robot, scene.obstacles)
    for c_mu, c_kappa in ((1.0, 0.0), (0.0, 1.0), (0.7, 1.9)):
        gains = Gains(c_mu=c_mu, c_kappa=c_kappa, epsilon=1.0)

        def objective(q: np.ndarray, gains: Gains = gains) -> float:
            measured = kinematics.measure(q)
            return float(gains.c_mu * measured.manipulability - gains.c_kappa * penalty(measured.clearance, 1.0).sum())

        for _ in range(10):
            q = random_q(robot, rng)
            assert_gradient(objective, secondary_velocity(kinematics.state(q), gains), q)


def test_4_9_puts_them_together(robot: Robot, scene: Scene, rng: np.random.Generator, Kinematics: type) -> None:
    kinematics, gains = Kinematics(robot, scene.obstacles), Gains(gain=(1, 2, 3, 4, 5, 6), c_mu=0.5, c_kappa=2.0)
    for _ in range(20):
        state = kinematics.state(random_q(robot, rng))
        J, e = state.jacobian, state.hands.ravel() - TARGETS.ravel()
        if np.linalg.svd(J, compute_uv=False)[-1] < SINGULAR_VALUE:
            continue
        inverse = J.T @ np.linalg.inv(J @ J.T)
        expected = -inverse @ np.diag([1, 2, 3, 4, 5, 6]) @ e
        expected = expected + (np.eye(12) - inverse @ J) @ secondary_velocity(state, gains)
        np.testing.assert_allclose(gradient_projection(state, points(TARGETS), gains), expected, rtol=1e-8, atol=1e-9)
        np.testing.assert_allclose(stack_error(state, points(TARGETS)), e)


def test_penalty() -> None:
    np.testing.assert_allclose(penalty([-0.5, 0.0, 0.5, 1.0, 1.5], 1.0), [2.25, 1.0, 0.25, 0.0, 0.0])
    psi = np.array([-2.0, -0.1, 0.0, 0.4, 0.9999, 1.0001, 3.0])
    numeric = (penalty(psi + 1e-6, 1.0) - penalty(psi - 1e-6, 1.0)) / 2e-6
    np.testing.assert_allclose(penalty_derivative(psi, 1.0), numeric, atol=1e-9)


def test_damping_is_off_away_from_singularities() -> None:
    assert damping(SINGULAR_VALUE) == 0.0
    assert damping(5.0) == 0.0
    assert damping(0.0) == MAX_DAMPING
    inside = [damping(s) for s in np.linspace(0.0, SINGULAR_VALUE, 50)]
    assert all(a >= b for a, b in pairwise(inside))


def test_damping_bounds_the_velocity_at_a_singularity(rng: np.random.Generator) -> None:
    U, _ = np.linalg.qr(rng.normal(size=(6, 6)))
    V, _ = np.linalg.qr(rng.normal(size=(12, 6)))
    for smallest in (0.0, 1e-9, 1e-3, 0.05, SINGULAR_VALUE):
        J = U @ np.diag([2.0, 1.5, 1.2, 1.0, 0.9, smallest]) @ V.T
        inverse = pseudoinverse(J)
        assert np.linalg.norm(inverse, 2) <= 1.000001 / SINGULAR_VALUE
        np.testing.assert_allclose(J @ null_space_projector(J), 0.0, atol=1e-12)
        # Only the direction that is being lost is damped.
        np.testing.assert_allclose(U[:, :5].T @ J @ inverse @ U[:, :5], np.eye(5), atol=0.01)


def test_lost_direction(rng: np.random.Generator) -> None:
    U, _ = np.linalg.qr(rng.normal(size=(6, 6)))
    V, _ = np.linalg.qr(rng.normal(size=(12, 6)))
    assert lost_direction(U @ np.diag([2, 1.5, 1.2, 1, 0.9, 0.05]) @ V.T) is None
    lost = lost_direction(U @ np.diag([2, 1.5, 1.2, 1, 0.9, 1e-5]) @ V.T)
    assert lost is not None
    assert abs(lost @ U[:, 5]) == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize(
    ("arguments", "field"),
    [
        ({"gain": 0.0}, "gain"),
        ({"gain": (1, 1, 1, 1, 1, -1)}, "gain"),
        ({"gain": float("nan")}, "gain"),
        ({"gain": ()}, "gain"),
        ({"gain": "high"}, "gain"),
        ({"c_mu": -1.0}, "c_mu"),
        ({"c_kappa": float("inf")}, "c_kappa"),
        ({"epsilon": -0.1}, "epsilon"),
        ({"epsilon": None}, "epsilon"),
    ],
)
def test_bad_gains_are_named(arguments: dict[str, float], field: str) -> None:
    with pytest.raises(InvalidInput) as caught:
        Gains(**arguments)
    assert caught.value.field == field


def test_gains_of_the_wrong_size() -> None:
    with pytest.raises(InvalidInput, match="gain"):
        Gains(gain=(1.0, 2.0)).diagonal(6)
    np.testing.assert_array_equal(Gains(gain=2.0).diagonal(6), 6 * [2.0])
    np.testing.assert_array_equal(Gains(gain=np.arange(1.0, 7.0)).diagonal(6), [1, 2, 3, 4, 5, 6])
    np.testing.assert_array_equal(Gains(gain=[3.0] * 6).diagonal(6), 6 * [3.0])
