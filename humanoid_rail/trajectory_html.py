"""What notebooks show of a trajectory: a small table."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape

from humanoid_rail.collision.certificate import Certificate
from humanoid_rail.result import Provenance, Status, Verdict

GOOD, BAD = "#2e7d32", "#c62828"
"""The colours of what is as it should be, and of what is not."""

LEFT = "text-align:left"


def table_of(provenance: Provenance, verdict: Verdict, durations: tuple[float, float | None], samples: int) -> str:
    """Return a table in HTML: status, proof, limits, duration, method. Names are shown as text, whatever is in them.

    Args:
        provenance: Where the motion comes from.
        verdict: What came of it.
        durations: How long it takes, and how long it would take at least, s; None if that is not known.
        samples: How many samples it has.
    """
    rows = "".join(
        f'<tr><th style="{LEFT}">{name}</th><td style="{LEFT};color:{colour}">{escape(text)}</td></tr>'
        for name, text, colour in _rows(provenance, verdict, durations, samples)
    )
    return f"<table><caption>{escape(provenance.scene)}</caption>{rows}</table>"


def _rows(
    provenance: Provenance, verdict: Verdict, durations: tuple[float, float | None], samples: int
) -> Iterator[tuple[str, str, str]]:
    reached, certificate = verdict.status is Status.REACHED, verdict.certificate
    yield "status", f"{verdict.status}: {verdict.reason}", GOOD if reached else BAD
    yield "certified", _proof(certificate), GOOD if certificate is not None and certificate.certified else BAD
    joints = ", ".join(dict.fromkeys(violation.joint for violation in verdict.violations))
    yield "limits", f"exceeded: {joints}" if joints else "kept", BAD if joints else GOOD
    yield "duration", f"{duration_text(*durations)}, {samples} samples, {timing_text(provenance)}", "inherit"
    yield "method", f"{provenance.method.name}, planned in {1e3 * provenance.planning_time:.1f} ms", "inherit"


def duration_text(duration: float, least: float | None) -> str:
    """Say how long a motion takes, and how long it would take at least, s."""
    return f"{duration:.4f} s" if not least else f"{duration:.4f} s ({duration / least:.3f} times the lower bound)"


def timing_text(provenance: Provenance) -> str:
    """Say where the timing of a motion comes from."""
    done = provenance.optimisation
    if provenance.retiming is not None:
        return "retimed"
    if done is None or done.reason:
        return "the method's own timing"
    passed = f", {done.passed} targets passed without stopping" if done.passed else ""
    return f"of least time{passed}" if done.optimised else "as fast along its path as limits allow"


def _proof(certificate: Certificate | None) -> str:
    if certificate is None:
        return "no: there was no native engine to prove it"
    if not certificate.certified:
        return f"no: {certificate.contact or certificate.reason or 'it could not be shown to be free of contact'}"
    bound = certificate.clearance_bound
    return "yes: there is nothing to touch" if bound is None else f"yes: no clearance below {bound:.4f} m"
