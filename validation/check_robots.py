"""Check the robots of the gallery against their URDFs and meshes, which Pinocchio loads by itself.

1. What touches by the meshes touches by the bodies, at all pairs that are checked, in random postures.
2. Few postures that are free by the meshes are lost.
3. Every link is where Pinocchio has it.
4. Plans of the gallery's scenes touch nothing by the meshes, every 4 mm.
5. A motion that is certified touches nothing by the meshes, and its bound is not above their distance.
"""

from __future__ import annotations

import os
import time
import warnings
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory

import click
import numpy as np
import pinocchio as pin

from humanoid_rail import Box, Robot, load_robot, load_scene, plan
from humanoid_rail._arrays import Array
from humanoid_rail._resources import resource
from humanoid_rail.cli.console import check_least, console, print_table, run
from humanoid_rail.collision.certifier import certify
from humanoid_rail.model.library import PAPER, robots
from humanoid_rail.model.robot_file import read_robot_file
from humanoid_rail.model.sources import package_root
from humanoid_rail.progress import progress_bar
from humanoid_rail.scene.scene import Scene
from validation.original_robots import Original, Pair, collide, frames_of, load_original

PRECISION = 1e-6
"""Bounds are precise to this, m."""
STEP = 0.004
"""Between two looks at a plan no body moves farther, m."""
CERTIFIED = ("baxter", "dual_fr3", "panda", "kinova", "talos")
"""The motions of these robots are looked at."""
LOOKS = 60
"""A random motion is looked at so many times."""


@dataclass(frozen=True, eq=False)
class Case:
    """A robot as it is loaded, and as its maker wrote it."""

    name: str
    robot: Robot
    original: Original

    @cached_property
    def bodies_of(self) -> dict[int, list[int]]:
        """The convex bodies that stand for each body of the original, by index."""
        found: dict[int, list[int]] = {}
        for index, body in enumerate(self.robot.collision_model.geometryObjects):
            link = self.robot.link_names[index]
            number = body.name.removeprefix(f"{link}_").partition(".")[0]
            found.setdefault(self.original.names.index(f"{link}_{number}"), []).append(index)
        return found

    @cached_property
    def pairs(self) -> dict[Pair, list[Pair]]:
        """The pairs of the original that are checked, each with those of bodies."""
        of = {body: index for index, bodies in self.bodies_of.items() for body in bodies}
        found: dict[Pair, list[Pair]] = {}
        for i, j in self.robot.self_collision_pairs:
            a, b = sorted((of[i], of[j]))
            found.setdefault((a, b), []).append((i, j))
        return found

    def positions(self, q: Array) -> dict[str, float]:
        """Return the positions of all joints of the original by name, m and rad."""
        model, full = self.robot.model, self.robot.full_configuration(q)
        moving = {model.names[i]: float(full[model.joints[i].idx_q]) for i in range(1, model.njoints)}
        return {**self.robot.locked, **moving}

    def places(self, q: Array) -> list[pin.SE3]:
        """Return where the bodies of the original are."""
        return self.original.places(self.positions(q))

    def touching(self, q: Array) -> set[Pair]:
        """Return the pairs of the original that touch by the convex bodies."""
        bodies, data = self.robot.collision_model.geometryObjects, self.robot.model.createData()
        pin.forwardKinematics(self.robot.model, data, self.robot.full_configuration(q))
        at = [data.oMi[body.parentJoint] * body.placement for body in bodies]

        def touch(i: int, j: int) -> bool:
            return collide(bodies[i].geometry, at[i], bodies[j].geometry, at[j])

        return {pair for pair, ours in self.pairs.items() if any(touch(i, j) for i, j in ours)}


def load_case(name: str) -> Case:
    """Return a robot of the gallery with its original."""
    file = read_robot_file(resource("robots", f"{name}/robot.yaml"))
    assert file.package is not None
    root = package_root(file.package.partition(">")[0].partition("=")[0])
    path = root / file.urdf
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        robot = load_robot(name)
    return Case(name, robot, load_original(path, [*path.parents][: len(path.parents) - len(root.parents) + 2]))


