"""Names in an SRDF that its URDF does not have."""

from __future__ import annotations

import warnings
from xml.etree.ElementTree import Element

from humanoid_rail.errors import did_you_mean
from humanoid_rail.model.urdf import Urdf

MOST_NAMES = 5
"""A warning has no more names than this."""


def warn_of_unknown_names(srdf: Element | None, urdf: Urdf) -> None:
    """Warn of links and joints of an SRDF that the URDF does not have: what it says of them is of no effect."""
    if srdf is None:
        return
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
            warnings.warn(f"{where}: no {kind} of the URDF, so of no effect{said}{more}", stacklevel=3)
