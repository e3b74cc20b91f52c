"""Measures the engine: an evaluation of eq. 4.9, a whole plan, many obstacles, many plans."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from benchmarks.stopwatch import Figure, Ratio, Works, each, figure, interleaved, once, ratio, repeated
from humanoid_rail._arrays import Array
from humanoid_rail._native import engine
from humanoid_rail.kinematics.kinematics import Kinematics
from humanoid_rail.kinematics.native_kinematics import NativeKinematics
from humanoid_rail.kinematics.native_tasks import native_tasks
from humanoid_rail.kinematics.task import PointTask
from humanoid_rail.kinematics.task_stack import count_rows
from humanoid_rail.model.library import load_robot
from humanoid_rail.model.native_robot import native_robot
from humanoid_rail.model.robot import Robot
from humanoid_rail.paper.cases import case_method, paper_scene, plan_case
from humanoid_rail.planning.batch import plan_many
from humanoid_rail.planning.planner import plan
from humanoid_rail.planning.target_tasks import tasks_of
from humanoid_rail.planning.verification import verify
from humanoid_rail.resolution.integrate import Settings
from humanoid_rail.resolution.native_options import native_gains, native_safety
from humanoid_rail.resolution.native_velocity import integrate_natively, projected_velocity
from humanoid_rail.resolution.qp import Safety
from humanoid_rail.resolution.velocity import Gains, gradient_projection
from humanoid_rail.scene.native_obstacles import native_obstacles
from humanoid_rail.scene.obstacles import Sphere
from humanoid_rail.scene.scene import Scene, make_scene, target_points

METHOD = "gradient-projection"
"""The method that many plans are measured with."""
COUNTS = (10, 100, 1000, 2000)
"""These numbers of spheres are measured."""
PER_METRE = 2.5
"""A metre of the aisle has this many spheres."""
EVERY_PAIR = 10.0
"""At this activation distance no pair of a link and an obstacle of the paper's scene is left out, m."""


def measure_evaluation(repeats: int, pink: bool) -> Iterator[Figure | Ratio]:
    """Measure one q_dot along case 3, all 18 pairs of a link and an obstacle within the activation distance."""
    robot, scene = load_robot(), paper_scene()
    q = plan_case(robot, 3).q[::8]
    works = {**_evaluations(robot, scene, q), **(_pinks(robot, scene, q) if pink else {})}
    times = interleaved(works, repeats)
    yield from (figure(f"eq. 4.9, 18 pairs: {name}", values) for name, values in times.items())
    called = times["native engine, called from Python"]
    floor, inner = times["the bare library calls"], times["native engine, called from C++"]
    yield ratio("evaluation: native engine / bare library calls, both called from C++", inner, floor)
    yield ratio("evaluation: Python engine / native engine called from Python", times["Python engine"], called)
    for name in ("along case 3", "solved everywhere"):
        yield ratio(f"evaluation: qp, {name} / eq. 4.9, both native", times[f"qp, {name}, called from C++"], inner)
    if pink:
        step = times["Pink, 18 barriers"]
        yield ratio("evaluation: Pink's step with barriers / native engine called from C++", step, inner)
        yield ratio("evaluation: Pink's step with barriers / native engine called from Python", step, called)


def _evaluations(robot: Robot, scene: Scene, q: Array) -> Works:
    """Return the evaluations of eq. 4.9 and of `qp` at configurations (N, n)."""
    native, tasks, gains = engine(), tasks_of(robot, scene.steps[0]), Gains(epsilon=EVERY_PAIR)
    fast, plain = NativeKinematics(robot, scene.obstacles), Kinematics(robot, scene.obstacles)
    assert (plain.along(q).clearance < gains.epsilon).all()
    state_at = fast.state_for_callback
    stack, converted = native_tasks(robot, tasks, state_at), native_gains(robot, gains, count_rows(tasks), state_at)
    bodies, obstacles = native_robot(robot), native_obstacles(scene.obstacles)
    velocity = projected_velocity(fast, tasks, gains)
    works: dict[str, Callable[[], float]] = {
        "the bare library calls": lambda: native.library_call_seconds(bodies, obstacles, q, 100),
        "native engine, called from C++": lambda: native.velocity_seconds(fast.native, q, stack, converted, 100),
        "native engine, called from Python": lambda: each(q, velocity),
        "Python engine": lambda: each(q, lambda x: gradient_projection(plain.state(x), tasks, gains)),
    }
    # At a large safety distance the program has to be solved at every one of these configurations.
    for name, safety in {"along case 3": Safety(), "solved everywhere": Safety(safety_distance=1.0)}.items():
        limits, dt = native_safety(safety, state_at), case_method(3).dt
        works[f"qp, {name}, called from C++"] = partial(
            native.safe_velocity_seconds, fast.native, q, stack, converted, limits, dt, 100
        )
    return works


