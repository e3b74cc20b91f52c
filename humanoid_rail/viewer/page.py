"""A page in one file: meshcat's viewer, what it is told to draw, and a page of our own around it."""

from __future__ import annotations

import base64
import gzip
import html
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import meshcat
import numpy as np
import umsgpack
from numpy.typing import ArrayLike

_VIEWER = Path(meshcat.__file__).parent / "viewer" / "dist" / "main.min.js"
_WEB = Path(__file__).parent / "web"
"""Scripts and styles."""
_LENGTH = 4
"""Before each command stands how many bytes it has, a number of this many bytes, the lowest first."""
_PAGE = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<link rel="icon" href="data:,">
<title>{title}</title>
<style>
body {{ margin: 0; }}
#meshcat-pane {{ width: 100vw; height: 100vh; overflow: hidden; }}
{style}
</style>
</head>
<body>
{body}
<script type="application/json" id="page-data">{data}</script>
<script>{viewer}</script>
<script>
try {{
    var viewer = new MeshCat.Viewer(document.getElementById("meshcat-pane"));
}} catch (error) {{
    const said = "No picture: this browser draws nothing in 3D, as it has no WebGL or it is switched off.";
    const style = "margin: 0; padding: 24px; font: 14px sans-serif; visibility: visible";
    const line = Object.assign(document.createElement("p"), {{ textContent: said, style }});
    document.getElementById("meshcat-pane").replaceChildren(line);
    throw error;
}}
fetch("data:application/gzip;base64,{commands}")
    .then(response => new Response(response.body.pipeThrough(new DecompressionStream("gzip"))).arrayBuffer())
    .then(buffer => {{
        const view = new DataView(buffer);
        for (let at = 0; at < buffer.byteLength;) {{
            const length = view.getUint32(at, true);
            viewer.handle_command_bytearray(new Uint8Array(buffer, at + {length}, length));
            at += {length} + length;
        }}
        document.dispatchEvent(new Event("drawn"));
    }});
</script>
{scripts}
</body>
</html>
"""


class CommandList:
    """Keeps what meshcat is told to draw, in place of its window, which sends that to a server."""

    def __init__(self) -> None:
        self.commands: list[bytes] = []

    def send(self, command: Any) -> None:
        """Keep one of meshcat's commands."""
        self.commands.append(umsgpack.packb(command.lower()))


def page_html(title: str, body: str, drawn: CommandList, data: Any, *, style: str, scripts: Sequence[str]) -> str:
    """Return a page that shows what was drawn; it needs neither a server nor the network.

    Args:
        title: Title of the page, as text.
        body: The page as HTML; in its element `meshcat-pane` meshcat draws.
        drawn: The commands that draw.
        data: What the scripts know, as data that JSON can hold; the element `page-data` has it.
        style: Name of a style sheet in `web/`.
        scripts: Names of scripts there, in the order in which they run; all is drawn at the event `drawn`.
    """
    stream = b"".join(len(command).to_bytes(_LENGTH, "little") + command for command in drawn.commands)
    return _PAGE.format(
        title=html.escape(title),
        style=_text(style),
        body=body,
        # `<` in a name must not end the script.
        data=json.dumps(data, separators=(",", ":")).replace("<", "\\u003c"),
        viewer=_VIEWER.read_text(encoding="utf-8"),
        commands=base64.b64encode(gzip.compress(stream, 6, mtime=0)).decode("ascii"),
        length=_LENGTH,
        scripts="\n".join(f"<script>{_text(name)}</script>" for name in scripts),
    )


def packed(values: ArrayLike) -> str:
    """Return numbers as the scripts unpack them: in single precision, row by row, as base64."""
    return base64.b64encode(np.ascontiguousarray(values, "<f4").tobytes()).decode("ascii")


def _text(name: str) -> str:
    return (_WEB / name).read_text(encoding="utf-8")
