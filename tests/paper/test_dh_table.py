"""The oracle itself: Table 1 against the matrices and the numbers that the paper prints."""

from __future__ import annotations

from math import cos, pi, sin

import numpy as np
import pytest

from humanoid_rail.model.humanoid import INITIAL
from humanoid_rail.paper import dh_table as dh


def printed_matrices(q: np.ndarray, lengths: dh.Lengths) -> dict[tuple[str, str], np.ndarray]:
    """Return the matrices of section 2 as printed, but for the misprints that are marked."""
    c, s = np.cos([0.0, *q]), np.sin([0.0, *q])
    star = pi / 2 - q[2] - q[3]
    cs, ss, link = cos(star), sin(star), lengths
    rows = {
        ("rs", "T1"): [[c[2], -s[2], 0, 0], [0, 0, -1, -link.l_t1], [s[2], c[2], 0, 0]],
        ("T1", "T2"): [[c[3], -s[3], 0, 0], [0, 0, -1, 0], [s[3], c[3], 0, 0]],
        ("T2", "T3"): [[c[4], -s[4], 0, link.l_t2], [s[4], c[4], 0, 0], [0, 0, 1, 0]],
        ("T3", "T4"): [[cs, -ss, 0, link.l_t3], [ss, cs, 0, 0], [0, 0, 1, 0]],
        # Misprint: the paper has 0 for l_L1.
        ("L0", "L1"): [[c[5], -s[5], 0, 0], [-s[5], -c[5], 0, 0], [0, 0, -1, link.l_l1]],
        ("L1", "L2"): [[c[6], -s[6], 0, 0], [0, 0, -1, 0], [s[6], c[6], 0, 0]],
        ("L2", "L3"): [[c[7], -s[7], 0, 0], [0, 0, 1, -link.l_l2], [-s[7], -c[7], 0, 0]],
        ("L3", "L4"): [[c[8], -s[8], 0, 0], [0, 0, -1, 0], [s[8], c[8], 0, 0]],
        # Misprint: the paper has l_L1 for l_R1.
        ("R0", "R1"): [[c[9], -s[9], 0, 0], [s[9], c[9], 0, 0], [0, 0, 1, link.l_r1]],
        ("R1", "R2"): [[c[10], -s[10], 0, 0], [0, 0, 1, 0], [-s[10], -c[10], 0, 0]],
        ("R2", "R3"): [[c[11], -s[11], 0, 0], [0, 0, -1, -link.l_r2], [s[11], c[11], 0, 0]],
        # Misprint: labelled as the transform from R3 to R4.
        ("R3", "R4"): [[c[12], -s[12], 0, 0], [0, 0, 1, 0], [-s[12], -c[12], 0, 0]],
    }
    return {pair: np.array([*matrix, [0, 0, 0, 1]], float) for pair, matrix in rows.items()}


def test_table_1_makes_the_printed_matrices(rng: np.random.Generator) -> None:
    lengths = dh.Lengths(*rng.uniform(0.3, 2.0, 10))
    for _ in range(20):
        q = rng.uniform(-pi, pi, 12)
        T = dh.frames(q, lengths)
        T["L0"], T["R0"] = T["T4"] @ dh.left_arm_base(lengths.beta), T["T4"] @ dh.right_arm_base(lengths.beta)
        for (previous, frame), matrix in printed_matrices(q, lengths).items():
            np.testing.assert_allclose(np.linalg.solve(T[previous], T[frame]), matrix, atol=1e-13)


def test_start_positions_are_the_printed_ones() -> None:
    left, right = dh.hands(INITIAL)
    np.testing.assert_allclose(left, [0.12, -2.23, 3.05], atol=0.005)
    np.testing.assert_allclose(right, [0.12, 2.23, 3.05], atol=0.005)


def test_the_printed_zero_for_l_l1_cannot_be_right() -> None:
    left, _ = dh.hands(INITIAL, dh.Lengths(l_l1=0.0))
    assert np.linalg.norm(left - [0.12, -2.23, 3.05]) > 0.5


@pytest.mark.parametrize("beta", [pi / 4, pi / 6, pi / 2])
def test_only_beta_pi_3_gives_the_printed_start(beta: float) -> None:
    assert abs(dh.hands(INITIAL, dh.Lengths(beta=beta)) - [[0.12, -2.23, 3.05], [0.12, 2.23, 3.05]]).max() > 0.1


def test_the_chest_stays_upright(rng: np.random.Generator) -> None:
    for _ in range(100):
        np.testing.assert_allclose(dh.frames(rng.uniform(-pi, pi, 12))["T4"][:3, 0], [0, 0, 1], atol=1e-14)


def test_bones_have_the_link_lengths(rng: np.random.Generator) -> None:
    expected = {"carriage": 2.0, "lower_torso": 0.5, "upper_torso": 0.5}
    for link, (start, end) in dh.bones(rng.uniform(-pi, pi, 12)).items():
        assert np.linalg.norm(end - start) == pytest.approx(expected.get(link, 1.0), abs=1e-13)


def test_many_configurations_are_as_one_by_one(rng: np.random.Generator) -> None:
    q = rng.uniform(-pi, pi, (3, 4, 12))
    lengths = dh.Lengths(*rng.uniform(0.3, 2.0, 10))
    frames, bones, hands = dh.frames(q, lengths), dh.bones(q, lengths), dh.hands(q, lengths)
    assert hands.shape == (3, 4, 2, 3)
    for i, j in np.ndindex(3, 4):
        one = dh.frames(q[i, j], lengths)
        assert one.keys() == frames.keys()
        for name, T in one.items():
            assert T.shape == (4, 4)
            np.testing.assert_allclose(frames[name][i, j], T, rtol=0, atol=1e-14, err_msg=name)
        for link, ends in dh.bones(q[i, j], lengths).items():
            assert ends.shape == (2, 3)
            np.testing.assert_allclose(bones[link][i, j], ends, rtol=0, atol=1e-14, err_msg=link)
        assert dh.hands(q[i, j], lengths).shape == (2, 3)
        np.testing.assert_allclose(hands[i, j], dh.hands(q[i, j], lengths), rtol=0, atol=1e-14)


def test_parameters_of_transforms_broadcast(rng: np.random.Generator) -> None:
    alpha, theta = rng.uniform(-pi, pi, (3, 1)), rng.uniform(-pi, pi, 4)
    many = dh.modified_dh(alpha, 0.3, -0.5, theta)
    assert many.shape == (3, 4, 4, 4)
    np.testing.assert_allclose(many[2, 1], dh.modified_dh(alpha[2, 0], 0.3, -0.5, theta[1]), rtol=0, atol=1e-15)
    np.testing.assert_array_equal(dh.rail(theta)[3], dh.rail(theta[3]))


def test_no_configurations_have_no_frames() -> None:
    assert dh.hands(np.empty((0, 12))).shape == (0, 2, 3)
