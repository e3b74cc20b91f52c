"""Finds out what no file says of a robot: convex bodies of its meshes, pairs that need no checks, a free start."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, tostring

import numpy as np
import pinocchio as pin

from humanoid_rail._arrays import Array
from humanoid_rail.errors import InvalidInput
from humanoid_rail.geometry.mesh_bodies import MOST_SWELLING, THICKENED, mesh_hull, mesh_pieces, saved_hull
from humanoid_rail.geometry.mesh_files import files_of, warn_of_size
from humanoid_rail.geometry.solids import size_of
from humanoid_rail.model import cache
from humanoid_rail.model.building import Mechanism
from humanoid_rail.model.collision_bodies import Pieces, collision_bodies
from humanoid_rail.model.found_pairs import FoundPairs, find_pairs, possible_pairs
from humanoid_rail.model.free_start import free_start
from humanoid_rail.model.lost_postures import Lost, Originals
from humanoid_rail.model.robot_file import RobotFile
from humanoid_rail.model.survey import POSTURES, random_postures, survey
from humanoid_rail.model.urdf import Urdf
from humanoid_rail.model.urdf_link import MeshFile, UrdfBody

MOST_LOST = 0.05
"""Hulls may lose this share of other random postures that are free by the meshes; then the worst mesh is decomposed."""
LEAST_LOST = 0.02
"""Meshes are decomposed until no more than this share is lost."""
LEAST_GAIN = 0.9
"""A mesh is not decomposed if more than this share of what was lost still is."""
MOST_ROUNDS = 8
"""So often meshes are decomposed and what is lost is measured again."""
TIMES_CUT = 2
"""A mesh is cut roughly, and if it still costs much, finely."""
CLOSE_POSTURES = 1600
"""So many random postures are looked at where the usual ones leave open whether too many are lost."""
LARGE = 10.0
"""A mesh of a robot that is larger than this is probably not in metres, m."""


@dataclass(frozen=True, eq=False)
class Examined:
    """What was found out about a robot."""

    bodies: pin.GeometryModel
    pairs: FoundPairs
    start: Array
    """Where motions start (n,), m and rad."""
    found: tuple[str, ...]
    """What was found, in sentences."""


@dataclass(frozen=True, eq=False)
class _Looked:
    """What bodies make of random postures."""

    decomposed: Sequence[str]
    """The meshes that are to be cut, by where they are in the URDF; twice, if finely."""
    pieces: Mapping[str, Pieces]
    """The convex pieces of each mesh; one of a mesh that is left whole."""
    bodies: pin.GeometryModel
    pairs: FoundPairs
    lost: Lost | None
    """None if it does not matter."""


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
    written = {body.where: body for link in mechanism.urdf.links.values() for body in link.collisions if _is_mesh(body)}
    is_cut_as_said = file.decomposed is not None or not written
    if is_cut_as_said and file.initial is not None and file.pairs.complete:
        asked = _asked_for(mechanism.urdf, file)
        bodies = collision_bodies(mechanism.model, mechanism.urdf, _pieces(written, meshes, asked, file.as_written))
        pairs = find_pairs(mechanism.model, bodies, mechanism.urdf, None, None, file.pairs)
        return Examined(bodies, pairs, starts[0][1], ())
    said = [
        mechanism.urdf.text,
        "" if srdf is None else tostring(srdf, encoding="unicode"),
        file.model_dump_json(exclude={"urdf", "srdf", "package", "packages"}),
        *(repr((why, q.tolist())) for why, q in starts),
    ]
    key = cache.key_of(said, _files(written.values(), meshes))
    known = cache.kept(key)
    if known is None:
        known = _look(mechanism, srdf, file, meshes, written, starts)
        cache.keep(key, known)
    pairs = FoundPairs(
        {frozenset((a, b)): why for a, b, why in known["left_out"]},
        {(i, j): distance for i, j, distance in known["distances"]},
    )
    bodies = collision_bodies(mechanism.model, mechanism.urdf, _pieces(written, meshes, known["decomposed"]))
    return Examined(bodies, pairs, np.array(known["start"]), tuple(known["found"]))


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
    lower, upper = mechanism.limits.lower, mechanism.limits.upper
    originals, is_cut_as_said = Originals(mechanism, meshes), file.decomposed is not None or not written

    def look(decomposed: Sequence[str], count: int, limit: float) -> _Looked:
        pieces = _pieces(written, meshes, decomposed)
        bodies = collision_bodies(model, urdf, pieces)
        possible = possible_pairs(bodies)
        seen = survey(model, bodies, possible, random_postures(lower, upper), full)
        pairs, lost = find_pairs(model, bodies, urdf, srdf, None if file.pairs.complete else seen, file.pairs), None
        if not is_cut_as_said:
            lost = originals.lost(bodies, pairs.left_out, seen)
            if count > POSTURES or lost.share <= limit < lost.most:
                seen = survey(model, bodies, possible, random_postures(lower, upper, CLOSE_POSTURES), full, 0.0)
                lost = originals.lost(bodies, pairs.left_out, seen)
        return _Looked(decomposed, pieces, bodies, pairs, lost)

    best = look(_asked_for(urdf, file), POSTURES, MOST_LOST)
    tried = Counter(best.decomposed)
    for _ in range(MOST_ROUNDS):
        limit = LEAST_LOST if best.decomposed else MOST_LOST
        if best.lost is None or best.lost.most <= limit:
            break
        worst = _worst(best.lost, written, tried)
        if not worst:
            break
        tried.update(worst)
        others = [where for where in best.decomposed if where not in worst]
        after = look([*others, *(w for where in worst for w in tried[where] * [where])], best.lost.postures, LEAST_LOST)
        best = after if _is_better(after, best) else best
    decomposed, bodies, pairs, lost = best.decomposed, best.bodies, best.pairs, best.lost
    start, why = free_start(mechanism, bodies, pairs, starts, is_given=file.initial is not None)
    found = [] if file.initial is not None else [f"Motions start at {why}."]
    if lost:
        if lost.share > MOST_LOST:
            warnings.warn(
                f"convex bodies lose {lost.share:.1%} of the free postures of {mechanism.model.name}", stacklevel=2
            )
        found.append(
            f"Convex bodies lose {lost.share:.1%} of the {lost.free} of {lost.postures} random postures that are free "
            "by the meshes."
        )
    for is_cut, said in ((True, "Cut into convex pieces"), (False, "Left whole, as pieces would save too little")):
        if named := [where for where in dict.fromkeys(decomposed) if (len(best.pieces[where]) > 1) is is_cut]:
            found.append(f"{said}: the meshes of {', '.join(named)}.")
    return _data(decomposed, pairs, start, found)


def _is_better(looked: _Looked, before: _Looked) -> bool:
    """Return whether more cuts have saved enough, or made pairs that were left out ones that are checked."""
    assert looked.lost is not None
    assert before.lost is not None
    if looked.lost.postures != before.lost.postures or looked.pairs.left_out.keys() != before.pairs.left_out.keys():
        return True
    return looked.lost.share <= LEAST_GAIN * before.lost.share


def _worst(lost: Lost, written: Mapping[str, UrdfBody], tried: Mapping[str, int]) -> list[str]:
    """Return the meshes that cost most and can be cut more: one, and those that cost at least half as much."""
    able = (where for where in lost.blamed if where in written and tried.get(where, 0) < TIMES_CUT)
    blamed = {where: lost.blamed[where] for where in able}
    return sorted(where for where, count in blamed.items() if 2 * count >= max(blamed.values()))


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
    """Return the files that the shapes of meshes are in."""
    names = {body.shape.filename for body in bodies if isinstance(body.shape, MeshFile)}
    return [file for name in sorted(names) for file in files_of(str(meshes[name]))]


def _pieces(
    written: Mapping[str, UrdfBody], meshes: Mapping[str, Path], decomposed: Sequence[str], are_saved: bool = False
) -> dict[str, Pieces]:
    """Return the convex pieces of meshes; those of a robot that was saved are its bodies already."""
    pieces: dict[str, Pieces] = {}
    for where, body in written.items():
        assert isinstance(body.shape, MeshFile)
        file, scale, times_cut = meshes[body.shape.filename], body.shape.scale, decomposed.count(where)
        try:
            if times_cut:
                made = mesh_pieces(file, scale, times_cut > 1)
            else:
                made = (saved_hull if are_saved else mesh_hull)(file, scale)
        except ValueError as error:
            raise InvalidInput(f"{where}.geometry.mesh.filename", str(file), str(error)) from error
        if made.swelling > MOST_SWELLING + 2.0 * THICKENED:
            warnings.warn(f"the body of {where} reaches {1e3 * made.swelling:.1f} mm out of its mesh", stacklevel=2)
        warn_of_size(str(file), size_of(np.vstack(made.pieces)), LARGE)
        pieces[where] = made.pieces
    return pieces


def _asked_for(urdf: Urdf, file: RobotFile) -> list[str]:
    """Return the meshes of the links that a robot file wants to have decomposed."""
    for link in file.decomposed or ():
        if link not in urdf.links:
            raise InvalidInput("decomposed", link, "links of the URDF")
    links = [urdf.links[name] for name in file.decomposed or ()]
    return [body.where for link in links for body in link.collisions if _is_mesh(body)]
