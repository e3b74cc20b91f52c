"""Builds robots from URDFs."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from humanoid_rail._arrays import Array, checked_array, frozen
from humanoid_rail.errors import MISSING, InvalidInput
from humanoid_rail.model.collision_bodies import collision_bodies
from humanoid_rail.model.followers import ActuatedLimits, folded_limits
from humanoid_rail.model.pairs import Pairs, choose_pairs, disabled_pairs, rigid_pairs
from humanoid_rail.model.robot import Hand, Robot
from humanoid_rail.model.urdf import Urdf, read_urdf
from humanoid_rail.model.urdf_elements import read_text
from humanoid_rail.model.urdf_joint import Mimic


@dataclass(frozen=True, eq=False)
class Mechanism:
    """How the joints of a URDF move; n is the number of those that are actuated."""

    urdf: Urdf
    model: pin.Model
    """All joints, those that follow others free."""
    joint_names: tuple[str, ...]
    """The actuated joints."""
    coupling: Array
    """S (model.nv, n)."""
    offset: Array
    """s0 (model.nq,)."""
    limits: ActuatedLimits
    """Limits within which each follower keeps its own too."""

    def full_configuration(self, q: Array) -> Array:
        """Return the configuration S q + s0 (model.nq,) of all joints."""
        full: Array = self.coupling @ q + self.offset
        return full


def robot_from_urdf(
    urdf: str | Path, srdf: str | Path | None, hands: Sequence[Hand], initial: ArrayLike | None = None
) -> Robot:
    """Return a robot from a URDF of version 1.0 to 1.2 as it is written; :func:`humanoid_rail.load_robot` does more.

    It is read strictly: every `<collision>` becomes a body of the size that is written, or the URDF is refused. A
    revolute joint that can turn by more than 2 pi from 0 is warned of, as its limits may be in degrees.

    Args:
        urdf: URDF text, or the path of a file. `<mimic>` joints become rows of the linear coupling.
        srdf: SRDF text, or the path of a file, naming the pairs of links that need not be checked against each other,
            if any.
        hands: The points that are given targets.
        initial: Configuration (n,) in m and rad; the middle of the position limits if not given.

    Raises:
        InvalidInput: If the URDF cannot be read as a whole, a joint has no Euclidean configuration (continuous,
            floating), a hand names a frame or a joint that the URDF does not have or points nowhere, arms overlap or
            have fewer than three joints, there are no collision bodies or one is a mesh, the SRDF is none, a passive
            joint cannot keep its limits wherever its leader is, or `initial` has the wrong size.
    """
    return robot_as_written(read_text("urdf", urdf), srdf, hands, initial)


def robot_as_written(
    text: str,
    srdf: str | Path | None,
    hands: Sequence[Hand],
    initial: ArrayLike | None = None,
    *,
    with_rigid_pairs: bool = True,
) -> Robot:
    """Return a robot as :func:`robot_from_urdf` does from the text of its URDF.

    Args:
        text: The URDF.
        srdf: As there.
        hands: As there.
        initial: As there.
        with_rigid_pairs: Whether links that no joint moves relative to each other are checked against each other.
    """
    mechanism = read_mechanism(text)
    bodies = collision_bodies(mechanism.model, mechanism.urdf, {})
    check_hands(mechanism.model, mechanism.joint_names, hands)
    middle = (mechanism.limits.lower + mechanism.limits.upper) / 2
    start = checked_start(mechanism, middle if initial is None else initial)
    disabled = disabled_pairs(mechanism.model, read_text("srdf", srdf) if srdf else None)
    if not with_rigid_pairs:
        disabled = rigid_pairs(mechanism.model, bodies) | disabled
    pairs = choose_pairs(mechanism.model, bodies, disabled, mechanism.full_configuration(start))
    return build_robot(mechanism, text, bodies, pairs, hands, start)


def read_mechanism(text: str) -> Mechanism:
    """Return how the joints of a URDF move.

    Raises:
        InvalidInput: If it cannot be read, or a joint has no Euclidean configuration.
    """
    urdf = read_urdf(text)
    for joint in urdf.joints.values():
        limit = joint.limit
        if joint.kind in ("revolute", "prismatic") and limit is not None and limit.has_no_range:
            valid = "lower < upper, in m or rad; one that is not written is 0"
            raise InvalidInput(f"joint {joint.name}.limit", f"from {limit.lower:g} to {limit.upper:g}", valid)
    model = _model(urdf)
    mimics = {name: mimic for name in list(model.names)[1:] if (mimic := urdf.joints[name].mimic) is not None}
    joint_names = tuple(name for name in list(model.names)[1:] if name not in mimics)
    coupling, offset = _linear_coupling(model, joint_names, mimics)
    return Mechanism(
        urdf, model, joint_names, coupling, offset, folded_limits(model, urdf, joint_names, coupling, offset)
    )


def checked_start(mechanism: Mechanism, initial: ArrayLike) -> Array:
    """Return a configuration (n,) of the actuated joints.

    Raises:
        InvalidInput: If it is none.
    """
    n = len(mechanism.joint_names)
    return checked_array("initial", initial, (n,), f"a finite number for each of the {n} actuated joints")


def build_robot(
    mechanism: Mechanism,
    text: str,
    bodies: pin.GeometryModel,
    pairs: Pairs,
    hands: Sequence[Hand],
    start: Array,
    **more: Any,
) -> Robot:
    """Return a robot.

    Args:
        mechanism: How its joints move.
        text: Its URDF.
        bodies: Its collision bodies.
        pairs: Which of them are checked against each other.
        hands: Its hands.
        start: Where motions start (n,), m and rad.
        **more: Further fields of :class:`Robot`.

    Raises:
        InvalidInput: If a hand is not one of this robot.
    """
    check_hands(mechanism.model, mechanism.joint_names, hands)
    _warn_of_degrees(mechanism.urdf, mechanism.joint_names)
    limits = mechanism.limits
    return Robot(
        name=mechanism.model.name,
        urdf=text,
        model=mechanism.model,
        collision_model=bodies,
        coupling=frozen(mechanism.coupling),
        offset=frozen(mechanism.offset),
        joint_names=mechanism.joint_names,
        lower=frozen(limits.lower),
        upper=frozen(limits.upper),
        velocity_limit=frozen(limits.velocity),
        acceleration_limit=frozen(limits.acceleration),
        jerk_limit=frozen(limits.jerk),
        hands=tuple(hands),
        initial=frozen(start),
        self_collision_pairs=pairs.checked,
        left_out=pairs.left_out,
        **more,
    )


def _model(urdf: Urdf) -> pin.Model:
    try:
        model = pin.buildModelFromXML(urdf.text)
    except (ValueError, RuntimeError) as error:
        raise InvalidInput("urdf", urdf.text, f"a URDF that Pinocchio reads ({error})") from error
    for name, joint in zip(list(model.names)[1:], list(model.joints)[1:], strict=True):
        if (joint.nq, joint.nv) != (1, 1):
            raise InvalidInput(f"joint {name}", joint.shortname(), "revolute with limits, or prismatic")
    return model


def _warn_of_degrees(urdf: Urdf, joint_names: Sequence[str]) -> None:
    """Warn of actuated joints that can turn so far that their limits may be in degrees."""
    for name in joint_names:
        limit = urdf.joints[name].limit
        if limit is not None and urdf.joints[name].kind == "revolute":
            farthest = max(-limit.lower, limit.upper)
            if farthest > 2 * np.pi + 1e-6:
                turns = f"joint {name} turns from {limit.lower:g} to {limit.upper:g} rad"
                warnings.warn(f"{turns}, more than once around: limits of a URDF are in rad, not degrees", stacklevel=3)


def _linear_coupling(model: pin.Model, joint_names: Sequence[str], mimics: Mapping[str, Mimic]) -> tuple[Array, Array]:
    """Return S and s0 of q_full = S q + s0; a joint that mimics a mimic follows its leader's leaders."""
    coupling, offset = np.zeros((model.nv, len(joint_names))), np.zeros(model.nq)

    def row(name: str) -> tuple[Array, float]:
        if name not in mimics:
            return np.eye(len(joint_names))[joint_names.index(name)], 0.0
        mimic = mimics[name]
        leader, constant = row(mimic.joint)
        return mimic.multiplier * leader, mimic.multiplier * constant + mimic.offset

    for joint_id, name in enumerate(list(model.names)[1:], start=1):
        joint = model.joints[joint_id]
        coupling[joint.idx_v], offset[joint.idx_q] = row(name)
    return coupling, offset