@click.command()
@click.option("--robot", "names", multiple=True, help="Robots to look at; all of the gallery if not given.")
@click.option("--postures", default=400, show_default=True, help="Random postures of each robot.")
@click.option("--motions", default=25, show_default=True, help="Random motions of each of five robots.")
@click.option("--seed", default=2026, show_default=True, help="Seed of the postures and motions.")
@click.option("--readme", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="Markdown file to update.")
def main(names: tuple[str, ...], postures: int, motions: int, seed: int, readme: Path | None) -> int:
    """Check robots against their meshes; exit code 1 if anything is wrong."""
    check_least(1, postures=postures, motions=motions)
    check_least(0, seed=seed)
    gallery = names or tuple(name for name in robots() if name != PAPER)
    loads, plans, proofs, broken = [], [], [], []
    with progress_bar("checking", len(gallery)) as advance:
        for name in gallery:
            case, rng = load_case(name), np.random.default_rng(seed)
            row, wrong = check_postures(case, postures, rng)
            loads.append([name, *load_times(name), *row])
            broken += wrong
            for row, wrong in (check_plan(case, file) for file in scenes_of(name)):
                plans.append(row)
                broken += wrong
            if name in CERTIFIED:
                row, wrong = check_motions(case, motions, rng)
                proofs.append([name, *row])
                broken += wrong
            advance(1)
    columns = (
        "robot",
        "first load, s",
        "again, s",
        "joints",
        "bodies",
        "pairs",
        "left out",
        "missed",
        "lost",
        "links off by, m",
    )
    print_table("robots", f"{postures} random postures, seed {seed}", columns, loads, readme)
    print_table("robot-plans", "Plans", ("scene", "status", "bound, mm", "looks", "touching"), plans, readme)
    print_table("robot-proofs", "Random motions", ("robot", "motions", "certified", "wrong"), proofs, readme)
    for line in broken:
        console().print(line, soft_wrap=True)
    return 1 if broken else 0


def load_times(name: str) -> list[str]:
    """Return how long a robot takes to load without and with what is kept of it, s."""
    before, took = os.environ.get("XDG_CACHE_HOME"), []
    with TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        os.environ["XDG_CACHE_HOME"] = folder
        try:
            for _ in range(2):
                began = time.perf_counter()
                load_robot(name)
                took.append(f"{time.perf_counter() - began:.2f}")
        finally:
            os.environ.pop("XDG_CACHE_HOME")
            if before is not None:
                os.environ["XDG_CACHE_HOME"] = before
    return took


def check_postures(case: Case, count: int, rng: np.random.Generator) -> tuple[list[str], list[str]]:
    """Return the row of a robot, and what is wrong: contacts that are missed, links that are elsewhere."""
    robot, missed, free, lost, off = case.robot, [], 0, 0, 0.0
    for k, q in enumerate(rng.uniform(robot.lower, robot.upper, (count, robot.n))):
        real = case.original.touching(case.places(q), case.pairs)
        ours = case.touching(q)
        missed += sorted(real - ours)
        free += not real
        lost += not real and bool(ours)
        if k < 10:
            off = max(off, _off(case, q))
    names = case.original.names
    wrong = [f"{case.name}: {names[i]} and {names[j]} touch, and their bodies do not" for i, j in missed]
    if off > 1e-9:
        wrong.append(f"{case.name}: a link is off by {off:.3g} m")
    share = lost / free if free else 0.0
    counts = [robot.n, robot.collision_model.ngeoms, len(robot.self_collision_pairs), len(robot.left_out), len(missed)]
    return [*map(str, counts), f"{share:.1%}", f"{off:.0e}"], wrong


