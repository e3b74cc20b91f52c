"""Mesh files as triangles in metres, with z up."""

from __future__ import annotations

import json
import warnings
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from humanoid_rail._arrays import Array
from humanoid_rail.geometry.file_parts import check_parts, unread_of_collada
from humanoid_rail.geometry.second_reading import check_against_assimp

UP: dict[str, Array] = {
    "X_UP": np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]]),
    "Y_UP": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]),
    "Z_UP": np.eye(3),
}
"""Rotations (3, 3) from the axes of a file to those with z up, by COLLADA's name of its up axis."""
WITHOUT_REFERENCES = frozenset({".stl", ".ply", ".off"})
"""Files of these formats never refer to others, and their numbers are taken as they are: metres, z up."""

SMALL = 1e-3
"""A mesh that is smaller than this is probably in another unit, m."""
ROUNDING = 1e-6
"""What counts as zero, relative to the coordinates: files in single precision round."""


class Triangles(NamedTuple):
    """A surface of triangles."""

    vertices: Array
    """(n, 3), m."""
    faces: NDArray[np.int64]
    """Indices of vertices (m, 3)."""

    @property
    def corners(self) -> Array:
        """The corners of the triangles (m, 3, 3), m."""
        corners: Array = self.vertices[self.faces]
        return corners

    @property
    def centred(self) -> Triangles:
        """The same with the mean of its vertices at the origin, where volumes lose least by rounding."""
        return self._replace(vertices=self.vertices - self.vertices.mean(axis=0))


def read_triangles(file: str, z_up: bool = True) -> Triangles:
    """Return all triangles of a mesh file, placed as the file says, in m.

    COLLADA files say what their unit and their up axis are. glTF (GLB) is in metres with y up by its specification. All
    other formats are taken to be in metres with z up.

    Args:
        file: Path of a mesh, in any format that both trimesh and assimp read.
        z_up: Whether they are turned until z is up. The meshes of robots are not, as everywhere in ROS.

    Raises:
        ValueError: If the file is not a mesh, or holds a part that is not read, or a second reader reads something
            else; the message says what would be valid.
    """
    check_parts(file)
    scene = load(file)
    placed = [_placed(scene, node) for node in scene.graph.nodes_geometry]
    placed = [part for part in placed if len(part.faces)]
    if not placed:
        raise ValueError("a file in which trimesh finds a triangle mesh; write it again as a binary STL file")
    begins = np.cumsum([0, *(len(part.vertices) for part in placed)])
    vertices = np.vstack([part.vertices for part in placed])
    faces = np.vstack([part.faces + begin for part, begin in zip(placed, begins[:-1], strict=True)])
    if not np.isfinite(vertices).all():
        raise ValueError("a mesh with finite vertices")
    if faces.min() < 0 or faces.max() >= len(vertices):
        raise ValueError(f"a mesh whose triangles have corners 0 to {len(vertices) - 1}")
    _check_surface(vertices[np.unique(faces)])
    in_metres = vertices * unit(file)
    check_against_assimp(file, vertices, faces)
    return Triangles(in_metres @ upright(file).T if z_up else in_metres, faces)


def warn_of_size(file: str | Path, size: float, largest: float) -> None:
    """Warn if a mesh is so large or so small, in m, that its numbers are probably in another unit."""
    if size > largest or size < SMALL:
        unit, scale = ("millimetres", 0.001) if size > largest else ("metres", 1)
        what = f"{Path(file).name} is {size:.6g} m large; if its numbers are {unit}, give it the scale {scale:g}"
        warnings.warn(what, stacklevel=3)


def load(file: str) -> Any:
    """Return a mesh file as trimesh's scene, its vertices as they are in the file.

    Raises:
        ValueError: If trimesh cannot read it; the message says what would be valid.
    """
    # Here, not above: it takes a second to import and few scenes hold a mesh.
    import trimesh

    try:
        return trimesh.load_scene(file, process=False)
    except Exception as error:  # trimesh's readers raise whatever their formats make them raise
        raise ValueError(f"a mesh file that trimesh can read ({type(error).__name__}: {error})") from error


