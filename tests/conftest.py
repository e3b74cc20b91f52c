"""Fixtures and checks that the tests share."""

from __future__ import annotations

import shutil
import sys
import warnings
from collections.abc import Callable, Iterator
from dataclasses import replace
from importlib import metadata
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import humanoid_rail
from humanoid_rail import (
    Box,
    Capsule,
    HalfSpace,
    NativeKinematics,
    PointTask,
    Robot,
    Scene,
    Sphere,
    Timing,
    Trajectory,
    load_robot,
    paper_scene,
)
from humanoid_rail import Kinematics as PythonKinematics
from humanoid_rail._native import why_no_engine
from humanoid_rail.planning.methods import METHODS
from humanoid_rail.planning.options import ENGINES
from humanoid_rail.samples import known_samples
from humanoid_rail.scene.obstacles import Obstacle

ROOT = Path(__file__).resolve().parent.parent
for folder in ("", "scripts", "tests/cli"):
    sys.path.insert(0, str(ROOT / folder))

AHEAD = {"left": (-1.6, 0.6, 3.4), "right": (-1.6, 2.2, 3.4)}
"""Targets that the robot can reach where nothing is in the way."""
KINEMATICS = {"native": NativeKinematics, "python": PythonKinematics}
"""The class of each engine."""


def plan(robot: Robot, scene: Scene, method: str = "auto", **options: Any) -> Trajectory:
    """Plan by a method of this name with these options."""
    known = isinstance(method, str) and method in METHODS
    return humanoid_rail.plan(robot, scene, METHODS[method](**options) if known else method)


def plan_many(
    robot: Robot, scenes: Any, *, n_jobs: Any = -1, progress: bool | None = None, method: str = "auto", **options: Any
) -> list[Any]:
    """Plan many scenes by a method of this name with these options."""
    known = isinstance(method, str) and method in METHODS
    chosen = METHODS[method](**options) if known else method
    return humanoid_rail.plan_many(robot, scenes, chosen, n_jobs=n_jobs, progress=progress)


LINKS = {"base_link": "B", "carriage": "rs", "waist": "T1", "lower_torso": "T2", "upper_torso": "T3", "chest": "T4"} | {
    f"{side}_{link}": f"{side[0].upper()}{i}"
    for side in ("left", "right")
    for i, link in enumerate(("clavicle", "shoulder", "upper_arm", "elbow", "forearm"))
}
LINKS |= {"left_hand": "pL", "right_hand": "pR"}
"""The paper's frame of every URDF link."""


@pytest.fixture(scope="session", autouse=True)
def _cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Keep convex pieces of meshes in a folder of the tests, which all their processes share."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.getbasetemp().parent / "cache"))
        yield


@pytest.fixture(scope="session")
def robot() -> Robot:
    return load_robot()


@pytest.fixture(scope="session")
def scene() -> Scene:
    return paper_scene()


@pytest.fixture
def rng() -> np.random.Generator:
    return np.random.default_rng(20190101)


@pytest.fixture(scope="session", params=ENGINES)
def engine(request: pytest.FixtureRequest) -> str:
    """Each engine in turn. Where there is a compiler the native one has to be there."""
    if request.param == "native" and (reason := why_no_engine()):
        (pytest.fail if shutil.which("c++") else pytest.skip)(f"no native engine: {reason}")
    return request.param


@pytest.fixture(scope="session")
def Kinematics(engine: str) -> type:
    """The class of each engine."""
    return KINEMATICS[engine]


class Plan(Protocol):
    def __call__(self, robot: Robot, scene: Scene, method: str = ..., **arguments: Any) -> Trajectory: ...


@pytest.fixture(scope="session", name="plan")
def _plan(engine: str) -> Plan:
    """`humanoid_rail.plan` with each engine, by the paper's method unless another is asked for."""

    def plan_with_engine(robot: Robot, scene: Scene, method: str = "gradient-projection", **options: Any) -> Trajectory:
        if method == "gradient-projection":
            options = {"engine": engine, **options}
        return plan(robot, scene, method, **options)

    return plan_with_engine


