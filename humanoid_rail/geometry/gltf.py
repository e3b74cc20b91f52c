"""What glTF files say of their shapes besides triangles, of which a reader may make something else."""

from __future__ import annotations

import base64
import json
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.parse import unquote

HARMLESS = ("KHR_materials_", "KHR_texture_", "EXT_texture_", "KHR_lights_", "KHR_xmp", "KHR_node_visibility")
"""Extensions whose names begin so do not change where triangles are."""
SHAPES = (
    "KHR_draco_mesh_compression",
    "EXT_meshopt_compression",
    "KHR_meshopt_compression",
    "KHR_mesh_quantization",
    "EXT_mesh_gpu_instancing",
)
"""Extensions that do; some files name them as used only, though nothing can be read without."""
FAN, FLOAT = 6, 5126
"""A primitive's mode, and an accessor's component type."""
JSON_CHUNK, BINARY_CHUNK = 0x4E4F534A, 0x004E4942


def check_features(file: Path) -> None:
    """Check that a glTF file says where its triangles are in a way that is read rightly.

    Raises:
        ValueError: If it is not a glTF file, or uses something that is not read; the message names it.
    """
    try:
        unread = next(_unread(_content(file)[0]), None)
    except Exception as error:  # whatever a file of another structure raises
        raise ValueError(f"a glTF file that can be read ({type(error).__name__}: {error})") from error
    if unread is not None:
        raise ValueError(f"a glTF file without {unread}, which is not read. Write it again without, or as an STL file")


def with_empty_root(file: Path) -> dict[str, Any]:
    """Return a glTF file with all its buffers inside, and its scene in one more node, which does not move it.

    Raises:
        Exception: Of any kind, if it is not a glTF file whose buffers are there.
    """
    content, binary = _content(file)
    buffers = []
    for number, buffer in enumerate(content.get("buffers", [])):
        uri = buffer.get("uri")
        if uri is None or not uri.startswith("data:"):
            held = binary if uri is None and number == 0 else (file.parent / unquote(uri)).read_bytes()
            uri = "data:application/octet-stream;base64," + base64.b64encode(held).decode()
        buffers.append({**buffer, "uri": uri})
    scenes, nodes = content["scenes"], content["nodes"]
    shown = int(content.get("scene", 0))
    root = {"children": scenes[shown]["nodes"]}
    return {
        **{key: value for key, value in content.items() if key not in ("animations", "skins")},
        "buffers": buffers,
        "nodes": [*nodes, root],
        "scenes": [{"nodes": [len(nodes)]}],
        "scene": 0,
    }


def _content(file: Path) -> tuple[Any, bytes]:
    """Return what a file says, and the buffer in it."""
    held = file.read_bytes()
    if not held.startswith(b"glTF"):
        return json.loads(held.decode("utf-8-sig")), b""
    said, binary, begin = None, b"", 12
    while begin + 8 <= len(held):
        length, kind = struct.unpack_from("<II", held, begin)
        chunk = held[begin + 8 : begin + 8 + length]
        if kind == JSON_CHUNK:
            said = json.loads(chunk)
        elif kind == BINARY_CHUNK:
            binary = chunk
        begin += 8 + length
    return said, binary


def _unread(content: Any) -> Iterator[str]:
    """Yield what a file uses that changes where its triangles are and is not read."""
    required = {name for name in content.get("extensionsRequired", []) if not name.startswith(HARMLESS)}
    yield from sorted(required | set(content.get("extensionsUsed", [])) & set(SHAPES))
    accessors, nodes, meshes = (content.get(name, []) for name in ("accessors", "nodes", "meshes"))
    if any("skin" in node for node in nodes):
        yield "skins"
    if any(any(shape.get("weights", [])) for shape in (*meshes, *nodes)):
        yield "morph targets that have a weight"
    for primitive in (primitive for mesh in meshes for primitive in mesh["primitives"]):
        if primitive.get("mode") == FAN:
            yield "triangle fans"
        position = accessors[primitive["attributes"]["POSITION"]]
        indices = accessors[primitive["indices"]] if "indices" in primitive else {}
        if "sparse" in position or "sparse" in indices:
            yield "sparse accessors"
        if position["componentType"] != FLOAT:
            yield "positions that are whole numbers"
