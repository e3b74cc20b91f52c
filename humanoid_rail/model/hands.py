"""Finds the hands of a robot: the ends of its arms."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Element

from humanoid_rail.errors import MISSING, InvalidInput
from humanoid_rail.model.urdf import Urdf

LEAST_JOINTS = 5
"""An arm has at least this many joints in a row without a branch."""
LEG = re.compile(r"leg|hip|knee|ankle|foot|toe|thigh|calf|shank", re.IGNORECASE)
"""Joints or links called so belong to legs."""
TOOL = re.compile(r"tcp|tool|grasp|ee_link|end_effector|palm|flange|gripper$", re.IGNORECASE)
"""A frame called so at the end of an arm is where its hand holds things."""
FINGER = re.compile(r"finger|gripper|jaw|thumb", re.IGNORECASE)
"""Joints called so move fingers."""
SIDES = ("left", "right")


@dataclass(frozen=True)
class FoundHand:
    """A hand that was found, or what is given of one."""

    name: str
    frame: str
    arm: tuple[str, ...]
    """Joints of its arm; of one that was found, some may not move by themselves."""
    pointing: tuple[float, float, float] | None
    why: str
    """How it was found, for a report."""
    is_arm_given: bool = False
    links: tuple[str, ...] | None = None
    """Its links, if they are given."""


@dataclass(frozen=True)
class _Run:
    """Joints in a row without a branch, from the base outwards."""

    joints: tuple[str, ...]
    end: str
    """The link after the last of them."""


def find_hands(urdf: Urdf, srdf: Element | None) -> tuple[FoundHand, ...]:
    """Return the hands of a robot: the end effectors of its SRDF that arms carry, else the ends of all its arms.

    An arm is a row of five joints or more without a branch. Fingers are branches.

    Raises:
        InvalidInput: If there are none, or legs among them, of which nobody can tell whether they are meant.
    """
    runs = list(_runs(urdf))
    if not runs:
        valid = f"hands={{name: frame}}: no row of {LEAST_JOINTS} joints or more without a branch was found"
        raise InvalidInput("hands", MISSING, valid)
    arms = [run for run in runs if not _is_leg(run)]
    named = list(_of_srdf(urdf, srdf, arms)) if srdf is not None else []
    if named:
        return _with_names(named)
    if len(arms) < len(runs):
        arm_frames = ", ".join(_tool(urdf, run.end) for run in arms) or "none"
        legs = ", ".join(run.end for run in runs if _is_leg(run))
        valid = f"hands={{name: frame}}: arms end at {arm_frames}; are the limbs that end at {legs} legs?"
        raise InvalidInput("hands", MISSING, valid)
    found = [(run, _tool(urdf, run.end), f"the end of {len(run.joints)} joints in a row") for run in arms]
    return _with_names(found)


def arm_of(urdf: Urdf, frame: str, others: Sequence[str]) -> tuple[str, ...]:
    """Return the moving joints before a frame that no other hand needs, from the base outwards.

    Args:
        urdf: The robot.
        frame: A link, or a joint.
        others: The frames of the other hands.
    """
    shared = {joint for other in others for joint in moving_before(urdf, other)}
    return tuple(joint for joint in moving_before(urdf, frame) if joint not in shared)


def moving_before(urdf: Urdf, frame: str) -> tuple[str, ...]:
    """Return the joints that move a frame, from the base outwards: followers too, and the joints that these follow.

    Args:
        urdf: The robot.
        frame: A link, or a joint.
    """
    by_child = {joint.child: joint for joint in urdf.joints.values()}
    link = frame if frame in urdf.links else urdf.joints[frame].child
    chain = []
    while link in by_child:
        joint = by_child[link]
        if joint.kind != "fixed":
            chain += with_leaders(urdf, joint.name)
        link = joint.parent
    return tuple(dict.fromkeys(reversed(chain)))


def with_leaders(urdf: Urdf, name: str) -> list[str]:
    """Return a joint, the one that it follows, if any, the one that this follows, and so on."""
    found, mimic = [name], urdf.joints[name].mimic
    while mimic is not None:
        found.append(mimic.joint)
        mimic = urdf.joints[mimic.joint].mimic
    return found


def _runs(urdf: Urdf) -> Iterator[_Run]:
    """Yield the longest rows of joints without a branch that have enough joints and a body at the end."""
    after: dict[str, list[str]] = {name: [] for name in urdf.links}
    for joint in urdf.joints.values():
        after[joint.parent].append(joint.name)

    def moving_children(link: str) -> list[str]:
        """Return the next joints that move, over those that are fixed."""
        found = []
        for name in after[link]:
            joint = urdf.joints[name]
            found += moving_children(joint.child) if joint.kind == "fixed" else [name]
        return found

    def follow(first: str) -> Iterator[_Run]:
        row, children = [first], moving_children(urdf.joints[first].child)
        while len(children) == 1:
            row.append(children[0])
            children = moving_children(urdf.joints[children[0]].child)
        # A last joint that follows another is a finger, and so is one that is called so.
        own = [name for name in row if urdf.joints[name].mimic is None]
        while own and FINGER.search(own[-1]):
            own.pop()
        if len(own) >= LEAST_JOINTS:  # what branches off behind an arm are the fingers of its hand
            yield _Run(tuple(own), urdf.joints[own[-1]].child)
        else:
            for child in children:
                yield from follow(child)

    moved = {joint.child for joint in urdf.joints.values()}
    root = next(name for name in urdf.links if name not in moved)
    for first in moving_children(root):
        yield from follow(first)


def _is_leg(run: _Run) -> bool:
    return any(LEG.search(name) for name in (*run.joints, run.end))


def _of_srdf(urdf: Urdf, srdf: Element, arms: Sequence[_Run]) -> Iterator[tuple[_Run, str, str]]:
    """Yield the arms that an end effector of the SRDF is at the end of, with its frame."""
    for effector in srdf.findall("end_effector"):
        link = effector.get("parent_link", "")
        if link not in urdf.links:
            continue
        chain = moving_before(urdf, link)
        for run in arms:
            if run.joints[-1] in chain:
                last = urdf.joints[run.joints[-1]].child
                frame = link if TOOL.search(link) else _tool(urdf, last, link)
                yield run, frame, f"the end effector {effector.get('name')} of the SRDF"


def _tool(urdf: Urdf, end: str, otherwise: str | None = None) -> str:
    """Return the link that is fixed to the end of an arm and is called as a tool is; the end itself if none is."""
    fixed, found = [end], []
    while fixed:
        link = fixed.pop(0)
        found.append(link)
        fixed += [j.child for j in urdf.joints.values() if j.parent == link and j.kind == "fixed"]
    tools = [link for link in found if TOOL.search(link)]
    tcp = [link for link in tools if "tcp" in link.lower()]
    return (tcp or tools or [otherwise or end])[-1]


def _with_names(found: Sequence[tuple[_Run, str, str]]) -> tuple[FoundHand, ...]:
    """Name hands left and right where their frames or joints say so, else hand, or hand_1 and so on."""
    names = []
    for run, frame, _ in found:
        text = "/".join((frame, *run.joints)).lower()
        sides = [side for side in SIDES if re.search(rf"(^|[_/]){side}|{side}([_/]|$)|(^|[_/]){side[0]}_", text)]
        names.append(sides[0] if len(sides) == 1 else "hand")
    if len(set(names)) < len(names):
        names = [f"hand_{i}" for i in range(1, len(names) + 1)]
    return tuple(
        FoundHand(name, frame, run.joints, None, why) for name, (run, frame, why) in zip(names, found, strict=True)
    )
