"""Finds out what no file says of a robot: convex bodies of its meshes, pairs that need no checks, a free start."""

from __future__ import annotations

import functools
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, tostring

import coal
import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput
from humanoid_rail.geometry.mesh_bodies import mesh_hull, mesh_pieces
from humanoid_rail.geometry.mesh_surface import mesh_surface
from humanoid_rail.model import cache
from humanoid_rail.model.building import Mechanism
from humanoid_rail.model.collision_bodies import Pieces, collision_bodies
from humanoid_rail.model.found_pairs import FoundPairs, find_pairs, possible_pairs
from humanoid_rail.model.free_start import free_start
from humanoid_rail.model.robot_file import RobotFile
from humanoid_rail.model.survey import Survey, meshes_touch, random_postures, survey
from humanoid_rail.model.urdf import Urdf
from humanoid_rail.model.urdf_link import MeshFile, UrdfBody

MOST_LOST = 0.05
"""Hulls may lose this share of the postures that are free by the meshes; then the worst mesh is decomposed."""
LEAST_LOST = 0.02
"""Meshes are decomposed until no more than this share is lost."""
MOST_DECOMPOSED = 6
"""No more meshes than this are decomposed."""


@dataclass(frozen=True, eq=False)
class Examined:
    """What was found out about a robot."""

    bodies: pin.GeometryModel
    pairs: FoundPairs
    start: Array
    """Where motions start (n,), m and rad."""
    found: tuple[str, ...]
    """What was found, in sentences."""


def examine(
    mechanism: Mechanism,
    srdf: Element | None,
    file: RobotFile,
    meshes: Mapping[str, Path],
    starts: Sequence[tuple[str, Array]],
) -> Examined:
    """Return what no file says of a robot. It is kept in the user's cache folder, by the content of all files.

    Nothing is looked for if the robot file gives pairs, start and which meshes are cut, as that of a saved robot does.

    Args:
        mechanism: How its joints move.
        srdf: Its SRDF, if any.
        file: Its robot file.
        meshes: The files of the meshes by their names.
        starts: Where motions could start, and what each place is called; the only one if it is given.

    Raises:
        InvalidInput: If a mesh cannot be read, or there is no start at which nothing touches.
    """
    urdf = mechanism.urdf
    bodies = {body.where: body for link in urdf.links.values() for body in link.collisions if _is_mesh(body)}
    known = _given(mechanism, file, meshes, bodies, starts) or _kept(mechanism, srdf, file, meshes, bodies, starts)
    pieces = {where: _pieces(body, meshes, where in known["decomposed"]) for where, body in bodies.items()}
    pairs = FoundPairs(
        {frozenset((a, b)): why for a, b, why in known["left_out"]},
        {(i, j): distance for i, j, distance in known["distances"]},
    )
    made = collision_bodies(mechanism.model, urdf, pieces)
    return Examined(made, pairs, np.array(known["start"]), tuple(known["found"]))


def _given(
    mechanism: Mechanism,
    file: RobotFile,
    meshes: Mapping[str, Path],
    written: Mapping[str, UrdfBody],
    starts: Sequence[tuple[str, Array]],
) -> dict[str, Any] | None:
    """Return what a robot file says if nothing has to be found out, as that of a robot that was saved; else None."""
    is_cut_as_said = file.decomposed is not None or not written
    if not is_cut_as_said or file.initial is None or not file.pairs.complete:
        return None
    decomposed = _asked_for(mechanism.urdf, file)
    pieces = {where: _pieces(body, meshes, where in decomposed) for where, body in written.items()}
    bodies = collision_bodies(mechanism.model, mechanism.urdf, pieces)
    pairs = find_pairs(mechanism.model, bodies, mechanism.urdf, None, None, file.pairs)
    return _data(decomposed, pairs, starts[0][1], [])


def _kept(
    mechanism: Mechanism,
    srdf: Element | None,
    file: RobotFile,
    meshes: Mapping[str, Path],
    bodies: Mapping[str, UrdfBody],
    starts: Sequence[tuple[str, Array]],
) -> dict[str, Any]:
    """Return what is found out, from the user's cache folder if it is there."""
    said = [
        mechanism.urdf.text,
        "" if srdf is None else tostring(srdf, encoding="unicode"),
        file.model_dump_json(exclude={"urdf", "srdf", "package", "packages"}),
    ]
    key = cache.key_of([*said, *(repr((why, q.tolist())) for why, q in starts)], _files(bodies.values(), meshes))
    known = cache.kept(key)
    if known is None:
        known = _look(mechanism, srdf, file, meshes, bodies, starts)
        cache.keep(key, known)
    return known


