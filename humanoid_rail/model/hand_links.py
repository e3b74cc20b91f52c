"""Which links, and which collision bodies, a hand is made of."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from weakref import WeakKeyDictionary

from humanoid_rail.model.robot import Hand, Robot
from humanoid_rail.model.urdf import Urdf, read_urdf
from humanoid_rail.model.urdf_joint import Joint

_found: WeakKeyDictionary[Robot, dict[str, tuple[int, ...]]] = WeakKeyDictionary()
"""What hands are made of, by robots: it takes reading the URDF."""


def hand_bodies(robot: Robot, name: str) -> tuple[int, ...]:
    """Return the collision bodies of a hand: those that may touch what it grasps.

    They are the bodies of `hand.links` where these are given. Else they are found: the last joint that moves the hand's
    frame moves a link, such as a forearm or a flange. What is mounted on that link is the hand: the links behind it,
    over fixed joints or those of fingers, but not the link itself. Where the frame is on that link itself, or nothing
    that is mounted on it has a body, the link counts too, as nothing tells it from the hand.

    Args:
        robot: The robot.
        name: The name of one of its hands.

    Returns:
        Indices in `robot.collision_model`; none if neither has a body.

    Raises:
        InvalidInput: If the robot has no such hand.
    """
    found = _found.setdefault(robot, {})
    if name not in found:
        found[name] = _hand_bodies(robot, robot.hands[robot.hand(name)])
    return found[name]


def _hand_bodies(robot: Robot, hand: Hand) -> tuple[int, ...]:
    wanted = hand.links
    if wanted is None:
        urdf = read_urdf(robot.urdf)
        mount, mounted = mounted_links(urdf, hand.frame, [other.frame for other in robot.hands])
        has_body = any(link in robot.link_names for link in mounted)
        wanted = mounted if has_body and mount != link_of(urdf, hand.frame) else (mount, *mounted)
    return tuple(i for i, link in enumerate(robot.link_names) if link in wanted)


def link_of(urdf: Urdf, frame: str) -> str:
    """Return the link that a frame belongs to: itself, or the one behind a joint."""
    return frame if frame in urdf.links else urdf.joints[frame].child


def mounted_links(urdf: Urdf, frame: str, hands: Sequence[str] = ()) -> tuple[str, tuple[str, ...]]:
    """Return the link that the last joint before a frame moves, and the links that are mounted on it.

    Args:
        urdf: The robot, with joints that are locked as fixed ones.
        frame: A link, or a joint: where a hand is.
        hands: The frames of all hands. Links behind joints that another hand needs are parts of its arm.
    """
    above = {joint.child: joint for joint in urdf.joints.values()}
    mount = next(link for link, joint in _upwards(above, link_of(urdf, frame)) if joint is None or _moves(joint))
    arms = {joint.name for other in hands for _, joint in _upwards(above, link_of(urdf, other)) if joint is not None}
    return mount, tuple(_below(urdf, mount, arms))


def _moves(joint: Joint) -> bool:
    return joint.kind != "fixed"


def _upwards(above: dict[str, Joint], link: str) -> Iterator[tuple[str, Joint | None]]:
    """Yield a link and the joint before it, the link before that, and so on up to the root, which has no joint."""
    while link in above:
        yield link, above[link]
        link = above[link].parent
    yield link, None


def _below(urdf: Urdf, link: str, arms: Collection[str]) -> Iterator[str]:
    """Yield the links behind a link, but not over joints that move and are of the arms of hands."""
    for joint in urdf.joints.values():
        if joint.parent == link and not (_moves(joint) and joint.name in arms):
            yield joint.child
            yield from _below(urdf, joint.child, arms)
