"""Check certificates of random motions among random obstacles against plain geometry, sampled 100 times finer.

These statements must hold of every motion:

1. One that is certified touches nothing, and nothing comes nearer than its bound of the clearance.
2. One that is free by more than 1 mm is certified.
3. A contact is where and when it is said to be, nothing touches before, and one that touches has a contact.
4. Links that share an end touch nowhere far from it, whether they were checked there or said not to need it.

The plain geometry is in `plain_geometry.py`, and what motions there are in `random_motions.py`.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import AbstractContextManager, nullcontext
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path

import click
import numpy as np

from humanoid_rail import Certificate, Contact, HumanoidRailError, verify
from humanoid_rail._arrays import Array
from humanoid_rail.cli.console import check_least, console, print_table, run
from humanoid_rail.progress import progress_bar
from humanoid_rail.scene.obstacles import Obstacle, name_of
from validation.plain_geometry import (
    LINKS,
    NEIGHBOURS,
    PAIRS,
    RADIUS,
    Course,
    bones,
    clearance,
    configuration,
    far_segments,
    point_segment,
    segment_segment,
)
from validation.random_motions import KINDS, Motion, make_motion, robot, scene_of

MARGIN = 1e-3
"""A motion that is free by more has to be certified, and contacts are where they are said to be to within this, m."""
PRECISION = 1e-6
"""Bounds are precise to this, m."""
SLIGHT = 1e-5
"""Penetration by no more than this may go unnoticed, m."""


@dataclass(frozen=True)
class Outcome:
    """The certificate of a motion compared with plain geometry."""

    index: int
    kind: str
    certified: bool
    clearance: float
    """Smallest by plain geometry, m."""
    bound: float
    """The certificate's, m."""
    broken: tuple[str, ...]
    """What does not hold."""


@click.command()
@click.option("--scenes", default=10000, show_default=True, help="Number of motions, each in a scene of its own.")
@click.option("--first", default=0, show_default=True, help="Number of the first one.")
@click.option("--seed", default=2019, show_default=True, help="Seed of the motions.")
@click.option("--jobs", default=2, show_default=True, help="Number of processes.")
@click.option("--finer", default=100, show_default=True, help="How many times finer than the samples to look.")
@click.option("--json", "json_file", type=click.Path(dir_okay=False, path_type=Path), help="File for the results.")
@click.option("--readme", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="Markdown file to update.")
def main(scenes: int, first: int, seed: int, jobs: int, finer: int, json_file: Path | None, readme: Path | None) -> int:
    """Check certificates of random motions against plain geometry; exit code 1 if one is wrong.

    To look at motion I of a seed again: --seed SEED --first I --scenes 1.
    """
    check_least(1, scenes=scenes, jobs=jobs, finer=finer)
    check_least(0, first=first, seed=seed)
    outcomes = check_all(range(first, first + scenes), seed, finer, jobs)
    rows = summary(outcomes)
    print_table("certificates", f"Certificates, seed {seed}; clearances in mm", ("", "all", *KINDS), rows, readme)
    broken = [outcome for outcome in outcomes if outcome.broken]
    for outcome in broken:
        console().print(f"motion {outcome.index} ({outcome.kind}): {'; '.join(outcome.broken)}", soft_wrap=True)
    console().print(f"The statements hold of {len(outcomes) - len(broken)} motions out of {len(outcomes)}.")
    if json_file is not None:
        table = {name: dict(zip(("all", *KINDS), values, strict=True)) for name, *values in rows}
        report = {"seed": seed, "first": first, "scenes": scenes, "finer": finer, "table": table}
        report["broken"] = [asdict(outcome) for outcome in broken]
        json_file.parent.mkdir(parents=True, exist_ok=True)
        json_file.write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
    return 1 if broken else 0


def check_all(indices: range, seed: int, finer: int, jobs: int) -> list[Outcome]:
    """Return the outcomes of motions by their numbers, in order; by processes of their own if jobs is above 1."""
    outcomes = []
    pools: AbstractContextManager[ProcessPoolExecutor | None] = ProcessPoolExecutor(jobs) if jobs > 1 else nullcontext()
    with pools as pool, progress_bar("checking", len(indices)) as advance:
        work = partial(check, seed, finer)
        found: Iterable[Outcome] = pool.map(work, indices, chunksize=8) if pool else map(work, indices)
        for outcome in found:
            outcomes.append(outcome)
            advance(1)
    return outcomes


def check(seed: int, finer: int, index: int) -> Outcome:
    """Make a motion and hold its certificate against plain geometry.

    Raises:
        HumanoidRailError: If the motion is refused.
    """
    try:
        motion = make_motion(seed, index)
        certificate = motion.certificate
        if certificate is None:
            certificate = verify(robot(), scene_of(motion.obstacles), motion)
    except HumanoidRailError as error:
        raise HumanoidRailError(f"motion {index}: {error}") from error
    course = motion.follow(finer)
    apart, neighbours = clearances(course, motion.obstacles), course.between_neighbours()
    bound = certificate.clearance_bound
    assert bound is not None  # there are links to touch
    if any("checked only" in pair.why for pair in certificate.unchecked_pairs):
        apart = np.hstack([apart, neighbours])
    broken = judge(motion, course, apart, certificate)
    if certificate.certified and neighbours.min() <= 0.0:
        links = [LINKS[i] for i in NEIGHBOURS[int(neighbours.min(axis=0).argmin())]]
        broken = (*broken, f"certified, but {' and '.join(links)} meet away from their joint")
    return Outcome(index, motion.kind, certificate.certified, float(apart.min()), bound, broken)


