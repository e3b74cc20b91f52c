"""Triangle meshes as coal has them: surfaces without an inside."""

from __future__ import annotations

from pathlib import Path

import coal

from humanoid_rail.geometry.mesh_files import read_triangles


def mesh_surface(file: str | Path, scale: tuple[float, float, float]) -> coal.BVHModelOBBRSS:
    """Return the surface of a mesh, to see what touches it, with factors along its axes."""
    vertices, faces = read_triangles(str(file), z_up=False)
    surface = coal.BVHModelOBBRSS()
    surface.beginModel(len(faces), len(vertices))
    surface.addVertices(vertices * scale)
    surface.addTriangles(faces)
    surface.endModel()
    return surface
