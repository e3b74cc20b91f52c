"""Serves a live page until it is interrupted."""

from __future__ import annotations

import errno
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from importlib.util import find_spec
from typing import TYPE_CHECKING, NamedTuple

from humanoid_rail._called import pip_install
from humanoid_rail._signals import END_ASKED, interruptible
from humanoid_rail.errors import HumanoidRailError, InvalidInput, checked_number
from humanoid_rail.live.session import Session
from humanoid_rail.live.world import World
from humanoid_rail.model.robot import Robot
from humanoid_rail.scene.scene import Scene

if TYPE_CHECKING:
    from humanoid_rail.live.page import Page

LOOPBACK = "127.0.0.1"
"""Only this machine reaches the page, unless another address is asked for."""
LAST_PORT = 65535
"""The last port."""
TAKEN = (errno.EADDRINUSE, errno.EACCES)
"""What is said of a port that another one listens at, or that only the system may use."""
FRAME = 1.0 / 30.0
"""The page shows another moment after this time, s."""


class Live(NamedTuple):
    """A live page that is served."""

    session: Session
    """What a user does, and what comes of it."""
    page: Page
    """What the browsers show."""
    url: str
    """Where it is."""


@contextmanager
def serving(robot: Robot, scene: Scene, *, host: str = LOOPBACK, port: int = 8080) -> Iterator[Live]:
    """Serve a live page, and end all of it afterwards.

    Args:
        robot: The robot.
        scene: The scene to begin with.
        host: The address to listen at. Whoever reaches it moves what is in the page; there is no password.
        port: The port to listen at; the next free one if it is taken.

    Yields:
        The page. What is done to its session is shown, and the other way round.

    Raises:
        InvalidInput: If the scene is not one for this robot, or nothing can listen at the address.
        HumanoidRailError: If viser is not installed.
    """
    if find_spec("viser") is None:
        raise HumanoidRailError(f"the live page needs viser: {pip_install('humanoid_rail[live]')}")
    checked_number("port", port, least=1, most=LAST_PORT)
    port = free_port(host, port)
    session = Session(World.of(robot, scene))
    try:
        # Imported here: it is an extra, and takes long.
        import viser

        from humanoid_rail.live.page import Page

        server = viser.ViserServer(host=host, port=port, verbose=False)
        ends = threading.Event()
        try:
            page = Page(server, session)
            ticker = threading.Thread(target=_tick, args=(page.show, session, ends), name="humanoid_rail live page")
            ticker.start()
            try:
                yield Live(session, page, f"http://{f'[{host}]' if ':' in host else host}:{server.get_port()}")
            finally:
                ends.set()
                ticker.join()
        finally:
            server.stop()
    finally:
        session.close()


def serve(
    robot: Robot,
    scene: Scene,
    *,
    host: str = LOOPBACK,
    port: int = 8080,
    on_ready: Callable[[str], None] = lambda url: None,
) -> None:
    """Serve a live page until interrupted (Ctrl-C, or the signals TERM and HUP); see :func:`serving`."""
    with interruptible(), suppress(KeyboardInterrupt), serving(robot, scene, host=host, port=port) as live:
        on_ready(live.url)
        while not END_ASKED.wait(0.5):
            pass


def free_port(host: str, port: int) -> int:
    """Return the first port from this one on that is free. The thread of viser's that looks for one may die of it.

    Raises:
        InvalidInput: If there is none, or nothing can listen at the address.
    """
    for free in range(port, LAST_PORT + 1):
        try:
            _listen(host, free)
        except (OSError, UnicodeError) as error:
            if getattr(error, "errno", None) not in TAKEN:
                raise InvalidInput("host", host, f"an address of this machine ({error})") from error
        else:
            return free
    raise InvalidInput("port", port, "a port that is free, or one below that")


def _listen(host: str, port: int) -> None:
    """Listen at all that a name stands for, and end it at once."""
    if not host:
        raise OSError("it is empty")
    for family, *_, address in socket.getaddrinfo(host, port, type=socket.SOCK_STREAM):
        socket.create_server(address, family=family).close()


def _tick(show: Callable[..., None], session: Session, ends: threading.Event) -> None:
    last = time.monotonic()
    while not ends.wait(FRAME):
        now = time.monotonic()
        try:
            show(session.tick(now - last))
        except Exception as error:  # shown in the page, which goes on
            session.failed(error)
        last = now
