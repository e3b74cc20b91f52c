"""A page in one file: meshcat's viewer, and what it is told to draw."""

from __future__ import annotations

import base64
import gzip
import html
from pathlib import Path
from typing import Any

import meshcat
import umsgpack

_VIEWER = Path(meshcat.__file__).parent / "viewer" / "dist" / "main.min.js"
_LENGTH = 4
"""Before each command stands how many bytes it has, a number of this many bytes, the lowest first."""
_PAGE = """<!DOCTYPE html>
<html>
<head>
<meta charset="utf-8">
<title>{title}</title>
<style>
body {{ margin: 0; }}
#meshcat-pane {{ width: 100vw; height: 100vh; overflow: hidden; }}
</style>
</head>
<body>
{caption}
<div id="meshcat-pane"></div>
<script>{viewer}</script>
<script>
var viewer = new MeshCat.Viewer(document.getElementById("meshcat-pane"));
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


def page_html(title: str, caption: str, drawn: CommandList) -> str:
    """Return a page that shows what was drawn; it needs neither a server nor the network.

    Args:
        title: Title of the page, as text.
        caption: What stands over the picture, as HTML.
        drawn: The commands that draw it.
    """
    stream = b"".join(len(command).to_bytes(_LENGTH, "little") + command for command in drawn.commands)
    return _PAGE.format(
        title=html.escape(title),
        caption=caption,
        viewer=_VIEWER.read_text(encoding="utf-8"),
        commands=base64.b64encode(gzip.compress(stream, mtime=0)).decode("ascii"),
        length=_LENGTH,
    )
