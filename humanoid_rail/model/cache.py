"""What was found out about robots, kept on disk."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any

from humanoid_rail.geometry import mesh_bodies
from humanoid_rail.geometry.kept import cache_folder, write_whole

VERSION = 5
"""Of what is kept: higher whenever the same files give other findings."""


def key_of(texts: Iterable[str], files: Iterable[Path]) -> str:
    """Return a name for what texts and the content of files say together. Files that are not there say nothing."""
    digest = hashlib.sha256(f"{VERSION} {mesh_bodies.VERSION}".encode())
    for text in texts:
        digest.update(f"{len(text)} ".encode() + text.encode())
    for file in files:
        content = file.read_bytes() if file.is_file() else b""  # who reads the mesh says what is missing
        digest.update(f"{len(content)} ".encode() + content)
    return digest.hexdigest()


def kept(key: str) -> dict[str, Any] | None:
    """Return what is kept by a name; None if nothing is, or it is damaged."""
    try:
        found = json.loads(_file(key).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    data = found.get("data") if isinstance(found, dict) else None
    return data if isinstance(data, dict) and found.get("digest") == _digest(data) else None


def keep(key: str, data: dict[str, Any]) -> None:
    """Keep data by a name, in the user's cache folder. Without one everything works, and takes longer."""
    with suppress(OSError):
        write_whole(_file(key), json.dumps({"digest": _digest(data), "data": data}).encode())


def _digest(data: dict[str, Any]) -> str:
    return hashlib.sha256(json.dumps(data, sort_keys=True).encode()).hexdigest()


def _file(key: str) -> Path:
    return cache_folder("robots") / f"{key}.json"
