"""What a playback page says of a motion, as HTML."""

from __future__ import annotations

import html
from collections.abc import Sequence

from humanoid_rail.collision.certificate import Certificate
from humanoid_rail.result import Status
from humanoid_rail.trajectory import Trajectory
from humanoid_rail.viewer.closest_pairs import Closest, ClosestPairs, trace_clearance
from humanoid_rail.viewer.colours import CLEARANCE_SCALE, CLOSEST_COLOUR, PENETRATION_COLOUR, hand_colour

HINT = "hint"
"""Class of the element that says how to use the page."""


def caption(name: str, trajectory: Trajectory, pairs: ClosestPairs, closest: Sequence[Closest]) -> str:
    """Return the caption of a page.

    Args:
        name: Name of the scene.
        trajectory: The motion.
        pairs: The closest pairs all along it.
        closest: The closest of them.
    """
    limits = "within limits" if trajectory.limits_ok else "beyond joint limits"
    status = trajectory.status.replace("_", " ")
    ended = "in" if trajectory.status is Status.REACHED else "after"
    said = f"{status} {ended} {trajectory.duration:.2f} s, {_proof(trajectory.certificate)}, {limits}"
    why = "" if trajectory.status is Status.REACHED else html.escape(trajectory.reason)
    described = "; ".join(
        f"{html.escape(pair.link)} &ndash; {html.escape(pair.other)}, {pair.distance:.3f} m at {pair.t:.2f} s"
        for pair in closest
    )
    hands = " ".join(
        f'<span style="color:#{hand_colour(i):06x}">&#9679;</span> {html.escape(hand)}'
        for i, hand in enumerate(trajectory.hand_names)
    )
    line = f'<span style="color:#{CLOSEST_COLOUR:06x}">&#9679;&#8212;&#9679;</span>'
    lines = [
        f"<b>{html.escape(name)}</b>: {html.escape(said)}",
        why,
        f"{line} closest: {described}" if described else "",
        f"{hands}{'' if trace_clearance(trajectory, pairs) is None else _legend(trajectory)}",
        f'<span class="{HINT}" style="color:#6b7684">'
        "Drag to turn, scroll to zoom; pause and time under Open Controls.</span>",
    ]
    return (
        '<div style="position:fixed;left:8px;top:6px;max-width:70vw;padding:6px 10px;border-radius:6px;'
        'background:rgba(245,248,251,0.45);font:14px/1.5 sans-serif;color:#2e3440;pointer-events:none">'
        f"{''.join(f'<div>{line}</div>' for line in lines if line)}</div>"
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


def _legend(trajectory: Trajectory) -> str:
    """Return what the colours of the traces mean: a bar with numbers in m."""
    of = "obstacles" if trajectory.clearance.size else "other links"
    zero, far = 18.0, CLEARANCE_SCALE[-1][0]  # the share of penetration, in per cent of the bar
    at = [zero + (100 - zero) * clearance / far for clearance, _ in CLEARANCE_SCALE]
    colours = [f"#{colour:06x} {x:g}%" for x, (_, colour) in zip(at, CLEARANCE_SCALE, strict=True)]
    stops = ",".join([f"#{PENETRATION_COLOUR:06x} {zero:g}%", *colours])
    marks = ["&lt; 0", *(f"{clearance:g}" for clearance, _ in CLEARANCE_SCALE[:-1]), f"&ge; {far:g}"]
    label = "position:absolute;top:11px;transform:translateX(-50%);white-space:nowrap;font-size:11px;line-height:1"
    numbers = "".join(
        f'<span style="{label};left:{x:g}%">{mark}</span>' for x, mark in zip([zero / 2, *at], marks, strict=True)
    )
    return (
        f'<span style="margin-left:20px">traces: clearance from {of}, m</span><span style="display:inline-block;'
        "position:relative;width:250px;height:9px;margin:0 16px 10px 10px;vertical-align:middle;"
        f'background:linear-gradient(to right,{stops})">{numbers}</span>'
    )
