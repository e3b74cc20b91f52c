"""Where robots come from: the paper's robot, robot files, URDFs, and the models of other packages."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from inspect import Parameter, Signature
from pathlib import Path
from typing import Any, TypedDict, Unpack, overload

import numpy as np
import pinocchio as pin

from humanoid_rail._resources import resource
from humanoid_rail.errors import InvalidInput, did_you_mean
from humanoid_rail.model.humanoid import RobotArguments, argument_parameters, build_urdf, paper_robot, xacro_arguments
from humanoid_rail.model.loading import robot_of
from humanoid_rail.model.robot import Hand, Robot
from humanoid_rail.model.robot_file import IN_FILES_ONLY, NAME, RobotFile, make_robot_file, read_robot_file
from humanoid_rail.model.sources import SUFFIXES, is_there

FILES = (".yaml", ".yml", ".json")
"""Robot files have these endings."""
PAPER = "humanoid_rail"
"""The paper's robot is called so."""
OWN = (PAPER, "human-sized", "humanoid-rail-with-grippers")
"""The robots that need no package of models; the others are the gallery."""


class FileArguments(TypedDict, total=False):
    """What a URDF does not say, as arguments: the fields of a robot file, which they replace."""

    srdf: str | Path
    """SRDF text or its path."""
    packages: Sequence[str | Path]
    """Folders of ROS packages, or folders that hold them."""
    package: str
    """A Python package whose models the URDF is one of."""
    name: str
    """What the robot is called."""
    xacro: Mapping[str, object]
    """Arguments of the xacro."""
    hands: Sequence[Hand] | Mapping[str, Any]
    """The hands; or by name their frames, or mappings as in a robot file."""
    joints: Sequence[str]
    """The joints that move."""
    locked: Mapping[str, float]
    """Where joints stand that do not move, m or rad."""
    locked_joints: Sequence[str]
    """Joints that do not move."""
    continuous_joints_within: tuple[float, float]
    """Joints without end are kept within this, rad."""
    limits: Mapping[str, Mapping[str, float]]
    """`lower`, `upper`, `velocity`, `acceleration`, `jerk` by joint; m, rad, s."""
    acceleration_time: float
    """Joints without a limit of acceleration reach their speed limit in this time, s."""
    postures: Mapping[str, Mapping[str, float]]
    """Positions of joints by the names of postures, m and rad."""
    initial: object
    """A posture's name, positions by joint, or all positions (n,); m and rad."""
    base: pin.SE3 | Mapping[str, Any]
    """Where the root of the URDF stands: `xyz` in m and `rpy` in rad."""
    pairs: Mapping[str, Any]
    """Pairs of links that are left out, or kept nearer than others."""
    decomposed: Sequence[str]
    """Links whose meshes are cut into convex pieces."""


@overload
def load_robot(**arguments: Unpack[RobotArguments]) -> Robot: ...


@overload
def load_robot(source: str | Path, **arguments: Unpack[FileArguments]) -> Robot: ...


def load_robot(source: str | Path | None = None, **arguments: Any) -> Robot:
    """Return a robot: the paper's without a source, else any other.

    Of another robot the files say what they say; hands, joints to lock, a free start, convex bodies for its meshes and
    pairs that need no checks are found by themselves unless they are given. `print(robot.report())` shows all of it.

    Args:
        source: A URDF or xacro: its path or text. A robot file, or a folder with a `robot.yaml`. A name: one of
            `robots/` such as `"panda"`, `PACKAGE:ROBOT` for a model of an installed Python package such as
            `"example-robot-data:baxter"`, or `NAME_description` of `robot_descriptions`.
        **arguments: With a source the fields of a robot file, which they replace; docs/robots.md describes them.
            Without, the arguments of the paper's robot: link lengths `l_*` (m), `beta`
            (rad), `link_radius` (m), limits `*_lower`, `*_upper`, `*_velocity`, `*_acceleration`, `*_effort` (m, rad,
            s, N, N m), `density` (kg/m^3), `trunk_bodies` and `grippers` (1 or 0), for example ``link_radius=0.0``.

    Raises:
        InvalidInput: If there is no such robot, an argument is unknown or its value is not valid, or something of the
            robot cannot be read: nothing is left out in silence.
    """
    if source is None or source == PAPER:
        if wrong := [name for name in arguments if name in RobotFile.model_fields]:
            valid = f"given with the source of a robot, such as load_robot('my.urdf', {wrong[0]}=...)"
            raise InvalidInput(wrong[0], arguments[wrong[0]], valid)
        return paper_robot(build_urdf(**arguments))
    for name in arguments:
        known = [field for field in RobotFile.model_fields if field not in IN_FILES_ONLY]
        if name not in known:
            valid = f"an argument that is one of {', '.join(known)}{did_you_mean(name, known)}"
            if name in xacro_arguments():
                valid = f"an argument of the paper's robot alone, which has no source; here {', '.join(known)}"
            raise InvalidInput(name, arguments[name], valid)
    given = {name: _plain(name, value) for name, value in arguments.items()}
    if (path := _robot_file(source)) is not None:
        file = read_robot_file(path)
        return robot_of(_with(file, given), (path if path.is_dir() else path.parent).absolute())
    _check_name(source)
    if not isinstance(source, str | Path):
        raise InvalidInput("source", source, "a path, the text of a URDF, or the name of a robot")
    return robot_of(_with(RobotFile(urdf=str(source)), given), Path.cwd())


