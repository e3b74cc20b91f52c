"""Whether a signal asks this process to end."""

from __future__ import annotations

import threading

END_ASKED = threading.Event()
"""Set by handlers of signals before they raise: Python ignores what is raised while an object is taken apart, and what
runs without an end would go on."""