@pytest.fixture(scope="session")
def free() -> Scene:
    """A scene without obstacles."""
    return humanoid_rail.make_scene({"name": "free", "targets": {"left": [0.6, -1.8, 2.6], "right": [0.6, 1.8, 2.6]}})


@pytest.fixture(scope="session")
def planned(robot: Robot, free: Scene) -> Trajectory:
    """A motion in it, linear between its samples."""
    return humanoid_rail.plan(robot, free, humanoid_rail.Auto(optimise=False))


@pytest.fixture(scope="session")
def motion(robot: Robot, scene: Scene) -> Trajectory:
    """The paper's third case, retimed."""
    return humanoid_rail.retime(humanoid_rail.plan_case(robot, 3), robot, scene)


def package_robot(name: str, **fields: Any) -> Robot:
    """Return a robot of another package, `PACKAGE:ROBOT`, with some fields of a robot file; skip if it is not there."""
    package = name.partition(":")[0]
    try:
        metadata.version(package)
    except metadata.PackageNotFoundError:
        pytest.skip(f"{package}, a package of models, is not installed")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of limits and links without bodies
        return load_robot(name, **fields)


def changed(trajectory: Trajectory, **values: Any) -> Trajectory:
    """Return a trajectory with some fields of its parts changed."""
    parts = {
        name: {field: values.pop(field) for field in list(values) if hasattr(getattr(trajectory, name), field)}
        for name in ("motion", "samples", "verdict", "provenance")
    }
    assert not values, values
    samples = trajectory.samples
    if new := parts.pop("samples"):
        hand_names = new.pop("hand_names", samples.hand_names)
        samples = known_samples(hand_names, samples.course._replace(**new))
    others = {name: replace(getattr(trajectory, name), **new) for name, new in parts.items()}
    return replace(trajectory, samples=samples, **others)


def points(targets: np.ndarray, hands: tuple[str, ...] = ("left", "right")) -> tuple[PointTask, ...]:
    """Return tasks that put hands at points (h, 3)."""
    at = np.asarray(targets, float).reshape(-1, 3).tolist()
    return tuple(PointTask(hand, (x, y, z)) for hand, (x, y, z) in zip(hands, at, strict=False))


def random_scene(rng: np.random.Generator, speed: float = 0.0) -> Scene:
    def place() -> tuple[float, ...]:
        return tuple(np.array([0.0, 2.0, 2.8]) + rng.uniform(-2.5, 2.5, 3))

    moves = tuple(speed * rng.uniform(-1, 1, 3))
    return Scene(
        name="some",
        targets=AHEAD,
        obstacles=(
            Sphere(center=place(), radius=rng.uniform(0.05, 0.4), velocity=moves),
            Box(center=place(), size=tuple(rng.uniform(0.05, 0.8, 3)), rpy=tuple(rng.uniform(-2, 2, 3))),
            Capsule(center=place(), radius=0.1, length=0.7, rpy=tuple(rng.uniform(-2, 2, 3)), velocity=moves),
            HalfSpace(normal=(0.1, 0.0, 1.0), offset=rng.uniform(-1.5, 0.0), velocity=(0.0, 0.0, 0.1 * speed)),
        ),
    )


