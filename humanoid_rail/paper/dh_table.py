"""Section 2 of the paper by hand: Table 1 and the transforms it defines. NumPy only.

This is the oracle of the tests. It shares nothing with the URDF or with Pinocchio, and the planner never imports it.
Misprints of the paper are corrected here; docs/method.md lists them.

Reference: C. Kacprzak and G. Pajak, "Trajectory planning of the humanoid manipulator", 2019. Modified
Denavit-Hartenberg notation after J. J. Craig, "Introduction to Robotics", 1989.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from math import cos, pi, sin
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Lengths:
    """Link lengths of section 5 in m, and the angle beta of the arm bases in rad.

    The paper does not give beta; pi/3 reproduces its start positions.
    """

    l_t1: float = 2.0
    l_t2: float = 0.5
    l_t3: float = 0.5
    l_l1: float = 1.0
    l_l2: float = 1.0
    l_l3: float = 1.0
    l_r1: float = 1.0
    l_r2: float = 1.0
    l_r3: float = 1.0
    beta: float = pi / 3


class Row(NamedTuple):
    """A row of Table 1: frame, frame before it, alpha_{i-1}, a_{i-1}, d_i, theta_i.

    Lengths and angles are names, with a sign, of a field of :class:`Lengths` or of a joint q1 to q12, q*.
    """

    frame: str
    previous: str
    alpha: float
    a: str
    d: str
    theta: str


TABLE_1 = (
    # torso
    Row("T1", "rs", pi / 2, "0", "l_t1", "q2"),
    Row("T2", "T1", pi / 2, "0", "0", "q3"),
    Row("T3", "T2", 0.0, "l_t2", "0", "q4"),
    Row("T4", "T3", 0.0, "l_t3", "0", "q*"),
    # left arm
    Row("L1", "L0", pi, "0", "-l_l1", "q5"),
    Row("L2", "L1", pi / 2, "0", "0", "q6"),
    Row("L3", "L2", -pi / 2, "0", "-l_l2", "q7"),
    Row("L4", "L3", pi / 2, "0", "0", "q8"),
    # right arm
    Row("R1", "R0", 0.0, "0", "l_r1", "q9"),
    Row("R2", "R1", -pi / 2, "0", "0", "q10"),
    Row("R3", "R2", pi / 2, "0", "l_r2", "q11"),
    Row("R4", "R3", -pi / 2, "0", "0", "q12"),
)
"""Table 1 of the paper."""

BONES = {
    "carriage": ("rs", "T2"),
    "lower_torso": ("T2", "T3"),
    "upper_torso": ("T3", "T4"),
    "left_clavicle": ("T4", "L1"),
    "left_upper_arm": ("L2", "L3"),
    "left_forearm": ("L4", "pL"),
    "right_clavicle": ("T4", "R1"),
    "right_upper_arm": ("R2", "R3"),
    "right_forearm": ("R4", "pR"),
}
"""The bones of the robot, by URDF link: the two frames each one joins."""


def modified_dh(alpha: ArrayLike, a: ArrayLike, d: ArrayLike, theta: ArrayLike) -> Array:
    """Return the transforms (..., 4, 4) Rot_x(alpha) Trans_x(a) Rot_z(theta) Trans_z(d) (Craig, eq. 3.6).

    The arguments are numbers or arrays (...) that broadcast.

    Args:
        alpha: Link twist alpha_{i-1} in rad.
        a: Link length a_{i-1} in m.
        d: Link offset d_i in m.
        theta: Joint angle theta_i in rad.
    """
    ca, sa, ct, st = np.cos(alpha), np.sin(alpha), np.cos(theta), np.sin(theta)
    T = np.zeros((*np.broadcast(alpha, a, d, theta).shape, 4, 4))
    T[..., 0, 0], T[..., 0, 1], T[..., 0, 3] = ct, -st, a
    T[..., 1, 0], T[..., 1, 1], T[..., 1, 2], T[..., 1, 3] = st * ca, ct * ca, -sa, -sa * d
    T[..., 2, 0], T[..., 2, 1], T[..., 2, 2], T[..., 2, 3] = st * sa, ct * sa, ca, ca * d
    T[..., 3, 3] = 1.0
    return T


def rail(q1: ArrayLike) -> Array:
    """Return the transforms (..., 4, 4) from rs, the carriage at q1 (...) along the rail in m, to the base B."""
    T = np.zeros((*np.shape(q1), 4, 4))
    T[..., :, :3] = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [0.0, 0.0, 0.0]]
    T[..., 1, 3], T[..., 3, 3] = q1, 1.0
    return T


def left_arm_base(beta: float) -> Array:
    """Return the transform from L0 to T4, for the angle beta in rad."""
    c, s = cos(beta), sin(beta)
    return np.array([[-s, 0.0, c, 0.0], [0.0, -1.0, 0.0, 0.0], [c, 0.0, s, 0.0], [0.0, 0.0, 0.0, 1.0]])


def right_arm_base(beta: float) -> Array:
    """Return the transform from R0 to T4, for the angle beta in rad."""
    c, s = cos(beta), sin(beta)
    return np.array([[-s, 0.0, c, 0.0], [0.0, 1.0, 0.0, 0.0], [-c, 0.0, -s, 0.0], [0.0, 0.0, 0.0, 1.0]])


def frames(q: ArrayLike, lengths: Lengths | None = None) -> dict[str, Array]:
    """Return the transforms (..., 4, 4) to the base B of every frame of Fig. 1, and of the hand points pL and pR.

    Args:
        q: Configurations (..., 12): q1 in m, q2 to q12 in rad.
        lengths: Link lengths; those of section 5 if not given.

    Returns:
        Transforms by the paper's name: rs, T1 to T4, L0 to L4, R0 to R4; pL and pR have the orientation of L4 and R4.
    """
    lengths = lengths or Lengths()
    values: dict[str, Array] = {name: np.array(value) for name, value in {"0": 0.0, **asdict(lengths)}.items()}
    values |= {f"q{i}": v for i, v in enumerate(np.moveaxis(np.asarray(q, float), -1, 0), start=1)}
    values["q*"] = pi / 2 - values["q3"] - values["q4"]

    def value(name: str) -> Array:
        return -values[name[1:]] if name.startswith("-") else values[name]

    constant = {"L0": left_arm_base(lengths.beta), "R0": right_arm_base(lengths.beta)}
    T = {"rs": rail(values["q1"])}
    for row in TABLE_1:
        if row.previous in constant:
            T[row.previous] = T["T4"] @ constant[row.previous]
        T[row.frame] = T[row.previous] @ modified_dh(row.alpha, value(row.a), value(row.d), value(row.theta))
    T["pL"] = T["L4"] @ modified_dh(0.0, lengths.l_l3, 0.0, 0.0)
    T["pR"] = T["R4"] @ modified_dh(0.0, lengths.l_r3, 0.0, 0.0)
    return T


def hands(q: ArrayLike, lengths: Lengths | None = None) -> Array:
    """Return f(q) of eq. 2.1: the positions (..., 2, 3) of the left and the right hand in the base frame, in m."""
    T = frames(q, lengths)
    return np.stack([T["pL"][..., :3, 3], T["pR"][..., :3, 3]], axis=-2)


def bones(q: ArrayLike, lengths: Lengths | None = None) -> dict[str, Array]:
    """Return the end points (..., 2, 3) of every bone in the base frame, in m, by URDF link."""
    T = frames(q, lengths)
    return {link: np.stack([T[start][..., :3, 3], T[end][..., :3, 3]], axis=-2) for link, (start, end) in BONES.items()}
