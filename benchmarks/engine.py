"""Measures the engines, side by side: an evaluation of eq. 4.9, a whole plan, many obstacles, many plans."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from humanoid_rail.planning.batch import plan_many
from benchmarks.stopwatch import (
    Figure,
    Ratio,
    each,
    figure,
    interleaved,
    limit,
    once,
    ratio,
    repeated,
)
from humanoid_rail.resolution.integrate import Settings
from humanoid_rail.kinematics.kinematics import Kinematics
from humanoid_rail.scene.obstacles import Sphere
from humanoid_rail.paper.cases import CASES, SETTINGS, paper_scene, plan_case
from humanoid_rail.planning.planner import plan
from humanoid_rail.resolution.velocity import Gains, gradient_projection
from humanoid_rail.model.robot import Robot, load_robot
from humanoid_rail.resolution.qp import Safety
from humanoid_rail.scene.scene import Scene, make_scene, target_points
from humanoid_rail.planning.verification import verify

METHOD = "gradient-projection"
"""What is measured unless something else is said."""
CASE = {**SETTINGS, **CASES[3], "far_clearances": False}
COUNTS = (10, 100, 1000, 2000)
"""Numbers of spheres."""
PER_METRE = 2.5
"""Spheres on a metre of the aisle."""


def measure_evaluation(repeats: int, pink: bool) -> Iterator[Figure | Ratio]:
    """Measure one q_dot along case 3, all 18 pairs of a link and an obstacle within the activation distance."""
    from humanoid_rail import _engine, native

    robot, scene = load_robot(), paper_scene()
    q = plan_case(robot, 3).q[::8]
    targets = target_points(robot, scene)
    gains = Gains(epsilon=10.0)
    fast, plain = native.Kinematics(robot, scene.obstacles), Kinematics(robot, scene.obstacles)
    assert (plain.along(q).clearance < gains.epsilon).all()
    native_gains = native.native_gains(gains, targets.size)
    native_robot, obstacles = native.native_robot(robot), native.native_obstacles(scene.obstacles)
    works: dict[str, Callable[[], float]] = {
        "the bare library calls": lambda: _engine.floor_seconds(native_robot, obstacles, q, 100),
        "native engine, called from C++": lambda: _engine.velocity_seconds(
            fast.engine, q, targets.ravel(), native_gains, 100
        ),
        "native engine, called from Python": lambda: each(q, fast.gradient_projection(targets, gains)),
        "Python engine": lambda: each(q, lambda x: gradient_projection(plain.state(x), targets, gains)),
    }
    # At a large safety distance the program has to be solved at every one of these configurations.
    for name, safety in {"along case 3": Safety(), "solved everywhere": Safety(safety_distance=1.0)}.items():
        limits = native.native_safety(safety)
        works[f"qp, {name}, called from C++"] = partial(
            _engine.safe_velocity_seconds, fast.safe, q, targets.ravel(), native_gains, limits, CASE["dt"], 100
        )
    if pink:
        from benchmarks.pink_baseline import Pink

        with_barriers, without = Pink(robot, scene), Pink(robot, scene, barriers=False)
        works["Pink, 18 barriers"] = lambda: each(q, with_barriers.at)
        works["Pink, no obstacles"] = lambda: each(q, without.at)
    times = interleaved(works, repeats)
    yield from (figure(f"eq. 4.9, 18 pairs: {name}", values) for name, values in times.items())
    engine = times["native engine, called from Python"]
    floor, inner = times["the bare library calls"], times["native engine, called from C++"]
    yield ratio("evaluation: native engine / bare library calls, both called from C++", inner, floor, most=1.5)
    yield ratio("evaluation: Python engine / native engine called from Python", times["Python engine"], engine)
    for name in ("along case 3", "solved everywhere"):
        yield ratio(
            f"evaluation: qp, {name} / eq. 4.9, both native", times[f"qp, {name}, called from C++"], inner, most=6
        )
    if pink:
        step = times["Pink, 18 barriers"]
        yield ratio("evaluation: Pink's step with barriers / native engine called from C++", step, inner, 200)
        yield ratio("evaluation: Pink's step with barriers / native engine called from Python", step, engine)


def measure_plan(repeats: int, pink: bool) -> Iterator[Figure | Ratio]:
    """Measure case 3 of the paper, at its tolerances."""
    from humanoid_rail import native

    robot, scene = load_robot(), paper_scene()
    fast = native.Kinematics(robot, scene.obstacles)
    targets = target_points(robot, scene)
    gains = Gains(CASE["gain"], CASE["c_mu"], CASE["c_kappa"], CASE["epsilon"])
    settings = Settings(**{name: CASE[name] for name in ("tolerance", "dt", "max_time", "rtol", "atol")})

    found = plan(robot, scene, METHOD, **CASE)

    def integrated() -> object:
        return native.integrate(fast, robot.initial, targets, gains, settings)

    works = {
        "integrated": lambda: repeated(integrated),
        "certified": lambda: repeated(lambda: verify(robot, scene, found)),
        "planned, with samples and certificate": lambda: repeated(lambda: plan(robot, scene, METHOD, **CASE)),
        "planned by qp": lambda: repeated(lambda: plan(robot, scene, "qp", **CASE)),
        "planned by the Python engine": lambda: once(lambda: plan(robot, scene, METHOD, engine="python", **CASE)),
    }
    if pink:
        from benchmarks.pink_baseline import Pink

        works["Pink's rollout"] = lambda: once(Pink(robot, scene).rollout)
    times = interleaved(works, repeats)
    yield from (figure(f"case 3: {name}", values) for name, values in times.items())
    planned = times["planned, with samples and certificate"]
    yield limit("case 3 integrated, ms", times["integrated"], 1.5)
    yield limit("case 3 certified, ms", times["certified"], 1.0)
    yield ratio("case 3: Python engine / native engine", times["planned by the Python engine"], planned)
    plain = planned - times["certified"]
    yield limit("case 3 planned, with samples, without certificate, ms", plain, 3.0)
    if pink:
        yield ratio("case 3: Pink's rollout / native plan without certificate", times["Pink's rollout"], plain, 200)


def measure_obstacles(repeats: int) -> Iterator[Figure | Ratio]:
    """Measure one q_dot among ever more spheres, along an ever longer aisle."""
    from humanoid_rail import _engine, native

    robot = load_robot()
    rng = np.random.default_rng(2019)
    q = rng.uniform(robot.lower, robot.upper, (50, robot.n))
    q[:, 0] = rng.uniform(3.0, 5.0, 50)
    gains = native.native_gains(Gains(), 3 * len(robot.hands))
    targets = np.tile([-2.0, 3.0, 4.0], len(robot.hands))
    works: dict[str, Callable[[], float]] = {}
    for count in COUNTS:
        obstacles = aisle(count, rng)
        method = native.Kinematics(robot, obstacles).engine
        spheres = native.native_obstacles(obstacles)
        works[f"{count} spheres"] = partial(_engine.velocity_seconds, method, q, targets, gains, 20)
        if count == 1000:
            every_pair = partial(_engine.floor_seconds, native.native_robot(robot), spheres, q, 1)
            works["the bare library calls, 1000 spheres, every pair"] = every_pair
    times = interleaved(works, repeats)
    yield from (figure(f"eq. 4.9, {name}", values) for name, values in times.items())
    yield ratio("evaluation: 1,000 spheres / 10, as dense", times["1000 spheres"], times["10 spheres"], most=4.0)
    yield ratio("evaluation: 2,000 spheres / 10, as dense", times["2000 spheres"], times["10 spheres"])


def aisle(count: int, rng: np.random.Generator) -> tuple[Sphere, ...]:
    """Return spheres on both sides of the rail, as many on each metre, the middle of the aisle at y = 3 m."""
    half = count / PER_METRE / 2
    side = rng.choice([-1.0, 1.0], count)
    places = np.column_stack(
        [side * rng.uniform(1.2, 3.0, count), 3.0 + rng.uniform(-half, half, count), rng.uniform(0.5, 5.0, count)]
    )
    return tuple(
        Sphere(center=place, radius=radius) for place, radius in zip(places, rng.uniform(0.05, 0.2, count), strict=True)
    )


def measure_batch(repeats: int, plans: int) -> Iterator[Figure | Ratio]:
    """Measure plan_many on one process, this one, and on two others that are warm."""
    robot = load_robot()
    scenes = picks(robot, plans)
    plan_many(robot, scenes[: min(plans, 64)], n_jobs=2, progress=False, method=METHOD)

    def on(processes: int) -> float:
        return once(lambda: plan_many(robot, scenes, n_jobs=processes, progress=False, method=METHOD)) / plans

    works = {"1 process": partial(on, 1), "2 processes": partial(on, 2)}
    times = interleaved(works, repeats)
    yield from (figure(f"a plan of {plans}: {name}", values) for name, values in times.items())
    yield ratio("plans per second: two processes / one", times["1 process"], times["2 processes"], 1.8)


def picks(robot: Robot, count: int) -> list[Scene]:
    """Return scenes in which both hands have to reach a place each, among ten spheres that the start is clear of."""
    rng = np.random.default_rng(2019)
    places = target_points(robot, paper_scene())
    scenes: list[Scene] = []
    while len(scenes) < count:
        obstacles = aisle(10, rng)
        if Kinematics(robot, obstacles).measure(robot.initial).clearance.min() < 0.1:
            continue
        for _ in range(min(20, count - len(scenes))):
            points = (places + rng.uniform(-0.2, 0.2, places.shape)).tolist()
            targets = dict(zip(robot.hand_names, points, strict=True))
            scenes.append(make_scene({"name": f"pick {len(scenes)}", "targets": targets, "obstacles": obstacles}))
    return scenes
