"""The obstacles in the browsers: each fades those that stand between its own camera and the robot."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pinocchio as pin
import viser

from humanoid_rail._arrays import Array
from humanoid_rail.live.stage import draw, put
from humanoid_rail.live.triangles import obstacle_triangles
from humanoid_rail.live.world import placed
from humanoid_rail.scene.obstacles import Box, HalfSpace, Obstacle
from humanoid_rail.viewer.drawing import is_plain_floor, obstacle_colours
from humanoid_rail.viewer.occlusion import Blockers, blockers, hiding

FADED, WALL = 0.12, 0.2
"""How much is left of what has faded, as on the page that plays motions back; walls are never more than this."""
OFTEN = 0.1
"""What hides the robot is looked for again after this time, s."""


class Obstacles:
    """The obstacles of a world. Their places are the same in all browsers; how solid they are is each browser's own."""

    def __init__(self, server: viser.ViserServer, obstacles: Sequence[Obstacle], choose: Callable[[int], None]) -> None:
        """Draw them in each browser that comes.

        Args:
            server: What the browsers are connected to.
            obstacles: What is drawn, but for floors.
            choose: Called with the number of an obstacle that is clicked on.
        """
        self._obstacles, self._choose = obstacles, choose
        self._colours = obstacle_colours(obstacles)
        self._frames = [
            None if is_plain_floor(obstacle) else server.scene.add_frame(_name(i), show_axes=False)
            for i, obstacle in enumerate(obstacles)
        ]
        self._own, self._owner = _bodies(obstacles)
        self._looked = -np.inf
        self._lock = threading.Lock()
        self._clients: dict[int, tuple[viser.ClientHandle, dict[int, Any]]] = {}
        server.on_client_connect(self._draw)
        server.on_client_disconnect(self._forget)

    def faded(self, client: int) -> set[int]:
        """Return the numbers of the obstacles that have faded in the browser of this number."""
        with self._lock:
            return {i for i, body in self._clients[client][1].items() if body.opacity == FADED}

    def show(self, places: Sequence[pin.SE3], points: Array) -> None:
        """Put the obstacles where they are, and fade those that hide some of the points (P, 3) of the robot, m."""
        for obstacle, frame, there in zip(self._obstacles, self._frames, places, strict=True):
            if frame is not None and not isinstance(obstacle, HalfSpace):
                put(frame, there)
        if time.monotonic() - self._looked < OFTEN:
            return
        self._looked = time.monotonic()
        bodies = _placed_bodies(self._own, self._owner, places)
        with self._lock:
            for client, drawn in self._clients.values():
                hides = set(self._owner[hiding(bodies, np.array(client.camera.position), points)].tolist())
                with client.atomic():
                    for i, body in drawn.items():
                        wanted = FADED if i in hides else None
                        if not isinstance(self._obstacles[i], HalfSpace) and body.opacity != wanted:
                            body.opacity = wanted

    def _draw(self, client: viser.ClientHandle) -> None:
        with self._lock:
            drawn = {i: self._body(client, i) for i, frame in enumerate(self._frames) if frame is not None}
            self._clients[client.client_id] = client, drawn

    def _body(self, client: viser.ClientHandle, i: int) -> Any:
        obstacle = self._obstacles[i]
        is_wall = isinstance(obstacle, HalfSpace)
        body = draw(
            client,
            f"{_name(i)}/body",
            obstacle_triangles(obstacle),
            self._colours[i],
            opacity=WALL if is_wall else None,
            flat=isinstance(obstacle, Box),
        )
        if not is_wall:
            body.on_click(lambda _: self._choose(i))
        return body

    def _forget(self, client: viser.ClientHandle) -> None:
        with self._lock:
            self._clients.pop(client.client_id, None)


def _name(i: int) -> str:
    return f"/obstacles/{i}"


def _bodies(obstacles: Sequence[Obstacle]) -> tuple[Blockers, Any]:
    """Return what can hide a robot, each body in the frame of its obstacle, and the numbers of these (B,)."""
    centred = [placed(obstacle, np.zeros(3), np.eye(3)) for obstacle in obstacles]
    each = [blockers([obstacle]) for obstacle in centred]
    owner = np.repeat(np.arange(len(each)), [len(bodies.centre) for bodies in each])
    columns = zip(blockers([]), *each, strict=True)
    return Blockers(*map(np.concatenate, columns)), owner


def _placed_bodies(own: Blockers, owner: Any, places: Sequence[pin.SE3]) -> Blockers:
    """Return bodies where their obstacles are."""
    if not len(owner):
        return own
    turn = np.array([there.rotation for there in places])[owner]
    origin = np.array([there.translation for there in places])[owner]
    return own._replace(
        centre=origin + np.einsum("bij,bj->bi", turn, own.centre), rotation=turn @ own.rotation, velocity=0.0 * origin
    )
