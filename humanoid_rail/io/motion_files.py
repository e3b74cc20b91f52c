"""Motions that other tools wrote: CSV, arrays of NumPy, and ROS messages of type JointTrajectory."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail._yaml import parse_yaml
from humanoid_rail.errors import MISSING, InvalidInput, did_you_mean
from humanoid_rail.io.foreign_joints import actuated_columns
from humanoid_rail.io.tables import EVENT
from humanoid_rail.io.trajectory_files import DAMAGED
from humanoid_rail.kinematics.joint_limits import JointMotion, Violation, limit_violations, sampled
from humanoid_rail.model.robot import Robot
from humanoid_rail.resampling import evaluate
from humanoid_rail.result import Motion, Timing

TIMES = ("t", "time", "times", "time_from_start")
"""Columns and arrays of these names hold times, s."""
POSITIONS = ("q", "qpos", "position", "positions")
"""Arrays of these names hold positions."""
VELOCITIES = ("velocity", "velocities", "qvel", "qd")
"""Arrays of these names hold velocities."""
ACCELERATIONS = ("acceleration", "accelerations", "qacc", "qdd")
"""Arrays of these names hold accelerations."""
FINER = 10
"""Limits of a cubic spline are looked at this many times finer than its samples."""
NAMES = ("joint_names", "names", "joints")
"""Arrays of these names hold the names of the joints."""
WRAPPERS = ("goal", "trajectory", "joint_trajectory")
"""Messages of actions and of MoveIt have a JointTrajectory in a field of this name."""
MULTI_DOF = "multi_dof_joint_trajectory"
"""Beside it MoveIt has joints of several degrees of freedom here, such as a base that moves."""
SUFFIXES = (".csv", ".npz", ".json", ".yaml", ".yml")
"""Files with these endings are read."""


@dataclass(frozen=True, eq=False)
class ForeignMotion:
    """A motion as another tool wrote it, to be given to :func:`humanoid_rail.verify`. N samples, n joints."""

    t: Array
    """Times (N,), s."""
    q: Array
    """Configurations (N, n), m and rad."""
    joint_names: tuple[str, ...]
    """The joints of the robot."""
    timing: SimpleNamespace | None
    """Has `velocity` (N, n) if the file does: the motion is then the cubic spline through both, else linear."""
    acceleration: Array | None
    """Accelerations (N, n) if the file has them: the cubic spline does not depend on them."""
    ignored: tuple[str, ...]
    """What else is in the file, and was not read."""


@dataclass
class _Table:
    """What a file says: joints by their names, one column or array column each."""

    t: Any = None
    names: Sequence[str] | None = None
    position: Any = None
    velocity: Any = None
    acceleration: Any = None
    ignored: list[str] = field(default_factory=list)


def read_motion(path: str | Path, robot: Robot, *, linear: bool = False) -> ForeignMotion:
    """Return the motion in a file.

    Joints are found by their names, in any order; joints that follow others or are locked may be there, where they have
    to be. Metres, radians and seconds.

    Args:
        path: A CSV file with a header: `t` or `time`, a column for each joint, and perhaps `JOINT_velocity` and
            `JOINT_acceleration`. An NPZ file with `t` (N,), `q` (N, n), perhaps `velocity`, `acceleration` and
            `joint_names`, without which the columns are the robot's joints in order. Or a ROS message of type
            JointTrajectory as JSON or YAML, of ROS 1 or 2, alone, as the `trajectory` of a goal or as MoveIt has it.
        robot: The robot.
        linear: Whether velocities are not used: the motion is then linear between its samples.

    Raises:
        InvalidInput: If the file cannot be read, a joint is missing, unknown or moves otherwise than the robot's, or
            positions look like degrees or millimetres.
    """
    file = Path(path)
    readers = {".csv": _of_csv, ".npz": _of_npz}
    if file.suffix.lower() not in SUFFIXES:
        raise InvalidInput("motion", str(path), f"a folder of a plan, or a file with the ending {', '.join(SUFFIXES)}")
    try:
        table = readers.get(file.suffix.lower(), _of_ros)(file)
        return _motion(table, robot, linear)
    except InvalidInput as error:
        error.source = error.source or str(path)
        raise
    except (OSError, EOFError, KeyError, IndexError, TypeError, ValueError, AttributeError, *DAMAGED) as error:
        valid = f"a file of a motion that can be read ({type(error).__name__}: {error})"
        raise InvalidInput("motion", str(path), valid) from error


def limits_exceeded(robot: Robot, motion: ForeignMotion) -> tuple[Violation, ...]:
    """Return for each joint the worst excess over each of its limits, looked at `FINER` times finer.

    Of a motion that is linear between its samples accelerations do not count.
    """
    if motion.timing is None or len(motion.t) == 1:
        return limit_violations(robot, sampled(motion.t, motion.q))
    t, q, velocity = motion.t, motion.q, motion.timing.velocity
    frame = Motion(t, q, motion.joint_names, Timing(velocity, np.zeros_like(q), ()))
    u = np.linspace(0.0, 1.0, FINER + 1)[:-1]
    times = np.append((t[:-1, None] + u * np.diff(t)[:, None]).ravel(), t[-1])
    positions, velocities, accelerations = evaluate(frame, times)
    _, _, before_end = evaluate(frame, np.nextafter(t[1:], -np.inf))
    ends = JointMotion(t[1:], q[1:], velocity[1:], before_end)
    return limit_violations(robot, JointMotion(times, positions, velocities, accelerations), ends)


def departure(motion: ForeignMotion) -> float:
    """Return how far at most a joint is from the cubic spline if the file's accelerations are used too, m or rad.

    Through positions, velocities and accelerations a controller follows a polynomial of degree five. That
    differs from the cubic by the differences of the accelerations at both ends, each times u^2 (1 - u)^3 h^2 / 2, which
    is largest at u = 2/5.
    """
    if motion.timing is None or motion.acceleration is None or len(motion.t) == 1:
        return 0.0
    h, v, a = np.diff(motion.t)[:, None], motion.timing.velocity, motion.acceleration
    mean = np.diff(motion.q, axis=0) / h
    first = (6.0 * mean - 4.0 * v[:-1] - 2.0 * v[1:]) / h
    last = (2.0 * v[:-1] + 4.0 * v[1:] - 6.0 * mean) / h
    off = abs(a[:-1] - first) + abs(a[1:] - last)
    return float((0.4**2 * 0.6**3 / 2.0 * h**2 * off).max())


def _motion(table: _Table, robot: Robot, linear: bool) -> ForeignMotion:
    if table.t is None:
        raise InvalidInput("motion.t", MISSING, f"times, s, called one of {', '.join(TIMES)}")
    if table.position is None:
        raise InvalidInput("motion.q", MISSING, f"positions, called one of {', '.join(POSITIONS)}, or by joint")
    t = _numbers("t", table.t).ravel()
    names = robot.joint_names if table.names is None else tuple(table.names)
    values = {}
    for name in ("position", "velocity", "acceleration"):
        if (given := getattr(table, name)) is not None:
            values[name] = _numbers(name, given)
            if values[name].shape != (len(t), len(names)) or not len(t):
                valid = f"an array of shape ({len(t)}, {len(names)}), not less than one row"
                raise InvalidInput(f"motion.{name}", values[name].shape, valid)
    columns = actuated_columns(robot, names, values["position"])
    own = {name: array[:, columns] for name, array in values.items()}
    timing = SimpleNamespace(velocity=own["velocity"]) if "velocity" in own and not linear else None
    return ForeignMotion(t, own["position"], robot.joint_names, timing, own.get("acceleration"), tuple(table.ignored))


def _numbers(name: str, values: Any) -> Array:
    if (kind := getattr(values, "dtype", None)) is not None and kind.kind in "bcmM":
        raise InvalidInput(f"motion.{name}", str(kind), "an array of real numbers")
    try:
        array = np.array(values, float)
    except (TypeError, ValueError):
        raise InvalidInput(f"motion.{name}", values, "numbers, as many in each row") from None
    if not np.isfinite(array).all():
        raise InvalidInput(f"motion.{name}", float(array[~np.isfinite(array)][0]), "finite numbers")
    return array


def _of_csv(file: Path) -> _Table:
    with file.open(newline="", encoding="utf-8-sig") as opened:
        reader = csv.reader(opened)
        lines = [(reader.line_num, row) for row in reader if row]
    names = [name.strip() for name in lines[0][1]] if lines else []
    if len(names) < 2:
        header = names[0] if names else MISSING
        raise InvalidInput("motion", header, "a header: the names of columns with commas between them")
    if len(set(names)) < len(names):
        raise InvalidInput("motion", next(n for n in names if names.count(n) > 1), "columns whose names differ")
    for number, row in lines[1:]:
        if len(row) != len(names):
            raise InvalidInput("motion", f"line {number}", f"{len(names)} values, as in the header")
    rows = [row for _, row in lines[1:]]
    columns = dict(zip(names, zip(*rows, strict=True), strict=True)) if rows else dict.fromkeys(names, ())
    table = _Table(t=_pop(columns, TIMES))
    if EVENT in columns and not all(map(_is_number, columns[EVENT])):
        del columns[EVENT]
        table.ignored.append(EVENT)
    derivatives: dict[str, dict[str, Any]] = {"velocity": {}, "acceleration": {}}
    for name in list(columns):
        joint, _, what = name.rpartition("_")
        if joint in columns and what in derivatives:
            derivatives[what][joint] = columns.pop(name)
    # The hands of this package's own tables are no joints.
    hands = {name[:-2] for name in columns if name.endswith("_x")}
    for hand in hands:
        axes = [f"{hand}_{axis}" for axis in "xyz"]
        if all(axis in columns for axis in axes):
            table.ignored += axes
            for axis in axes:
                del columns[axis]
    table.names, table.position = list(columns), _side_by_side(columns, list(columns), "position")
    for what, found in derivatives.items():
        if found:
            setattr(table, what, _side_by_side(found, list(columns), what))
    return table


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _side_by_side(columns: Mapping[str, Any], names: Sequence[str], what: str) -> Array:
    for name in names:
        if name not in columns:
            raise InvalidInput(f"motion.{name}_{what}", MISSING, f"a column, as other joints have one for their {what}")
    return np.stack([_numbers(name, columns[name]) for name in names], axis=1)


def _of_npz(file: Path) -> _Table:
    with np.load(file) as arrays:
        found = {name: arrays[name] for name in arrays.files}
    table = _Table(t=_pop(found, TIMES), position=_pop(found, POSITIONS))
    table.velocity, table.acceleration = _pop(found, VELOCITIES), _pop(found, ACCELERATIONS)
    names = _pop(found, NAMES)
    table.names = None if names is None else names.astype(str).tolist()
    table.ignored = list(found)
    return table


def _of_ros(file: Path) -> _Table:
    # `ros2 topic echo` ends each message so.
    text = file.read_text(encoding="utf-8-sig").rstrip().removesuffix("---")
    data = json.loads(text) if file.suffix.lower() == ".json" else parse_yaml("motion", text, str(file))
    while isinstance(data, Mapping) and (inside := [name for name in WRAPPERS if name in data]):
        if len((data.get(MULTI_DOF) or {}).get("points") or ()):
            raise InvalidInput(f"motion.{MULTI_DOF}.points", data[MULTI_DOF]["points"], "none: they are not read")
        data = data[inside[0]]
        data = data[0] if isinstance(data, list) and len(data) == 1 else data
    if not isinstance(data, Mapping) or "joint_names" not in data or "points" not in data:
        near = did_you_mean("joint_names", list(data)) if isinstance(data, Mapping) else ""
        raise InvalidInput("motion", str(file), f"a JointTrajectory with joint_names and points{near}")
    points = data["points"]
    table = _Table(t=[_seconds(point["time_from_start"]) for point in points], names=list(data["joint_names"]))
    table.position = [point["positions"] for point in points]
    for what, key in (("velocity", "velocities"), ("acceleration", "accelerations")):
        given = [point.get(key) or [] for point in points]
        if all(given):
            setattr(table, what, given)
        elif any(given):
            raise InvalidInput(
                f"motion.points[{[bool(g) for g in given].index(False)}].{key}", MISSING, "for all or none"
            )
    if any(point.get("effort") for point in points):
        table.ignored.append("effort")
    return table


def _seconds(time: Any) -> float:
    """Return a ROS duration in s: `sec` and `nanosec`, `secs` and `nsecs`, or a number."""
    if isinstance(time, int | float):
        return float(time)
    if not isinstance(time, Mapping) or not set(time) <= {"sec", "secs", "nanosec", "nsecs"}:
        raise InvalidInput("motion.points.time_from_start", time, "sec and nanosec, secs and nsecs, or a number, s")
    whole, part = (time.get(name, time.get(other, 0)) for name, other in (("sec", "secs"), ("nanosec", "nsecs")))
    return float(whole) + 1e-9 * float(part)


def _pop(found: dict[str, Any], names: Sequence[str]) -> Any:
    """Return and remove what is there by one of these names; None if nothing is.

    Raises:
        InvalidInput: If there is more than one.
    """
    there = [name for name in names if name in found]
    if len(there) > 1:
        raise InvalidInput("motion", ", ".join(there), "one of them")
    return found.pop(there[0]) if there else None
