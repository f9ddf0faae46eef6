"""The cameras of the connected browsers, each its own."""

from __future__ import annotations

import threading
import time

import numpy as np
from viser import ClientHandle, ViserServer

from app.viewer.scene.camera import View, view
from app.viewer.scene.picture import Picture
from app.viewer.scene.stage import Stage

GLIDE = 0.25
"""Time constant with which a following camera catches up, s."""
CLOSE_UP = 1.2
"""Half side of what a following camera shows at first, display units."""


class Viewpoints:
    """Places each browser's camera at first, on request, and every frame for those that follow."""

    def __init__(self, server: ViserServer) -> None:
        self._server = server
        self._lock = threading.Lock()
        self._followed: dict[int, int] = {}
        """Client -> identity of the agent its camera follows."""
        self._picture: Picture | None = None
        self._stage: Stage | None = None
        self._last = time.monotonic()
        server.on_client_connect(self._welcome)
        server.on_client_disconnect(self._farewell)

    def place(self, client: ClientHandle, name: str) -> None:
        """Give one browser the preset `name`."""
        picture = self._picture
        if picture is None:
            return
        if name == "follow":
            self.follow(client, _worth_following(picture))
            return
        self.follow(client, None)
        low, high = extent(picture)
        _set(client, view(name, picture.stage.dim, low, high, _aspect(client)))

    def follow(self, client: ClientHandle, row: int | None) -> None:
        """Keep the agent now in `row` in view, or let go of it with None."""
        picture = self._picture
        if picture is None or row is None or not 0 <= row < len(picture.at):
            self._forget(client)
            return
        low, high = picture.at[row] - CLOSE_UP, picture.at[row] + CLOSE_UP
        if picture.stage.dim == 2:
            low[2] = high[2] = picture.at[row, 2]
        _set(client, view("follow", picture.stage.dim, low, high, _aspect(client)))
        with self._lock:
            self._followed[client.client_id] = int(picture.frame.ids[row])

    def update(self, picture: Picture) -> None:
        """Take in a new frame: welcome a new world, and move the cameras that follow."""
        self._picture = picture
        now = time.monotonic()
        share = 1.0 - float(np.exp(-(now - self._last) / GLIDE))
        self._last = now
        clients = self._server.get_clients()
        if picture.stage != self._stage:
            self._stage = picture.stage
            self._enter(picture, list(clients.values()))
        with self._lock:
            followed = dict(self._followed)
        for client_id, identity in followed.items():
            rows = np.flatnonzero(picture.frame.ids == identity)
            if client_id in clients and len(rows):
                _glide(clients[client_id], picture, picture.at[rows[0]], share)

    def _enter(self, picture: Picture, clients: list[ClientHandle]) -> None:
        start = view(_first(picture), picture.stage.dim, *extent(picture), 1.0)
        initial = self._server.initial_camera
        initial.position, initial.look_at = start.position, start.target
        initial.up, initial.fov, initial.near = np.array([0.0, 0.0, 1.0]), start.fov, start.near
        for client in clients:
            self.place(client, _first(picture))

    def _welcome(self, client: ClientHandle) -> None:
        if self._picture is not None:
            self.place(client, _first(self._picture))

    async def _farewell(self, client: ClientHandle) -> None:
        """On the event loop: viser's thread pool may be gone when the server stops."""
        self._forget(client)

    def _forget(self, client: ClientHandle) -> None:
        with self._lock:
            self._followed.pop(client.client_id, None)


def _first(picture: Picture) -> str:
    return "top-down" if picture.stage.dim == 2 else "perspective"


def _worth_following(picture: Picture) -> int | None:
    """The inspected agent, else the leader, else the first."""
    if picture.inspected is not None:
        return picture.inspected
    if picture.leader is not None:
        return picture.leader
    return 0 if len(picture.at) else None


def extent(picture: Picture) -> tuple[np.ndarray, np.ndarray]:
    """Corners (3,) of the world's box, its mission, and the flock where it has flown out of it."""
    low, high = -picture.stage.half, picture.stage.half.copy()
    for place in places(picture):
        low, high = np.minimum(low, place), np.maximum(high, place)
    if len(picture.at):
        low = np.minimum(low, np.quantile(picture.at, 0.02, axis=0))
        high = np.maximum(high, np.quantile(picture.at, 0.98, axis=0))
    if picture.leader is not None:
        low = np.minimum(low, picture.at[picture.leader])
        high = np.maximum(high, picture.at[picture.leader])
    return low, high


def places(picture: Picture) -> np.ndarray:
    """Where the mission takes the flock: start, waypoints and the goal's route, (K, 3)."""
    frame, found = picture.frame, [np.empty((0, picture.stage.dim))]
    if frame.room is not None:
        found.append(np.stack(frame.room))
    mission = frame.world.mission
    if mission is not None and mission.path is not None:
        found.append(np.array(mission.path.waypoints, float))
    if mission is not None and mission.goal is not None:
        found.append(np.array(mission.goal.route, float))
    return picture.stage.shown(np.concatenate(found))


def _aspect(client: ClientHandle) -> float:
    camera = client.camera
    tall = max(camera.image_height, 1)
    return float(np.clip(camera.image_width / tall, 0.3, 4.0))


def _set(client: ClientHandle, wanted: View) -> None:
    with client.atomic():
        client.camera.up_direction = np.array([0.0, 0.0, 1.0])
        client.camera.fov = wanted.fov
        client.camera.near = wanted.near
        client.camera.position = wanted.position
        client.camera.look_at = wanted.target


def _glide(client: ClientHandle, picture: Picture, target: np.ndarray, share: float) -> None:
    """Shift the camera towards its agent; through a seam it jumps with it."""
    camera = client.camera
    gap = target - camera.look_at
    if np.any(np.abs(gap) > 0.5 * picture.stage.period):
        share = 1.0
    if np.linalg.norm(gap) * share > 1e-4:
        with client.atomic():
            camera.position = camera.position + share * gap
