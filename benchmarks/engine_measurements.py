"""Measurements of the engine, side by side: an evaluation of eq. 4.9, a whole plan, many obstacles, many plans."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from itertools import chain

import numpy as np

from benchmarks.stopwatch import Figure, Ratio, each, figure, interleaved, once, ratio, repeated
from humanoid_rail import (
    Gains,
    GradientProjection,
    Kinematics,
    NativeKinematics,
    Robot,
    SafeVelocity,
    Safety,
    Scene,
    Sphere,
    load_robot,
    make_scene,
    paper_scene,
    plan,
    plan_case,
    plan_many,
    verify,
)
from humanoid_rail._arrays import Array
from humanoid_rail._native import engine
from humanoid_rail.kinematics.native_tasks import native_tasks
from humanoid_rail.kinematics.task import PointTask, tasks_of
from humanoid_rail.model.native_robot import native_robot
from humanoid_rail.paper.cases import case_method
from humanoid_rail.resolution.integrate import Settings
from humanoid_rail.resolution.native_options import native_gains, native_safety
from humanoid_rail.resolution.native_velocity import integrate_natively, projected_velocity
from humanoid_rail.resolution.velocity import gradient_projection
from humanoid_rail.scene.native_obstacles import native_obstacles
from humanoid_rail.scene.scene import target_points

METHOD = GradientProjection()
"""This is what is measured unless something else is said."""
CASE = {"far_clearances": False}
"""The options of case 3 that differ from the paper's: clearances beyond the activation distance are not measured."""
COUNTS = (10, 100, 1000, 2000)
"""The numbers of spheres among which evaluations are measured."""
PER_METRE = 2.5
"""The number of spheres on a metre of the aisle."""


def measure_evaluation(repeats: int, pink: bool) -> Iterator[Figure | Ratio]:
    """Measure one q_dot along case 3, all 18 pairs of a link and an obstacle within the activation distance."""
    robot, scene = load_robot(), paper_scene()
    q = plan_case(robot, 3).q[::8]
    gains, tasks = Gains(epsilon=10.0), tasks_of(robot, scene.steps[0])
    native, plain = NativeKinematics(robot, scene.obstacles), Kinematics(robot, scene.obstacles)
    assert (plain.along(q).clearance < gains.epsilon).all()
    works = {
        **_native_evaluations(native, q, tasks, gains),
        "native engine, called from Python": lambda: each(q, projected_velocity(native, tasks, gains)),
        "Python engine": lambda: each(q, lambda x: gradient_projection(plain.state(x), tasks, gains)),
    }
    if pink:
        from benchmarks.pink_baseline import Pink

        with_barriers, without = Pink(robot, scene), Pink(robot, scene, barriers=False)
        works["Pink, 18 barriers"] = lambda: each(q, with_barriers.at)
        works["Pink, no obstacles"] = lambda: each(q, without.at)
    times = interleaved(works, repeats)
    yield from (figure(f"eq. 4.9, 18 pairs: {name}", values) for name, values in times.items())
    from_python, inner = times["native engine, called from Python"], times["native engine, called from C++"]
    calls = times["the bare library calls"]
    yield ratio("evaluation: native engine / bare library calls, both called from C++", inner, calls, most=1.5)
    yield ratio("evaluation: Python engine / native engine called from Python", times["Python engine"], from_python)
    for name in ("along case 3", "solved everywhere"):
        program = times[f"qp, {name}, called from C++"]
        yield ratio(f"evaluation: qp, {name} / eq. 4.9, both native", program, inner, most=6)
    if pink:
        step = times["Pink, 18 barriers"]
        yield ratio("evaluation: Pink's step with barriers / native engine called from C++", step, inner, least=200)
        yield ratio("evaluation: Pink's step with barriers / native engine called from Python", step, from_python)


def _native_evaluations(
    kinematics: NativeKinematics, q: Array, tasks: tuple[PointTask, ...], gains: Gains
) -> dict[str, Callable[[], float]]:
    """Return evaluations that are called and timed in C++, at configurations (N, n)."""
    robot, native, state_at = kinematics.robot, engine(), kinematics.state_for_callback
    stack = native_tasks(robot, tasks, state_at)
    converted = native_gains(gains, stack.rows, state_at)
    obstacles = native_obstacles(kinematics.obstacles)
    works: dict[str, Callable[[], float]] = {
        "the bare library calls": partial(native.library_call_seconds, native_robot(robot), obstacles, q, 100),
        "native engine, called from C++": partial(native.velocity_seconds, kinematics.native, q, stack, converted, 100),
    }
    # At a large safety distance the program has to be solved at every one of these configurations.
    for name, safety in {"along case 3": Safety(), "solved everywhere": Safety(safety_distance=1.0)}.items():
        options = (converted, native_safety(safety, state_at), METHOD.dt, 100)
        works[f"qp, {name}, called from C++"] = partial(
            native.safe_velocity_seconds, kinematics.native, q, stack, *options
        )
    return works


