"""A page served to browsers on this machine."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

from humanoid_rail.errors import HumanoidRailError

HOST = "127.0.0.1"
"""Nobody else can reach it."""


@contextmanager
def served(page: str) -> Iterator[str]:
    """Serve a page, in a thread of this process, at a port that is free.

    Args:
        page: The page, as HTML.

    Yields:
        Its URL.

    Raises:
        HumanoidRailError: If no port can be served.
    """
    content = page.encode()

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            is_page = self.path == "/"
            self.send_response(200 if is_page else 404)
            self.send_header("Content-Type", "text/html; charset=utf-8")
            self.send_header("Content-Length", str(len(content) if is_page else 0))
            self.end_headers()
            if is_page:
                self.wfile.write(content)

        def log_message(self, format: str, *args: object) -> None:
            """Print nothing."""

    try:
        server = _Server((HOST, 0), Handler)
    except OSError as error:
        raise HumanoidRailError(f"the playback cannot be served at {HOST}: {error}") from error
    threading.Thread(target=_serve, args=(server,), daemon=True).start()
    try:
        yield f"http://{HOST}:{server.server_port}/"
    finally:
        server.shutdown()
        server.server_close()


class _Server(ThreadingHTTPServer):
    daemon_threads = True

    def handle_error(self, request: object, client_address: object) -> None:
        """Say nothing of a browser that goes away while it reads."""
        if not isinstance(sys.exc_info()[1], ConnectionError):
            super().handle_error(request, client_address)  # type: ignore[arg-type]


def _serve(server: _Server) -> None:
    """Answer requests; the threads that do inherit that SIGPIPE is blocked."""
    if hasattr(signal, "SIGPIPE"):
        # A command ends by it where nobody reads its output. A browser that goes away is no such end.
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGPIPE})
    server.serve_forever()