def clearances(course: Course, obstacles: Sequence[Obstacle]) -> Array:
    """Return the clearances (M, P) of all pairs, m: those of links, then each link's from each obstacle.

    What is neither the smallest of its pairs nor below MARGIN may be a lower bound.
    """
    return np.hstack([course.between_links(MARGIN), *(course.from_obstacle(o, MARGIN) for o in obstacles)])


def judge(motion: Motion, course: Course, apart: Array, certificate: Certificate) -> tuple[str, ...]:
    """Return which statements a certificate breaks, given the clearances (M, P) on the course of its motion."""
    k, pair = np.unravel_index(apart.argmin(), apart.shape)
    least, bound, contact = apart[k, pair], certificate.clearance_bound, certificate.contact
    names = _names(motion, int(pair))
    found = f"{' and '.join(names)} are {1e3 * least:.4f} mm apart at t = {course.t[k]:.6f} s"
    broken = []
    if certificate.certified and (least <= 0.0 or contact is not None):
        broken.append(f"certified, but {found}")
    if bound is None or bound > least + PRECISION:
        broken.append(f"the bound is {bound} m, but {found}")
    if not certificate.certified and least > MARGIN:
        broken.append(f"not certified, but {found}")
    if contact is None and least < -SLIGHT:
        broken.append(f"no contact, but {found}")
    if contact is not None:
        if (away := distance_of(contact, motion)) > MARGIN:
            broken.append(f"{contact}, but that is {1e3 * away:.4f} mm off")
        if (before := apart[course.t < contact.t].min(initial=np.inf)) < -SLIGHT:
            broken.append(f"{contact}, but before there are {1e3 * before:.4f} mm")
    return tuple(broken)


def _names(motion: Motion, pair: int) -> list[str]:
    """Return what the two of a pair are called: of links, of a link and an obstacle, of neighbours."""
    number, link = divmod(pair - len(PAIRS), len(LINKS))
    if number < 0:
        return [LINKS[i] for i in PAIRS[pair]]
    if number < len(motion.obstacles):
        return [LINKS[link], name_of(motion.obstacles, number)]
    return [LINKS[i] for i in NEIGHBOURS[pair - len(PAIRS) - len(LINKS) * len(motion.obstacles)]]


def distance_of(contact: Contact, motion: Motion) -> float:
    """Return how far from each other the two are that are said to touch, or its point from the link, m."""
    ends = bones(configuration(motion.t, motion.q, contact.t))
    bone = ends[LINKS.index(contact.link)]
    if contact.other in LINKS:
        pair = (LINKS.index(contact.link), LINKS.index(contact.other))
        segments = (ends[pair[0]], ends[pair[1]])
        if tuple(sorted(pair)) in NEIGHBOURS:
            segments = far_segments(*segments)
        apart = segment_segment(*segments) - 2.0 * RADIUS
    else:
        names = [name_of(motion.obstacles, i) for i in range(len(motion.obstacles))]
        apart = clearance(motion.obstacles[names.index(contact.other)], contact.t, bone)
    return float(max(apart, point_segment(np.array(contact.point), bone) - RADIUS))


def summary(outcomes: Sequence[Outcome]) -> list[list[str]]:
    """Return rows of what came of all motions and of those of each kind.

    The last four have, in mm, the smallest clearance of motions that are certified, the largest of those that are not,
    and how far bounds are above the clearance and, of motions that are certified, below it.
    """
    groups = [list(outcomes), *([o for o in outcomes if o.kind == kind] for kind in KINDS)]
    counts: dict[str, Callable[[Outcome], bool]] = {
        "motions": lambda o: True,
        "certified": lambda o: o.certified,
        "touching": lambda o: o.clearance <= 0.0,
        "free by up to 1 mm": lambda o: 0.0 < o.clearance <= MARGIN,
        "of these certified": lambda o: 0.0 < o.clearance <= MARGIN and o.certified,
        "wrong": lambda o: bool(o.broken),
    }
    rows = [[name, *(str(sum(map(counted, group))) for group in groups)] for name, counted in counts.items()]
    extremes = {
        "least if certified": [min(_of(group, True), default=None) for group in groups],
        "largest if not": [max(_of(group, False), default=None) for group in groups],
        "bound above by up to": [max((o.bound - o.clearance for o in group), default=None) for group in groups],
        "bound below by up to": [
            max((o.clearance - o.bound for o in group if o.certified), default=None) for group in groups
        ],
    }
    for name, values in extremes.items():
        rows.append([name, *("" if value is None else f"{1e3 * value:.4f}" for value in values)])
    return rows


def _of(outcomes: Sequence[Outcome], certified: bool) -> list[float]:
    """Return the clearances of motions that are certified, or of those that are not, m."""
    return [o.clearance for o in outcomes if o.certified == certified]


if __name__ == "__main__":
    run(main)
