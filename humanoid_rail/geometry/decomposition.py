"""CoACD in a process of its own, and its results on disk."""

from __future__ import annotations

import hashlib
import json
import signal
import subprocess
import sys
from collections.abc import Mapping
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from humanoid_rail._arrays import Array
from humanoid_rail.geometry import kept
from humanoid_rail.geometry.mesh_files import Triangles
from humanoid_rail.progress import progress

CONCAVITY = 0.05
"""CoACD leaves at most this concavity in a piece, relative to the size of the mesh."""
OPTIONS: Mapping[str, float | str] = {"threshold": CONCAVITY, "seed": 0}
"""The options of CoACD that are not its defaults."""
BUDGET = 600
"""A decomposition may take this much processor time, s; one that takes more is refused and gives no other result."""
WORKER = Path(__file__).with_name("coacd_worker.py")
"""The program that decomposes."""


def decompose(solid: Triangles, name: str, budget: int = BUDGET) -> list[Array]:
    """Return the vertices (k, 3) of the pieces that CoACD makes of a solid, m.

    Results are kept in the user's cache folder (`$XDG_CACHE_HOME/humanoid_rail`, else `~/.cache/humanoid_rail`), by the
    content of the mesh, the options and the version of CoACD.

    Args:
        solid: A closed surface.
        name: What messages call the mesh.
        budget: Processor time that it may take, s.

    Raises:
        ValueError: If it cannot be decomposed within the budget; the message says what would be valid.
    """
    file = cache_folder() / f"{_key(solid)}.npz"
    try:
        return kept.read_bodies(file)
    except Exception:  # it is not there or damaged, and a damaged archive may raise anything: made anew
        pieces = _run(solid, name, budget)
    # Without a cache everything works, and takes longer.
    with suppress(OSError):
        kept.keep_bodies(pieces, file)
    return pieces


def cache_folder() -> Path:
    """Return the folder that results are kept in."""
    return kept.cache_folder("convex_pieces")


def forget(solid: Triangles) -> None:
    """Remove the result of a solid from the cache, if it is there."""
    with suppress(OSError):
        (cache_folder() / f"{_key(solid)}.npz").unlink()


def _key(solid: Triangles) -> str:
    said = json.dumps([dict(OPTIONS), version("coacd"), solid.vertices.shape, solid.faces.shape], sort_keys=True)
    content = said.encode() + solid.vertices.astype("<f8").tobytes() + solid.faces.astype("<i8").tobytes()
    return hashlib.sha256(content).hexdigest()


def _run(solid: Triangles, name: str, budget: int) -> list[Array]:
    """Decompose a solid in a process that ends with this function, however it ends."""
    with TemporaryDirectory(prefix="humanoid_rail-") as folder, progress(f"cutting {name} into convex pieces"):
        mesh, pieces = Path(folder) / "mesh.npz", Path(folder) / "pieces.npz"
        np.savez(mesh, vertices=solid.vertices, faces=solid.faces)
        # Without -P modules beside the program would hide others of the same names.
        command = [sys.executable, "-P", str(WORKER), str(mesh), str(pieces), json.dumps(dict(OPTIONS)), str(budget)]
        with subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE
        ) as process:
            try:
                # Not communicate(), which lets a process go on for a while after an interrupt.
                said = process.stderr.read().decode(errors="replace") if process.stderr else ""
            except BaseException:
                process.kill()
                raise
        code = process.returncode
        if code == -signal.SIGXCPU:
            raise ValueError(
                f"a mesh that can be cut into convex pieces within {budget} s of processor time: one of fewer "
                f"triangles (a part has {len(solid.faces)}), or one that consists of convex parts"
            )
        if code != 0 or not pieces.exists():
            last = (said.strip().splitlines() or [f"exit code {code}"])[-1]
            raise ValueError(f"a mesh that can be cut into convex pieces ({last})")
        return kept.read_bodies(pieces)
