"""What notebooks show of a trajectory: a small table."""

from __future__ import annotations

from collections.abc import Iterator
from html import escape

from humanoid_rail.collision.certificate import Certificate
from humanoid_rail.result import Provenance, Status, Verdict

GOOD, BAD = "#2e7d32", "#c62828"
"""The colours of what is as it should be, and of what is not."""

LEFT = "text-align:left"


def table_of(provenance: Provenance, verdict: Verdict, duration: float, samples: int) -> str:
    """Return a table in HTML: status, proof, limits, duration, method. Names are shown as text, whatever is in them.

    Args:
        provenance: Where the motion comes from.
        verdict: What came of it.
        duration: How long it takes, s.
        samples: How many samples it has.
    """
    rows = "".join(
        f'<tr><th style="{LEFT}">{name}</th><td style="{LEFT};color:{colour}">{escape(text)}</td></tr>'
        for name, text, colour in _rows(provenance, verdict, duration, samples)
    )
    return f"<table><caption>{escape(provenance.scene)}</caption>{rows}</table>"


def _rows(provenance: Provenance, verdict: Verdict, duration: float, samples: int) -> Iterator[tuple[str, str, str]]:
    reached, certificate = verdict.status is Status.REACHED, verdict.certificate
    yield "status", f"{verdict.status}: {verdict.reason}", GOOD if reached else BAD
    yield "certified", _proof(certificate), GOOD if certificate is not None and certificate.certified else BAD
    joints = ", ".join(dict.fromkeys(violation.joint for violation in verdict.violations))
    yield "limits", f"exceeded: {joints}" if joints else "kept", BAD if joints else GOOD
    retimed = "the method's own timing" if provenance.retiming is None else "retimed for a drive"
    yield "duration", f"{duration:.4f} s, {samples} samples, {retimed}", "inherit"
    yield "method", f"{provenance.method.name}, planned in {1e3 * provenance.planning_time:.1f} ms", "inherit"


def _proof(certificate: Certificate | None) -> str:
    if certificate is None:
        return "no: there was no native engine to prove it"
    if not certificate.certified:
        return f"no: {certificate.contact or certificate.reason or 'it could not be shown to be free of contact'}"
    bound = certificate.clearance_bound
    return "yes: there is nothing to touch" if bound is None else f"yes: no clearance below {bound:.4f} m"
