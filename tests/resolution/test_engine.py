"""The native engine against the Python engine, and what is its own: horizon, threads, memory, versions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from conftest import KINEMATICS, ROOT, plan, points, random_q

import humanoid_rail
from humanoid_rail import (
    Box,
    Capsule,
    Gains,
    GradientProjection,
    HalfSpace,
    Hand,
    InvalidInput,
    Mesh,
    NativeKinematics,
    Robot,
    Safety,
    Scene,
    Sphere,
    Status,
    load_robot,
    load_scene,
    robot_from_urdf,
)
from humanoid_rail.collision.certifier import certify
from humanoid_rail.kinematics import kinematics
from humanoid_rail.planning.options import ENGINES
from humanoid_rail.resolution import velocity as resolution
from humanoid_rail.resolution.integrate import Settings
from humanoid_rail.resolution.native_velocity import constrained_velocity, integrate_natively, projected_velocity
from humanoid_rail.resolution.rollout import rollout
from humanoid_rail.scene.obstacles import Obstacle

native = pytest.importorskip("humanoid_rail._engine", reason="the native engine was not built")

TARGETS = np.array([[-2.0, 2.0, 4.0], [-2.0, 4.0, 4.0]])
ANY_WAY_ROUND = 3.0


def random_obstacles(rng: np.random.Generator, cube: str, count: int = 6) -> tuple[Obstacle, ...]:
    """Return obstacles of random kinds about the robot, some in contact with it; no two features parallel."""

    def one() -> Obstacle:
        center = rng.uniform([-2.0, -1.0, 0.5], [2.0, 5.0, 4.5])
        rpy = rng.uniform(-ANY_WAY_ROUND, ANY_WAY_ROUND, 3)
        size = rng.uniform(0.1, 0.9, 3)
        match rng.integers(5):
            case 0:
                return Sphere(center=center, radius=size[0])
            case 1:
                return Box(center=center, size=size, rpy=rpy)
            case 2:
                return Capsule(center=center, radius=size[0] / 2, length=size[1], rpy=rpy)
            case 3:
                return HalfSpace(normal=rpy, offset=rng.uniform(-3.0, -1.0))
            case _:
                return Mesh(file=cube, center=center, rpy=rpy, scale=size)

    return tuple(one() for _ in range(count))


def is_ambiguous(reference: kinematics.Kinematics, q: np.ndarray, gains: Gains, rng: np.random.Generator) -> bool:
    """Whether q_dot jumps next to a configuration, because the nearest points of parallel features do."""
    here = resolution.gradient_projection(reference.state(q), points(TARGETS), gains)
    there = resolution.gradient_projection(reference.state(q + 1e-9 * rng.normal(size=q.size)), points(TARGETS), gains)
    return bool(np.linalg.norm(there - here) > 1e-5 * np.linalg.norm(here))


def test_q_dot_agrees_to_1e_10(robot: Robot, cube_file: str) -> None:
    """1,000 random configurations and scenes, in contact too."""
    rng = np.random.default_rng(1)
    compared = {"apart": 0, "contact": 0}
    for _ in range(200):
        obstacles = random_obstacles(rng, cube_file)
        gains = Gains(
            gain=rng.uniform(0.2, 3.0, 6), c_mu=rng.uniform(0, 2), c_kappa=rng.uniform(0, 2), epsilon=rng.uniform(0, 2)
        )
        fast, reference = NativeKinematics(robot, obstacles), kinematics.Kinematics(robot, obstacles)
        for _ in range(5):
            q = random_q(robot, rng)
            state = reference.state(q)
            expected = resolution.gradient_projection(state, points(TARGETS), gains)
            error = np.linalg.norm(projected_velocity(fast, points(TARGETS), gains)(q) - expected) / np.linalg.norm(
                expected
            )
            if error > 1e-10:
                assert is_ambiguous(reference, q, gains, rng), error
                continue
            compared["contact" if (state.clearance < 0).any() else "apart"] += 1
    assert sum(compared.values()) >= 990, compared
    assert min(compared.values()) >= 100, compared


@pytest.mark.parametrize("stretch", [0.3, 0.1, 0.03, 1e-3, 1e-6, 0.0])
def test_q_dot_agrees_next_to_singularities(
    robot: Robot, scene: Scene, rng: np.random.Generator, stretch: float
) -> None:
    """Stretched out towards a target out of reach, where the pseudo-inverse is damped; and an arm by itself."""
    fast, reference = NativeKinematics(robot, scene.obstacles), kinematics.Kinematics(robot, scene.obstacles)
    away = scene.model_copy(update={"targets": {"left": (-2.0, 2.0, 9.0), "right": (-2.0, 4.0, 4.0)}})
    stretched = plan(robot, away, "gradient-projection", dt=0.1).q[-20:]
    arm = np.array([random_q(robot, rng) for _ in range(20)])
    arm[:, 4:8] = [0.3, np.pi / 2, 0.4, stretch]
    smallest = []
    for q in [*(stretched + stretch * rng.normal(size=12)), *arm]:
        state = reference.state(q)
        smallest.append(np.linalg.svd(state.jacobian, compute_uv=False)[-1])
        expected = resolution.gradient_projection(state, points(TARGETS), Gains())
        np.testing.assert_allclose(
            projected_velocity(fast, points(TARGETS), Gains())(q), expected, rtol=1e-8, atol=1e-9
        )
        np.testing.assert_allclose(fast.state(q).manipulability, state.manipulability, rtol=1e-10, atol=1e-14)
    assert stretch > 0.01 or min(smallest) < 0.1 * resolution.SINGULAR_VALUE


def test_states_and_measurements_agree(robot: Robot, rng: np.random.Generator, cube_file: str) -> None:
    obstacles = random_obstacles(rng, cube_file, 10)
    fast, reference = NativeKinematics(robot, obstacles), kinematics.Kinematics(robot, obstacles)
    for _ in range(20):
        q = random_q(robot, rng)
        a, b = fast.state(q), reference.state(q)
        for name in ("q", "hands", "jacobian", "manipulability_gradient", "clearance"):
            np.testing.assert_allclose(getattr(a, name), getattr(b, name), rtol=1e-10, atol=1e-12, err_msg=name)
        # Where features are parallel the nearest points may differ, and with them the gradient.
        same = np.isclose(a.clearance_gradient, b.clearance_gradient, rtol=1e-6, atol=1e-6).all(axis=-1)
        assert same.mean() > 0.95
        for horizon in (0.0, 0.5, 1.0, np.inf):
            np.testing.assert_allclose(fast.measure(q, horizon).clearance, reference.measure(q, horizon).clearance)
    path = np.array([random_q(robot, rng) for _ in range(20)])
    for horizon in (0.0, 0.5, np.inf):
        for values, expected in zip(fast.along(path, horizon), reference.along(path, horizon), strict=True):
            np.testing.assert_allclose(values, expected, rtol=1e-10, atol=1e-12)


@pytest.mark.parametrize("offset", [0.0, 3.0, 300.0, 9000.0])
def test_the_nearest_obstacle_is_measured_however_far(robot: Robot, engine: str, offset: float) -> None:
    obstacles = (
        Sphere(center=(0.0, 7.0 + offset, 2.0), radius=0.3),
        Sphere(center=(0.0, 8.0 + offset, 2.0), radius=0.3),
    )
    measuring = KINEMATICS[engine](robot, obstacles)
    everything = measuring.measure(robot.initial).clearance
    near = measuring.measure(robot.initial, 0.5).clearance
    assert near.min() == everything.min()
    assert np.isinf(near[:, 1]).all()
    assert np.isfinite(everything).all()
    (course,) = measuring.along(robot.initial[None, :], 0.5).clearance
    np.testing.assert_array_equal(course, [everything.min(), np.inf])


def test_far_clearances_are_measured_only_when_asked_for(robot: Robot, scene: Scene, engine: str) -> None:
    near = plan(robot, scene, "gradient-projection", engine=engine, epsilon=0.6, dt=0.1)
    everything = plan(robot, scene, "gradient-projection", engine=engine, epsilon=0.6, dt=0.1, far_clearances=True)
    np.testing.assert_array_equal(near.q, everything.q)
    assert np.isfinite(everything.clearance).all()
    assert near.min_clearance == everything.min_clearance
    np.testing.assert_array_equal(near.clearance.min(axis=1), everything.clearance.min(axis=1))
    left_out = np.isinf(near.clearance)
    assert left_out.any()
    assert (everything.clearance[left_out] > 0.6).all()
    np.testing.assert_array_equal(near.clearance[~left_out], everything.clearance[~left_out])


@pytest.mark.parametrize("family", ["sparse", "shelf"])
def test_trajectories_agree_to_the_integrators_tolerance(robot: Robot, family: str) -> None:
    scene = load_scene(min((ROOT / "scenes" / "dev").glob(f"{family}-*.json")))
    tight = {"rtol": 1e-9, "atol": 1e-9, "max_time": 1.0, "dt": 0.05}
    a, b = (
        plan(robot, scene, "gradient-projection", **tight),
        plan(robot, scene, "gradient-projection", engine="python", **tight),
    )
    assert (a.engine, b.engine) == ("native", "python")
    assert a.status is b.status
    np.testing.assert_allclose(a.q, b.q, atol=1e-5)


@pytest.mark.parametrize("case", [1, 2, 3])
def test_the_papers_cases_agree(robot: Robot, case: int) -> None:
    loose = [humanoid_rail.plan_case(robot, case, engine=engine) for engine in ENGINES]
    tight = [humanoid_rail.plan_case(robot, case, engine=e, rtol=1e-10, atol=1e-10) for e in ENGINES]
    for (a, b), atol in ((loose, 5e-4), (tight, 1e-6)):
        assert a.status is b.status is Status.REACHED
        assert a.duration == pytest.approx(b.duration, abs=atol)
        np.testing.assert_allclose(a.q[:630], b.q[:630], atol=atol)
        np.testing.assert_allclose(a.clearance[:630], b.clearance[:630], atol=atol)
        assert [(v.joint, v.quantity) for v in a.violations] == [(v.joint, v.quantity) for v in b.violations]


def test_other_robots(rng: np.random.Generator, scene: Scene) -> None:
    """One hand, an arm that includes the rail, a passive joint that follows two others within the arm."""
    one = robot_from_urdf(
        load_robot().urdf,
        None,
        hands=[Hand("left", "left_hand", ("rail", "waist_pitch", "left_shoulder_pitch", "left_elbow_pitch"))],
    )
    fast, reference = NativeKinematics(one, scene.obstacles), kinematics.Kinematics(one, scene.obstacles)
    for _ in range(20):
        q = random_q(one, rng)
        expected = resolution.gradient_projection(reference.state(q), points(TARGETS[:1]), Gains())
        np.testing.assert_allclose(
            projected_velocity(fast, points(TARGETS[:1]), Gains())(q), expected, rtol=1e-9, atol=1e-10
        )


def test_limits_may_be_infinite(scene: Scene) -> None:
    robot = load_robot()
    model = robot.model.copy()
    model.velocityLimit[:] = np.inf
    model.effortLimit[:] = np.inf
    trajectory = plan(replace(robot, model=model), scene, "gradient-projection", dt=0.1)
    assert trajectory.engine == "native"
    np.testing.assert_array_equal(trajectory.q, plan(robot, scene, "gradient-projection", dt=0.1).q)


@pytest.mark.parametrize("q", [np.zeros(11), np.zeros(13), np.zeros((2, 12)), np.zeros(0)])
def test_configurations_of_the_wrong_size_are_refused(robot: Robot, q: np.ndarray) -> None:
    fast = NativeKinematics(robot)
    for call in (fast.state, fast.measure, lambda q: projected_velocity(fast, points(TARGETS), Gains())(q)):
        with pytest.raises((ValueError, TypeError)):
            call(q)
    with pytest.raises((ValueError, TypeError)):
        fast.along(q.reshape(1, -1) if q.ndim == 1 else q[:, :5])


NAN, INF = float("nan"), float("inf")


@pytest.mark.parametrize("bad", [NAN, INF])
def test_numbers_that_are_none_are_refused(robot: Robot, scene: Scene, bad: float) -> None:
    fast = NativeKinematics(robot, scene.obstacles)
    q, targets = robot.initial.copy(), TARGETS.copy()
    q[3] = targets[1, 2] = bad
    settings = Settings(tolerance=0.01, dt=0.01, max_time=60.0, rtol=1e-6, atol=1e-6)
    calls = (
        lambda: fast.state(q),
        lambda: fast.measure(q),
        lambda: fast.along(q[None, :]),
        lambda: projected_velocity(fast, points(TARGETS), Gains())(q),
        lambda: projected_velocity(fast, points(targets), Gains())(robot.initial),
        lambda: constrained_velocity(fast, points(TARGETS), Gains(), Safety(), 0.01)(q),
        lambda: constrained_velocity(fast, points(targets), Gains(), Safety(), 0.01)(robot.initial),
        lambda: rollout(fast, q, points(TARGETS), Gains(), Safety(), settings),
        lambda: certify(robot, scene.obstacles, np.array([0.0]), q[None, :]),
        lambda: integrate_natively(fast, q, points(TARGETS), Gains(), settings),
        lambda: integrate_natively(fast, robot.initial, points(targets), Gains(), settings),
    )
    for call in calls:
        with pytest.raises(ValueError, match="finite"):
            call()
    for change in ({"dt": 0.0}, {"dt": -1.0}, {"max_time": NAN}):
        with pytest.raises(ValueError, match="greater than 0"):
            integrate_natively(fast, robot.initial, points(TARGETS), Gains(), replace(settings, **change))


def test_unknown_obstacles_are_refused(robot: Robot) -> None:
    with pytest.raises(InvalidInput, match="obstacles"):
        NativeKinematics(robot, ({"type": "box"},))


def test_an_engine_is_named() -> None:
    for name in ("c++", "", None, 3):
        with pytest.raises(InvalidInput, match="native, python"):
            GradientProjection(engine=name)
