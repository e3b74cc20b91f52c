"""Count how often the sampled filter of edges is too kind, and see that no plan rests on it. docs/auto.md tells more.

The filter says of an edge that it is free where samples of it are. The proof is what counts: edges that the filter lets
pass and the proof does not are counted, and those that the filter turns down although they are proven. Then scenes are
planned, and each edge of the paths that sampling found is proven once more.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import click
import numpy as np

from humanoid_rail import Robot, Scene, load_robot, load_scene
from humanoid_rail._arrays import Array
from humanoid_rail._native import engine
from humanoid_rail.cli.console import check_least, print_table, run
from humanoid_rail.collision.edge_checker import EdgeChecker
from humanoid_rail.kinematics.path_metric import speed_units
from humanoid_rail.model.native_robot import native_robot
from humanoid_rail.progress import progress_bar
from humanoid_rail.scene.native_obstacles import native_obstacles
from humanoid_rail.scene.scene import start_of_scene
from humanoid_rail.search.sampler import Sampler

ROBOTS = {
    "humanoid_rail": ("dev/shelf-*.json", "dev/dense-*.json", "dev/deep-*.json"),
    "panda": ("robots/panda-*.json",),
    "dual_fr3": ("robots/dual-fr3-*.json",),
    "talos": ("robots/talos-*.json",),
}
"""The robots, and the scenes among whose obstacles their edges are."""
SCENES = Path(__file__).parents[1] / "scenes"
DISTANCE = 0.0108
"""What edges keep, m: what `auto` asks of paths by default."""
LONGEST = 0.7
"""Edges take at most this long at the speed limits, s, as those of RRT-Connect."""
PATHS = 20
"""So many paths are looked for in each scene."""
CHECKS = 4000
"""The most edges that are checked for one path."""


@dataclass(frozen=True)
class Count:
    """What became of edges."""

    edges: int = 0
    valid: int = 0
    too_kind: int = 0
    too_strict: int = 0
    paths: int = 0
    path_edges: int = 0
    unproven: int = 0

    def __add__(self, other: Count) -> Count:
        return Count(*(getattr(self, name) + getattr(other, name) for name in self.__dataclass_fields__))


@click.command()
@click.option("--edges", default=100_000, show_default=True, help="Number of edges, of all robots together.")
@click.option("--seed", default=2019, show_default=True, help="Seed of the edges.")
@click.option("--readme", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="Markdown file to update.")
def main(edges: int, seed: int, readme: Path | None) -> int:
    """Compare the filter with the proof; exit code 1 if an edge of a path cannot be proven."""
    check_least(len(ROBOTS), edges=edges)
    check_least(0, seed=seed)
    counts = dict[str, Count]()
    for number, name in enumerate(ROBOTS):
        scenes = list(scenes_of(name))
        counts[name] = Count()
        with progress_bar(name, len(scenes)) as advance:
            for i, (robot, scene) in enumerate(scenes):
                share = edges // len(ROBOTS)
                count = share * (i + 1) // len(scenes) - share * i // len(scenes)
                rng = np.random.default_rng([seed, number, i])
                counts[name] += compared(robot, scene, count, rng) + planned(robot, scene, rng)
                advance(1)
    header = ("robot", "edges", "proven", "too kind", "too strict", "paths found", "edges in paths", "not proven")
    rows = [
        [name, *(f"{getattr(count, field)}" for field in count.__dataclass_fields__)] for name, count in counts.items()
    ]
    print_table("filter", "The sampled filter against the proof", header, rows, readme)
    return int(any(count.unproven for count in counts.values()))


def scenes_of(name: str) -> Iterator[tuple[Robot, Scene]]:
    """Yield the scenes of a robot with the robot that each is for."""
    files = sorted(file for pattern in ROBOTS[name] for file in SCENES.glob(pattern))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of limits and links without bodies
        robot = load_robot() if name == "humanoid_rail" else load_robot(name)
        for file in files:
            yield robot, load_scene(file)


def random_edges(
    robot: Robot, start: Array, checker: EdgeChecker, rng: np.random.Generator
) -> Iterator[tuple[Array, Array]]:
    """Yield edges without end that begin at valid configurations, between the start and anywhere."""
    units, moves = speed_units(robot), robot.velocity_limit > 0
    lower = np.where(moves, np.maximum(robot.lower, start - 4.0), start)
    upper = np.where(moves, np.minimum(robot.upper, start + 4.0), start)
    while True:
        a = start + rng.random() * (rng.uniform(lower, upper) - start)
        if not checker.is_valid(a):
            continue
        step = rng.uniform(lower, upper) - a
        b = a + min(1.0, rng.uniform(0.0, LONGEST) / float(np.linalg.norm(step / units))) * step
        yield a, b


def compared(robot: Robot, scene: Scene, edges: int, rng: np.random.Generator) -> Count:
    """Return what filter and proof say of random edges in a scene."""
    checker = EdgeChecker(robot, scene.obstacles, DISTANCE)
    seems = engine().EdgeFilter(native_robot(robot), native_obstacles(scene.obstacles), DISTANCE, 1.0).is_edge_free
    found = Count()
    some = random_edges(robot, start_of_scene(robot, scene), checker, rng)
    for (a, b), _ in zip(some, range(edges), strict=False):
        free, valid = seems(a, b), checker.is_edge_valid(a, b)
        found += Count(1, int(valid), int(free and not valid), int(valid and not free))
    return found


def planned(robot: Robot, scene: Scene, rng: np.random.Generator) -> Count:
    """Return how many edges of paths between random configurations in a scene can be proven."""
    checker = EdgeChecker(robot, scene.obstacles, DISTANCE)
    sampler = Sampler(robot, scene.obstacles, DISTANCE)
    start, found = start_of_scene(robot, scene), Count()
    if not checker.is_valid(start):
        return found
    goals = (a for a, _ in random_edges(robot, start, checker, rng))
    for goal, number in zip(goals, range(PATHS), strict=False):
        raw = sampler.connect(start, [goal], (robot.lower, robot.upper), number, LONGEST, CHECKS)
        path = None if raw is None else sampler.shorten(raw, number, CHECKS)
        if path is not None:
            proven = [checker.is_edge_valid(a, b) for a, b in pairwise(path)]
            found += Count(paths=1, path_edges=len(proven), unproven=proven.count(False))
    return found


if __name__ == "__main__":
    run(main)
