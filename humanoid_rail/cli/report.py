"""What commands print of a plan."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

from humanoid_rail._arrays import Array
from humanoid_rail.cli.console import console
from humanoid_rail.collision.certificate import Certificate
from humanoid_rail.diagnosis import TRIED, Diagnosis, besides
from humanoid_rail.errors import told_apart
from humanoid_rail.events import Event
from humanoid_rail.kinematics.joint_limits import Violation
from humanoid_rail.kinematics.path_metric import PathQuality
from humanoid_rail.model.allowed_contacts import allowed_contacts, may_touch
from humanoid_rail.model.pairs import NEITHER_MOVES, UncheckedPair
from humanoid_rail.result import SO_FAR, Status
from humanoid_rail.trajectory import Trajectory
from humanoid_rail.trajectory_html import duration_text, timing_text

NO_ENGINE = "nothing can be proven without the native engine"
"""This is said of a motion that has no certificate."""
SMALL = 1e-3
"""Lengths below this are printed in mm, m."""
FIRST_LINKS, FIRST_PAIRS, FIRST_BLOCKING = 4, 1, 3
"""A table names so many links without a body, pairs that are not checked and pairs that block; of more it says how many
there are. summary.json has all of them."""


def report_plan(title: str, trajectory: Trajectory) -> None:
    """Print a short table of what came of a plan."""
    certificate = trajectory.certificate
    rows = [
        ("status", f"{trajectory.status}: {'; '.join(besides(trajectory.reason, trajectory.diagnosis))}"),
        *_diagnosis(trajectory.diagnosis),
        ("certified", _certified(certificate, float(trajectory.t[0]), float(trajectory.t[-1]), _as_far(trajectory))),
        *_limits(trajectory),
        ("duration", duration_text(trajectory.duration, trajectory.least_duration)),
        *_timing(trajectory),
        ("method", trajectory.method.name + _found_by(trajectory)),
        *_clearances(certificate, trajectory.events),
        ("manipulability", f"{trajectory.manipulability[0]:.3f} to {trajectory.manipulability[-1]:.3f}"),
        ("path", _path(trajectory)),
        (
            "planning",
            f"{_time(trajectory.planning_time)} ({trajectory.engine}), {trajectory.evaluations} velocities computed",
        ),
    ]
    _print(title, rows)


def report_certificate(
    title: str,
    certificate: Certificate,
    t: Array,
    more: Iterable[tuple[str, str]] = (),
    events: Sequence[Event] = (),
) -> None:
    """Print a short table of what is proven of a motion with samples at times (N,) in s and events, and more rows."""
    start, end = float(t[0]), float(t[-1])
    clearances = _clearances(certificate, events)
    _print(title, [("certified", _certified(certificate, start, end)), *_before(start), *more, *clearances])


def _before(start: float) -> Iterator[tuple[str, str]]:
    """Say that a proof begins after the time at which obstacles start to move, if so."""
    if start > 0.0:
        yield "", "nothing is said of the time before the first sample; obstacles that move start at t = 0"


def _print(title: str, rows: Iterable[tuple[str, str]]) -> None:
    # Imported here: the help of the commands needs nothing of it.
    from rich.table import Table

    table = Table(title=title, title_justify="left", show_header=False)
    for name, text in rows:
        table.add_row(name, text)
    console().print(table)


def _time(seconds: float) -> str:
    return f"{1e3 * seconds:.1f} ms" if seconds < 1.0 else f"{seconds:.1f} s"


def _as_far(trajectory: Trajectory) -> str:
    """Return what is added to the proofs of a motion that ends before its targets."""
    return "" if trajectory.status is Status.REACHED else SO_FAR


def _diagnosis(diagnosis: Diagnosis | None) -> Iterator[tuple[str, str]]:
    """Say how near a plan that failed gets, what blocks it, and all that would help."""
    if diagnosis is None:
        return
    if diagnosis.miss:
        yield "nearest miss", diagnosis.miss
    pairs = [f"{pair.link} and {pair.other}, {_apart(pair.beyond)}" for pair in diagnosis.blocking]
    more = len(pairs) - FIRST_BLOCKING
    for number, pair in enumerate(pairs[:FIRST_BLOCKING]):
        yield "" if number else "blocked by", pair
    if more > 0:
        yield "", f"and {more} more pairs (summary.json)"
    for number, remedy in enumerate(diagnosis.remedies):
        yield "" if number else "would help", f"{remedy.what} ({TRIED[remedy.proven]})"


def _apart(distance: float) -> str:
    return f"{_length(-distance)} inside one another" if distance < 0 else f"{_length(distance)} apart"


def _limits(trajectory: Trajectory) -> Iterator[tuple[str, str]]:
    """Say whether the joint limits are kept."""
    if trajectory.limits_ok:
        what = "position and velocity" if trajectory.timing is None else "position, velocity and acceleration"
        yield "limits", f"kept{_as_far(trajectory)}: {what}"
    yield from beyond_limits(trajectory.violations)


def beyond_limits(violations: Sequence[Violation]) -> Iterator[tuple[str, str]]:
    """Say which limits are not kept."""
    for i, violation in enumerate(violations):
        value, limit = (
            told_apart(a, b, 3) for a, b in ((violation.value, violation.limit), (violation.limit, violation.value))
        )
        what = f"{violation.joint} {violation.quantity} {value}, limit {limit}"
        yield "" if i else "beyond limits", f"{what}, at {violation.t:.2f} s"


def _clearances(certificate: Certificate | None, events: Sequence[Event]) -> Iterator[tuple[str, str]]:
    """Say how near things come."""
    if certificate is not None:
        yield "least clearance", _clearance(certificate.min_clearance_obstacles, "no obstacles")
        yield "between links", _clearance(certificate.min_clearance_self, "no pairs to check")
        contacts = allowed_contacts(certificate.unchecked_pairs, {event.object for event in events})
        for i, contact in enumerate(contacts):
            yield "" if i else "may touch", contact
        unmoved = [pair for pair in certificate.unchecked_pairs if pair.why.startswith(NEITHER_MOVES)]
        pairs = [
            f"{pair.link} and {pair.other}"
            for pair in certificate.unchecked_pairs
            if pair not in unmoved and not may_touch(pair)
        ]
        if pairs:
            yield "left out", f"{_shortened(pairs, FIRST_PAIRS, ' pairs')}, near joints"
        for i, pair in enumerate(unmoved):  # all of them: some may be deep in one another
            yield "" if i else "fixed, left out", _unmoved(pair)
        if certificate.links_without_body:
            yield "no body", _shortened(certificate.links_without_body, FIRST_LINKS)
        for i, cover in enumerate(certificate.covers):
            yield "" if i else "covers", str(cover)


def _unmoved(pair: UncheckedPair) -> str:
    return f"{pair.link} and {pair.other}: {pair.why.removeprefix(f'{NEITHER_MOVES}; ')}"


def _shortened(names: Sequence[str], first: int, what: str = "") -> str:
    """Return the first names in a row, and how many more there are."""
    rest = len(names) - first
    return ", ".join(names[:first]) + (f" and {rest} more{what}" if rest > 0 else "")


def _timing(trajectory: Trajectory) -> Iterator[tuple[str, str]]:
    """Say how fast a motion is, and how near that comes to the limits."""
    if trajectory.timing is None:
        done = trajectory.provenance.optimisation
        why = f", as {done.reason}" if done is not None else ""
        yield "timing", f"the method's own{why}; retime it before a drive runs it (--retime)"
        return
    limits = "within limits of velocity and acceleration, at rest at both ends"
    yield "timing", f"{timing_text(trajectory.provenance)}: {limits}"
    for quantity, per in (("velocity", "s"), ("acceleration", "s^2"), ("jerk", "s^3")):
        rows = [
            (getattr(peak, quantity), getattr(peak, f"{quantity}_limit"), peak.joint)
            for peak in trajectory.timing.peaks
        ]
        peak, limit, joint = max(rows, key=lambda row: (row[0] / row[1], row[0]))
        share = f"{peak / limit:.1%} of the limit of {limit:.4g}" if math.isfinite(limit) else "no limit"
        unit = "(m, rad)" if trajectory.robot is None else trajectory.robot.unit_of(joint)
        yield f"peak {quantity}", f"{peak:.4g} {unit}/{per}, {share}, {joint}"


def why_not_certified(certificate: Certificate) -> str:
    """Return what is known of a motion that is not certified."""
    known = [str(said) for said in (certificate.contact, certificate.reason) if said is not None]
    return ", and ".join(known) or "it could not be shown to be free of contact"


def _certified(certificate: Certificate | None, start: float, end: float, as_far: str = "") -> str:
    if certificate is None:
        return f"no: {NO_ENGINE}"
    if not certificate.certified:
        return f"no: {why_not_certified(certificate)}"
    bound = certificate.clearance_bound
    nothing = f"yes{as_far}: there is nothing to touch"
    when = f"until t = {end:.4g} s" if start == 0.0 else f"from t = {start:.4g} s to t = {end:.4g} s"
    return nothing if bound is None else f"yes{as_far}: no clearance below {_length(bound)} {when}"


def _found_by(trajectory: Trajectory) -> str:
    return f": found by {trajectory.found_by}" if trajectory.method.name == "auto" and trajectory.found_by else ""


def _path(trajectory: Trajectory) -> str:
    """Say how long the path is and how sharply it turns, and what it was before it was smoothed."""
    path, raw = trajectory.path, trajectory.search.raw if trajectory.search else None
    said = f"length {path.length:.3g} s (joints in units of their speed limits), sharpest turn {_degrees(path)}"
    return said + (f"; as it was sampled {raw.length:.3g} s and {_degrees(raw)}" if raw else "")


def _degrees(path: PathQuality) -> str:
    return f"{round(math.degrees(path.sharpest_turn), 1):g} deg"


def _clearance(clearance: float | None, nothing: str) -> str:
    return nothing if clearance is None else _length(clearance)


def _length(length: float) -> str:
    """Return a length in m, or in mm where little of it would be seen."""
    return f"{length:.4f} m" if abs(length) >= SMALL else f"{1e3 * length:.3g} mm"
