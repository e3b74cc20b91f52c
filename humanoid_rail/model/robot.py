"""A robot as frozen data: Pinocchio model, linear coupling, collision bodies, limits and hands."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from humanoid_rail._arrays import Array, FrozenArrays, checked_array, frozen
from humanoid_rail.errors import MISSING, InvalidInput
from humanoid_rail.model.arm_reach import arm_reach
from humanoid_rail.model.collision_bodies import collision_bodies
from humanoid_rail.model.followers import folded_limits
from humanoid_rail.model.pairs import UncheckedPair, choose_pairs, links_without_body, unchecked_pairs
from humanoid_rail.model.urdf import Urdf, read_urdf
from humanoid_rail.model.urdf_elements import read_text
from humanoid_rail.model.urdf_joint import Mimic


@dataclass(frozen=True)
class Hand:
    """A point of the robot that is given targets."""

    name: str
    """Name in scenes, for example `left`."""
    frame: str
    """Frame of the model whose origin is the point."""
    arm: tuple[str, ...]
    """Actuated joints of its arm: the columns of its block in J_arms of eq. 3.4."""
    pointing: tuple[float, float, float] | None = (1.0, 0.0, 0.0)
    """The direction in the frame in which the hand points, of any length; what `approach` of a pose is about. None if
    it points nowhere: then no target can ask for a direction."""


@dataclass(frozen=True, eq=False, repr=False)
class Robot(FrozenArrays):
    """A robot whose joints follow its actuated ones linearly: q_full = S q + s0.

    The limits are those of `<limit>` in the URDF. A passive joint has limits of its own: where they are narrower than
    what its leader makes of them, the leader's limits are narrower here than in the URDF, so that both are kept.

    The passive joints are ordinary joints of the Pinocchio model, moved by the coupling, because Pinocchio's own mimic
    joints support neither kinematic Hessians nor pickling. n is the number of actuated joints.
    """

    name: str
    urdf: str
    """URDF text the robot was built from."""
    model: pin.Model
    """All joints, passive ones free."""
    collision_model: pin.GeometryModel
    """The collision bodies ("links"), in the parents' order, and after them far parts of neighbours that
    can meet away from their joint (:mod:`humanoid_rail.model.pairs`)."""
    coupling: Array
    """S (model.nv, n)."""
    offset: Array
    """s0 (model.nq,)."""
    joint_names: tuple[str, ...]
    """Actuated joints in Pinocchio's order."""
    lower: Array
    """Lower position limits (n,), m or rad, within which passive joints keep theirs."""
    upper: Array
    """Upper position limits (n,), m or rad, within which passive joints keep theirs."""
    velocity_limit: Array
    """(n,), m/s or rad/s."""
    acceleration_limit: Array
    """(n,), m/s^2 or rad/s^2; infinite where the URDF has none."""
    jerk_limit: Array
    """(n,), m/s^3 or rad/s^3; infinite where the URDF has none."""
    hands: tuple[Hand, ...]
    initial: Array
    """Configuration (n,) where motions start unless a scene says otherwise."""
    self_collision_pairs: tuple[tuple[int, int], ...]
    """Pairs of collision bodies that may collide, by index in collision_model."""
    left_out: tuple[UncheckedPair, ...] = ()
    """Pairs that were left out of these when the robot was loaded, each with the reason."""
    pair_distances: Mapping[tuple[int, int], float] = field(default_factory=dict)
    """Pairs that are always near each other: how far apart they are kept, m, where that is less than the safety
    distance."""
    meshes: Mapping[str, Path] = field(default_factory=dict)
    """The files of the meshes that the URDF names, by the names that it has for them."""
    postures: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    """Configurations with a name, which scenes can start at: (n,), m and rad."""
    locked: Mapping[str, float] = field(default_factory=dict)
    """Joints of the original URDF that do not move here, and where they stand, m or rad."""
    assumed: tuple[str, ...] = ()
    """What was not given and was found or assumed when the robot was loaded, in sentences."""

    def __repr__(self) -> str:
        return f"Robot({self.name!r}, {self.n} actuated joints, {self.collision_model.ngeoms} collision bodies)"

    @property
    def n(self) -> int:
        """Number of actuated joints."""
        return len(self.joint_names)

    @property
    def link_names(self) -> tuple[str, ...]:
        """Names of the URDF links that have a collision body."""
        return tuple(self.model.frames[body.parentFrame].name for body in self.collision_model.geometryObjects)

    @cached_property
    def unchecked_pairs(self) -> tuple[UncheckedPair, ...]:
        """Pairs of links whose bodies are not checked against each other, or only in part, each with the reason."""
        return tuple(unchecked_pairs(self.link_names, self.self_collision_pairs, self.left_out))

    @cached_property
    def links_without_body(self) -> tuple[str, ...]:
        """Links that are visible or have a mass, and no collision body: nothing is known of what they touch."""
        return links_without_body(read_urdf(self.urdf), self.link_names)

    @cached_property
    def arm_reaches(self) -> tuple[float, ...]:
        """How far each hand's arm reaches from its first joint, m."""
        return tuple(arm_reach(self.model, hand.frame, hand.arm) for hand in self.hands)

    @cached_property
    def speed_units(self) -> Array:
        """The unit of each joint coordinate in lengths of paths (n,): its speed limit, or 1 where it has none."""
        limit = self.velocity_limit
        return frozen(np.where(np.isfinite(limit) & (limit > 0), limit, 1.0))

    @property
    def hand_names(self) -> tuple[str, ...]:
        """Names of the hands, in the order of their rows in the Jacobian."""
        return tuple(hand.name for hand in self.hands)

    def full_configuration(self, q: ArrayLike) -> Array:
        """Return the configuration q_full = S q + s0 (model.nq,) of all joints, passive ones included."""
        full: Array = self.coupling @ np.asarray(q, float) + self.offset
        return full

    def with_hands(self, names: Sequence[str]) -> Robot:
        """Return the same robot with these of its hands alone, in its own order."""
        hands = tuple(hand for hand in self.hands if hand.name in names)
        return self if hands == self.hands else replace(self, hands=hands)

    def hand(self, name: str) -> int:
        """Return the index of a hand by its name.

        Raises:
            InvalidInput: If the robot has no such hand.
        """
        if name not in self.hand_names:
            raise InvalidInput("hand", name, f"one of {', '.join(self.hand_names)}")
        return self.hand_names.index(name)

    def arm_columns(self, hand: Hand) -> list[int]:
        """Return the indices in q of the joints of a hand's arm."""
        return [self.joint_names.index(name) for name in hand.arm]


