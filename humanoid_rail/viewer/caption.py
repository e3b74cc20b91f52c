"""What a playback page says of a motion, as HTML."""

from __future__ import annotations

import html
from collections.abc import Sequence

from humanoid_rail.collision.certificate import Certificate
from humanoid_rail.diagnosis import besides
from humanoid_rail.model.allowed_contacts import allowed_contacts
from humanoid_rail.result import SO_FAR, Status
from humanoid_rail.scene.scene import Scene
from humanoid_rail.trajectory import Trajectory
from humanoid_rail.trajectory_html import timing_text
from humanoid_rail.viewer.closest_pairs import Closest
from humanoid_rail.viewer.colours import CLEARANCE_SCALE, PENETRATION_COLOUR

OTHER_SCENE = "planned {} than those in the picture, which are of the first motion"
"""What is said of a motion whose scene is not drawn, and differs from the one that is."""
NAMED = 4
"""So many are named of links of which nothing is proven, and of contacts that are allowed; a click on the caption or
the pointer shows all."""


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
    status, lasts = trajectory.status.replace("_", " "), f"{trajectory.duration:.2f} s"
    certificate, provenance = trajectory.certificate, trajectory.provenance
    chips = [
        (reached, f"reached in {lasts}" if reached else f"not reached: {status}; the motion ends at {lasts}"),
        (trajectory.certified, _proof(certificate) + (SO_FAR if trajectory.certified and not reached else "")),
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
    lines = [note, f"closest: {pairs}" if pairs else ""]
    why = "" if reached else _why(trajectory)
    said = "".join(f'<span class="chip {"good" if good else "bad"}">{html.escape(text)}</span>' for good, text in chips)
    below = why + "".join(f"<p>{html.escape(line)}</p>" for line in lines if line)
    if certificate is not None:
        contacts = allowed_contacts(certificate.unchecked_pairs, {event.object for event in trajectory.events})
        below += _shortened("allowed", "may touch, not checked: ", contacts, "; ")
        below += _shortened(
            "bare", "not checked, as they have no collision body: ", certificate.links_without_body, ", "
        )
    return (
        f'<section><div class="verdict">{mark}<h1>{html.escape(name)}</h1>{said}'
        f'<span class="method">{html.escape(method)}</span></div>{below}</section>'
    )


def other_scene(drawn: Scene, own: Scene) -> str:
    """Return how the scene of a motion differs from the one that is drawn; empty if it does not."""
    differs = {"among other obstacles": own.obstacles != drawn.obstacles, "for other targets": own.steps != drawn.steps}
    said = " and ".join(what for what, is_so in differs.items() if is_so)
    return OTHER_SCENE.format(said) if said else ""


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


def _why(trajectory: Trajectory) -> str:
    """Return why a motion did not reach its targets: what a panel says beside is seen when the caption is opened."""
    first = besides(trajectory.reason, trajectory.diagnosis)[0]
    rest = trajectory.reason.removeprefix(first)
    return f'<p class="why">{html.escape(first)}<span class="all">{html.escape(rest)}</span></p>'


def _shortened(kind: str, heading: str, names: Sequence[str], between: str) -> str:
    """Return a line with the first of some names and how many more there are, as HTML; empty if there are none."""
    if not names:
        return ""
    escaped = [html.escape(name) for name in names]
    first, rest = between.join(escaped[:NAMED]), escaped[NAMED:]
    if rest:
        more = between + between.join(rest)
        first += f'<span class="more"> and {len(rest)} more</span><span class="all">{more}</span>'
    return f'<p class="{kind}" title="{between.join(escaped)}">{heading}{first}</p>'