def _pinks(robot: Robot, scene: Scene, q: Array) -> Works:
    from benchmarks.pink_baseline import Pink

    with_barriers, without = Pink(robot, scene), Pink(robot, scene, barriers=False)
    return {
        "Pink, 18 barriers": lambda: each(q, with_barriers.at),
        "Pink, no obstacles": lambda: each(q, without.at),
    }


def measure_plan(repeats: int, pink: bool) -> Iterator[Figure | Ratio]:
    """Measure case 3 of the paper, at its tolerances."""
    robot, scene = load_robot(), paper_scene()
    native, reference, safe = (
        case_method(3, far_clearances=False),
        case_method(3, far_clearances=False, engine="python"),
        case_method(3, "qp", far_clearances=False),
    )
    fast, tasks = NativeKinematics(robot, scene.obstacles), tasks_of(robot, scene.steps[0])
    options = native.options()
    settings = Settings(**{name: options[name] for name in ("tolerance", "dt", "max_time", "rtol", "atol")})
    start, found = np.array(robot.initial), plan(robot, scene, native)
    works: dict[str, Callable[[], float]] = {
        "integrated": lambda: repeated(lambda: integrate_natively(fast, start, tasks, native.gains, settings)),
        "certified": lambda: repeated(lambda: verify(robot, scene, found)),
        "planned, with samples and certificate": lambda: repeated(lambda: plan(robot, scene, native)),
        "planned by qp": lambda: repeated(lambda: plan(robot, scene, safe)),
        "planned by the Python engine": lambda: once(lambda: plan(robot, scene, reference)),
    }
    if pink:
        from benchmarks.pink_baseline import Pink

        works["Pink's rollout"] = lambda: once(Pink(robot, scene).rollout)
    times = interleaved(works, repeats)
    yield from (figure(f"case 3: {name}", values) for name, values in times.items())
    planned, integrated = times["planned, with samples and certificate"], times["integrated"]
    plain = planned - times["certified"]
    yield ratio("case 3: certified / integrated", times["certified"], integrated)
    yield ratio("case 3: planned, with samples, without certificate / integrated", plain, integrated)
    yield ratio("case 3: Python engine / native engine", times["planned by the Python engine"], planned)
    if pink:
        yield ratio("case 3: Pink's rollout / native plan without certificate", times["Pink's rollout"], plain)


def measure_obstacles(repeats: int) -> Iterator[Figure | Ratio]:
    """Measure one q_dot among ever more spheres, along an ever longer aisle."""
    native, robot = engine(), load_robot()
    rng = np.random.default_rng(2019)
    q = rng.uniform(robot.lower, robot.upper, (50, robot.n))
    q[:, 0] = rng.uniform(3.0, 5.0, 50)
    tasks = [PointTask(name, (-2.0, 3.0, 4.0)) for name in robot.hand_names]
    works: dict[str, Callable[[], float]] = {}
    for count in COUNTS:
        obstacles = aisle(count, rng)
        fast = NativeKinematics(robot, obstacles)
        stack = native_tasks(robot, tasks, fast.state_for_callback)
        gains = native_gains(robot, Gains(), count_rows(tasks), fast.state_for_callback)
        works[f"{count} spheres"] = partial(native.velocity_seconds, fast.native, q, stack, gains, 20)
        if count == 1000:
            every_pair = partial(native.library_call_seconds, native_robot(robot), native_obstacles(obstacles), q, 1)
            works["the bare library calls, 1000 spheres, every pair"] = every_pair
    times = interleaved(works, repeats)
    yield from (figure(f"eq. 4.9, {name}", values) for name, values in times.items())
    yield ratio("evaluation: 1,000 spheres / 10, as dense", times["1000 spheres"], times["10 spheres"])
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
    plan_many(robot, scenes[: min(plans, 64)], METHOD, n_jobs=2, progress=False)

    def on(processes: int) -> float:
        return once(lambda: plan_many(robot, scenes, METHOD, n_jobs=processes, progress=False)) / plans

    works = {"1 process": partial(on, 1), "2 processes": partial(on, 2)}
    times = interleaved(works, repeats)
    yield from (figure(f"a plan of {plans}: {name}", values) for name, values in times.items())
    yield ratio("plans per second: two processes / one", times["1 process"], times["2 processes"])


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