def check_joint_names(robot: Robot, names: Sequence[str]) -> None:
    """Check that a trajectory with these joints is one of a robot.

    Raises:
        InvalidInput: If it is not.
    """
    if tuple(names) != robot.joint_names:
        raise InvalidInput("trajectory.joint_names", names, f"those of the robot: {', '.join(robot.joint_names)}")


def robot_from_urdf(
    urdf: str | Path, srdf: str | Path | None, hands: Sequence[Hand], initial: ArrayLike | None = None
) -> Robot:
    """Return a robot from a URDF of version 1.0 to 1.2.

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
    text = read_text("urdf", urdf)
    described = read_urdf(text)
    model, joints = _model(described), described.joints
    mimics = {name: mimic for name in list(model.names)[1:] if (mimic := joints[name].mimic) is not None}
    joint_names = tuple(name for name in list(model.names)[1:] if name not in mimics)
    coupling, offset = _linear_coupling(model, joint_names, mimics)
    collision_model = collision_bodies(model, described)
    _check_hands(model, joint_names, hands)

    limits = folded_limits(model, described, joint_names, coupling, offset)
    middle, n = (limits.lower + limits.upper) / 2, len(joint_names)
    valid = f"a finite number for each of the {n} actuated joints"
    start = checked_array("initial", middle if initial is None else initial, (n,), valid)
    pairs = choose_pairs(model, collision_model, read_text("srdf", srdf) if srdf else None, coupling @ start + offset)
    _warn_of_degrees(described, joint_names)
    return Robot(
        name=model.name,
        urdf=text,
        model=model,
        collision_model=collision_model,
        coupling=frozen(coupling),
        offset=frozen(offset),
        joint_names=joint_names,
        lower=frozen(limits.lower),
        upper=frozen(limits.upper),
        velocity_limit=frozen(limits.velocity),
        acceleration_limit=frozen(limits.acceleration),
        jerk_limit=frozen(limits.jerk),
        hands=tuple(hands),
        initial=frozen(start),
        self_collision_pairs=pairs.checked,
        left_out=pairs.left_out,
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


def _check_hands(model: pin.Model, joint_names: Sequence[str], hands: Sequence[Hand]) -> None:
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
    if not isinstance(hand.frame, str) or sum(frame.name == hand.frame for frame in model.frames) != 1:
        raise InvalidInput(f"{where}.frame", hand.frame, "a frame of the URDF, with a name of its own")
    if not isinstance(hand.arm, tuple | list) or len(hand.arm) < 3:
        raise InvalidInput(f"{where}.arm", hand.arm, "three joints or more: with fewer, eq. 3.4 is 0")
    for joint in hand.arm:
        if joint not in joint_names:
            raise InvalidInput(f"{where}.arm", joint, f"actuated joints: {', '.join(joint_names)}")
    if hand.pointing is None:
        return
    valid = "a direction (3,) of finite numbers, not of length 0"
    if not np.linalg.norm(checked_array(f"{where}.pointing", hand.pointing, (3,), valid)) > 0:
        raise InvalidInput(f"{where}.pointing", hand.pointing, valid)
