"""Check what the engine takes for solid in random meshes against formulas of their parts.

These statements must hold of every mesh:

1. It is accepted.
2. A point inside of it is inside for the engine, to within GAP of the mesh's size.
3. A point that is inside for the engine is inside of the mesh, or nearer to it than TOLERANCE of its size.
4. Of its parts in files that are easily read in part, all is read, or the file is refused.

The meshes are in `random_meshes.py`, the files of the last statement in `mesh_traps.py`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import click
import coal
import numpy as np
import trimesh

from humanoid_rail import HumanoidRailError, Mesh
from humanoid_rail._arrays import Array
from humanoid_rail.cli.console import check_least, console, run
from humanoid_rail.progress import progress_bar
from humanoid_rail.scene.shapes import placed_shapes
from validation.mesh_traps import read_wrongly
from validation.random_meshes import Part, RandomMesh, make_mesh

GAP = 1e-3
"""Points inside a mesh are in its pieces to within this, relative to its size."""
TOLERANCE = 0.05
"""Points farther from the mesh than this are outside of its pieces, relative to its size."""
POINTS = 300
"""So many random points are looked at in each part of a mesh, and as many around it."""


@dataclass(frozen=True)
class Outcome:
    """A mesh compared with its pieces."""

    index: int
    suffix: str
    troubles: tuple[str, ...]
    pieces: int
    inside: int
    """Number of points inside that were looked at."""
    gap: float
    """The largest distance of a point inside from the pieces, relative to the size."""
    excess: float
    """The largest distance of a point inside the pieces from the mesh, relative to the size."""
    broken: tuple[str, ...]
    """What does not hold."""


@click.command()
@click.option("--meshes", default=100, show_default=True, help="Number of meshes.")
@click.option("--first", default=0, show_default=True, help="Number of the first one.")
@click.option("--seed", default=2019, show_default=True, help="Seed of the meshes.")
def main(meshes: int, first: int, seed: int) -> int:
    """Check the convex pieces of random meshes; exit code 1 if one is wrong.

    To look at mesh I of a seed again: --seed SEED --first I --meshes 1.
    """
    check_least(1, meshes=meshes)
    check_least(0, first=first, seed=seed)
    outcomes = check_all(range(first, first + meshes), seed)
    for outcome in outcomes:
        if outcome.broken:
            what = f"mesh {outcome.index} ({outcome.suffix}; {', '.join(outcome.troubles) or 'no troubles'})"
            console().print(f"{what}: {'; '.join(outcome.broken)}", soft_wrap=True)
    console().print(summary(outcomes), soft_wrap=True)
    return 1 if any(outcome.broken for outcome in outcomes) else 0


def check_all(indices: range, seed: int) -> list[Outcome]:
    """Return the outcomes of meshes by their numbers, in order."""
    outcomes = []
    with progress_bar("checking", len(indices)) as advance:
        for index in indices:
            outcomes.append(check(seed, index))
            advance(1)
    return outcomes


def check(seed: int, index: int) -> Outcome:
    """Write a mesh to a file and compare what the engine takes for solid with its parts."""
    mesh = make_mesh(seed, index)
    with TemporaryDirectory() as folder:
        try:
            wrongly = list(read_wrongly([part.placed() for part in mesh.parts], Path(folder)))
            obstacle = Mesh(file=str(mesh.write(Path(folder))), center=(0.0, 0.0, 0.0))
        except HumanoidRailError as error:
            return Outcome(index, mesh.suffix, mesh.troubles, 0, 0, np.inf, np.inf, (f"refused: {error}",))
    rng = np.random.default_rng([seed, index, 1])
    inside, around = points_inside(mesh, rng), points_around(mesh, rng)
    outside = around[~mesh.contains(around)]
    gap = float(engine_distances(obstacle, inside).max(initial=0.0)) / mesh.size
    taken = outside[engine_distances(obstacle, outside) <= 0.0]
    excess = distance_to_surface(mesh, taken) / mesh.size
    broken = [f"a point inside is outside of all pieces by {gap:.4f} of the size"] * (gap > GAP)
    broken += [f"a point {excess:.4f} of the size outside is in a piece"] * (excess > TOLERANCE)
    broken += [f"a file is read wrongly ({name})" for name in wrongly]
    return Outcome(index, mesh.suffix, mesh.troubles, len(obstacle.pieces), len(inside), gap, excess, tuple(broken))


def engine_distances(obstacle: Mesh, points: Array) -> Array:
    """Return the distances (n,) of points (n, 3) from an obstacle, m; coal's, which are not above 0 inside."""
    point, request = coal.Sphere(0.0), coal.DistanceRequest()
    shapes = placed_shapes(obstacle)

    def distance(at: Array) -> float:
        place = coal.Transform3s(np.eye(3), at)
        apart = (coal.distance(s.shape, s.placement, point, place, request, coal.DistanceResult()) for s in shapes)
        return float(min(apart))

    return np.array([distance(at) for at in points])


def points_inside(mesh: RandomMesh, rng: np.random.Generator) -> Array:
    """Return points (n, 3) inside of the parts, m."""
    found = []
    for part in mesh.parts:
        points = rng.uniform(*_box(part), (POINTS, 3))
        found.append(points[part.contains(points)])
    return np.vstack(found)


def points_around(mesh: RandomMesh, rng: np.random.Generator) -> Array:
    """Return points (n, 3) in and around the parts, m."""
    boxes, margin = [_box(part) for part in mesh.parts], 0.1 * mesh.size
    return np.vstack([rng.uniform(low - margin, high + margin, (POINTS, 3)) for low, high in boxes])


def _box(part: Part) -> tuple[Array, Array]:
    """Return the lowest and the highest coordinates (3,) of a part, m."""
    low, high = part.placed().bounds
    return np.array(low, float), np.array(high, float)


def distance_to_surface(mesh: RandomMesh, points: Array) -> float:
    """Return the largest distance of points (n, 3) from the triangles of a mesh, m."""
    corners = mesh.triangles.triangles
    farthest = 0.0
    for point in points:
        nearest = trimesh.triangles.closest_point(corners, np.broadcast_to(point, (len(corners), 3)))
        farthest = max(farthest, float(np.linalg.norm(nearest - point, axis=1).min()))
    return farthest


def summary(outcomes: Sequence[Outcome]) -> str:
    """Return in words what came of meshes."""
    held = [outcome for outcome in outcomes if not outcome.broken]
    formats = ", ".join(f"{count} {suffix}" for suffix, count in sorted(Counter(o.suffix for o in outcomes).items()))
    gap, excess = (max((getattr(o, name) for o in held), default=0.0) for name in ("gap", "excess"))
    return (
        f"The statements hold of {len(held)} meshes out of {len(outcomes)} ({formats}); "
        f"{sum(o.inside for o in held)} points inside are in the pieces to within {gap:.2e} of the size, "
        f"and points in the pieces in the mesh to within {excess:.2e}."
    )


if __name__ == "__main__":
    run(main)
