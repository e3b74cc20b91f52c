"""What tests read out of a playback page."""

from __future__ import annotations

import base64
import gzip
import json
import re
from io import BytesIO
from typing import Any

import numpy as np
import pytest
import umsgpack
from PIL import Image
from screenshot import browser_path

needs_browser = pytest.mark.skipif(browser_path() is None, reason="Chromium (Debian: chromium) is not installed")


def pixels(page: Any) -> np.ndarray:
    return np.asarray(Image.open(BytesIO(page.screenshot())).convert("RGB")).astype(int)


def share(image: np.ndarray, rgb: tuple[int, int, int], tolerance: int = 40) -> float:
    """Return the share of pixels that have about this colour."""
    return float((abs(image - rgb).max(axis=2) < tolerance).mean())


def commands(page: str) -> list[dict[str, Any]]:
    """Return what a page tells meshcat to draw."""
    (blob,) = re.findall(r'fetch\("data:application/gzip;base64,([^"]+)"', page)
    stream, found = BytesIO(gzip.decompress(base64.b64decode(blob))), []
    while length := int.from_bytes(stream.read(4), "little"):
        found.append(umsgpack.unpackb(stream.read(length)))
    return found


def drawn(page: Any, group: str) -> list[list[tuple[np.ndarray, np.ndarray]]]:
    """Return for each object of a group the corners, m, of the box around each of the bodies that a browser draws."""
    objects = page.evaluate(
        """group => {
            viewer.scene.updateMatrixWorld(true);
            const world = viewer.scene_tree.find(["meshcat", "world"]).object;
            return world.getObjectByName(group).children.filter(mesh => mesh.userData.owners).map(mesh => {
                mesh.geometry.computeBoundingBox();
                return [...Array(mesh.count).keys()].map(i => {
                    const at = world.matrixWorld.clone(), own = at.clone();
                    mesh.getMatrixAt(i, own);
                    at.invert().multiply(mesh.matrixWorld).multiply(own);
                    const box = mesh.geometry.boundingBox.clone().applyMatrix4(at);
                    return [box.min.toArray(), box.max.toArray()];
                });
            });
        }""",
        group,
    )
    return [[(np.array(low), np.array(high)) for low, high in boxes] for boxes in objects]


def page_data(page: str) -> dict[str, Any]:
    """Return what the scripts of a page know."""
    (text,) = re.findall(r'<script type="application/json" id="page-data">(.*?)</script>', page)
    return json.loads(text)


def unpacked(packed: str, width: int | None = None) -> np.ndarray:
    """Return numbers that a page has in base64, in rows of a width if one is given."""
    values = np.frombuffer(base64.b64decode(packed), "<f4").astype(float)
    return values if width is None else values.reshape(-1, width)


def trace(page: str, hand: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the beads of a trace: where they are (B, 3), m, and their colours (B, 3) from 0 to 255."""
    (command,) = [
        c for c in commands(page) if c["type"] == "set_object" and c["path"].endswith(f"motion0/traces/{hand}")
    ]
    attributes = command["object"]["geometries"][0]["data"]["attributes"]
    return tuple(
        np.frombuffer(attributes[name]["array"].data, np.float32).reshape(-1, 3) * factor
        for name, factor in (("position", 1.0), ("color", 255.0))
    )


def rgb(colour: int) -> list[int]:
    return [colour >> 16, colour >> 8 & 255, colour & 255]
