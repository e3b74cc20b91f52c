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


def long_arm(*, joints: dict[str, str] | None = None, links: dict[str, str] | None = None, more: str = "") -> str:
    """Return the URDF of an arm of six joints j0 to j5 within +-1.5 rad and links l0 to l5, boxes of 0.2 m, on a base.

    Args:
        joints: Attributes of the `<limit>` of joints instead of these, or what comes after it, such as `<mimic>`.
        links: What is in links by their names, instead of a box.
        more: Further elements of the URDF.
    """
    plain = 'lower="-1.5" upper="1.5" velocity="2"'
    names = ["base", *(f"l{i}" for i in range(6))]
    bodies = {"base": ""} | {name: box(0.2, 0.02) for name in names[1:]} | (links or {})
    text = "".join(f'<link name="{name}">{bodies[name]}</link>' for name in names)
    for i in range(6):
        extra = (joints or {}).get(f"j{i}", "")
        limit, after = (extra, "") if extra and not extra.startswith("<") else (plain, extra)
        axis = "0 0 1" if i % 2 == 0 else "0 1 0"
        text += joint(f"j{i}", names[i], names[i + 1], 0.2 if i else 0.0, limit, axis, after)
    return f'<robot name="long">{text}{more}</robot>'


def fixed(name: str, parent: str, child: str, xyz: str, body: str) -> str:
    """Return a link with a body that is fixed to another at xyz in m."""
    return (
        f'<link name="{child}">{body}</link><joint name="{name}" type="fixed"><parent link="{parent}"/>'
        f'<child link="{child}"/><origin xyz="{xyz}"/></joint>'
    )


def ball(radius: float, xyz: str = "0 0 0") -> str:
    """Return a ball at xyz in a link, m."""
    return f'<collision><origin xyz="{xyz}"/><geometry><sphere radius="{radius}"/></geometry></collision>'
