"""A page served to browsers on this machine."""

from __future__ import annotations

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
        server = ThreadingHTTPServer((HOST, 0), Handler)
    except OSError as error:
        raise HumanoidRailError(f"the playback cannot be served at {HOST}: {error}") from error
    server.daemon_threads = True
    threading.Thread(target=server.serve_forever, daemon=True).start()
    try:
        yield f"http://{HOST}:{server.server_port}/"
    finally:
        server.shutdown()
        server.server_close()
