"""Check what is loaded of random URDFs, many of them spoiled, against a count of what is written in them.

Of every URDF one of these must hold:

1. The robot loads whole: its collision bodies are the elements `<collision>` of the URDF, each on its link, of the size
   and at the place that are written.
2. It is refused by an `InvalidInput` that names a field.

The count is in `written_bodies.py`, and what URDFs there are in `random_urdfs.py`.
"""

from __future__ import annotations

import warnings
from collections import Counter

import click
import coal
import numpy as np

from humanoid_rail import Hand, InvalidInput, Robot, robot_from_urdf
from humanoid_rail.cli.console import check_least, console, run
from humanoid_rail.progress import progress_bar
from validation.random_urdfs import random_urdf
from validation.written_bodies import Written, written_bodies

HANDS = (Hand("tip", "l3", ("j1", "j2", "j3")),)
"""The hand of every robot."""
LOADED = "loaded"
"""What is counted of URDFs that are not refused; of others the field that is named."""
PRECISION = 1e-9
"""Sizes and places are as written to within this, m."""


@click.command()
@click.option("--urdfs", default=10000, show_default=True, help="Number of URDFs.")
@click.option("--first", default=0, show_default=True, help="Number of the first one.")
@click.option("--seed", default=2019, show_default=True, help="Seed of the URDFs.")
def main(urdfs: int, first: int, seed: int) -> int:
    """Load random URDFs; exit code 1 if one loads other than written or is not refused by an InvalidInput.

    To look at URDF I of a seed again: --seed SEED --first I --urdfs 1.
    """
    check_least(1, urdfs=urdfs)
    check_least(0, first=first, seed=seed)
    found, broken = Counter[str](), 0
    with progress_bar("checking", urdfs) as advance:
        for index in range(first, first + urdfs):
            try:
                found[outcome(random_urdf(seed, index))] += 1
            except Exception as error:  # whatever it is, it is what is looked for
                broken += 1
                console().print(f"URDF {index}: {type(error).__name__}: {error}", soft_wrap=True, markup=False)
            advance(1)
    console().print(f"{found[LOADED]} robots are loaded, {found.total() - found[LOADED]} refused.")
    console().print(f"The statements hold of {urdfs - broken} URDFs out of {urdfs}.")
    return 1 if broken else 0


def outcome(text: str) -> str:
    """Load a URDF and hold its bodies against what is written.

    Returns:
        The field that a refusal names, or `LOADED`.

    Raises:
        AssertionError: If it loads with other bodies than are written.
        Exception: Whatever loading raises that is no InvalidInput.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            robot = robot_from_urdf(text, None, HANDS)
    except InvalidInput as error:
        if not error.field or not error.valid:
            raise AssertionError("refused without saying what is wrong") from error
        return error.field
    loaded, written = loaded_bodies(robot), written_bodies(text)
    same = len(loaded) == len(written) and all(map(_same, loaded, written))
    if not same:
        raise AssertionError(f"loaded are {loaded}, written are {written}")
    return LOADED


def loaded_bodies(robot: Robot) -> list[Written]:
    """Return the collision bodies of a robot, sorted."""
    bodies = []
    for body in robot.collision_model.geometryObjects:
        frame, shape = robot.model.frames[body.parentFrame], body.geometry
        match shape:
            case coal.Box():
                sizes = 2 * shape.halfSide
            case coal.Sphere():
                sizes = np.array([shape.radius])
            case _:
                sizes = np.array([shape.radius, 2 * shape.halfLength])
        at = frame.placement.actInv(body.placement).translation
        kind = type(shape).__name__.lower()
        bodies.append(Written(frame.name, kind, tuple(sizes.tolist()), tuple(at.tolist())))
    return sorted(bodies)


def _same(one: Written, other: Written) -> bool:
    if (one.link, one.kind, len(one.sizes)) != (other.link, other.kind, len(other.sizes)):
        return False
    return bool(np.allclose([*one.sizes, *one.at], [*other.sizes, *other.at], rtol=PRECISION, atol=PRECISION))


if __name__ == "__main__":
    run(main)
