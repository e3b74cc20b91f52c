"""Mesh files that are easily read in part: of each, all is to be read, or nothing."""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import trimesh
from numpy.typing import NDArray

from humanoid_rail.geometry.mesh_files import read_triangles

Parts = Sequence[trimesh.Trimesh]
FLOAT, UNSIGNED = 5126, 5125
"""Component types of glTF accessors."""


class Trap(NamedTuple):
    """A way to write parts of a mesh to a file."""

    suffix: str
    write: Callable[[Parts], bytes]
    """Return the file's content."""
    is_valid: bool
    """Whether the file says by its format where all triangles are. One that is cut off or names what is not there
    does not, and is to be refused."""


def _obj(parts: Parts, face: Callable[[NDArray[np.int64], int, int], str]) -> bytes:
    """Return an OBJ file whose triangles follow the vertices of their part.

    Args:
        parts: The parts.
        face: Returns a line, given the triangle's indices in its part, how many vertices are before, and in the part.
    """
    lines, before = [], 0
    for number, part in enumerate(parts):
        lines += [f"o part{number}", *(f"v {x!r} {y!r} {z!r}" for x, y, z in part.vertices.tolist())]
        lines += [face(triangle, before, len(part.vertices)) for triangle in part.faces]
        before += len(part.vertices)
    return "\n".join([*lines, ""]).encode()


def _relative(triangle: NDArray[np.int64], before: int, count: int) -> str:
    return "f " + " ".join(str(i - count) for i in triangle)


def _tabs(triangle: NDArray[np.int64], before: int, count: int) -> str:
    return ("f\t" if before else "f ") + " ".join(str(before + i + 1) for i in triangle)


def _from_zero(triangle: NDArray[np.int64], before: int, count: int) -> str:
    return "f " + " ".join(str(before + i) for i in triangle)


def _gltf(parts: Parts, change: Callable[[dict[str, Any]], None]) -> bytes:
    """Return a glTF file of a part for each mesh, below one node that turns and moves them, with a change."""
    scene = trimesh.Scene()
    for number, part in enumerate(parts):
        scene.add_geometry(part.copy().apply_transform(np.linalg.inv(PLACED)), geom_name=f"part{number}")
    files = trimesh.exchange.gltf.export_gltf(scene, merge_buffers=True)
    content = json.loads(files.pop("model.gltf"))
    ((_, buffer),) = files.items()
    root = {"children": content["scenes"][0]["nodes"], "matrix": PLACED.T.ravel().tolist()}
    content["scenes"][0]["nodes"] = [len(content["nodes"])]
    content["nodes"].append(root)
    content["buffers"][0]["uri"] = _data(buffer)
    change(content)
    return json.dumps(content).encode()


PLACED = trimesh.transformations.rotation_matrix(0.7, (1.0, 2.0, 3.0), (0.4, 0.5, 0.6))
"""Where the root of glTF files puts the parts."""


def _data(content: bytes) -> str:
    """Return bytes as the name of a buffer that they are in."""
    return "data:application/octet-stream;base64," + base64.b64encode(content).decode()


def _last(content: dict[str, Any]) -> dict[str, Any]:
    """Return the primitive of the last mesh."""
    primitive: dict[str, Any] = content["meshes"][-1]["primitives"][0]
    return primitive


def _sparse(content: dict[str, Any]) -> None:
    """Move a vertex by a sparse accessor, which is how files do it that are made of others."""
    position = content["accessors"][_last(content)["attributes"]["POSITION"]]
    index_and_place = np.array([0.0, 9.0, 9.0, 9.0], np.float32)  # the index is 0, whose bytes are those of 0.0
    content["buffers"].append({"byteLength": 16, "uri": _data(index_and_place.tobytes())})
    number = len(content["buffers"]) - 1
    begin = len(content["bufferViews"])
    content["bufferViews"] += [{"buffer": number, "byteOffset": a, "byteLength": b} for a, b in ((0, 4), (4, 12))]
    indices = {"bufferView": begin, "componentType": UNSIGNED}
    position["sparse"] = {"count": 1, "indices": indices, "values": {"bufferView": begin + 1}}


def _compressed(content: dict[str, Any]) -> None:
    for key in ("extensionsUsed", "extensionsRequired"):
        content[key] = ["KHR_draco_mesh_compression"]


def _instanced(content: dict[str, Any]) -> None:
    content["extensionsUsed"] = ["EXT_mesh_gpu_instancing"]


def _skinned(content: dict[str, Any]) -> None:
    content["skins"] = [{"joints": [0]}]
    next(node for node in content["nodes"] if "mesh" in node)["skin"] = 0


