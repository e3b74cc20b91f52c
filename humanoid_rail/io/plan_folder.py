"""A plan in a folder: the motion with the robot and the scene it was planned for, so that nothing else is needed."""

from __future__ import annotations

import json
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from humanoid_rail._files import check_folder
from humanoid_rail.errors import InvalidInput
from humanoid_rail.geometry.mesh_files import WITHOUT_REFERENCES, off_bytes, read_triangles
from humanoid_rail.io.carried_robot import URDF, carried_files, carried_robot, given_robot, remove_other
from humanoid_rail.io.trajectory_files import TRAJECTORY_FILES, read_trajectory, write_trajectory
from humanoid_rail.model.robot import Robot
from humanoid_rail.model.robot_file import NAME
from humanoid_rail.scene.covers import HeightField, PointCloud
from humanoid_rail.scene.obstacles import Mesh
from humanoid_rail.scene.scene import Scene, check_scene, load_scene, make_scene
from humanoid_rail.trajectory import Trajectory

SCENE = "scene.json"
"""A scene file with all that has a default written out. Mesh files are beside it, as copies or as OFF; so are files
of points and heights."""
_LEFT_OUT = ("robot", "expect", "checked")
"""These fields of a scene are not written where there is nothing in them."""


@dataclass(frozen=True, eq=False)
class Plan:
    """A motion, and what it was planned for; or the robot and the scene that were given instead."""

    robot: Robot
    scene: Scene
    trajectory: Trajectory
    """It knows this robot and this scene."""


def write_plan(
    trajectory: Trajectory, robot: Robot, scene: Scene, folder: str | Path, extra: Iterable[tuple[str, str]] = ()
) -> tuple[Path, ...]:
    """Write a motion as :func:`humanoid_rail.write_trajectory` does, and the scene and the robot beside it.

    The commands `play`, `verify` and `export` take such a folder, wherever it is moved to. The scene is `scene.json`.
    The paper's robot is `robot.urdf`; another one is there as :meth:`Robot.save` writes it, and the scene names it.

    Args:
        trajectory: The motion.
        robot: The robot it was planned for.
        scene: The scene it was planned in.
        folder: Where to; made if need be.
        extra: Further text files, by name and content.

    Returns:
        The files written.

    Raises:
        InvalidInput: If the robot cannot be saved, the folder cannot be written to, or a mesh file is gone or has
            changed.
    """
    carried = carried_files(robot)
    data, meshes = scene.model_dump(mode="json"), dict[str, bytes]()
    data["obstacles"] = [
        {field: value for field, value in obstacle.items() if value is not None} for obstacle in data["obstacles"]
    ]
    for number, obstacle in enumerate(scene.obstacles):
        if isinstance(obstacle, Mesh | HeightField | PointCloud):
            name, content = _mesh(obstacle, number) if isinstance(obstacle, Mesh) else _measured(obstacle, number)
            meshes[name] = content
            data["obstacles"][number]["file"] = name
    data["robot"] = NAME if NAME in carried else None
    data = {name: value for name, value in data.items() if name not in _LEFT_OUT or value is not None}
    texts = {SCENE: json.dumps(data, indent=2, ensure_ascii=False) + "\n", **dict(extra)}
    files = {**meshes, **carried, **{name: text.encode() for name, text in texts.items()}}
    written = write_trajectory(trajectory, folder, files)
    remove_other(Path(folder), carried)
    return written


def check_plan_folder(folder: str | Path, extra: Iterable[str] = ()) -> None:
    """Check, before anything is planned, that a plan can be written to a folder.

    Args:
        folder: The folder.
        extra: The names of further files.

    Raises:
        InvalidInput: If it cannot.
    """
    check_folder(folder, [*TRAJECTORY_FILES, SCENE, URDF, NAME, *extra])


