from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull

from humanoid_rail.geometry.mesh_files import load, unit


@dataclass(frozen=True, eq=False)
class MeshBodies:
    pieces: tuple
    swelling: float = 0.0
    hull_share: float = 1.0


def mesh_hull(file, scale):
    m = load(str(file)).to_mesh()
    v = np.asarray(m.vertices) * unit(str(file)) * np.array(scale)
    h = ConvexHull(v)
    p = v[h.vertices]
    if len(p) > 64:
        i = np.unique((p @ np.random.default_rng(0).normal(size=(3, 200))).argmax(0))
        p = p[i]
    return MeshBodies((p,))


mesh_pieces = mesh_hull
