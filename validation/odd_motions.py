"""Random motions of odd robots: tiny and huge links, long strokes, thin bodies, short and long spans.

The seed determines the motion.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from humanoid_rail import Box, Capsule, HalfSpace, Robot, Sphere
from humanoid_rail._arrays import Array, triple
from humanoid_rail.model.building import robot_from_urdf
from humanoid_rail.model.robot import Hand
from humanoid_rail.scene.obstacles import Obstacle

BODIES = ("capsule", "capsule", "box", "sphere", "cylinder")
"""The bodies of links are one of these."""
NEIGHBOURS = 2
"""Links that are so many joints apart are not checked against each other."""


@dataclass(frozen=True, eq=False)
class OddMotion:
    """A motion of a robot among obstacles."""

    robot: Robot
    obstacles: tuple[Obstacle, ...]
    t: Array
    """(N,), s."""
    q: Array
    """(N, n), m and rad."""
    velocity: Array | None
    """Velocities (N, n) if the motion is a cubic spline, m/s and rad/s."""


def odd_motion(seed: int, *, spline: bool) -> OddMotion:
    """Return the motion of a seed: a spline, or linear between its samples."""
    rng = np.random.default_rng(seed)
    scale = float(np.exp(rng.uniform(np.log(1e-2), np.log(10.0))))
    robot = odd_robot(rng, scale)
    slides = np.array(["PrismaticUnaligned" in name or name[:-1].endswith("P") for name in _kinds(robot)])
    units = np.where(slides, scale, 1.0)
    size, span = np.exp(rng.uniform(np.log([0.03, 0.01]), np.log([1.5, 200.0])))
    samples = int(rng.integers(2, 8))
    q = np.cumsum(rng.normal(0.0, size, (samples, robot.n)), axis=0) * units
    t = span * np.cumsum(rng.uniform(0.2, 1.0, samples))
    obstacles = tuple(odd_obstacle(rng, scale) for _ in range(rng.integers(1, 6)))
    velocity = rng.normal(0.0, 2.0 * size / span, q.shape) * units if spline else None
    return OddMotion(robot, obstacles, t - t[0], q, velocity)


def _kinds(robot: Robot) -> list[str]:
    return [joint.shortname().removeprefix("JointModel") for joint in list(robot.model.joints)[1:]]


def odd_robot(rng: np.random.Generator, scale: float) -> Robot:
    """Return a chain of links whose lengths are about a scale, m, on revolute and prismatic joints."""
    count = int(rng.integers(3, 7))
    parts, parent, offset = ['<link name="base"/>'], "base", 0.0
    for i in range(count):
        length = scale * float(np.exp(rng.uniform(-3.0, 1.0)))
        radius = length * float(np.exp(rng.uniform(-3.0, -1.0)))
        kind = "prismatic" if rng.random() < 0.3 else "revolute"
        axis = np.eye(3)[rng.integers(3)] if rng.random() < 0.7 else rng.normal(size=3)
        parts += [
            _link(i, str(rng.choice(BODIES)), length, radius),
            f'<joint name="joint_{i}" type="{kind}"><parent link="{parent}"/><child link="link_{i}"/>'
            f'<origin xyz="0 0 {offset}"/><axis xyz="{" ".join(map(str, axis))}"/>'
            '<limit lower="-100" upper="100" effort="1" velocity="1"/></joint>',
        ]
        parent, offset = f"link_{i}", length
    near = [(i, j) for i in range(count) for j in range(i + 1, min(count, i + 1 + NEIGHBOURS))]
    pairs = [f'<disable_collisions link1="link_{i}" link2="link_{j}"/>' for i, j in near]
    hand = Hand("hand", f"link_{count - 1}", ("joint_0", "joint_1", "joint_2"))
    urdf = f'<robot name="odd" version="1.0">{"".join(parts)}</robot>'
    return robot_from_urdf(urdf, f'<robot name="odd">{"".join(pairs)}</robot>', [hand])


def _link(i: int, kind: str, length: float, radius: float) -> str:
    """Return a link with a body along its z axis, m. URDF has no capsule, so it is a cylinder that Pinocchio closes."""
    shape = {
        "box": f'<box size="{2.0 * radius} {radius} {length}"/>',
        "sphere": f'<sphere radius="{radius}"/>',
    }.get(kind, f'<cylinder radius="{radius}" length="{length}"/>')
    closed = f'<collision_checking><capsule name="body_{i}"/></collision_checking>' if kind == "capsule" else ""
    return (
        f'<link name="link_{i}"><collision name="body_{i}"><origin xyz="0 0 {length / 2.0}"/>'
        f"<geometry>{shape}</geometry></collision>{closed}</link>"
    )


def odd_obstacle(rng: np.random.Generator, scale: float) -> Obstacle:
    """Return an obstacle of about a scale, m; boxes may be very thin. One in five moves."""
    center, rpy = triple(rng.normal(0.0, 3.0 * scale, 3)), triple(rng.uniform(-3.0, 3.0, 3))
    velocity = triple(rng.normal(0.0, 0.3 * scale, 3) * (rng.random() < 0.2))
    sizes = scale * np.exp(rng.uniform([-4.0, -4.0, -8.0], [0.5, 0.5, 0.0]))
    match rng.integers(4):
        case 0:
            return Sphere(center=center, radius=sizes[0], velocity=velocity)
        case 1:
            return Box(center=center, size=triple(sizes * [3.0, 3.0, 1.0]), rpy=rpy, velocity=velocity)
        case 2:
            return Capsule(center=center, radius=sizes[0], length=2.0 * sizes[1], rpy=rpy, velocity=velocity)
        case _:
            normal = rng.normal(size=3)
            offset = -scale * float(rng.uniform(1.0, 6.0) * np.linalg.norm(normal))
            return HalfSpace(normal=triple(normal), offset=offset, velocity=velocity)