def check_hands(model: pin.Model, joint_names: Sequence[str], hands: Sequence[Hand]) -> None:
    """Check that hands are those of a robot.

    Raises:
        InvalidInput: If one is not.
    """
    if not isinstance(hands, Sequence) or not all(isinstance(hand, Hand) for hand in hands):
        raise InvalidInput("hands", hands, "a list of Hand")
    if not hands:
        raise InvalidInput("hands", MISSING, "at least one hand")
    for hand in hands:
        _check_hand(model, joint_names, hand)
    arms = [joint for hand in hands for joint in hand.arm]
    names = [hand.name for hand in hands]
    if len(set(names)) < len(names):
        raise InvalidInput("hands", names, "hands whose names differ")
    for hand in hands:
        for joint in hand.arm:
            if arms.count(joint) > 1:
                raise InvalidInput(f"hands.{hand.name}.arm", joint, "each joint in one arm, once")


def _check_hand(model: pin.Model, joint_names: Sequence[str], hand: Hand) -> None:
    if not isinstance(hand.name, str) or not hand.name:
        raise InvalidInput("hands.name", hand.name, "a name")
    where = f"hands.{hand.name}"
    # A link and a joint may have the same name; a frame that is meant has to be the only one.
    count = sum(frame.name == hand.frame for frame in model.frames) if isinstance(hand.frame, str) else 0
    if count != 1:
        valid = "a frame with a name of its own; a link and a joint are called so" if count else "a frame of the URDF"
        raise InvalidInput(f"{where}.frame", hand.frame, valid)
    if not isinstance(hand.arm, tuple | list) or len(hand.arm) < 3:
        valid = "three joints that move or more; with fewer the manipulability (eq. 3.4) is always 0"
        raise InvalidInput(f"{where}.arm", hand.arm, valid)
    for joint in hand.arm:
        if joint not in joint_names:
            raise InvalidInput(f"{where}.arm", joint, f"actuated joints: {', '.join(joint_names)}")
    if hand.pointing is None:
        return
    valid = "a direction (3,) of finite numbers, not of length 0"
    if not np.linalg.norm(checked_array(f"{where}.pointing", hand.pointing, (3,), valid)) > 0:
        raise InvalidInput(f"{where}.pointing", hand.pointing, valid)
