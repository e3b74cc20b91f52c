"""The limits of the ratios that `engine_report.py` measures: `python -m benchmarks.engine_report --check`.

Only ratios have limits, since times depend on the machine.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from benchmarks.stopwatch import Ratio


@dataclass(frozen=True)
class Limit:
    """The range of a ratio."""

    least: float = 0.0
    """The ratio has to be at least this."""
    most: float = np.inf
    """The ratio has to be at most this."""

    def __str__(self) -> str:
        return f"at least {self.least:g}" if self.least else f"at most {self.most:g}"


LIMITS: Mapping[str, Limit] = {
    "plans per second: two processes / one": Limit(least=1.6),
    "evaluation: native engine / bare library calls, both called from C++": Limit(most=1.5),
    "evaluation: Python engine / native engine called from Python": Limit(least=40),
    "evaluation: qp, along case 3 / eq. 4.9, both native": Limit(most=6),
    "evaluation: qp, solved everywhere / eq. 4.9, both native": Limit(most=6),
    "evaluation: Pink's step with barriers / native engine called from C++": Limit(least=200),
    "case 3: certified / integrated": Limit(most=1.3),
    "case 3: planned, with samples, without certificate / integrated": Limit(most=4),
    "case 3: Python engine / native engine": Limit(least=40),
    "case 3: Pink's rollout / native plan without certificate": Limit(least=200),
    "evaluation: 1,000 spheres / 10, as dense": Limit(most=4),
}
"""The limits of ratios, by what is compared."""


def broken(ratios: Iterable[Ratio]) -> list[str]:
    """Return for each ratio outside its limit a sentence that names it.

    Three of four repeats have to be outside, as other work on the machine disturbs some.
    """
    return [
        f"{ratio.what} is {ratio.median:.3g} ({ratio.low:.3g} to {ratio.high:.3g}), and should be {limit}"
        for ratio in ratios
        if (limit := LIMITS.get(ratio.what)) is not None and (ratio.high < limit.least or ratio.low > limit.most)
    ]
