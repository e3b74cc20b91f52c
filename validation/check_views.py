"""Measure how much of the robot obstacles hide from the camera of the playback page. docs/page.md tells the rest.

Random points on the robot's collision bodies at random times are looked for, by coal: whether a thin capsule from the
camera to the point touches an obstacle. The page chooses its camera by rays of its own to other points.
"""

from __future__ import annotations

import statistics
from collections import defaultdict
from pathlib import Path

import click
import coal
import numpy as np
import pinocchio as pin

from humanoid_rail import HumanoidRailError, Robot, Scene, Trajectory, load_robot, load_scene, plan
from humanoid_rail._arrays import Array
from humanoid_rail.cli.console import print_table, run
from humanoid_rail.model.collision_bodies import coal_placement
from humanoid_rail.progress import progress_bar
from humanoid_rail.scene.obstacles import HalfSpace
from humanoid_rail.scene.shapes import PlacedShape, placed_shapes
from humanoid_rail.viewer.camera import best_view

THIN = 1e-4
"""Radius of the capsule that stands for a ray, m."""
MOST = {"shelf": 0.02, "deep": 0.02}
"""The largest median of the share that is hidden, by kind of scene."""


@click.command()
@click.argument("folder", type=click.Path(exists=True, file_okay=False, path_type=Path))
@click.option("--points", default=200, show_default=True, help="Number of points on the robot in each scene.")
@click.option("--readme", type=click.Path(exists=True, dir_okay=False, path_type=Path), help="Markdown file to update.")
def main(folder: Path, points: int, readme: Path | None) -> int:
    """Plan the scenes in FOLDER and measure; exit code 1 if too much is hidden in the shelf or the deep scenes."""
    robot, shares = load_robot(), defaultdict[str, list[tuple[float, float]]](list)
    files = sorted(folder.glob("*.json"))
    if not files:
        raise HumanoidRailError(f"no scenes in {folder}")
    with progress_bar("looking", len(files)) as advance:
        for file in files:
            scene = load_scene(file)
            trajectory = plan(robot, scene)
            view = best_view(robot, scene, trajectory)
            mirrored = view.middle + view.camera * [-1.0, -1.0, 1.0]
            cameras = view.middle + view.camera, mirrored
            own, other = (hidden_share(robot, scene, trajectory, camera, points) for camera in cameras)
            shares[file.name.partition("-")[0]].append((own, other))
            advance(1)
    rows = [
        [kind, str(len(found)), *(f"{100 * value:.1f} %" for value in _summary(found))]
        for kind, found in shares.items()
    ]
    header = ("scenes", "number", "hidden, median", "hidden, worst", "from behind, median", "from behind, worst")
    print_table("views", "Share of the robot that obstacles hide", header, rows, readme)
    return int(any(_summary(found)[0] > MOST.get(kind, 1.0) for kind, found in shares.items()))


def hidden_share(
    robot: Robot, scene: Scene, trajectory: Trajectory, camera: Array, points: int, seed: int = 0
) -> float:
    """Return the share of random points of a robot during a motion that obstacles hide from a camera.

    Args:
        robot: The robot.
        scene: The scene; its half-spaces hide nothing.
        trajectory: The motion.
        camera: Where the camera is (3,), m.
        points: Their number.
        seed: The seed of the random numbers.
    """
    rng, data = np.random.default_rng(seed), robot.model.createData()
    obstacles = [
        (placed, np.array(obstacle.velocity))
        for obstacle in scene.obstacles
        if not isinstance(obstacle, HalfSpace)
        for placed in placed_shapes(obstacle)
    ]
    found = 0
    for t in rng.uniform(0.0, trajectory.duration, points):
        pin.forwardKinematics(robot.model, data, robot.full_configuration(trajectory.configuration(t)))
        body = robot.collision_model.geometryObjects[int(rng.integers(robot.collision_model.ngeoms))]
        placement = data.oMi[body.parentJoint] * body.placement
        found += any(_is_hit(camera, _on(body.geometry, placement, rng), placed, t * v) for placed, v in obstacles)
    return found / points


def _on(shape: coal.CollisionGeometry, placement: pin.SE3, rng: np.random.Generator) -> Array:
    """Return a random point within a shape, by its bounding box: one that is in it, or nearly."""
    shape.computeLocalAABB()
    low, high = np.array(shape.aabb_local.min_), np.array(shape.aabb_local.max_)
    local = low + rng.uniform(0.05, 0.95, 3) * (high - low)
    point: Array = coal_placement(placement).transform(local)
    return point


def _is_hit(camera: Array, point: Array, placed: PlacedShape, moved: Array) -> bool:
    ray = camera - point
    turn = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), ray).matrix()
    capsule = coal.Capsule(THIN, float(np.linalg.norm(ray)))
    at = coal.Transform3s(placed.placement.getRotation(), placed.placement.getTranslation() + moved)
    here = coal.Transform3s(turn, (camera + point) / 2)
    return bool(coal.collide(capsule, here, placed.shape, at, coal.CollisionRequest(), coal.CollisionResult()))


def _summary(found: list[tuple[float, float]]) -> list[float]:
    own, other = zip(*found, strict=True)
    return [statistics.median(own), max(own), statistics.median(other), max(other)]


if __name__ == "__main__":
    run(main)
