"""Check certificates of random motions that carry objects against plain geometry, sampled 100 times finer.

These statements must hold of every motion:

1. One that is certified touches nothing that has to be checked, and nothing comes nearer than its clearance bound.
2. One that is free by more than 1 mm is certified, and one that touches by more than 0.01 mm has a contact.
3. A contact is of a pair that has to be checked, is where and when it is said to be, and nothing touches before.
4. Pairs that are not checked, as the object is held or may touch there, are among those that the certificate names.

The plain geometry is in `held_geometry.py` and `plain_geometry.py`, and what motions there are in `held_motions.py`.
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
from humanoid_rail.model.pairs import IN_PART
from humanoid_rail.progress import progress_bar
from validation.held_course import HeldMotion, Part, parts
from validation.held_geometry import Body, bone, clearances, distance, point
from validation.held_motions import KINDS, make_motion
from validation.plain_geometry import LINKS, NEIGHBOURS, PAIRS, far_segments
from validation.random_motions import robot

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
    with_object: bool
    """Whether an object is one of those that are nearest."""
    left_out: int
    """How many pairs are not checked somewhere."""
    broken: tuple[str, ...]
    """What does not hold."""


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
    print_table("holding", f"Certificates with objects, seed {seed}; mm", ("", "all", *KINDS), rows, readme)
    broken = [outcome for outcome in outcomes if outcome.broken]
    for outcome in broken:
        console().print(f"motion {outcome.index} ({outcome.kind}): {'; '.join(outcome.broken)}", soft_wrap=True)
    console().print(f"The statements hold of {len(outcomes) - len(broken)} motions out of {len(outcomes)}.")
    if json_file is not None:
        table = {name: dict(zip(("all", *KINDS), values, strict=True)) for name, *values in rows}
        report = {"seed": seed, "first": first, "motions": motions, "finer": finer, "table": table}
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
        certificate = verify(robot(), motion.scene(), motion)
    except HumanoidRailError as error:
        raise HumanoidRailError(f"motion {index}: {error}") from error
    in_part = any(IN_PART in pair.why for pair in certificate.unchecked_pairs)
    looked = look(motion, finer, in_part)
    nearest = min(looked, key=lambda one: one.least)
    objects = {str(one.name) for one in motion.objects}
    return Outcome(
        index,
        motion.kind,
        certificate.certified,
        nearest.least,
        np.nan if certificate.clearance_bound is None else certificate.clearance_bound,
        not objects.isdisjoint(nearest.nearest),
        len(frozenset[frozenset[str]]().union(*(one.part.left_out for one in looked))),
        judge(looked, certificate),
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
    least, bound, contact = nearest.least, certificate.clearance_bound, certificate.contact
    found = f"{' and '.join(nearest.nearest)} are {1e3 * least:.4f} mm apart at t = {nearest.at:.6f} s"
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
        "an object nearest": lambda o: o.with_object,
        "of these certified": lambda o: o.with_object and o.certified,
        "with pairs left out": lambda o: o.left_out > 0,
        "free by up to 1 mm": lambda o: 0.0 < o.clearance <= MARGIN,
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
