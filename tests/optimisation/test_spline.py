"""Splines from rest to rest, held against SciPy's."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import BSpline

from humanoid_rail.optimisation.seed import along
from humanoid_rail.optimisation.spline import ramp, refined, shortest_interval, weights

DEGREES = (2, 3)


def some_control(degree: int, intervals: int, rng: np.random.Generator) -> np.ndarray:
    control = rng.normal(size=(intervals + degree, 3))
    control[:degree], control[-degree:] = control[0], control[-1]
    return control


def curve(control: np.ndarray, degree: int, interval: float = 1.0) -> BSpline:
    """Return the spline from t = 0 on, by SciPy."""
    return BSpline(interval * np.arange(-degree, len(control) + 1.0), control, degree)


@pytest.mark.parametrize("degree", DEGREES)
def test_weights(degree: int, rng: np.random.Generator) -> None:
    control = some_control(degree, 7, rng)
    times = np.append(rng.uniform(0.0, 7.0, 50), [0.0, 7.0])
    expected = np.array([curve(control, degree)(min(t, 7.0 - 1e-12)) for t in times])
    np.testing.assert_allclose(weights(degree, 7, times) @ control, expected, atol=1e-9)


@pytest.mark.parametrize("degree", DEGREES)
def test_it_rests_at_both_ends(degree: int, rng: np.random.Generator) -> None:
    control = some_control(degree, 7, rng)
    spline = curve(control, degree)
    for order in range(1, degree):
        for t in (0.0, 7.0 - 1e-12):
            np.testing.assert_allclose(spline(t, order), 0.0, atol=1e-9)
    np.testing.assert_allclose(spline(0.0), control[0])


@pytest.mark.parametrize("degree", DEGREES)
@pytest.mark.parametrize("parts", [1, 2, 5, 12])
def test_knots_that_are_inserted_change_nothing(degree: int, parts: int, rng: np.random.Generator) -> None:
    control = some_control(degree, 6, rng)
    control[:, 1] = 0.1
    fine = refined(control, degree, parts)
    assert len(fine) == 6 * parts + degree
    times = np.linspace(0.0, 6.0, 200)
    coarse = weights(degree, 6, times) @ control
    np.testing.assert_allclose(weights(degree, 6 * parts, parts * times) @ fine, coarse, atol=1e-12)
    assert np.ptp(fine[:, 1]) == 0.0
    assert (fine[:degree] == control[0]).all()
    assert (fine[-degree:] == control[-1]).all()


@pytest.mark.parametrize("degree", DEGREES)
def test_the_shortest_interval_just_keeps_the_limits(degree: int, rng: np.random.Generator) -> None:
    control = some_control(degree, 8, rng)
    control[:, 2] = 0.3
    limits = (np.array([1.0, 2.0, 0.0]), np.array([3.0, np.inf, 0.0]), np.array([20.0, 15.0, 0.0]))[:degree]
    interval = shortest_interval(control, limits)
    spline = curve(control, degree, interval)
    times = np.linspace(0.0, 8 * interval - 1e-9, 20_001)
    shares = [(abs(spline(times, order))[:, :2] / limit[:2]).max() for order, limit in enumerate(limits, start=1)]
    # The highest derivative is constant between knots; the lower ones may keep away from the hull.
    assert max(shares) <= 1.0 + 1e-6
    assert max(shares) >= 0.5
    slower = [np.full(3, np.inf)] * (degree - 1) + [limits[-1]]
    spline = curve(control, degree, shortest_interval(control, slower))
    times = np.linspace(0.0, 8 * shortest_interval(control, slower) - 1e-9, 20_001)
    highest = abs(spline(times, degree))[:, :2] / limits[-1][:2]
    assert highest.max() == pytest.approx(1.0)


@pytest.mark.parametrize("degree", DEGREES)
def test_a_ramp_goes_from_0_to_1(degree: int) -> None:
    shape = ramp(degree, 10)
    assert (shape[:degree] == 0.0).all()
    assert (shape[-degree:] == 1.0).all()
    assert (np.diff(shape) >= 0.0).all()


@pytest.mark.parametrize("degree", DEGREES)
@pytest.mark.parametrize("rise", [0.01, 0.5, 10.0])
def test_a_seed_is_on_the_path(degree: int, rise: float) -> None:
    path = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.5]])
    control = along(path, rise, degree, 40)
    assert len(control) == 40 + degree
    on_first, on_second = abs(control[:, 1]) < 1e-12, abs(control[:, 0] - 1.0) < 1e-12
    assert (on_first | on_second).all()
    assert (np.diff(control, axis=0) >= -1e-12).all()
    # It speeds up as long as it brakes, and is at half of its way at half of its time.
    steps = np.abs(np.diff(control, axis=0)).sum(axis=1)
    np.testing.assert_allclose(steps, steps[::-1], atol=1e-12)
    full_speed = (1.5 / 40) / (1.0 - min(0.5, rise / (1.5 + rise)))
    assert steps[degree:-degree].max() <= full_speed + 1e-9
