"""Check certificates of random motions that carry objects against plain geometry, sampled 100 times finer.

These statements must hold of every motion:

1. One that is certified touches nothing that has to be checked, and nothing comes nearer than its clearance bound.
2. One that is free by more than 1 mm is certified, and one that touches by more than 0.01 mm has a contact.
3. A contact is of a pair that has to be checked, is where and when it is said to be, and nothing touches before.
4. Pairs that are not checked, as the object is held or may touch there, are among those that the certificate names.

The plain geometry is in `held_geometry.py` and `plain_geometry.py`, and what motions there are in `held_motions.py`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import click
import numpy as np

from humanoid_rail import Certificate, Contact, HumanoidRailError, verify
from humanoid_rail._arrays import Array
from humanoid_rail.cli.console import check_least, run
from humanoid_rail.model.pairs import IN_PART
from validation import compared
from validation.compared import MARGIN, SLIGHT, Outcome, compare_all, contradictions, tell
from validation.held_course import HeldMotion, Part, parts
from validation.held_geometry import Body, bone, clearances, distance, point
from validation.held_motions import KINDS, make_motion
from validation.plain_geometry import LINKS, NEIGHBOURS, PAIRS, far_segments
from validation.random_motions import robot


@dataclass(frozen=True, kw_only=True)
class HeldOutcome(Outcome):
    """The certificate of a motion that carries objects, compared with plain geometry."""

    with_object: bool
    """Whether an object is one of those that are nearest."""
    left_out: int
    """How many pairs are not checked somewhere."""


@dataclass(frozen=True, eq=False)
class Looked:
    """What plain geometry finds of a part of a motion."""

    part: Part
    pairs: tuple[tuple[str, str], ...]
    bodies: dict[str, Body]
    apart: Array
    """The smallest clearance at each moment (K,), m, or a lower bound where it does not matter."""
    least: float
    nearest: tuple[str, str]
    at: float
    """When they are, s."""


@click.command()
@click.option("--motions", default=2000, show_default=True, help="Number of motions, each in a scene of its own.")
@click.option("--first", default=0, show_default=True, help="Number of the first one.")
@click.option("--seed", default=2019, show_default=True, help="Seed of the motions.")
@click.option("--jobs", default=2, show_default=True, help="Number of processes.")
@click.option("--finer", default=100, show_default=True, help="How many times finer than the samples to look.")
@click.option("--json", "json_file", type=click.Path(dir_okay=False, path_type=Path), help="File for the results.")
@click.option("--readme", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="Markdown file to update.")
def main(
    motions: int, first: int, seed: int, jobs: int, finer: int, json_file: Path | None, readme: Path | None
) -> int:
    """Check certificates of motions that carry objects against plain geometry; exit code 1 if one is wrong.

    To look at motion I of a seed again: --seed SEED --first I --motions 1.
    """
    check_least(1, motions=motions, jobs=jobs, finer=finer)
    check_least(0, first=first, seed=seed)
    outcomes = check_all(range(first, first + motions), seed, finer, jobs)
    rows = summary(outcomes)
    asked = {"seed": seed, "first": first, "motions": motions, "finer": finer}
    title = f"Certificates with objects, seed {seed}; mm"
    return tell("holding", title, KINDS, rows, outcomes, asked, json_file, readme)


def check_all(indices: range, seed: int, finer: int, jobs: int) -> list[HeldOutcome]:
    """Return the outcomes of motions by their numbers, in order; by processes of their own if jobs is above 1."""
    return compare_all(partial(check, seed, finer), indices, jobs)


def check(seed: int, finer: int, index: int) -> HeldOutcome:
    """Make a motion and hold its certificate against plain geometry.

    Raises:
        HumanoidRailError: If the motion is refused.
    """
    try:
        motion = make_motion(seed, index)
        certificate = verify(robot(), motion.scene(), motion)
    except HumanoidRailError as error:
        raise HumanoidRailError(f"motion {index}: {error}") from error
    in_part = any(IN_PART in pair.why for pair in certificate.unchecked_pairs)
    looked = look(motion, finer, in_part)
    nearest = min(looked, key=lambda one: one.least)
    objects = {str(one.name) for one in motion.objects}
    return HeldOutcome(
        index=index,
        kind=motion.kind,
        certified=certificate.certified,
        clearance=nearest.least,
        bound=np.nan if certificate.clearance_bound is None else certificate.clearance_bound,
        with_object=not objects.isdisjoint(nearest.nearest),
        left_out=len(frozenset[frozenset[str]]().union(*(one.part.left_out for one in looked))),
        broken=judge(looked, certificate),
    )


def look(motion: HeldMotion, finer: int, in_part: bool = False) -> list[Looked]:
    """Return what plain geometry finds of each part of a motion, of neighbours away from their joint if `in_part`."""
    return [_look(part, in_part and part.leaves_limits) for part in parts(motion, finer)]


def _look(part: Part, in_part: bool) -> Looked:
    bodies = dict(part.bodies)
    pairs = [*part.pairs, *((LINKS[a], LINKS[b]) for a, b in PAIRS)]
    # Within the limits neighbours meet nowhere away from their joint.
    for a, b in NEIGHBOURS if in_part else ():
        far = far_segments(bodies[LINKS[a]].edges[:, 0], bodies[LINKS[b]].edges[:, 0])
        names = (f"{LINKS[a]} away from {LINKS[b]}", f"{LINKS[b]} away from {LINKS[a]}")
        bodies |= dict(zip(names, map(bone, far), strict=True))
        pairs.append(names)
    apart, least, nearest, at = np.full(len(part.t), np.inf), np.inf, pairs[0], 0
    for one, other in pairs:
        found = clearances(bodies[one], bodies[other], len(part.t), MARGIN)
        apart = np.minimum(apart, found)
        if found.min() < least:
            at = int(found.argmin())
            least, nearest = float(found[at]), (one, other)
    return Looked(part, tuple(pairs), bodies, apart, least, nearest, float(part.t[at]))


def judge(looked: Sequence[Looked], certificate: Certificate) -> tuple[str, ...]:
    """Return which statements a certificate breaks, given what plain geometry finds of the parts of its motion."""
    nearest = min(looked, key=lambda one: one.least)
    least, contact = nearest.least, certificate.contact
    found = f"{' and '.join(nearest.nearest)} are {1e3 * least:.4f} mm apart at t = {nearest.at:.6f} s"
    broken = contradictions(certificate, least, found)
    if contact is not None:
        away = min(distance_of(contact, one) for one in looked)
        if away > MARGIN:
            broken.append(f"{contact}, but that is {1e3 * away:.4f} mm off")
        before = min(one.apart[one.part.t < contact.t].min(initial=np.inf) for one in looked)
        if before < -SLIGHT:
            broken.append(f"{contact}, but before there are {1e3 * before:.4f} mm")
    named = {frozenset((pair.link, pair.other)) for pair in certificate.unchecked_pairs}
    unsaid = frozenset[frozenset[str]]().union(*(one.part.left_out for one in looked)) - named
    broken += [f"{' and '.join(sorted(pair))} are not checked, which the certificate does not say" for pair in unsaid]
    return tuple(broken)


def distance_of(contact: Contact, looked: Looked) -> float:
    """Return how far from each other the two are in a part that are said to touch, or its point from the link, m.

    It is infinite if the contact is not in the part, or the two need not be checked there.
    """
    t, names = looked.part.t, {contact.link, contact.other}
    far = {f"{a} away from {b}" for a in names for b in names}
    pair = next((pair for pair in looked.pairs if set(pair) == names or set(pair) <= far), None)
    if pair is None or not t[0] <= contact.t <= t[-1]:
        return np.inf
    k = np.array([int(abs(t - contact.t).argmin())])
    one, other = (looked.bodies[name].at(k) for name in pair)
    touched = one if pair[0].split(" away ")[0] == contact.link else other
    return float(max(distance(one, other)[0], distance(point(np.array(contact.point)), touched)[0]))


def summary(outcomes: Sequence[HeldOutcome]) -> list[list[str]]:
    """Return rows of what came of all motions and of those of each kind.

    The last four are those of :func:`validation.compared.summary`.
    """
    counts: dict[str, Callable[[HeldOutcome], bool]] = {
        "motions": lambda o: True,
        "certified": lambda o: o.certified,
        "touching": lambda o: o.clearance <= 0.0,
        "an object nearest": lambda o: o.with_object,
        "of these certified": lambda o: o.with_object and o.certified,
        "with pairs left out": lambda o: o.left_out > 0,
        "free by up to 1 mm": lambda o: 0.0 < o.clearance <= MARGIN,
        "wrong": lambda o: bool(o.broken),
    }
    return compared.summary(outcomes, KINDS, counts)


if __name__ == "__main__":
    run(main)
