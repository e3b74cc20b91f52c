"""The page around the picture of a motion, as HTML: caption, plots, timeline and help."""

from __future__ import annotations

import html
from collections.abc import Mapping
from typing import Any

PLAY = "Play or pause"
VIEWS = {
    "F": ("follow", "Follow the robot"),
    "R": ("reset", "Whole motion in view"),
    "O": ("fade", "Fade obstacles in the way"),
    "M": ("robot", "Robot as it looks"),
    "B": ("bodies", "Collision bodies"),
    "A": ("axes", "Frames of the joints"),
    "C": ("closest", "Closest pair"),
    "T": ("traces", "Traces of the hands"),
    "N": ("names", "Names"),
    "S": ("steps", "Numbers of the targets"),
    "P": ("plots", "Plots"),
}
"""What a key turns on and off: what the script calls it, and what the page does."""
MOVES = (
    ("Space", PLAY),
    ("\u2190 \u2192", "A frame back, forward"),
    ("Shift + \u2190 \u2192", "Previous, next target"),
    ("Home End", "Start, end"),
    ("\u2212 +", "Slower, faster"),
    ("?", "This help"),
)
"""The other keys, and what they do."""


WHY = ("W", "why", "Why it failed")
"""The key of what a plan that failed shows, what the script calls it, and what it does."""


def playback_body(captions: str, legend: str, panel: str, data: Mapping[str, Any]) -> str:
    """Return the page.

    Args:
        captions: What it says of each motion, as HTML.
        legend: What colours mean, as HTML.
        panel: Why a plan failed, as HTML; empty if none did.
        data: What the script knows.
    """
    hands = "".join(
        f'<span><i style="background:{hand["colour"]}"></i>{html.escape(hand["name"])} hand</span>'
        for hand in data["hands"]
    )
    moves = "".join(f"<dt>{_keys(keys)}</dt><dd>{does}</dd>" for keys, does in MOVES)
    views = "".join(
        f'<button type="button" data-view="{name}" aria-pressed="false"><kbd>{key}</kbd>{does}</button>'
        for key, name, does in [*((key, *view) for key, view in VIEWS.items()), *([WHY] if panel else [])]
    )
    why = f'<aside id="why" hidden>{panel}</aside>' if panel else ""
    return f"""<div id="page">
<header id="caption">{captions}</header>
<div id="view">
<main id="stage">
<div id="meshcat-pane"></div>
<div id="labels"></div>
<button type="button" id="help-button" title="Keys and views (?)" aria-label="Keys and views">?</button>
<aside id="help" hidden>
<div><h2>View</h2><div class="views">{views}</div></div>
<div><h2>Keys</h2><dl>{moves}</dl>
<p>Drag to turn, right-drag or two fingers to shift, scroll or pinch to zoom to the pointer.</p>
<h2>Colours</h2><p class="hands">{hands}</p>{legend}</div>
</aside>
</main>
{why}
</div>
<section id="plots" aria-label="Plots over time"></section>
<footer id="timeline">
<button type="button" id="play" title="{PLAY} (Space)" aria-label="{PLAY}"></button>
<button type="button" id="back" title="A frame back (\u2190)" aria-label="A frame back">\u2039</button>
<button type="button" id="forward" title="A frame forward (\u2192)" aria-label="A frame forward">\u203a</button>
<button type="button" id="speed" title="Speed (\u2212 +)" aria-label="Speed">1\u00d7</button>
<div id="scrubber" role="slider" tabindex="0" aria-label="Time" aria-valuemin="0"><div id="track"></div></div>
<output id="time"></output>
</footer>
</div>"""


def _keys(keys: str) -> str:
    return " ".join(key if key == "+" and " + " in keys else f"<kbd>{html.escape(key)}</kbd>" for key in keys.split())
