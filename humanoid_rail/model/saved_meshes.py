"""The mesh files of a robot that is saved: convex bodies as OBJ, and copies of visual meshes."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from urllib.parse import unquote

import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput
from humanoid_rail.model.robot import Robot

BODIES = "meshes/collision"
"""The folder of convex bodies."""
VISUALS = "meshes/visual"
"""The folder of what is seen."""

_IN_MTL = re.compile(r"^\s*(?:map_\w+|bump|disp|decal|norm|refl)\s+(?:.*\s)?(\S+)\s*$", re.MULTILINE | re.IGNORECASE)
_IN_OBJ = re.compile(r"^\s*mtllib\s+(.+?)\s*$", re.MULTILINE)
_IN_DAE = re.compile(r"<(?:\w+:)?(?:init_from|ref)\s*>\s*([^<]+?)\s*</")


class SavedMeshes:
    """Collects the files of meshes, each once, by names that are relative and unique."""

    def __init__(self, robot: Robot) -> None:
        self._meshes = robot.meshes
        self._by_content: dict[bytes, str] = {}
        self._by_file: dict[Path, str] = {}
        self.files: dict[str, bytes] = {}
        """What is in the files, by their names."""

    def piece(self, body: pin.GeometryObject) -> str:
        """Return the name of the file with a convex body."""
        content = _obj(body)
        if content not in self._by_content:
            self._by_content[content] = self._free(BODIES, body.name, ".obj")
            self.files[self._by_content[content]] = content
        return self._by_content[content]

    def visual(self, field: str, name: str) -> str:
        """Return the name of the copy of a mesh that a URDF names.

        Raises:
            InvalidInput: If its file is gone.
        """
        file = self._meshes[name].resolve()
        if file not in self._by_file:
            try:
                self._copy(file)
            except OSError as error:
                raise InvalidInput(f"{field}.mesh", str(file), f"a file that is still there ({error})") from error
        return self._by_file[file]

    def _copy(self, file: Path) -> None:
        """Copy a file; with what it refers to, in a folder of its own, so that the names in it stay right."""
        needed = {file: file.read_bytes()}
        ahead = [file]
        while ahead:
            of = ahead.pop()
            for other in _references(of, needed[of]):
                with suppress(OSError, ValueError):  # what is missing is not there for the original either
                    if other not in needed and other.is_file():
                        needed[other] = other.read_bytes()
                        ahead.append(other)
        if len(needed) == 1:
            self._by_file[file] = self._free(VISUALS, file.stem, file.suffix)
            self.files[self._by_file[file]] = needed[file]
            return
        root = Path(os.path.commonpath([other.parent for other in needed]))
        home = self._free(VISUALS, file.stem, "")
        for other, content in needed.items():
            self.files[f"{home}/{other.relative_to(root).as_posix()}"] = content
        self._by_file[file] = f"{home}/{file.relative_to(root).as_posix()}"

    def _free(self, folder: str, stem: str, suffix: str) -> str:
        """Return a name that no file or folder has yet, whether or not names differ by their case."""
        stem = re.sub(r"[^\w.-]", "_", stem)
        taken = {"/".join(name.split("/")[:3]).lower() for name in self.files}
        names = (f"{folder}/{stem}{'' if k == 1 else f'-{k}'}{suffix}" for k in range(1, len(taken) + 2))
        return next(name for name in names if name.lower() not in taken)


def _obj(body: pin.GeometryObject) -> bytes:
    """Return a convex body as OBJ, which holds its vertices without any loss, triangles facing outwards."""
    shape = body.geometry
    vertices: Array = np.array([shape.point(i) for i in range(shape.num_points)])
    middle = vertices.mean(axis=0)
    lines = [" ".join(("v", *map(repr, vertex))) for vertex in vertices.tolist()]
    for k in range(shape.num_polygons):
        triangle = shape.polygons(k)
        a, b, c = (int(triangle[i]) for i in range(3))
        if np.cross(vertices[b] - vertices[a], vertices[c] - vertices[a]) @ (vertices[a] - middle) < 0.0:
            b, c = c, b
        lines.append(f"f {a + 1} {b + 1} {c + 1}")
    return ("\n".join(lines) + "\n").encode()


def _references(file: Path, content: bytes) -> Iterator[Path]:
    """Yield the files that a mesh file, or one that it refers to, names."""
    for name in _names(file.suffix.lower(), content):
        plain = unquote(name.removeprefix("file://"))
        yield from (Path(os.path.normpath(file.parent / said)) for said in dict.fromkeys((name, plain)))


def _names(suffix: str, content: bytes) -> list[str]:
    text = content.decode("utf-8", errors="replace") if suffix in (".obj", ".mtl", ".dae", ".gltf") else ""
    match suffix:
        case ".obj":
            said = _IN_OBJ.findall(text)
            return [*said, *(part for names in said for part in names.split())]
        case ".mtl":
            return [name.replace("\\", "/") for name in _IN_MTL.findall(text)]
        case ".dae":
            return list(_IN_DAE.findall(text))
        case ".gltf":
            with suppress(ValueError, AttributeError, TypeError):
                data = json.loads(text)
                parts = [*data.get("buffers", []), *data.get("images", [])]
                return [str(part["uri"]) for part in parts if not str(part.get("uri", "data:")).startswith("data:")]
    return []
