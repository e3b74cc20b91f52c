"""Plans scenes by several methods, and counts per family of scenes what came of it."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from benchmarks.planners import FAILED, NOTHING_PROVEN, Motion, Planner
from humanoid_rail.errors import MISSING, InvalidInput
from humanoid_rail.kinematics.path_metric import path_quality
from humanoid_rail.model.robot import Robot
from humanoid_rail.result import Status
from humanoid_rail.scene.scene import Scene, check_scene, is_of_a_scene, load_scene, start_of_scene

SUFFIXES = (".json", ".yaml", ".yml")
"""Scene files have one of these suffixes."""
ALL = "all"
"""The families together have this name."""
BEYOND = 1e-6
"""An excess over a limit counts from this on, m, rad, m/s or rad/s."""


@dataclass(frozen=True)
class Outcome:
    """What came of one scene by one method."""

    scene: str
    family: str
    method: str
    status: str
    """A :class:`humanoid_rail.Status`, or `failed`."""
    reason: str
    """The status in a sentence."""
    certified: bool
    """Whether the motion is proven free of contact."""
    touched: bool
    """Whether there is a contact."""
    excess: float
    """By how much the motion exceeds a limit at the most, m, rad, m/s or rad/s; 0 if it keeps to them."""
    planning_time: float
    """s, the certificate included."""
    duration: float
    """T, s."""
    path_length: float
    """Sum over the samples of the norm of dq / speed limit, s: at the speed limits no path takes longer."""
    sharpest_turn: float
    """The largest angle between two steps that follow each other, rad."""
    sampled_length: float | None
    """Of the path as a sampling planner found it first, s; None if none did."""
    sampled_turn: float | None
    """Of that, rad."""
    min_clearance_obstacles: float | None
    """m; None without obstacles."""
    min_clearance_self: float | None
    """m; None without pairs of links to check."""

    @property
    def reached(self) -> bool:
        """Whether the hands are at their targets, whatever happened before."""
        return self.status == Status.REACHED

    @property
    def good(self) -> bool:
        """Whether the hands are at their targets and the motion is proven free of contact."""
        return self.reached and self.certified


@dataclass(frozen=True)
class Row:
    """What came of the scenes of one family by one method: numbers of scenes, and figures over them."""

    family: str
    method: str
    scenes: int
    reached: int
    reached_and_certified: int
    certified: int
    touched: int
    beyond_limits: int
    """Motions that exceed a limit by more than 1e-6."""
    failed: int
    median_time: float
    """Of planning, the certificate included, s, over all scenes."""
    p95_time: float
    """95th percentile, s."""
    min_clearance_obstacles: float | None
    """Smallest of all motions, m."""
    min_clearance_self: float | None
    """Smallest of all motions, m."""
    path_length: float | None
    """Median of those that reached their targets, s."""
    sharpest_turn: float | None
    """The largest of those, rad."""
    sampled_length: float | None
    """Median of those that were sampled, as the sampling planner found them first, s."""
    sampled_turn: float | None
    """The largest of those, rad."""


@dataclass(frozen=True)
class Evaluation:
    """Everything that was found."""

    machine: str
    rows: list[Row]
    outcomes: list[Outcome]


def load_families(robot: Robot, folder: str, wanted: Sequence[str] = ()) -> list[Scene]:
    """Return the scenes in a folder, in the order of the files' names; see :func:`load_files`."""
    return list(load_files(robot, folder, wanted).values())


def load_files(robot: Robot, folder: str, wanted: Sequence[str] = ()) -> dict[Path, Scene]:
    """Return the scenes in a folder by their files, in the order of the files' names.

    Args:
        robot: What they are for.
        folder: Where the files are.
        wanted: The families to return; all if none is given.

    Raises:
        InvalidInput: If there are no scenes, one of them is not valid, or there is no such family.
    """
    place = Path(folder).resolve()
    files = sorted(path for path in place.iterdir() if path.suffix in SUFFIXES) if place.is_dir() else []
    if not files:
        valid = f"a folder with scenes ({', '.join(f'*{suffix}' for suffix in SUFFIXES)})"
        raise InvalidInput("scenes", MISSING, valid, source=folder)
    scenes = {}
    for file in files:
        scenes[file] = scene = load_scene(file)
        try:
            check_scene(robot, scene)
        except InvalidInput as error:
            error.source = str(file)
            raise
    families = sorted({family_of(scene) for scene in scenes.values()})
    for name in wanted:
        if name not in families:
            raise InvalidInput("family", name, f"one of {', '.join(families)}")
    return {file: scene for file, scene in scenes.items() if not wanted or family_of(scene) in wanted}