def read_plan(
    folder: str | Path,
    scene_file: str | None = None,
    robot_file: str | None = None,
    *,
    srdf: str | None = None,
    packages: tuple[str, ...] = (),
) -> Plan:
    """Return the plan in a folder.

    Args:
        folder: What :func:`write_plan` wrote, or :func:`humanoid_rail.write_trajectory` if both files are given.
        scene_file: The scene, instead of the one in the folder.
        robot_file: The robot, instead of the one in the folder: what :func:`humanoid_rail.load_robot` takes, or the
            URDF of the paper's robot as `humanoid-rail urdf` writes it.
        srdf: The SRDF of that robot, if one is given.
        packages: Folders of ROS packages for it.

    Raises:
        InvalidInput: If the folder holds no plan, a file is not valid, or the three do not go together.
    """
    trajectory = read_trajectory(folder)
    if (srdf or packages) and not robot_file:
        raise InvalidInput("srdf" if srdf else "packages", srdf or packages, "beside a robot that is given (--robot)")
    source = robot_file or str(Path(folder) / (NAME if (Path(folder) / NAME).is_file() else URDF))
    robot = given_robot(robot_file, srdf, packages) if robot_file else carried_robot(Path(folder))
    if (robot.joint_names, robot.hand_names) != (trajectory.joint_names, trajectory.hand_names):
        valid = f"the robot of the trajectory, with the joints {', '.join(trajectory.joint_names)}"
        raise InvalidInput("robot", ", ".join(robot.joint_names), valid, source)
    source = scene_file or str(Path(folder) / SCENE)
    scene = load_scene(scene_file) if scene_file else _scene(source)
    if not scene_file and scene.name != trajectory.provenance.scene:
        planned = trajectory.provenance.scene
        valid = f"{planned!r}, the scene that this trajectory was planned for, or another given by --scene"
        raise InvalidInput("name", scene.name, valid, source)
    try:
        check_scene(robot, scene)
    except InvalidInput as error:
        error.source = source
        raise
    known = _planned_in(Path(folder), trajectory, scene) if scene_file else scene
    return Plan(robot, scene, replace(trajectory, robot=robot, scene=known))


def _planned_in(folder: Path, trajectory: Trajectory, given: Scene) -> Scene:
    """Return the scene in a folder, which the certificate is about, or the one given if it is not there or another."""
    try:
        own = _scene(str(folder / SCENE))
    except InvalidInput:
        return given
    return own if own.name == trajectory.provenance.scene else given


def _mesh(obstacle: Mesh, number: int) -> tuple[str, bytes]:
    """Return the name and content of a file that holds a mesh without any other: the file itself, or its triangles."""
    path, field = Path(obstacle.file), f"obstacles[{number}].file"
    suffix = path.suffix.lower()
    try:
        pieces = obstacle.model_copy().pieces
        own = suffix in WITHOUT_REFERENCES
        content = path.read_bytes() if own else off_bytes(read_triangles(obstacle.file))
    except (OSError, ValueError) as error:
        raise InvalidInput(field, obstacle.file, f"a file that is still there ({error})") from error
    if len(pieces) != len(obstacle.pieces) or not all(map(np.array_equal, pieces, obstacle.pieces)):
        raise InvalidInput(field, obstacle.file, "a file that has not changed since the scene was loaded")
    return f"mesh-{number}{suffix if own else '.off'}", content


def _measured(obstacle: HeightField | PointCloud, number: int) -> tuple[str, bytes]:
    """Return the name and content of the file of a height field or a point cloud."""
    field = f"obstacles[{number}].file"
    try:
        content, again = Path(obstacle.file).read_bytes(), obstacle.model_copy()
    except (OSError, ValueError) as error:
        raise InvalidInput(field, obstacle.file, f"a file that is still there ({error})") from error
    if again != obstacle:
        raise InvalidInput(field, obstacle.file, "a file that has not changed since the scene was loaded")
    return f"{obstacle.type}-{number}{Path(obstacle.file).suffix.lower()}", content


def _scene(file: str) -> Scene:
    try:
        text = Path(file).read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        valid = f"a file as `humanoid-rail plan --out` writes it, or another given by --scene ({error})"
        raise InvalidInput("scene", file, valid) from error
    try:
        data = json.loads(text)
    except ValueError as error:
        raise InvalidInput("scene", text, f"JSON ({error})", file) from error
    return make_scene(data, folder=Path(file).parent, source=file)
