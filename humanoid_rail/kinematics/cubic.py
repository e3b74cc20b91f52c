"""Cubic polynomials between samples of a motion."""

from __future__ import annotations

from humanoid_rail._arrays import Array


def hermite(first: Array, last: Array, begins: Array, ends: Array, h: Array, u: Array) -> tuple[Array, Array, Array]:
    """Return positions, velocities and accelerations (M, n) of cubics through positions and velocities at their ends.

    Args:
        first: Positions (M, n) where they begin.
        last: Where they end.
        begins: Velocities there.
        ends: The same.
        h: How long each takes (M, 1), s.
        u: Shares (M, 1) of that.
    """
    # Written as deviations: where nothing moves not even rounding does.
    step, a, b = last - first, h * begins, h * ends
    q = first + u * (a + u * (3.0 * step - 2.0 * a - b + u * (a + b - 2.0 * step)))
    velocity = (a + u * (6.0 * step - 4.0 * a - 2.0 * b + u * (3.0 * (a + b) - 6.0 * step))) / h
    acceleration = (6.0 * step - 4.0 * a - 2.0 * b + u * (6.0 * (a + b) - 12.0 * step)) / h**2
    return q, velocity, acceleration
