"""Small arms as URDF text, whose numbers a test chooses."""

from __future__ import annotations

from humanoid_rail import Hand, Robot, robot_from_urdf

HAND = Hand("tool", "tool", ("j0", "j1", "j2"))
"""The hand of the arms here."""


def joint(name: str, parent: str, child: str, x: float, limit: str, axis: str = "0 0 1", more: str = "") -> str:
    """Return a revolute joint at x in m along its parent."""
    return (
        f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="{x} 0 0"/><axis xyz="{axis}"/><limit effort="9" {limit}/>{more}</joint>'
    )


def capsule(length: float, radius: float) -> str:
    """Return a capsule from the origin of a link along x, m."""
    return (
        f'<collision name="body"><origin xyz="{length / 2} 0 0" rpy="0 1.5707963267948966 0"/>'
        f'<geometry><cylinder length="{length}" radius="{radius}"/></geometry></collision>'
        '<collision_checking><capsule name="body"/></collision_checking>'
    )


def box(length: float, radius: float) -> str:
    """Return a box from the origin of a link along x, m."""
    size = f"{length} {2 * radius} {2 * radius}"
    return f'<collision><origin xyz="{length / 2} 0 0"/><geometry><box size="{size}"/></geometry></collision>'


def arm(
    *, limits: dict[str, str] | None = None, more: str = "", body: str | None = None, srdf: str | None = None
) -> Robot:
    """Return a planar arm of three joints j0, j1, j2 and three bones of 0.5 m: b0, b1, b2.

    Args:
        limits: Attributes of `<limit>` by the name of the joint, instead of +-2 rad at 2 rad/s.
        more: Further elements of the URDF.
        body: The collision element of each bone; a thin capsule if not given.
        srdf: SRDF text; the one that leaves out neighbours if not given.
    """
    shape = capsule(0.5, 0.02) if body is None else body
    plain = 'lower="-2" upper="2" velocity="2"'
    chosen = {f"j{i}": plain for i in range(3)} | (limits or {})
    bones = "".join(f'<link name="b{i}">{shape}</link>' for i in range(3))
    joints = joint("j0", "base", "b0", 0.0, chosen["j0"]) + "".join(
        joint(f"j{i}", f"b{i - 1}", f"b{i}", 0.5, chosen[f"j{i}"]) for i in (1, 2)
    )
    tool = '<link name="tool"/><joint name="fix" type="fixed"><parent link="b2"/><child link="tool"/>'
    links = f'<link name="base"/>{bones}{tool}<origin xyz="0.5 0 0"/></joint>'
    urdf = f'<robot name="arm" xmlns:drake="http://drake.mit.edu">{links}{joints}{more}</robot>'
    pairs = "".join(f'<disable_collisions link1="b{i}" link2="b{i + 1}"/>' for i in range(2))
    return robot_from_urdf(urdf, f"<robot>{pairs}</robot>" if srdf is None else srdf, [HAND])