def _off(case: Case, q: Array) -> float:
    """Return how far links are from where Pinocchio has them, in all elements of their placements."""
    data = case.robot.model.createData()
    pin.framesForwardKinematics(case.robot.model, data, case.robot.full_configuration(q))
    there = frames_of(case.original.path, case.positions(q))
    ours = {f.name: data.oMf[i] for i, f in enumerate(case.robot.model.frames) if f.type == pin.FrameType.BODY}
    return max(
        float(abs(ours[name].homogeneous - place.homogeneous).max()) for name, place in there.items() if name in ours
    )


def scenes_of(name: str) -> list[Path]:
    """Return the scenes of a robot of the gallery."""
    home = resource("scenes", "paper.yaml").parent / "robots"
    return sorted(home.glob(f"{name.replace('_', '-')}-*.json"))


def check_plan(case: Case, file: Path) -> tuple[list[str], list[str]]:
    """Return the row of a scene, and what is wrong with its plan by the meshes."""
    scene = load_scene(file)
    motion = plan(case.robot, scene)
    proof, wrong, looks = motion.certificate, [], 0
    if motion.status != "reached" or proof is None or not proof.certified or (proof.clearance_bound or 0.0) < 0.008:
        wrong.append(f"{scene.name}: {motion.status}, certified: {bool(proof)}, {motion.reason}")
    touching: set[str] = set()
    for q in _dense(case, motion.q):
        touching |= _contacts(case, scene, q)
        looks += 1
    wrong += [f"{scene.name}: {what}" for what in sorted(touching)]
    bound = "" if proof is None or proof.clearance_bound is None else f"{1e3 * proof.clearance_bound:.1f}"
    return [scene.name, str(motion.status), bound, str(looks), str(len(touching))], wrong


def _dense(case: Case, q: Array) -> list[Array]:
    """Return configurations on the way between which no body moves farther than `STEP`."""
    found = [q[0]]
    corners = [
        np.array([s.aabb_center + s.aabb_radius * (2.0 * np.array(c) - 1.0) for c in np.ndindex(2, 2, 2)])
        for s in case.original.shapes
    ]
    for a, b in pairwise(q):
        here, there = case.places(a), case.places(b)
        moves = [
            np.linalg.norm([h.act(c) - t.act(c) for c in p], axis=1).max()
            for h, t, p in zip(here, there, corners, strict=True)
        ]
        pieces = max(1, int(np.ceil(max(moves) / STEP)))
        found += [a + (b - a) * k / pieces for k in range(1, pieces + 1)]
    return found


def _contacts(case: Case, scene: Scene, q: Array) -> set[str]:
    names, places = case.original.names, case.places(q)
    found = {f"{names[i]} and {names[j]} touch" for i, j in case.original.touching(places, case.pairs)}
    for number, box in enumerate(scene.obstacles):
        assert isinstance(box, Box)
        at = pin.SE3(pin.rpy.rpyToMatrix(*box.rpy), np.array(box.center))
        found |= {f"{name} touches obstacles[{number}]" for name in case.original.touches_box(places, box.size, at)}
    return found


def check_motions(case: Case, count: int, rng: np.random.Generator) -> tuple[list[str], list[str]]:
    """Return how many random motions are certified and how many of these wrongly, and which."""
    robot, certified, wrong = case.robot, 0, []
    for k in range(count):
        start = robot.initial + 0.3 * rng.normal(size=robot.n) * (robot.upper - robot.lower) / 4.0
        ends = np.clip([start, start + 0.2 * rng.normal(size=robot.n)], robot.lower, robot.upper)
        proof = certify(robot, (), np.array([0.0, 1.0]), ends)
        if not proof.certified or proof.clearance_bound is None:
            continue
        certified += 1
        ways = np.linspace(ends[0], ends[1], LOOKS)
        apart = min(case.original.apart(case.places(q), list(case.pairs), proof.clearance_bound) for q in ways)
        if apart <= 0.0 or proof.clearance_bound > apart + PRECISION:
            wrong.append(f"{case.name}, motion {k}: bound {proof.clearance_bound:.6f} m, meshes {apart:.6f} m apart")
    return [str(count), str(certified), str(len(wrong))], wrong


if __name__ == "__main__":
    run(main)
