"""Measure what the margin of proofs is made of: the library's excess, and rounding. docs/safety.md tells the rest.

1. How much the library's distance of two convex bodies is above the separation along its own normal, which is proven.
2. How much a proven distance is above the exact one. Only rounding can do that, and less than the margin takes off.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import combinations_with_replacement, cycle, islice, product
from pathlib import Path

import click
import coal
import numpy as np
import pinocchio as pin

from humanoid_rail.cli.console import check_least, console, print_table, run
from humanoid_rail.model.collision_bodies import coal_placement
from humanoid_rail.progress import progress_bar
from humanoid_rail.scene.shapes import PlacedShape, support
from validation.exact_distances import KINDS, measured_distances

SIZES = (1e-3, 1e2)
"""The smallest and the largest size and distance of the pairs, m."""
SHAPES: dict[str, Callable[[np.random.Generator], coal.ShapeBase]] = {
    "sphere": lambda rng: coal.Sphere(_size(rng)),
    "capsule": lambda rng: coal.Capsule(_size(rng), _size(rng)),
    "box": lambda rng: coal.Box(_size(rng), _size(rng), _size(rng)),
    "cylinder": lambda rng: coal.Cylinder(_size(rng), _size(rng)),
    "hull": lambda rng: _hull(rng),
}
ALLOWED = 64.0
"""The margin takes off this many units in the last place (RELATIVE_ROUNDING in engine/collision/margin.hpp)."""
SCALES, FAR = (0.01, 1.0, 100.0), (0.0, 2e3)
"""Sizes of bodies, and how far from the base they are, m."""


@click.command()
@click.option("--pairs", default=1200, show_default=True, help="Number of pairs of each kind.")
@click.option("--seed", default=2019, show_default=True, help="Seed of the pairs.")
@click.option("--readme", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="Markdown file to update.")
def main(pairs: int, seed: int, readme: Path | None) -> int:
    """Compare distances with proven and exact ones; exit code 1 if rounding takes more than the margin allows."""
    check_least(1, pairs=pairs)
    check_least(0, seed=seed)
    kinds = list(combinations_with_replacement(SHAPES, 2))
    with progress_bar("measuring", len(kinds) + len(KINDS)) as advance:
        excess = {}
        for i, kind in enumerate(kinds):
            excess[kind] = largest_excess(kind, pairs, np.random.default_rng([seed, i]))
            advance(1)
        rounding = {}
        for i, obstacle in enumerate(KINDS):
            rounding[obstacle] = largest_rounding(obstacle, pairs, np.random.default_rng([seed, len(kinds) + i]))
            advance(1)
    rows = [[other, *(f"{excess[_in_order(one, other)]:.2f}" for one in SHAPES)] for other in SHAPES]
    print_table("excess", "Excess of the library's distance, um per (1 + d)", ("", *SHAPES), rows, readme)
    units = [[f"{value:.1f}" for value in rounding.values()]]
    print_table("rounding", "Proven above exact, units in the last place", tuple(rounding), units, readme)
    console().print(f"The margin takes off {ALLOWED:g} units in the last place.")
    return int(max(rounding.values()) > ALLOWED)


def largest_excess(kind: tuple[str, str], pairs: int, rng: np.random.Generator) -> float:
    """Return the largest excess of the library's distance d over the separation along its normal, um per (1 + d)."""
    return 1e6 * max(_excesses(kind, pairs, rng), default=0.0)


def largest_rounding(kind: str, pairs: int, rng: np.random.Generator) -> float:
    """Return how much proven distances of a capsule from obstacles of a kind are above exact ones at most.

    In units in the last place of the largest coordinate: epsilon times that.
    """
    above = 0.0
    for scale, far in islice(cycle(product(SCALES, FAR)), pairs):
        proven, exact, largest = measured_distances(kind, rng, scale, far)
        if exact > 0.0:  # what is proven of a depth is only a bound
            above = max(above, (proven - exact) / (np.finfo(float).eps * largest))
    return above


def _size(rng: np.random.Generator) -> float:
    return float(np.exp(rng.uniform(*np.log(SIZES))))


def _hull(rng: np.random.Generator) -> coal.ConvexBase:
    points = coal.StdVec_Vec3s()
    points.extend(list(rng.normal(size=(rng.integers(8, 40), 3)) * [_size(rng) / 2.0 for _ in range(3)]))
    return coal.ConvexBase.convexHull(points, True, "Qt")


def _excesses(kind: tuple[str, str], pairs: int, rng: np.random.Generator) -> Iterator[float]:
    """Yield the excess of pairs, m per (1 + d)."""
    for _ in range(pairs):
        one, other = _apart(SHAPES[kind[0]](rng), SHAPES[kind[1]](rng), rng)
        result = coal.DistanceResult()
        distance = coal.distance(*one, *other, coal.DistanceRequest(), result)
        proven = -support(other, -result.normal) - support(one, result.normal)
        yield (distance - proven) / (1.0 + distance)


def _apart(shape: coal.ShapeBase, other: coal.ShapeBase, rng: np.random.Generator) -> tuple[PlacedShape, PlacedShape]:
    """Return two shapes on either side of a gap, nearly parallel as often as not."""
    turn = pin.exp3(rng.uniform(-3.0, 3.0, 3))
    like = turn if rng.random() < 0.5 else pin.exp3(rng.uniform(-3.0, 3.0, 3))
    like = like @ pin.exp3(rng.normal(size=3) * 10.0 ** rng.uniform(-10.0, -2.0))
    here = PlacedShape(shape, coal_placement(pin.SE3(turn, np.zeros(3))))
    there = PlacedShape(other, coal_placement(pin.SE3(like, np.zeros(3))))
    across = rng.normal(size=3)
    across /= np.linalg.norm(across)
    aside = np.cross(across, rng.normal(size=3)) * min(support(here, across), support(there, -across))
    place = across * (support(here, across) + support(there, -across) + _size(rng)) + aside
    return here, PlacedShape(other, coal_placement(pin.SE3(like, place)))


def _in_order(one: str, other: str) -> tuple[str, str]:
    names = list(SHAPES)
    first, second = sorted((one, other), key=names.index)
    return first, second


if __name__ == "__main__":
    run(main)
