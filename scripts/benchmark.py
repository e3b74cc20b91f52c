"""Measure the engines, side by side in one run: an evaluation of eq. 4.9, a whole plan, many obstacles, many plans."""

from __future__ import annotations

import json
import os
import platform
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

import click
import numpy as np

from humanoid_rail import (
    Gains,
    HumanoidRailError,
    InvalidInput,
    Kinematics,
    Robot,
    Safety,
    Scene,
    Sphere,
    load_robot,
    paper_scene,
    plan,
    plan_case,
    plan_many,
    verify,
)
from humanoid_rail.arrays import Array
from humanoid_rail.cli import console, print_table, progress, run
from humanoid_rail.engines import why_not_native
from humanoid_rail.integration import Settings
from humanoid_rail.paper import CASES, SETTINGS
from humanoid_rail.resolution import gradient_projection

Works = Mapping[str, Callable[[], float]]
"""Things to measure, by name: each returns how long one of its units took, s."""

METHOD = "gradient-projection"
"""What is measured unless something else is said."""
CASE = {**SETTINGS, **CASES[3], "far_clearances": False}
COUNTS = (10, 100, 1000, 2000)
"""Numbers of spheres."""
PER_METRE = 2.5
"""Spheres on a metre of the aisle."""
TIME_COLUMNS = ("measured", "median", "quartiles")
RATIO_COLUMNS = ("compared", "ratio", "quartiles", "wanted", "holds")
SETTLE = 0.05
"""How long one measurement lasts at the least, s."""


@dataclass(frozen=True)
class Figure:
    """How long something takes."""

    what: str
    median: float
    """s."""
    low: float
    """First quartile, s."""
    high: float
    """Third quartile, s."""
    repeats: int


@dataclass(frozen=True)
class Ratio:
    """One figure over another, repeat by repeat, so that what slows the machine down slows both."""

    what: str
    median: float
    low: float
    """First quartile."""
    high: float
    """Third quartile."""
    wanted: str
    """What it should be."""
    holds: bool
    """Whether it is."""


@dataclass(frozen=True)
class Report:
    """Everything measured."""

    machine: str
    figures: list[Figure]
    ratios: list[Ratio]