def robots() -> tuple[str, ...]:
    """Return the names of the robots that come with the package."""
    home = resource("robots", "humanoid_rail.urdf.xacro").parent
    return (PAPER, *sorted(path.parent.name for path in home.glob(f"*/{NAME}")))


def _robot_file(source: object) -> Path | None:
    """Return the robot file, or the folder of one, that a source means; None if it means something else."""
    if isinstance(source, str) and source in robots():
        return resource("robots", f"{source}/{NAME}")
    if not isinstance(source, Path) and (not isinstance(source, str) or "<" in source):
        return None
    path = Path(source)
    return path if path.suffix in FILES or is_there(path / NAME) else None


def _check_name(source: object) -> None:
    """Check that a source that can only be the name of a robot here is one.

    Raises:
        InvalidInput: If it is not; the error names those that there are.
    """
    if not isinstance(source, str) or "<" in source or ":" in source or source.endswith("_description"):
        return
    if Path(source).suffix not in SUFFIXES and not is_there(source, Path.exists):
        valid = f"the path of a URDF, xacro or robot file, its text, PACKAGE:ROBOT, or one of {', '.join(robots())}"
        raise InvalidInput("robot", source, f"{valid}{did_you_mean(source, robots())}")


def _with(file: RobotFile, given: Mapping[str, Any]) -> RobotFile:
    """Return a robot file with other fields. What it says of joints that these lock does not count any more."""
    data: dict[str, Any] = {name: getattr(file, name) for name in file.model_fields_set}
    moving, locked = given.get("joints"), {*_names(given, "locked"), *_names(given, "locked_joints")}

    def moves(name: str) -> bool:
        return name not in locked and (moving is None or name in moving)

    if (moving is not None or locked) and not isinstance(moving, str):
        if file.joints is not None:
            data["joints"] = tuple(filter(moves, file.joints))
        if isinstance(file.initial, Mapping):
            data["initial"] = {name: x for name, x in file.initial.items() if moves(name)}
        if moving is not None:
            data["locked"] = {name: x for name, x in file.locked.items() if name not in moving}
        data["hands"] = {
            name: hand.model_copy(update={"arm": None if hand.arm is None else tuple(filter(moves, hand.arm))})
            for name, hand in (file.hands or {}).items()
        } or None
    return make_robot_file({**data, **given})


def _names(given: Mapping[str, Any], field: str) -> Sequence[str]:
    value = given.get(field, ())
    return () if isinstance(value, str) else tuple(value)


def _plain(name: str, value: Any) -> object:
    """Return an argument as a robot file has it."""
    match name, value:
        case "hands", _ if isinstance(value, Sequence) and all(isinstance(hand, Hand) for hand in value):
            return {
                hand.name: {"frame": hand.frame, "arm": hand.arm, "pointing": hand.pointing, "links": hand.links}
                for hand in value
            }
        case "base", pin.SE3():
            return {"xyz": value.translation.tolist(), "rpy": pin.rpy.matrixToRpy(value.rotation).tolist()}
        case "packages", str() | Path():
            return (str(Path(value).absolute()),)
        case "packages", _ if isinstance(value, Sequence):
            return tuple(str(Path(place).absolute()) for place in value)
        case "srdf", Path() | str() if "<" not in str(value):
            return str(Path(value).absolute())
        case _ if isinstance(value, np.ndarray):
            return value.tolist()
    return value


load_robot.__signature__ = Signature(  # type: ignore[attr-defined]
    [
        Parameter("source", Parameter.POSITIONAL_OR_KEYWORD, default=None),
        *(Parameter(name, Parameter.KEYWORD_ONLY, default=None) for name in FileArguments.__annotations__),
        *argument_parameters(),
    ],
    return_annotation="Robot",
)