def unit(file: str) -> float:
    """Return the length of the file's unit, m: 1 unless it is COLLADA, which says."""
    meter = _collada_asset(file, _stamp(Path(file)))[0] if _is_collada(file) else None
    return 1.0 if meter is None else float(meter)


def upright(file: str) -> Array:
    """Return the rotation (3, 3) from the axes of a file to those with z up."""
    if _is_collada(file):
        return UP[_collada_asset(file, _stamp(Path(file)))[1] or "Y_UP"]
    return UP["Y_UP" if Path(file).suffix.lower() in (".gltf", ".glb") else "Z_UP"]


def off_bytes(triangles: Triangles) -> bytes:
    """Return a file of the format OFF, which holds the triangles without any loss."""
    lines = [f"OFF\n{len(triangles.vertices)} {len(triangles.faces)} 0"]
    lines += [" ".join(map(repr, vertex)) for vertex in triangles.vertices.tolist()]
    lines += [f"3 {a} {b} {c}" for a, b, c in triangles.faces.tolist()]
    return ("\n".join(lines) + "\n").encode()


def stamps(file: str) -> tuple[tuple[str, int, int], ...]:
    """Return name, time of change and size of the files that a mesh's shape is in, to notice when one changes."""
    return tuple((str(name), *_stamp(name)) for name in files_of(file))


def files_of(file: str) -> list[Path]:
    """Return the files that a mesh's shape is in: itself, and the buffers of a glTF file."""
    path = Path(file)
    names = [path]
    if path.suffix.lower() == ".gltf":
        try:
            buffers = json.loads(path.read_text(encoding="utf-8")).get("buffers", [])
            names += [path.parent / b["uri"] for b in buffers if not str(b.get("uri", "data:")).startswith("data:")]
        except (OSError, ValueError, AttributeError, TypeError):  # who reads it says what is wrong with it
            pass
    return names


def _stamp(path: Path) -> tuple[int, int]:
    try:
        found = path.stat()
    except (OSError, ValueError):  # who reads it says that it is not there
        return 0, 0
    return found.st_mtime_ns, found.st_size


def _placed(scene: Any, node: str) -> Triangles:
    """Return what hangs in a node of a scene, in the scene's frame: no triangles if it is a path or a cloud."""
    T, name = scene.graph[node]
    geometry = scene.geometry[name]
    faces = np.asarray(getattr(geometry, "faces", np.zeros((0, 3))), np.int64).reshape(-1, 3)
    vertices = np.asarray(geometry.vertices, float)
    if not len(faces):
        return Triangles(np.zeros((0, 3)), faces)
    if vertices.ndim != 2 or vertices.shape[1] != 3:
        raise ValueError("a mesh whose vertices have three coordinates each")
    return Triangles(vertices @ T[:3, :3].T + T[:3, 3], faces)


def _check_surface(vertices: Array) -> None:
    """Check that vertices (n, 3) of triangles are not all at one point or on one line, up to rounding."""
    width = np.linalg.svd(vertices - vertices.mean(axis=0), compute_uv=False) / np.sqrt(len(vertices))
    where = np.count_nonzero(width > ROUNDING * np.abs(vertices).max())
    if where < 2:
        raise ValueError(f"a mesh that has a surface: all its vertices are {('at one point', 'on one line')[where]}")


def _is_collada(file: str) -> bool:
    return Path(file).suffix.lower() in (".dae", ".zae")


@cache
def _collada_asset(file: str, _stamp: tuple[int, int]) -> tuple[float | None, str | None]:
    """Return unit in m and up axis of a COLLADA file, where it has them, if all of it can be read."""
    import collada

    try:
        read = collada.Collada(file, ignore=[collada.DaeError])
        unread = next(unread_of_collada(read.xmlnode.getroot()), None)
    except Exception as error:  # whatever the reader of XML raises
        raise ValueError(f"a COLLADA file that can be read ({type(error).__name__}: {error})") from error
    if unread is not None:
        raise ValueError(f"a COLLADA file without {unread}, which is not read; write it again as an STL file")
    return read.assetInfo.unitmeter, read.assetInfo.upaxis