@click.command()
@click.option("--json", "json_file", type=click.Path(dir_okay=False, path_type=Path), help="File for the figures.")
@click.option(
    "--readme", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="Markdown file for the ratios."
)
@click.option(
    "--docs", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="Markdown file for the times."
)
@click.option("--repeats", default=9, show_default=True, help="Repeats of each measurement.")
@click.option("--plans", default=2000, show_default=True, help="Plans for the measurement of plan_many.")
@click.option("--pink/--no-pink", default=True, show_default=True, help="Compare with Pink (extra `compare`).")
def main(json_file: Path | None, readme: Path | None, docs: Path | None, repeats: int, plans: int, pink: bool) -> None:
    """Measure the engines and compare them with the bare library calls, with Pink and with each other.

    The first table has medians and quartiles, the second ratios within this run.
    """
    if (reason := why_not_native()) is not None:
        raise HumanoidRailError(f"there is no native engine to measure: {reason}")
    if pink and find_spec("pink") is None:
        raise HumanoidRailError("Pink is not installed: pip install 'humanoid_rail[compare]', or --no-pink")
    for name, value in (("repeats", repeats), ("plans", plans)):
        if value < 1:
            raise InvalidInput(name, value, "1 or more")
    measured_on = machine()
    figures: list[Figure] = []
    ratios: list[Ratio] = []
    for what, measured in (
        # First, while this process is as light as the workers.
        ("many plans", measure_batch(max(3, repeats // 2), plans)),
        ("an evaluation", measure_evaluation(repeats, pink)),
        ("a plan", measure_plan(repeats, pink)),
        ("many obstacles", measure_obstacles(repeats)),
    ):
        with progress(f"measuring {what}"):
            for found in measured:
                if isinstance(found, Figure):
                    figures.append(found)
                else:
                    ratios.append(found)
    report = Report(measured_on, figures, ratios)
    console.print(report.machine)
    rows = [[f.what, seconds(f.median), f"{seconds(f.low)} to {seconds(f.high)}"] for f in figures]
    print_table("times", "Times", TIME_COLUMNS, rows, docs)
    print_table("ratios", "Ratios and limits", RATIO_COLUMNS, [ratio_row(r) for r in ratios], readme)
    if json_file is not None:
        json_file.parent.mkdir(parents=True, exist_ok=True)
        json_file.write_text(json.dumps(asdict(report), indent=2) + "\n", encoding="utf-8")


def measure_evaluation(repeats: int, pink: bool) -> Iterator[Figure | Ratio]:
    """Measure one q_dot along case 3, all 18 pairs of a link and an obstacle within the activation distance."""
    from humanoid_rail import _engine, native

    robot, scene = load_robot(), paper_scene()
    q = plan_case(robot, 3).q[::8]
    targets = np.array([scene.targets[name] for name in robot.hand_names])
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
        from pink_baseline import Pink

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
    targets = np.array([scene.targets[name] for name in robot.hand_names])
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
        from pink_baseline import Pink

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
    scene = paper_scene()
    scenes: list[Scene] = []
    while len(scenes) < count:
        obstacles = aisle(10, rng)
        if Kinematics(robot, obstacles).measure(robot.initial).clearance.min() < 0.1:
            continue
        for _ in range(min(20, count - len(scenes))):
            targets = {hand: tuple(np.add(place, rng.uniform(-0.2, 0.2, 3))) for hand, place in scene.targets.items()}
            scenes.append(Scene(name=f"pick {len(scenes)}", targets=targets, obstacles=obstacles))
    return scenes


def interleaved(works: Works, repeats: int) -> dict[str, Array]:
    """Return how long each work took in each repeat (repeats,), s; the works take turns."""
    for work in works.values():
        work()
    times: dict[str, list[float]] = {name: [] for name in works}
    for _ in range(repeats):
        for name, work in works.items():
            times[name].append(work())
    return {name: np.array(values) for name, values in times.items()}


def each(q: Array, work: Callable[[Array], object]) -> float:
    """Return how long one call takes on average over configurations (N, n), s."""
    start = time.perf_counter()
    for row in q:
        work(row)
    return (time.perf_counter() - start) / len(q)


def once(work: Callable[[], object]) -> float:
    """Return how long a call takes, s."""
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def repeated(work: Callable[[], object]) -> float:
    """Return how long a short call takes on average, s."""
    calls = max(1, int(SETTLE / once(work)))
    return once(lambda: [work() for _ in range(calls)]) / calls


def figure(what: str, values: Array) -> Figure:
    """Return times as a figure."""
    low, median, high = np.quantile(values, [0.25, 0.5, 0.75])
    return Figure(what, float(median), float(low), float(high), len(values))


def ratio(what: str, above: Array, below: Array, least: float | None = None, most: float | None = None) -> Ratio:
    """Return the ratio of two works that took turns."""
    low, median, high = (float(x) for x in np.quantile(above / below, [0.25, 0.5, 0.75]))
    wanted = f"at least {least:g}" if least is not None else f"at most {most:g}" if most is not None else ""
    holds = (least is None or median >= least) and (most is None or median <= most)
    return Ratio(what, median, low, high, wanted, holds)


def limit(what: str, values: Array, most: float) -> Ratio:
    """Return a time in ms as a ratio to 1 ms."""
    return ratio(what, 1e3 * values, np.ones(len(values)), most=most)


def seconds(value: float) -> str:
    """Return a time with three digits and a unit."""
    for unit, factor in (("s", 1.0), ("ms", 1e3), ("us", 1e6)):
        if value * factor >= 1.0 or unit == "us":
            return f"{value * factor:.3g} {unit}"
    raise AssertionError


def ratio_row(r: Ratio) -> Sequence[str]:
    """Return a row of the table of ratios."""
    return [
        r.what,
        f"{r.median:.3g}",
        f"{r.low:.3g} to {r.high:.3g}",
        r.wanted,
        ("yes" if r.holds else "NO") if r.wanted else "",
    ]


def machine() -> str:
    """Return what this was measured on."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    python = platform.python_version()
    load = f"load {os.getloadavg()[0]:.1f}"
    libraries = f"Pinocchio {version('pin')}, coal {version('coal')}"
    return f"{platform.system()} {platform.machine()}, {cores} cores ({load} before), Python {python}, {libraries}"


if __name__ == "__main__":
    run(main)
