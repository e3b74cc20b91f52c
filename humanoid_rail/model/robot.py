"""A robot as frozen data: Pinocchio model, linear coupling, collision bodies, limits and hands."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from humanoid_rail._arrays import Array, FrozenArrays, frozen
from humanoid_rail.errors import InvalidInput
from humanoid_rail.model.arm_reach import arm_reach, farthest_from_base
from humanoid_rail.model.pairs import UncheckedPair, links_without_body, unchecked_pairs
from humanoid_rail.model.urdf import read_urdf


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
    links: tuple[str, ...] | None = None
    """The links that make up the hand; None for those that :func:`humanoid_rail.hand_bodies` finds."""


def called(hand: str) -> str:
    """Return what sentences call a hand by its name: the left hand, or the left_hand."""
    return f"the {hand}" if "hand" in hand.lower() else f"the {hand} hand"


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
    objects: tuple[str, ...] = ()
    """Links that are no part of the robot: objects, and obstacles that one may touch
    (:mod:`humanoid_rail.model.attached`)."""
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
        return tuple(unchecked_pairs(self.link_names, self.self_collision_pairs, self.left_out, self.objects))

    @cached_property
    def moving_bodies(self) -> tuple[bool, ...]:
        """Whether any actuated joint moves each of the collision bodies."""
        moved = {0: False}
        for joint, parent in enumerate(list(self.model.parents)[1:], start=1):
            moved[joint] = moved[parent] or bool(self.coupling[self.model.joints[joint].idx_v].any())
        return tuple(moved[body.parentJoint] for body in self.collision_model.geometryObjects)

    @cached_property
    def links_without_body(self) -> tuple[str, ...]:
        """Links that are visible or have a mass, and no collision body: nothing is known of what they touch.

        Hands come first, then what is seen reaching farthest, last what no joint moves.
        """
        fixed = {frame.name for frame in self.model.frames if frame.parentJoint == 0}
        return links_without_body(read_urdf(self.urdf), self.link_names, {hand.frame for hand in self.hands}, fixed)

    @cached_property
    def arm_reaches(self) -> tuple[float, ...]:
        """How far each hand's arm reaches from its first joint, m."""
        return tuple(arm_reach(self.model, hand.frame, hand.arm) for hand in self.hands)

    @cached_property
    def farthest_hand(self) -> float:
        """A distance from the base that no hand exceeds, m."""
        return farthest_from_base(self.model, [hand.frame for hand in self.hands])

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

    def save(self, folder: str | Path) -> tuple[Path, ...]:
        """Write the robot to a folder that `load_robot(folder)` loads anywhere, as the same robot, without a search.

        The folder has `robot.yaml`, the URDF, an SRDF with the pairs that are left out, which is for other tools, and
        `meshes/` with a file for each convex body and copies of the meshes that are seen.

        Args:
            folder: Where to; made if need be.

        Returns:
            The files written.

        Raises:
            InvalidInput: If the folder cannot be written to, a mesh file is gone, or bodies or pairs were replaced
                by others than the URDF and `unchecked_pairs` say.
        """
        from humanoid_rail.model.saving import save_robot

        return save_robot(self, folder)

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

    def report(self) -> str:
        """Return a text about the robot: hands, joints and limits, bodies, pairs, and what was found or assumed."""
        # Imported here: it is about robots.
        from humanoid_rail.model.report import report_of

        return report_of(self)

    def unit_of(self, joint: str) -> str:
        """Return the unit of a joint's position: m or rad."""
        kind = self.model.joints[self.model.getJointId(joint)].shortname()
        return "m" if kind.startswith("JointModelP") else "rad"

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
