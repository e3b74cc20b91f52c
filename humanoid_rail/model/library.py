"""From xacro to URDF text."""

from __future__ import annotations

from pathlib import Path
from typing import SupportsFloat
from xml.etree import ElementTree

import xacro

from humanoid_rail.errors import InvalidInput, checked_number
from humanoid_rail._resources import resource

_XACRO = "{http://www.ros.org/wiki/xacro}"


def xacro_arguments(path: Path | None = None) -> dict[str, str]:
    """Return the arguments that a xacro file declares, with their defaults as written there.

    Args:
        path: xacro file; `robots/humanoid_rail.urdf.xacro` if not given.
    """
    root = ElementTree.parse(path or resource("robots", "humanoid_rail.urdf.xacro")).getroot()
    return {arg.attrib["name"]: arg.attrib["default"] for arg in root.iter(f"{_XACRO}arg")}


def build_urdf(**xacro_args: SupportsFloat) -> str:
    """Return the URDF of the paper's robot as text.

    Args:
        **xacro_args: Arguments of `robots/humanoid_rail.urdf.xacro`: link lengths (m), `beta` (rad), `link_radius` (m),
            limits (m, rad, s) and `density` (kg/m^3).

    Raises:
        InvalidInput: If an argument is unknown or its value cannot be built.
    """
    path = resource("robots", "humanoid_rail.urdf.xacro")
    known = xacro_arguments(path)
    values = {name: _number(name, value, known) for name, value in xacro_args.items()}
    # Not process_file, which writes the path of this installation into the URDF.
    document = xacro.parse(None, str(path))
    xacro.process_doc(document, mappings={name: repr(value) for name, value in values.items()})
    urdf: str = document.toprettyxml(indent="  ")
    _check_limits(urdf)
    return urdf


def _number(name: str, value: SupportsFloat, known: dict[str, str]) -> float:
    """Return the value of a xacro argument, checked."""
    if name not in known:
        raise InvalidInput(name, value, f"one of the xacro arguments {', '.join(sorted(known))}")
    if name == "link_radius":
        return checked_number(name, value, least=0.0)
    positive = name.startswith("l_") or name.endswith(("_velocity", "_acceleration", "_effort")) or name == "density"
    return checked_number(name, value, above=0.0) if positive else checked_number(name, value)


def _check_limits(urdf: str) -> None:
    for joint in ElementTree.fromstring(urdf).findall("joint"):
        limit = joint.find("limit")
        if limit is None:
            continue
        lower, upper = float(limit.attrib["lower"]), float(limit.attrib["upper"])
        if lower >= upper:
            raise InvalidInput(
                f"limits of joint {joint.attrib['name']}", (lower, upper), "a lower limit below the upper"
            )
