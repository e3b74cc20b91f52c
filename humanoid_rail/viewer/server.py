"""The meshcat server, a process of its own, and the connection to it."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryFile
from typing import IO

import meshcat
from meshcat.visualizer import ViewerWindow

from humanoid_rail.errors import HumanoidRailError

_COMMAND = (sys.executable, "-u", "-m", "humanoid_rail.viewer.server_process")


@contextmanager
def meshcat_server() -> Iterator[meshcat.Visualizer]:
    """Run a meshcat server, which is a process of its own, and end it whatever happens, even to this process.

    Yields:
        What draws in it. It may be used in one thread only, but each thread may have a server of its own.

    Raises:
        HumanoidRailError: If the server does not start.
    """
    folders = [str(file.resolve().parent.parent) for file in (Path(meshcat.__file__), Path(__file__).parent)]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(folders)}
    with TemporaryFile() as log:  # a pipe that nobody reads would stop the server once it is full
        server = subprocess.Popen(
            (*_COMMAND, str(os.getpid())),
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=log,
            start_new_session=True,  # Ctrl-C is for the caller, who ends the server then
        )
        try:
            # In the order in which the server prints them.
            addresses = [_address(name, server, log) for name in ("zmq_url", "web_url")]
            window = _Window(*addresses)
            try:
                yield meshcat.Visualizer(window=window)
            finally:
                window.zmq_socket.close(linger=0)
        finally:
            server.kill()
            server.communicate()


def _address(name: str, server: subprocess.Popen[bytes], log: IO[bytes]) -> str:
    """Return an address that a server prints as `NAME=ADDRESS` when it has started."""
    assert server.stdout is not None
    for line in server.stdout:
        key, _, address = line.decode().strip().partition("=")
        if key == name:
            return address
    log.seek(0)
    last = log.read().decode(errors="replace").strip().splitlines()[-1:]
    raise HumanoidRailError(f"the meshcat server of the playback ended before it said where it is: {' '.join(last)}")


class _Window(ViewerWindow):  # type: ignore[misc]  # meshcat has no types
    """A connection to a running server. Unlike meshcat's own it prints nothing.

    Redirecting what meshcat prints would not do: stdout is one for all threads.
    """

    def __init__(self, zmq_url: str, web_url: str) -> None:
        self.server_proc, self.zmq_url, self.web_url = None, zmq_url, web_url
        self.connect_zmq()