def in_order(sides: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return the rows of constraints (k, n) behind their sides (k,), sorted: each engine has an order of its own."""
    table = np.column_stack([sides, rows])
    return table[np.lexsort(np.round(table, 6).T[::-1])]


def some_obstacles(rng: np.random.Generator, count: int = 6, speed: float = 0.0) -> tuple[Obstacle, ...]:
    """Return spheres, capsules and boxes around the robot."""

    def place() -> tuple[float, ...]:
        return tuple(np.array([0.0, 2.0, 2.8]) + rng.uniform(-2.2, 2.2, 3))

    def velocity() -> tuple[float, ...]:
        return tuple(speed * rng.uniform(-1, 1, 3))

    kinds = (
        lambda: Sphere(center=place(), radius=rng.uniform(0.1, 0.4), velocity=velocity()),
        lambda: Capsule(center=place(), radius=0.1, length=0.8, rpy=tuple(rng.uniform(-1, 1, 3)), velocity=velocity()),
        lambda: Box(center=place(), size=tuple(rng.uniform(0.1, 0.8, 3)), velocity=velocity()),
    )
    return tuple(kinds[i % 3]() for i in range(count))


def random_q(robot: Robot, rng: np.random.Generator) -> np.ndarray:
    """Return a random configuration within the limits, the rail where the obstacles of the tests are."""
    q = rng.uniform(robot.lower, robot.upper)
    q[0] = rng.uniform(0.0, 4.0)
    return q


@pytest.fixture(scope="session")
def folded_q(robot: Robot) -> np.ndarray:
    """A configuration within the limits in which links that may collide are inside each other."""
    rng = np.random.default_rng(3)
    kinematics = humanoid_rail.Kinematics(robot)
    while True:
        q = rng.uniform(robot.lower, robot.upper)
        if kinematics.measure(q).self_clearance.min() < -0.02:
            return q


def central_difference(f: Callable[[np.ndarray], np.ndarray], q: np.ndarray, h: float = 1e-6) -> np.ndarray:
    """Return df/dq, the last axis the column, by central differences."""
    columns = [(np.asarray(f(q + step)) - np.asarray(f(q - step))) / (2 * h) for step in h * np.eye(q.size)]
    return np.stack(columns, axis=-1)


def assert_gradient(
    f: Callable[[np.ndarray], np.ndarray], gradient: np.ndarray, q: np.ndarray, rtol: float = 1e-6
) -> None:
    """Hold a gradient, every column of it, against central differences: error at most rtol of the gradient's norm."""
    numeric = central_difference(f, q)
    assert numeric.shape == gradient.shape
    assert np.linalg.norm(gradient - numeric) <= rtol * np.linalg.norm(gradient)


def rest_to_rest(robot: Robot, trajectory: Trajectory, duration: float, dt: float = 0.01) -> Trajectory:
    """Return a motion along the path of another from rest to rest: by a polynomial of degree five in the path's length.

    Neither limits nor clearances are looked at.
    """
    steps = np.linalg.norm(np.diff(trajectory.q, axis=0) / robot.velocity_limit, axis=1)
    length = np.concatenate([[0.0], np.cumsum(steps)])
    t = np.linspace(0.0, duration, round(duration / dt) + 1)
    u = t / duration
    s = length[-1] * np.clip(10 * u**3 - 15 * u**4 + 6 * u**5, 0.0, 1.0)
    speed = (length[-1] / duration * 30 * (u**2 - 2 * u**3 + u**4))[:, None]
    gain = (length[-1] / duration**2 * 60 * (u - 3 * u**2 + 2 * u**3))[:, None]
    path = CubicSpline(length, trajectory.q)
    timing = Timing(path(s, 1) * speed, path(s, 2) * speed**2 + path(s, 1) * gain, ())
    kinematics = humanoid_rail.Kinematics(robot)
    hands = np.array([kinematics.hand_positions(q) for q in path(s)]).reshape(len(t), -1, 3)
    clearance, ones = np.full((len(t), trajectory.clearance.shape[1]), np.inf), np.ones(len(t))
    return changed(
        trajectory, t=t, q=path(s), hands=hands, clearance=clearance, manipulability=ones, timing=timing, arrivals=()
    )


@pytest.fixture(scope="session")
def cube_file(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A unit cube around the origin, as a mesh file."""
    import trimesh

    path = tmp_path_factory.mktemp("meshes") / "cube.stl"
    trimesh.creation.box((1.0, 1.0, 1.0)).export(path)
    return str(path)
