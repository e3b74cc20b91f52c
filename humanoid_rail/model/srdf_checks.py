"""What an SRDF says in vain: names that its URDF does not have, and elements that nothing here follows."""

from __future__ import annotations

import warnings
from xml.etree.ElementTree import Element

from humanoid_rail.errors import InvalidInput, did_you_mean
from humanoid_rail.model.urdf import Urdf
from humanoid_rail.model.urdf_elements import parse_xml

MOST_NAMES = 5
"""A warning has no more names than this."""


KNOWN = ("disable_collisions", "enable_collisions", "end_effector", "group", "group_state", "virtual_joint")
"""These elements are read, or say nothing that matters here."""
UNFOLLOWED = ("disable_default_collisions",)
"""What these say is not followed."""


def read_srdf(text: str, urdf: Urdf, all_pairs_given: bool) -> Element:
    """Return an SRDF, checked.

    Args:
        text: The SRDF.
        urdf: Its robot.
        all_pairs_given: Whether a robot file says all of the pairs that are left out: then the SRDF's do not count.

    Raises:
        InvalidInput: If it is none, or names what the robot does not have.
    """
    srdf = parse_xml("srdf", text)
    check_srdf(srdf, urdf)
    if all_pairs_given and srdf.find("disable_collisions") is not None:
        warnings.warn("pairs.complete is true, so the pairs that the SRDF disables are not left out", stacklevel=4)
    return srdf


def check_srdf(srdf: Element, urdf: Urdf) -> None:
    """Check that a document is an SRDF, and warn of what is of no effect in it.

    Raises:
        InvalidInput: If it is none.
    """
    if srdf.tag != "robot":
        raise InvalidInput("srdf", f"<{srdf.tag}>", "an SRDF: its root is <robot>")
    if srdf.find("link") is not None:
        raise InvalidInput("srdf", f"<robot name={srdf.get('name')!r}>", "an SRDF; this one has links, as a URDF has")
    _warn_of_elements(srdf)
    _warn_of_names(srdf, urdf)


def _warn_of_elements(srdf: Element) -> None:
    for tag in dict.fromkeys(child.tag for child in srdf):
        near = did_you_mean(tag, KNOWN)
        if tag in UNFOLLOWED:
            warnings.warn(f"srdf.{tag} is not followed: the pairs of these links are checked like others", stacklevel=4)
        elif tag not in KNOWN and near:
            warnings.warn(f"srdf.{tag}: no element of an SRDF, so of no effect{near}", stacklevel=4)
    nested = len(srdf.findall(".//disable_collisions")) - len(srdf.findall("disable_collisions"))
    if nested:
        warnings.warn(f"srdf: {nested} disable_collisions inside of other elements are of no effect", stacklevel=4)


def _warn_of_names(srdf: Element, urdf: Urdf) -> None:
    """Warn of links and joints that the URDF does not have: what is said of them is of no effect."""
    joints = [*urdf.joints, *(joint.get("name", "") for joint in srdf.findall("virtual_joint"))]
    for path, attribute, kind, known in (
        ("disable_collisions", "link1", "link", urdf.links),
        ("disable_collisions", "link2", "link", urdf.links),
        ("end_effector", "parent_link", "link", urdf.links),
        ("group_state/joint", "name", "joint", joints),
    ):
        names = {element.get(attribute, "") for element in srdf.findall(path)}
        if unknown := sorted(name for name in names if name not in known):
            said = "".join(f"; {name}{did_you_mean(name, known)}" for name in unknown[:MOST_NAMES])
            more = f"; and {len(unknown) - MOST_NAMES} more" if len(unknown) > MOST_NAMES else ""
            where = f"srdf.{path.replace('/', '.')}.{attribute}"
            warnings.warn(f"{where}: no {kind} of the URDF, so of no effect{said}{more}", stacklevel=4)
