"""Parts of mesh files that readers leave out without a word: they are looked for, and such a file is refused."""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from humanoid_rail.geometry import gltf

STL_HEADER, STL_TRIANGLE = 84, 50
"""Bytes before the triangles of a binary STL file, the last four of which are their number, and of each triangle."""
FREE_FORM = re.compile(rb"^[ \t]*(surf|curv2?)[ \t]", re.MULTILINE)
"""Surfaces and curves of an OBJ file that are given by control points."""


def check_parts(file: str) -> None:
    """Check that a mesh file is whole, and holds nothing that is known to be left out by its readers.

    Raises:
        ValueError: If it does; the message names it.
    """
    path = Path(file)
    try:
        match path.suffix.lower():
            case ".stl":
                _check_stl(path.read_bytes())
            case ".obj":
                if found := FREE_FORM.search(path.read_bytes()):
                    said = f'free-form surfaces ("{found[1].decode()}")'
                    raise ValueError(f"an OBJ file without {said}, which are not read; write it as triangles")
            case ".gltf" | ".glb":
                gltf.check_features(path)
    except OSError as error:
        raise ValueError(f"a mesh file that can be read ({type(error).__name__}: {error})") from error


def unread_of_collada(root: Any) -> Iterator[str]:
    """Yield what the root element of a COLLADA file has below it that changes its shape and is not read."""
    elements = [(element, _name(element)) for element in root.iter()]
    known = {element.get("id") for element, name in elements if name}
    for element, name in elements:
        if name in ("instance_controller", "ph"):
            yield f"<{name}>"
        if name in ("instance_geometry", "instance_node") and str(element.get("url")).removeprefix("#") not in known:
            yield f"<{name}> of something outside of it ({element.get('url')})"
        if name == "geometry":
            yield from (f"<{kind}>" for kind in map(_name, element) if kind in ("convex_mesh", "spline", "brep"))


def _name(element: Any) -> str:
    """Return the name of an element without its namespace: empty if it is a comment."""
    return element.tag.rpartition("}")[2] if isinstance(element.tag, str) else ""


def _check_stl(content: bytes) -> None:
    triangles = struct.unpack_from("<I", content, STL_HEADER - 4)[0] if len(content) >= STL_HEADER else 0
    whole = STL_HEADER + STL_TRIANGLE * triangles
    if len(content) == whole:
        return
    text = content.lower()
    if b"facet" not in text[:10_000] or not text.lstrip().startswith(b"solid"):
        said = f"it says that it has {triangles} triangles, which take {whole} bytes, and it has {len(content)} bytes"
        raise ValueError(f"a whole STL file: {said}")
    if b"endsolid" not in text[text.rfind(b"endfacet") :]:
        raise ValueError('a whole STL file: it is text and ends before "endsolid"')