def family_of(scene: Scene) -> str:
    """Return a scene's name without the number at its end: `sparse` of `sparse-80000`."""
    return re.sub(r"(?<=.)-\d+$", "", scene.name)


def evaluate(
    robot: Robot,
    scenes: Sequence[Scene],
    planners: Mapping[str, Planner],
    advance: Callable[[int], None] = lambda more: None,
) -> list[Outcome]:
    """Return what comes of each scene by each method.

    The methods take turns, so that what slows the machine down slows all of them.

    Args:
        robot: What the scenes are for.
        scenes: What to plan.
        planners: What plans, by the names of the methods.
        advance: Told how many plans more are made.
    """
    outcomes = []
    for scene in scenes:
        for method, planner in planners.items():
            outcomes.append(judge(robot, scene, method, attempt(planner, robot, scene)))
            advance(1)
    return outcomes


def attempt(planner: Planner, robot: Robot, scene: Scene) -> Motion:
    """Return a motion for a scene; where the planner does not take the scene, one that stays at the start."""
    started = time.perf_counter()
    try:
        return planner(robot, scene)
    except InvalidInput as error:
        if not is_of_a_scene(error):
            raise
        planning_time = time.perf_counter() - started
        start = np.array(start_of_scene(robot, scene))
        return Motion(np.zeros(1), start[None], FAILED, str(error), NOTHING_PROVEN, (), planning_time)


def judge(robot: Robot, scene: Scene, method: str, motion: Motion) -> Outcome:
    """Return what came of a scene."""
    certificate, path = motion.certificate, path_quality(robot, motion.q)
    return Outcome(
        scene=scene.name,
        family=family_of(scene),
        method=method,
        status=str(motion.status),
        reason=motion.reason,
        certified=certificate.certified,
        touched=certificate.contact is not None,
        excess=max((abs(violation.value - violation.limit) for violation in motion.violations), default=0.0),
        planning_time=motion.planning_time,
        duration=float(motion.t[-1]),
        path_length=path.length,
        sharpest_turn=path.sharpest_turn,
        sampled_length=motion.sampled.length if motion.sampled else None,
        sampled_turn=motion.sampled.sharpest_turn if motion.sampled else None,
        min_clearance_obstacles=certificate.min_clearance_obstacles,
        min_clearance_self=certificate.min_clearance_self,
    )


def make_rows(outcomes: Sequence[Outcome]) -> list[Row]:
    """Return a row per family and method; if there are several families also one per method for all of them."""
    methods = dict.fromkeys(outcome.method for outcome in outcomes)
    families = sorted({outcome.family for outcome in outcomes})
    groups = [(family, {family}) for family in families]
    if len(families) > 1:
        groups.append((ALL, set(families)))
    return [
        make_row(name, method, [o for o in outcomes if o.family in members and o.method == method])
        for name, members in groups
        for method in methods
    ]


def make_row(family: str, method: str, outcomes: Sequence[Outcome]) -> Row:
    """Return what came of some scenes by one method."""
    median, p95 = np.quantile([o.planning_time for o in outcomes], [0.5, 0.95])
    lengths = [o.path_length for o in outcomes if o.reached]
    before = [o.sampled_length for o in outcomes if o.sampled_length is not None]
    return Row(
        family=family,
        method=method,
        scenes=len(outcomes),
        reached=sum(o.reached for o in outcomes),
        reached_and_certified=sum(o.good for o in outcomes),
        certified=sum(o.certified for o in outcomes),
        touched=sum(o.touched for o in outcomes),
        beyond_limits=sum(o.excess > BEYOND for o in outcomes),
        failed=sum(o.status == FAILED for o in outcomes),
        median_time=float(median),
        p95_time=float(p95),
        min_clearance_obstacles=least(o.min_clearance_obstacles for o in outcomes),
        min_clearance_self=least(o.min_clearance_self for o in outcomes),
        path_length=float(np.median(lengths)) if lengths else None,
        sharpest_turn=max((o.sharpest_turn for o in outcomes if o.reached), default=None),
        sampled_length=float(np.median(before)) if before else None,
        sampled_turn=max((o.sampled_turn for o in outcomes if o.sampled_turn is not None), default=None),
    )


def least(clearances: Iterable[float | None]) -> float | None:
    """Return the smallest clearance that there is, m."""
    return min((clearance for clearance in clearances if clearance is not None), default=None)
