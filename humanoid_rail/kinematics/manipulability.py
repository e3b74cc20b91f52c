"""Manipulability of the arms and its gradient, eq. 3.4."""

from __future__ import annotations

import numpy as np

from humanoid_rail._arrays import Array

ZERO = 1e-14
"""A singular value this much smaller than the largest is 0 up to rounding."""


def manipulability(arms: list[Array]) -> float:
    """Return mu = sqrt(det(J_arms J_arms^T)), eq. 3.4 (Yoshikawa 1985).

    J_arms is block diagonal, so its singular values are those of its blocks, and mu is their product.

    Args:
        arms: The blocks of J_arms, (3, k) each with k not less than 3.
    """
    return float(np.prod(np.concatenate([np.linalg.svd(J, compute_uv=False) for J in arms])))


def manipulability_gradient(arms: list[Array], derivatives: list[Array]) -> Array:
    """Return d mu / dq (n,).

    d mu / dq_k = mu tr(J_arms^# dJ_arms/dq_k). With J_arms = sum_i sigma_i u_i v_i^T this is
    sum_i (prod_{j != i} sigma_j) u_i^T dJ_arms/dq_k v_i, which needs no division and stays exact next to singularities.

    Where mu is 0 it is at its minimum and, like |x| at 0, in general not differentiable: the gradient is then taken
    as 0, which is an element of Clarke's generalised gradient. A motion that starts there gets no push from mu.

    Args:
        arms: The blocks of J_arms, (3, k) each.
        derivatives: dJ/dq of each block, (3, k, n).
    """
    decompositions = [np.linalg.svd(J, full_matrices=False) for J in arms]
    sigma = np.concatenate([s for _, s, _ in decompositions])
    gradient = np.zeros(derivatives[0].shape[2])
    if sigma.min() <= ZERO * sigma.max():
        return gradient
    i = 0
    for (U, _, Vt), dJ in zip(decompositions, derivatives, strict=True):
        for u, v in zip(U.T, Vt, strict=True):
            gradient += np.prod(np.delete(sigma, i)) * np.einsum("x,xcn,c->n", u, dJ, v)
            i += 1
    return gradient