def measure_plan(repeats: int, pink: bool) -> Iterator[Figure | Ratio]:
    """Measure case 3 of the paper, at its tolerances."""
    robot, scene = load_robot(), paper_scene()
    method, kinematics = GradientProjection(), NativeKinematics(robot, scene.obstacles)
    by_qp, by_python = case_method(3, SafeVelocity.name, **CASE), case_method(3, engine="python", **CASE)
    tasks, gains = tasks_of(robot, scene.steps[0]), method.gains
    settings = Settings(method.tolerance, method.dt, method.max_time, method.rtol, method.atol)
    found = plan(robot, scene, case_method(3, **CASE))
    library = partial(
        engine().library_call_seconds, native_robot(robot), native_obstacles(scene.obstacles), found.q[::8], 100
    )
    works: dict[str, Callable[[], float]] = {
        "the bare library calls of one evaluation": library,
        "integrated": lambda: repeated(lambda: integrate_natively(kinematics, robot.initial, tasks, gains, settings)),
        "certified": lambda: repeated(lambda: verify(robot, scene, found)),
        "planned, with samples and certificate": lambda: repeated(lambda: plan(robot, scene, case_method(3, **CASE))),
        "planned by qp": lambda: repeated(lambda: plan(robot, scene, by_qp)),
        "planned by the Python engine": lambda: once(lambda: plan(robot, scene, by_python)),
    }
    if pink:
        from benchmarks.pink_baseline import Pink

        works["Pink's rollout"] = lambda: once(Pink(robot, scene).rollout)
    times = interleaved(works, repeats)
    yield from (figure(f"case 3: {name}", values) for name, values in times.items())
    yield from _plan_ratios(times, found.evaluations, len(found.t))


def _plan_ratios(times: dict[str, Array], evaluations: int, samples: int) -> Iterator[Ratio]:
    """Compare what planning case 3 takes with the library calls that it cannot do without."""
    calls, certified = times["the bare library calls of one evaluation"], times["certified"]
    planned = times["planned, with samples and certificate"]
    plain = planned - certified
    yield ratio("case 3: integration / library calls of its evaluations", times["integrated"], evaluations * calls)
    yield ratio("case 3: certificate / library calls at its samples", certified, samples * calls)
    yield ratio("case 3: Python engine / native engine", times["planned by the Python engine"], planned)
    if "Pink's rollout" in times:
        pinks = times["Pink's rollout"]
        yield ratio("case 3: Pink's rollout / native plan without certificate", pinks, plain, least=200)
    every = (evaluations + samples) * calls
    yield ratio("case 3: plan without certificate / library calls of evaluations and samples", plain, every)


def measure_obstacles(repeats: int) -> Iterator[Figure | Ratio]:
    """Measure one q_dot among ever more spheres, along an ever longer aisle."""
    robot, native = load_robot(), engine()
    rng = np.random.default_rng(2019)
    q = rng.uniform(robot.lower, robot.upper, (50, robot.n))
    q[:, 0] = rng.uniform(3.0, 5.0, 50)
    tasks = tuple(PointTask(name, (-2.0, 3.0, 4.0)) for name in robot.hand_names)
    works: dict[str, Callable[[], float]] = {}
    for count in COUNTS:
        kinematics = NativeKinematics(robot, aisle(count, rng))
        stack = native_tasks(robot, tasks, kinematics.state_for_callback)
        gains = native_gains(Gains(), stack.rows, kinematics.state_for_callback)
        works[f"{count} spheres"] = partial(native.velocity_seconds, kinematics.native, q, stack, gains, 20)
        if count == 1000:
            spheres = native_obstacles(kinematics.obstacles)
            every_pair = partial(native.library_call_seconds, native_robot(robot), spheres, q, 1)
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
    plan_many(robot, scenes[: min(plans, 64)], METHOD, n_jobs=2, progress=False)

    def on(processes: int) -> float:
        return once(lambda: plan_many(robot, scenes, METHOD, n_jobs=processes, progress=False)) / plans

    works = {"1 process": partial(on, 1), "2 processes": partial(on, 2)}
    times = interleaved(works, repeats)
    yield from (figure(f"a plan of {plans}: {name}", values) for name, values in times.items())
    yield ratio("plans per second: two processes / one", times["1 process"], times["2 processes"], least=1.8)


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


def measure_all(repeats: int, plans: int, pink: bool) -> Iterator[Figure | Ratio]:
    """Measure everything."""
    return chain(
        # First, while this process is as light as the workers.
        measure_batch(max(3, repeats // 2), plans),
        measure_evaluation(repeats, pink),
        measure_plan(repeats, pink),
        measure_obstacles(repeats),
    )
