"""The robot of a plan folder: the paper's as its URDF alone, any other as `Robot.save` writes it."""

from __future__ import annotations

import shutil
from contextlib import suppress
from pathlib import Path

import coal
import numpy as np

from humanoid_rail.errors import InvalidInput
from humanoid_rail.model.humanoid import paper_robot
from humanoid_rail.model.library import FileArguments, load_robot
from humanoid_rail.model.robot import Robot
from humanoid_rail.model.robot_file import NAME
from humanoid_rail.model.saving import robot_files

URDF = "robot.urdf"
"""The URDF that the paper's robot was built from; with `robot.yaml` beside it the robot is another one."""
MESHES = "meshes"
"""The folder of the meshes of a robot that was saved."""


def is_papers(robot: Robot) -> bool:
    """Return whether a robot is the paper's, of whatever lengths and limits, and nothing of it was replaced."""
    try:
        own = paper_robot(robot.urdf)
    except InvalidInput:
        return False
    named = ("joint_names", "hands", "self_collision_pairs", "left_out", "pair_distances", "postures", "locked")
    arrays = ("initial", "lower", "upper", "velocity_limit", "acceleration_limit", "jerk_limit")
    return (
        all(getattr(own, name) == getattr(robot, name) for name in named)
        and all(np.array_equal(getattr(own, name), getattr(robot, name)) for name in arrays)
        and _same_bodies(own, robot)
    )


def _same_bodies(robot: Robot, other: Robot) -> bool:
    """Return whether two robots have the same bodies; boxes around them do not count."""
    bodies, others = (list(r.collision_model.geometryObjects) for r in (robot, other))
    return len(bodies) == len(others) and all(
        (a.name, a.parentJoint, a.parentFrame) == (b.name, b.parentJoint, b.parentFrame)
        and a.placement == b.placement
        and type(a.geometry) is type(b.geometry)
        and _boxed(a.geometry) == _boxed(b.geometry)
        for a, b in zip(bodies, others, strict=True)
    )


def _boxed(shape: coal.CollisionGeometry) -> coal.CollisionGeometry:
    """Return a copy of a shape with the box around it, which some have been given and others not."""
    copy = shape.clone()
    copy.computeLocalAABB()
    return copy


def carried_files(robot: Robot) -> dict[str, bytes]:
    """Return the files that a robot is in, by their names.

    Raises:
        InvalidInput: If it cannot be saved.
    """
    return {URDF: robot.urdf.encode()} if is_papers(robot) else robot_files(robot)


def remove_other(folder: Path, files: dict[str, bytes]) -> None:
    """Remove what is left in a folder of the robot of an older plan, which is not among these files."""
    if NAME in files:
        if URDF not in files:
            (folder / URDF).unlink(missing_ok=True)
        return
    if (folder / NAME).is_file():
        (folder / NAME).unlink()
        with suppress(OSError):
            shutil.rmtree(folder / MESHES)


def carried_robot(folder: Path) -> Robot:
    """Return the robot that is in a folder.

    Raises:
        InvalidInput: If there is none, or it is not valid.
    """
    if (folder / NAME).is_file():
        return load_robot(folder)
    return papers_robot_in(folder / URDF)


def given_robot(source: str, srdf: str | None = None, packages: tuple[str, ...] = ()) -> Robot:
    """Return the robot that someone asks for instead.

    Args:
        source: What :func:`humanoid_rail.load_robot` takes. The URDF of the paper's robot, as `humanoid-rail urdf`
            writes it, is that with its hands and pairs.
        srdf: The SRDF, if one is given.
        packages: Folders of ROS packages.

    Raises:
        InvalidInput: If there is no such robot, or it is not valid.
    """
    more: FileArguments = {}
    if srdf is not None:
        more["srdf"] = str(Path(srdf).absolute())
    if packages:
        more["packages"] = packages
    path = Path(source)
    if not more and path.suffix == ".urdf" and path.is_file():
        with suppress(InvalidInput):
            return papers_robot_in(path)
    try:
        return load_robot(source, **more)
    except InvalidInput as error:
        error.source = error.source or source
        raise


def papers_robot_in(file: Path) -> Robot:
    """Return the paper's robot from the file of its URDF.

    Raises:
        InvalidInput: If it cannot be read, or is not that of this robot.
    """
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        valid = f"a file as `humanoid-rail plan --out` writes it, or another given by --robot ({error})"
        raise InvalidInput("robot", str(file), valid) from error
    try:
        return paper_robot(text)
    except InvalidInput as error:
        error.source = str(file)
        raise