def _morphed(content: dict[str, Any]) -> None:
    primitive = _last(content)
    primitive["targets"] = [{"POSITION": primitive["attributes"]["POSITION"]}]
    content["meshes"][-1]["weights"] = [1.0]


def _fan(content: dict[str, Any]) -> None:
    _last(content)["mode"] = 6


def _unchanged(content: dict[str, Any]) -> None:
    pass


def _dae(parts: Parts, change: Callable[[str], str]) -> bytes:
    scene = trimesh.Scene({f"part{number}": part for number, part in enumerate(parts)})
    text: str = trimesh.exchange.dae.export_collada(list(scene.geometry.values())).decode()
    return change(text.replace("Y_UP", "Z_UP")).encode()


def _elsewhere(text: str) -> str:
    return re.sub(r'(<instance_geometry url="#)', r"\1nowhere", text, count=1)


def _controller(text: str) -> str:
    """Hang the first geometry into the scene by a controller, as skins do."""
    found = re.search(r'<instance_geometry url="#([^"]*)"', text)
    assert found is not None
    skin = f'<skin source="#{found[1]}"/>'
    controllers = f'<library_controllers><controller id="skin">{skin}</controller></library_controllers>'
    body = re.sub(
        r"<instance_geometry[^>]*?(/>|>.*?</instance_geometry>)",
        '<instance_controller url="#skin"/>',
        text,
        count=1,
        flags=re.DOTALL,
    )
    return body.replace("<library_visual_scenes", controllers + "<library_visual_scenes")


def _cut(suffix: str, lines: int = 0, share: float = 1.0, **options: Any) -> Callable[[Parts], bytes]:
    """Return a writer of files that end too early, by lines or to a share of their bytes."""

    def write(parts: Parts) -> bytes:
        content = trimesh.util.concatenate(list(parts)).export(file_type=suffix, **options)
        content = content.encode() if isinstance(content, str) else content
        if lines:
            return b"\n".join(content.splitlines()[:-lines]) + b"\n"
        return bytes(content[: int(share * len(content))])

    return write


TRAPS = {
    "OBJ, indices from the end": Trap("obj", lambda parts: _obj(parts, _relative), True),
    "OBJ, tabs": Trap("obj", lambda parts: _obj(parts, _tabs), True),
    "OBJ, indices from 0": Trap("obj", lambda parts: _obj(parts, _from_zero), False),
    "glTF, placed root": Trap("gltf", lambda parts: _gltf(parts, _unchanged), True),
    "glTF, sparse": Trap("gltf", lambda parts: _gltf(parts, _sparse), False),
    "glTF, compressed": Trap("gltf", lambda parts: _gltf(parts, _compressed), False),
    "glTF, instanced": Trap("gltf", lambda parts: _gltf(parts, _instanced), False),
    "glTF, skinned": Trap("gltf", lambda parts: _gltf(parts, _skinned), False),
    "glTF, morphed": Trap("gltf", lambda parts: _gltf(parts, _morphed), False),
    "glTF, fan": Trap("gltf", lambda parts: _gltf(parts, _fan), False),
    "DAE, controller": Trap("dae", lambda parts: _dae(parts, _controller), False),
    "DAE, reference to nothing": Trap("dae", lambda parts: _dae(parts, _elsewhere), False),
    "STL, cut off": Trap("stl", _cut("stl", share=0.7), False),
    "STL as text, cut off": Trap("stl", _cut("stl_ascii", lines=8), False),
    "PLY, cut off": Trap("ply", _cut("ply", share=0.9), False),
    "PLY as text, cut off": Trap("ply", _cut("ply", lines=3, encoding="ascii"), False),
    "OFF, cut off": Trap("off", _cut("off", lines=3), False),
}
"""By a name that says what it is."""


def read_wrongly(parts: Parts, folder: Path) -> Iterator[str]:
    """Yield the names of traps of which something else than the parts is read."""
    whole = trimesh.util.concatenate(list(parts))
    for number, (name, trap) in enumerate(TRAPS.items()):
        file = folder / f"trap{number}.{trap.suffix}"
        file.write_bytes(trap.write(parts))
        try:
            found = read_triangles(str(file), z_up=False)
        except ValueError:
            continue
        same_count = len(found.faces) == len(whole.faces)
        corners = found.corners.reshape(-1, 3)
        bounds = np.array([corners.min(axis=0), corners.max(axis=0)])
        if not trap.is_valid or not same_count or not np.allclose(bounds, whole.bounds, atol=1e-4):
            yield name
