"""How long things take, and how that compares."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from humanoid_rail._arrays import Array

Works = Mapping[str, Callable[[], float]]
"""Things to measure have names; each returns how long one of its units took, s."""

SETTLE = 0.05
"""One measurement lasts at least this long, s."""


@dataclass(frozen=True)
class Figure:
    """How long something takes."""

    what: str
    """What was measured."""
    median: float
    """The median over the repeats, s."""
    low: float
    """First quartile, s."""
    high: float
    """Third quartile, s."""
    repeats: int
    """How often it was measured."""


@dataclass(frozen=True)
class Ratio:
    """One figure over another, repeat by repeat, so that what slows the machine down slows both."""

    what: str
    """What was compared."""
    median: float
    """The median over the repeats."""
    low: float
    """First quartile."""
    high: float
    """Third quartile."""


def interleaved(works: Works, repeats: int) -> dict[str, Array]:
    """Return how long each work took in each repeat (repeats,), s; the works take turns."""
    for work in works.values():
        work()
    times: dict[str, list[float]] = {name: [] for name in works}
    for _ in range(repeats):
        for name, work in works.items():
            times[name].append(work())
    return {name: np.array(values) for name, values in times.items()}


def each(q: Array, work: Callable[[Array], object]) -> float:
    """Return how long one call takes on average over configurations (N, n), s."""
    start = time.perf_counter()
    for row in q:
        work(row)
    return (time.perf_counter() - start) / len(q)


def once(work: Callable[[], object]) -> float:
    """Return how long a call takes, s."""
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def repeated(work: Callable[[], object]) -> float:
    """Return how long a short call takes on average, s."""
    calls = max(1, int(SETTLE / once(work)))
    return once(lambda: [work() for _ in range(calls)]) / calls


def figure(what: str, values: Array) -> Figure:
    """Return times as a figure."""
    low, median, high = np.quantile(values, [0.25, 0.5, 0.75])
    return Figure(what, float(median), float(low), float(high), len(values))


def ratio(what: str, above: Array, below: Array) -> Ratio:
    """Return the ratio of two works that took turns."""
    low, median, high = (float(x) for x in np.quantile(above / below, [0.25, 0.5, 0.75]))
    return Ratio(what, median, low, high)
