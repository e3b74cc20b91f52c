"""The meshcat server as `python -m humanoid_rail.viewer.server_process PARENT`: it ends with the process PARENT."""

from __future__ import annotations

import runpy
import sys

from humanoid_rail._parent import end_with_parent


def main() -> None:
    """Serve until the process ends that is named by the argument."""
    end_with_parent(int(sys.argv.pop()))
    runpy.run_module("meshcat.servers.zmqserver", run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main()
