"""Check certificates of random motions among random obstacles against plain geometry, sampled 100 times finer.

These statements must hold of every motion:

1. One that is certified touches nothing, and nothing comes nearer than its bound of the clearance.
2. One that is free by more than 1 mm is certified.
3. A contact is where and when it is said to be, nothing touches before, and one that touches has a contact.
4. Links that share an end touch nowhere far from it, whether they were checked there or said not to need it.

The plain geometry is in `plain_geometry.py`, and what motions there are in `random_motions.py`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path

import click
import numpy as np

from humanoid_rail import Certificate, Contact, HumanoidRailError, verify
from humanoid_rail._arrays import Array
from humanoid_rail.cli.console import check_least, run
from humanoid_rail.scene.obstacles import Obstacle, name_of
from validation import compared
from validation.compared import MARGIN, SLIGHT, Outcome, compare_all, contradictions, tell
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
    asked = {"seed": seed, "first": first, "scenes": scenes, "finer": finer}
    title = f"Certificates, seed {seed}; clearances in mm"
    return tell("certificates", title, KINDS, rows, outcomes, asked, json_file, readme)


def check_all(indices: range, seed: int, finer: int, jobs: int) -> list[Outcome]:
    """Return the outcomes of motions by their numbers, in order; by processes of their own if jobs is above 1."""
    return compare_all(partial(check, seed, finer), indices, jobs)


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
    return Outcome(
        index=index,
        kind=motion.kind,
        certified=certificate.certified,
        clearance=float(apart.min()),
        bound=bound,
        broken=broken,
    )


def clearances(course: Course, obstacles: Sequence[Obstacle]) -> Array:
    """Return the clearances (M, P) of all pairs, m: those of links, then each link's from each obstacle.

    What is neither the smallest of its pairs nor below MARGIN may be a lower bound.
    """
    return np.hstack([course.between_links(MARGIN), *(course.from_obstacle(o, MARGIN) for o in obstacles)])


def judge(motion: Motion, course: Course, apart: Array, certificate: Certificate) -> tuple[str, ...]:
    """Return which statements a certificate breaks, given the clearances (M, P) on the course of its motion."""
    k, pair = np.unravel_index(apart.argmin(), apart.shape)
    least, contact = apart[k, pair], certificate.contact
    names = _names(motion, int(pair))
    found = f"{' and '.join(names)} are {1e3 * least:.4f} mm apart at t = {course.t[k]:.6f} s"
    broken = contradictions(certificate, least, found)
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

    The last four are those of :func:`validation.compared.summary`.
    """
    counts: dict[str, Callable[[Outcome], bool]] = {
        "motions": lambda o: True,
        "certified": lambda o: o.certified,
        "touching": lambda o: o.clearance <= 0.0,
        "free by up to 1 mm": lambda o: 0.0 < o.clearance <= MARGIN,
        "of these certified": lambda o: 0.0 < o.clearance <= MARGIN and o.certified,
        "wrong": lambda o: bool(o.broken),
    }
    return compared.summary(outcomes, KINDS, counts)


if __name__ == "__main__":
    run(main)
