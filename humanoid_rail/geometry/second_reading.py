"""A second reading of mesh files, by assimp: the two readers share no code, so neither loses a part in silence."""

from __future__ import annotations

import json
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from humanoid_rail._arrays import Array
from humanoid_rail.geometry.gltf import with_empty_root

TOLERANCE = 1e-5
"""Corners may differ by this share of their largest coordinate: assimp keeps numbers in single precision."""
INSTEAD = "Write it again as a binary STL, PLY or OBJ file, for example with Blender or MeshLab"


def check_against_assimp(file: str, vertices: Array, faces: NDArray[np.int64]) -> None:
    """Check that assimp reads the same from a file.

    It must find the same corners of triangles to within :data:`TOLERANCE`, and as many triangles. It leaves out those
    of which two corners are the same. How polygons are cut into triangles may differ.

    Args:
        file: Path of a mesh, in any format that assimp reads.
        vertices: What was read (n, 3), with the unit and the axes of the file.
        faces: The triangles (m, 3), as indices of vertices.

    Raises:
        ValueError: If assimp does not read the file, or reads something else; the message says what both have read.
    """
    used = vertices[np.unique(faces)]
    ours = _said(used, len(faces))
    try:
        found, count = _read(file)
    except Exception as error:  # whatever assimp and the file system raise
        reason = " ".join(str(error).split("message:")[-1].split("Hint:")[0].split()) or type(error).__name__
        what = f"a mesh file that both trimesh and assimp can read: trimesh reads {ours}, assimp fails ({reason})"
        raise ValueError(f"{what}. {INSTEAD}") from error
    corners = vertices[faces].astype(np.float32)
    lines = int((corners == np.roll(corners, 1, axis=1)).all(axis=2).any(axis=1).sum())
    rounding = TOLERANCE * float(np.abs(used).max())
    if not len(faces) - lines <= count <= len(faces) or _apart(found, used) > rounding:
        what = f"a mesh file of which trimesh and assimp read the same: trimesh reads {ours}, assimp"
        raise ValueError(f"{what} {_said(found, count)}. One of them loses or moves a part. {INSTEAD}")


def _read(file: str) -> tuple[Array, int]:
    """Return the vertices (n, 3) and the number of triangles that assimp reads, with the file's unit and axes."""
    import coal  # here, not above: few scenes hold a mesh

    # Of coal's bounding volumes these are made fastest. Its triangles are of no use: where a node has several meshes,
    # their corners are wrong.
    loader = coal.MeshLoader(coal.NODE_TYPE.BV_AABB)
    if Path(file).suffix.lower() not in (".gltf", ".glb"):
        found = loader.load(file, np.ones(3))
    else:
        # coal leaves out the transform of the root, and assimp makes a single node of a scene the root.
        with TemporaryDirectory() as folder:
            copy = Path(folder) / "mesh.gltf"
            copy.write_text(json.dumps(with_empty_root(Path(file))), encoding="utf-8")
            found = loader.load(str(copy), np.ones(3))
    return np.array(found.vertices(), float).reshape(-1, 3), int(found.num_tris)


def _apart(one: Array, other: Array) -> float:
    """Return how far a point of one set is from the other set at most: infinite if one is empty or has no number."""
    if not len(one) or not len(other) or not np.isfinite(one).all():
        return np.inf
    return max(float(np.max(cKDTree(a).query(b)[0])) for a, b in ((one, other), (other, one)))


def _said(vertices: Array, triangles: int) -> str:
    if not len(vertices):
        return "nothing"
    low, high = (" ".join(f"{x:.6g}" for x in bound) for bound in (vertices.min(axis=0), vertices.max(axis=0)))
    return f"{triangles} triangles from ({low}) to ({high})"
