"""What a playback page says of a motion, as HTML."""

from __future__ import annotations

import html
from collections.abc import Sequence

from humanoid_rail.collision.certificate import Certificate
from humanoid_rail.result import Status
from humanoid_rail.trajectory import Trajectory
from humanoid_rail.trajectory_html import timing_text
from humanoid_rail.viewer.closest_pairs import Closest
from humanoid_rail.viewer.colours import CLEARANCE_SCALE, PENETRATION_COLOUR

OTHER_SCENE = "planned among other obstacles than those in the picture, which are of the first motion"
NAMED = 3
"""Of links of which nothing is proven so many are named."""


def caption(name: str, trajectory: Trajectory, closest: Sequence[Closest], *, mark: str = "", note: str = "") -> str:
    """Return the caption of a motion: status, certificate, limits, method, and what came closest.

    Args:
        name: What the motion is called.
        trajectory: The motion.
        closest: The closest pairs of the whole motion.
        mark: HTML before the name.
        note: A line of its own.
    """
    reached = trajectory.status is Status.REACHED
    status = trajectory.status.replace("_", " ")
    certificate, provenance = trajectory.certificate, trajectory.provenance
    chips = [
        (reached, f"{status} {'in' if reached else 'after'} {trajectory.duration:.2f} s"),
        (trajectory.certified, _proof(certificate)),
        (trajectory.limits_ok, "within limits" if trajectory.limits_ok else "beyond joint limits"),
    ]
    method = trajectory.method.name
    if trajectory.found_by not in ("", method):
        method += f", found by {trajectory.found_by}"
    if (retiming := provenance.retiming) is not None:
        method += f", retimed at {retiming.speed:.0%} of the speed limits"
    elif trajectory.timing is not None:
        method += f", {timing_text(provenance)}"
    if least := trajectory.least_duration:
        method += f", {trajectory.duration / least:.2f} times the least duration of each joint alone"
    pairs = "; ".join(f"{pair.link} \u2013 {pair.other}, {pair.distance:.3f} m at {pair.t:.2f} s" for pair in closest)
    details = [f"closest: {pairs}" if pairs else "", "" if certificate is None else _left_out(certificate)]
    lines = [note, " \u00b7 ".join(filter(None, details))]
    why = "" if reached else f'<p class="why">{html.escape(trajectory.reason)}</p>'
    said = "".join(f'<span class="chip {"good" if good else "bad"}">{html.escape(text)}</span>' for good, text in chips)
    below = why + "".join(f"<p>{html.escape(line)}</p>" for line in lines if line)
    return (
        f'<section><div class="verdict">{mark}<h1>{html.escape(name)}</h1>{said}'
        f'<span class="method">{html.escape(method)}</span></div>{below}</section>'
    )


def legend(trajectory: Trajectory) -> str:
    """Return what the colours of traces and clearances mean: a bar with numbers in m, as HTML."""
    of = "obstacles" if trajectory.clearance.size else "other links"
    zero, far = 18.0, CLEARANCE_SCALE[-1][0]  # the share of penetration, in per cent of the bar
    at = [zero + (100 - zero) * clearance / far for clearance, _ in CLEARANCE_SCALE]
    colours = [f"#{colour:06x} {x:g}%" for x, (_, colour) in zip(at, CLEARANCE_SCALE, strict=True)]
    stops = ",".join([f"#{PENETRATION_COLOUR:06x} {zero:g}%", *colours])
    marks = ["&lt; 0", *(f"{clearance:g}" for clearance, _ in CLEARANCE_SCALE[:-1]), f"&ge; {far:g}"]
    numbers = "".join(
        f'<span style="left:{x:g}%">{mark}</span>' for x, mark in zip([zero / 2, *at], marks, strict=True)
    )
    return (
        f"<p>Traces of the hands: clearance from {of}, m</p>"
        f'<div class="legend" style="background:linear-gradient(to right,{stops})">{numbers}</div>'
    )


def _proof(certificate: Certificate | None) -> str:
    """Return in a few words what is proven of a motion."""
    if certificate is None:
        return "not certified, as there was no native engine"
    if certificate.certified:
        return "certified free of contact"
    contact = certificate.contact
    found = f"{contact.link} touches {contact.other} at {contact.t:.2f} s" if contact else certificate.reason
    return "not certified" + (f": {found}" if found else "")


def _left_out(certificate: Certificate) -> str:
    """Return of what nothing is proven; empty if that is nothing."""
    links = certificate.links_without_body
    named = ", ".join(links[:NAMED]) + (f" and {len(links) - NAMED} more" if len(links) > NAMED else "")
    return f"not looked at, as they have no collision body: {named}" if links else ""
