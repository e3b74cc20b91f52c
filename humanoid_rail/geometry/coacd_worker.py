"""A program that decomposes a mesh by CoACD: a process of its own, which can be interrupted and has a budget.

Its arguments are the file of the mesh (vertices, faces), the file for the pieces, CoACD's options as JSON, and its
budget in seconds of processor time. It ends when its standard input does, which is when its parent ends.
"""

from __future__ import annotations

import json
import os
import resource
import signal
import sys
import threading


def main(mesh_file: str, pieces_file: str, options: str, budget: str) -> None:
    """Decompose a mesh."""
    resource.setrlimit(resource.RLIMIT_CPU, (int(budget), int(budget) + 5))
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent hears of it too, and ends this
    threading.Thread(target=_end_with_parent, daemon=True).start()
    import coacd
    import numpy as np

    coacd.set_log_level("error")
    mesh = np.load(mesh_file)
    pieces = coacd.run_coacd(coacd.Mesh(mesh["vertices"], mesh["faces"]), **json.loads(options))
    np.savez(pieces_file, *(vertices for vertices, _ in pieces))


def _end_with_parent() -> None:
    os.read(sys.stdin.fileno(), 1)
    os._exit(1)


if __name__ == "__main__":
    main(*sys.argv[1:])
