"""What checks of certificates against plain geometry have in common: how motions are gone through, judged and told."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import AbstractContextManager, nullcontext
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, TypeVar

from humanoid_rail import Certificate
from humanoid_rail.cli.console import console, print_table
from humanoid_rail.progress import progress_bar

MARGIN = 1e-3
"""A motion that is free by more has to be certified, and contacts are where they are said to be to within this, m."""
PRECISION = 1e-6
"""Bounds are precise to this, m."""
SLIGHT = 1e-5
"""Penetration by no more than this may go unnoticed, m."""


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """The certificate of a motion compared with plain geometry."""

    index: int
    kind: str
    certified: bool
    clearance: float
    """Smallest by plain geometry, m."""
    bound: float
    """The certificate's, m."""
    broken: tuple[str, ...]
    """What does not hold."""


Compared = TypeVar("Compared", bound=Outcome)


def compare_all(compare: Callable[[int], Compared], indices: range, jobs: int) -> list[Compared]:
    """Return the outcomes of motions by their numbers, in order; by processes of their own if jobs is above 1."""
    outcomes = []
    pools: AbstractContextManager[ProcessPoolExecutor | None] = ProcessPoolExecutor(jobs) if jobs > 1 else nullcontext()
    with pools as pool, progress_bar("checking", len(indices)) as advance:
        found: Iterable[Compared] = pool.map(compare, indices, chunksize=8) if pool else map(compare, indices)
        for outcome in found:
            outcomes.append(outcome)
            advance(1)
    return outcomes


def contradictions(certificate: Certificate, least: float, found: str) -> list[str]:
    """Return what a certificate says of a motion that is not so.

    Args:
        certificate: The certificate.
        least: The smallest clearance by plain geometry, m.
        found: That in words.
    """
    bound, contact = certificate.clearance_bound, certificate.contact
    broken = []
    if certificate.certified and (least <= 0.0 or contact is not None):
        broken.append(f"certified, but {found}")
    if bound is None or bound > least + PRECISION:
        broken.append(f"the bound is {bound} m, but {found}")
    if not certificate.certified and least > MARGIN:
        broken.append(f"not certified, but {found}")
    if contact is None and least < -SLIGHT:
        broken.append(f"no contact, but {found}")
    return broken


def summary(
    outcomes: Sequence[Compared], kinds: Iterable[str], counts: Mapping[str, Callable[[Compared], bool]]
) -> list[list[str]]:
    """Return rows of what came of all motions and of those of each kind.

    The last four have, in mm, the smallest clearance of motions that are certified, the largest of those that are not,
    and how far bounds are above the clearance and, of motions that are certified, below it.

    Args:
        outcomes: All of them.
        kinds: The kinds of motions.
        counts: What is counted in the rows before.
    """
    groups = [list(outcomes), *([o for o in outcomes if o.kind == kind] for kind in kinds)]
    rows = [[name, *(str(sum(map(counted, group))) for group in groups)] for name, counted in counts.items()]
    extremes = {
        "least if certified": [min(_of(group, True), default=None) for group in groups],
        "largest if not": [max(_of(group, False), default=None) for group in groups],
        "bound above by up to": [max((o.bound - o.clearance for o in group), default=None) for group in groups],
        "bound below by up to": [
            max((o.clearance - o.bound for o in group if o.certified), default=None) for group in groups
        ],
    }
    for name, values in extremes.items():
        rows.append([name, *("" if value is None else f"{1e3 * value:.4f}" for value in values)])
    return rows


def _of(outcomes: Sequence[Outcome], certified: bool) -> list[float]:
    """Return the clearances of motions that are certified, or of those that are not, m."""
    return [o.clearance for o in outcomes if o.certified == certified]


def tell(
    name: str,
    title: str,
    kinds: Sequence[str],
    rows: Sequence[Sequence[str]],
    outcomes: Sequence[Outcome],
    asked: Mapping[str, Any],
    json_file: Path | None,
    readme: Path | None,
) -> int:
    """Print a table and what is broken, write them where that is asked for, and return the exit code.

    Args:
        name: The name of the table in the file whose table is replaced.
        title: What is above it.
        kinds: The kinds of motions, which are its columns.
        rows: Its rows.
        outcomes: What became of the motions.
        asked: Which motions were asked for, and how.
        json_file: File for the results, if any.
        readme: Markdown file to update, if any.
    """
    print_table(name, title, ("", "all", *kinds), rows, readme)
    broken = [outcome for outcome in outcomes if outcome.broken]
    for outcome in broken:
        console().print(f"motion {outcome.index} ({outcome.kind}): {'; '.join(outcome.broken)}", soft_wrap=True)
    console().print(f"The statements hold of {len(outcomes) - len(broken)} motions out of {len(outcomes)}.")
    if json_file is not None:
        table = {label: dict(zip(("all", *kinds), values, strict=True)) for label, *values in rows}
        report = {**asked, "table": table, "broken": [asdict(outcome) for outcome in broken]}
        json_file.parent.mkdir(parents=True, exist_ok=True)
        json_file.write_text(json.dumps(report, indent=2) + "\n", encoding="utf-8")
    return 1 if broken else 0