def _look(
    mechanism: Mechanism,
    srdf: Element | None,
    file: RobotFile,
    meshes: Mapping[str, Path],
    written: Mapping[str, UrdfBody],
    starts: Sequence[tuple[str, Array]],
) -> dict[str, Any]:
    """Return what is found out, as data that JSON can hold."""
    model, urdf, full = mechanism.model, mechanism.urdf, mechanism.full_configuration
    postures = random_postures(mechanism.limits.lower, mechanism.limits.upper)
    decomposed = _asked_for(urdf, file)
    lost: list[float] = []
    while True:
        pieces = {where: _pieces(body, meshes, where in decomposed) for where, body in written.items()}
        bodies = collision_bodies(model, urdf, pieces)
        seen = survey(model, bodies, possible_pairs(bodies), postures, full)
        pairs = find_pairs(model, bodies, urdf, srdf, None if file.pairs.complete else seen, file.pairs)
        if file.decomposed is not None or not written:
            break
        share, worst = _lost(mechanism, bodies, meshes, pairs, seen, decomposed)
        lost.append(share)
        enough = MOST_LOST if len(lost) == 1 else LEAST_LOST
        if share <= enough or worst is None or len(decomposed) >= MOST_DECOMPOSED:
            break
        decomposed = [*decomposed, worst]
    start, why = free_start(mechanism, bodies, pairs, starts, is_given=file.initial is not None)
    found = [] if file.initial is not None else [f"Motions start at {why}."]
    if lost:
        found.append(
            f"Convex bodies lose {lost[-1]:.1%} of {len(postures)} random postures that are free by the meshes."
        )
    if decomposed:
        found.append(f"Cut into convex pieces: the meshes of {', '.join(decomposed)}.")
    return _data(decomposed, pairs, start, found)


def _data(decomposed: Sequence[str], pairs: FoundPairs, start: Array, found: Sequence[str]) -> dict[str, Any]:
    return {
        "decomposed": list(decomposed),
        "left_out": [[*sorted(pair), why] for pair, why in pairs.left_out.items()],
        "distances": [[*pair, distance] for pair, distance in pairs.distances.items()],
        "start": start.tolist(),
        "found": list(found),
    }


def _is_mesh(body: UrdfBody) -> bool:
    return isinstance(body.shape, MeshFile)


def _files(bodies: Iterable[UrdfBody], meshes: Mapping[str, Path]) -> list[Path]:
    names = {body.shape.filename for body in bodies if isinstance(body.shape, MeshFile)}
    return [meshes[name] for name in sorted(names)]


def _pieces(body: UrdfBody, meshes: Mapping[str, Path], is_decomposed: bool) -> Pieces:
    assert isinstance(body.shape, MeshFile)
    make = mesh_pieces if is_decomposed else mesh_hull
    try:
        return make(meshes[body.shape.filename], body.shape.scale).pieces
    except ValueError as error:
        file = str(meshes[body.shape.filename])
        raise InvalidInput(f"{body.where}.geometry.mesh.filename", file, str(error)) from error


def _asked_for(urdf: Urdf, file: RobotFile) -> list[str]:
    """Return the meshes of the links that a robot file wants to have decomposed."""
    for link in file.decomposed or ():
        if link not in urdf.links:
            raise InvalidInput("decomposed", link, "links of the URDF")
    links = [urdf.links[name] for name in file.decomposed or ()]
    return [body.where for link in links for body in link.collisions if _is_mesh(body)]


def _lost(
    mechanism: Mechanism,
    bodies: pin.GeometryModel,
    meshes: Mapping[str, Path],
    pairs: FoundPairs,
    seen: Survey,
    decomposed: Sequence[str],
) -> tuple[float, str | None]:
    """Return which share of the postures that are free by the meshes is not by the bodies, and the worst mesh."""
    links = [mechanism.model.frames[body.parentFrame].name for body in bodies.geometryObjects]
    checked = np.array([frozenset((links[i], links[j])) not in pairs.left_out for i, j in seen.pairs], bool)
    sources = _sources(mechanism.urdf, bodies, links)

    @functools.cache
    def surface(index: int) -> coal.CollisionGeometry:
        body = sources[index]
        if isinstance(body.shape, MeshFile):
            return mesh_surface(meshes[body.shape.filename], body.shape.scale)
        return bodies.geometryObjects[index].geometry

    free, lost, blamed = 0, 0, Counter[str]()
    for q, touches in zip(seen.postures, seen.touching() & checked, strict=True):
        touching = [seen.pairs[k] for k in np.flatnonzero(touches)]
        if touching and meshes_touch(mechanism.model, bodies, surface, touching, mechanism.full_configuration(q)):
            continue
        free += 1
        if touching:
            lost += 1
            wheres = {sources[index].where for pair in touching for index in pair if _is_mesh(sources[index])}
            blamed.update(where for where in wheres if where not in decomposed)
    worst = blamed.most_common(1)
    return (lost / free if free else 0.0), (worst[0][0] if worst else None)


def _sources(urdf: Urdf, bodies: pin.GeometryModel, links: Sequence[str]) -> list[UrdfBody]:
    """Return for each body the element of the URDF that it stands for."""
    found = []
    for body, link in zip(bodies.geometryObjects, links, strict=True):
        number = body.name.removeprefix(f"{link}_").partition(".")[0]
        found.append(urdf.links[link].collisions[int(number)])
    return found
