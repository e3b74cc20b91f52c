"""The joints of another tool's motion as those of a robot: by name, checked, and none lost."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.errors import MISSING, InvalidInput, did_you_mean
from humanoid_rail.model.robot import Robot

SAME_POSITION = 1e-5
"""Joints that follow others or are locked may be off by this, m and rad: what a file with six digits loses."""
ROUNDED = 1e-3
"""What is beyond a limit by no more than this in the other unit was rounded, m and rad."""
FAR = 2.0 * np.pi
"""Positions beyond a limit by no more than this may be what they seem, m and rad."""
UNITS = {True: ("millimetres", "m", 1e-3), False: ("degrees", "rad", np.pi / 180.0)}
"""What may have been meant, what is right, and one in the other, by whether a joint slides."""


def actuated_columns(robot: Robot, names: Sequence[str], q: Array) -> list[int]:
    """Return the columns (n,) of the actuated joints of a robot, in its order.

    Args:
        robot: The robot.
        names: The joints of the columns, m of them.
        q: Positions (N, m), m and rad.

    Raises:
        InvalidInput: If a joint is missing, there twice or unknown, or follows another or is locked and is not where it
            has to be, or positions look like degrees or millimetres.
    """
    passive = [name for name in list(robot.model.names)[1:] if name not in robot.joint_names]
    known = [*robot.joint_names, *passive, *robot.locked]
    for name in names:
        if name not in known:
            near = did_you_mean(name, [n for n in known if n not in names])
            raise InvalidInput("motion.joint_names", name, f"joints of {robot.name}{near}: {', '.join(known)}")
        if list(names).count(name) > 1:
            raise InvalidInput("motion.joint_names", name, "each joint once")
    for name in robot.joint_names:
        if name not in names:
            raise InvalidInput(f"motion.{name}", MISSING, f"a column for each of {', '.join(robot.joint_names)}")
    own = [list(names).index(name) for name in robot.joint_names]
    _check_units(robot, q[:, own])
    _check_others(robot, names, q, q[:, own], passive)
    return own


def _check_others(robot: Robot, names: Sequence[str], q: Array, own: Array, passive: Sequence[str]) -> None:
    """Check that joints that follow others or are locked are where they have to be."""
    full = own @ robot.coupling.T + robot.offset
    expected = {name: full[:, robot.model.joints[robot.model.getJointId(name)].idx_q] for name in passive}
    expected |= {name: np.full(len(q), at) for name, at in robot.locked.items()}
    for name, there in expected.items():
        if name in names:
            off = abs(q[:, list(names).index(name)] - there)
            if off.max(initial=0.0) > SAME_POSITION:
                k = int(off.argmax())
                value = float(q[k, list(names).index(name)])
                how = "locked" if name in robot.locked else "it follows other joints"
                raise InvalidInput(f"motion.{name}", value, f"{there[k]:.6g} in row {k}: {how} on this robot")


def _check_units(robot: Robot, q: Array) -> None:
    """Check that positions beyond the limits would not be within them in another unit, all of them.

    Raises:
        InvalidInput: If they would: no robot turns or goes so far by chance.
    """
    for slides, (other, right, factor) in UNITS.items():
        columns = [j for j in range(robot.n) if _slides(robot, robot.joint_names[j]) == slides]
        beyond = [j for j in columns if max(robot.lower[j] - q[:, j].min(), q[:, j].max() - robot.upper[j]) > FAR]
        scaled = factor * q[:, columns]
        kept = ((scaled >= robot.lower[columns] - ROUNDED) & (scaled <= robot.upper[columns] + ROUNDED)).all()
        if beyond and kept:
            j = beyond[0]
            value = float(q[abs(q[:, j]).argmax(), j])
            valid = f"{right}, within {robot.lower[j]:.4g} to {robot.upper[j]:.4g}; these look like {other}"
            raise InvalidInput(f"motion.{robot.joint_names[j]}", value, valid)


def _slides(robot: Robot, name: str) -> bool:
    return bool(robot.model.joints[robot.model.getJointId(name)].shortname().startswith("JointModelP"))
