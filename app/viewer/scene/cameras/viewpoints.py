"""The cameras of the connected browsers, each its own."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from viser import CameraHandle, ClientHandle, ViserServer

from app.front.viser_internals import camera_report
from app.viewer.scene.cameras.camera import CameraView, Ride, view
from app.viewer.scene.draw.drawn_frame import Picture
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.marks.ribbons import present_height
from app.viewer.scene.shown.drawing_style import RIDE, STEP_OFF

GLIDE = 0.25
"""Time constant with which a following camera catches up, s."""
TITLE = {2: 0.08, 3: 0.17}
"""Room for the title over a flock, as a multiple of the longest side, by dimension."""
CLOSE_UP = 1.2
"""Half side of what a following camera shows at first, display units."""
RESHAPED = 0.02
"""Change in the shape of a canvas, width over height, from which on the picture does not fit."""
AGAIN = 0.5
"""Seconds between two looks whether a flock in the open has left what is shown."""
BEYOND, AHEAD, ROOM = 0.02, 0.25, 1.0
"""How far it is out then, and how much more is shown at each side, of the longest side shown:
around the world, and around a flock alone, which goes on."""
MOST = 4.0
"""Sides of the world from which on a flock is shown without its world, or if it is as far spread
is let go: its agents would be too small to be seen."""
ARRIVES = 10.0
"""Seconds after which a camera that was never where it was put has been moved by a person."""
MOVED = 0.01
"""How far a camera that nobody moved is from where it was put at most, of its distance."""


MANY = 50_000
"""Of more agents some stand for all where it is asked how far a flock reaches."""


class Sight(NamedTuple):
    """A flock, and where its room stands."""

    picture: Picture
    aside: np.ndarray
    """Where the room's centre is on the display, (3,)."""


@dataclass
class SavedCamera:
    """Where a camera was put, to be put there again when its canvas changes its shape."""

    preset: str
    view: CameraView
    aspect: float
    since: float
    shows: tuple[np.ndarray, np.ndarray]
    """Corners (3,) of what it shows."""
    run: int
    """In which run it was put there."""
    told: object
    """What its browser had told of it until then; viser has it say what it was told itself."""
    leans: bool = False
    """Whether it stood straight above before something rose."""
    arrived: bool = False
    """Whether the browser has told that it is there; before, it tells of where it was."""

    def has(self, camera: CameraHandle) -> bool:
        """Whether the camera is where it was put."""
        return is_at(camera, self.view.position, self.view.target)

    def is_left(self, camera: CameraHandle) -> bool:
        """Whether a person has moved the camera since."""
        if camera_report(camera) is self.told:
            return False
        is_there = self.has(camera)
        self.arrived |= is_there or time.monotonic() > self.since + ARRIVES
        return self.arrived and not is_there


def is_at(camera: CameraHandle, position: np.ndarray, target: np.ndarray) -> bool:
    """Whether a camera is as good as in a place, and looks at the target."""
    put = np.stack([position, target])
    gap = np.abs(put - np.stack([camera.position, camera.look_at])).max()
    return bool(gap <= MOVED * np.linalg.norm(put[0] - put[1]))


class Viewpoints:
    """Places each browser's camera at first, on request, and every frame for those that follow."""

    def __init__(self, server: ViserServer) -> None:
        self._server = server
        # Browsers come, go and choose on viser's threads; the drawing has one of its own.
        self._lock = threading.Lock()
        self._followed: dict[int, tuple[int, int]] = {}
        """Client -> which of the flocks, and identity of the agent its camera follows."""
        self._riders: dict[int, Ride] = {}
        """Client -> the ride that it is on."""
        self._stands: dict[int, SavedCamera] = {}
        """Client -> where its camera was put, unless a person moved it or it follows somebody."""
        self._sights: tuple[Sight, ...] = ()
        self._entered: tuple[Stage, list[list[float]]] | None = None
        """The stage, and where each flock's room stands, that the cameras were last pointed at."""
        self._risen = 0.0
        """Height of what rises with time."""
        self._last = self._looks = time.monotonic()
        self.first = ""
        """The preset on which a world opens; empty: the usual one."""
        server.on_client_connect(self._add_client)
        server.on_client_disconnect(self._remove_client)

    def place(
        self, client: ClientHandle, name: str, whom: tuple[int | None, int] | None = None
    ) -> None:
        """Give one browser the preset `name`, or let it get on a bird or off it.

        `whom`: row and side of the agent to follow or to ride on; None: see `_worth_following`.
        """
        if not self._sights:
            return
        if name in (RIDE, STEP_OFF):
            with self._lock:
                ride = self._riders.pop(client.client_id, None)
            if ride is not None:
                _set(client, ride.before)
            elif name == RIDE:
                self.ride(client, *(whom or self._worth_following()))
            return
        if name == "follow":
            self.follow(client, *(whom or self._worth_following()))
            return
        self._place(client, name)

    def _place(
        self, client: ClientHandle, name: str, leans: bool = False, ahead: float = 0.0
    ) -> None:
        """Give one browser a preset that shows the whole, and `ahead` more of it at each side."""
        self._forget(client)
        low, high = scene_corners(self._sights)
        shows = low - ahead * longest_side(low, high), high + ahead * longest_side(low, high)
        (low, high), run = (point.copy() for point in shows), self._sights[0].picture.frame.run
        if name != "top-down":
            high[2] = max(high[2], present_height(self._sights[0].picture))
        aspect = aspect_of(client)
        new_view = view(name, self._sights[0].picture.stage.dim, low, high, aspect)
        reported = camera_report(client.camera)
        stand = SavedCamera(name, new_view, aspect, time.monotonic(), shows, run, reported, leans)
        self._keep(self._stands, client, stand)
        _set(client, new_view)

    def follow(self, client: ClientHandle, row: int | None, side: int = 0) -> None:
        """Keep the agent now in `row` of the flock `side` in view, or let go of it with None."""
        self._forget(client)
        if row is None or side >= len(self._sights):
            return
        picture, aside = self._sights[side]
        if not 0 <= row < len(picture.at):
            return
        at = picture.at[row] + aside
        low, high = at - CLOSE_UP, at + CLOSE_UP
        if picture.stage.dim == 2:
            low[2] = high[2] = at[2]
        _set(client, view("follow", picture.stage.dim, low, high, aspect_of(client)))
        self._keep(self._followed, client, (side, int(picture.frame.ids[row])))

    def ride(self, client: ClientHandle, row: int | None, side: int = 0) -> None:
        """Put one browser's camera behind the agent now in `row` of the flock `side`."""
        if row is None or side >= len(self._sights):
            return
        if not 0 <= row < len(self._sights[side].picture.at):
            return
        self._forget(client)
        camera = client.camera
        before = CameraView(camera.position.copy(), camera.look_at.copy(), camera.fov)
        ride = Ride(self._sights[side].picture, row, self._sights[side].aside, side, before)
        _set(client, ride.view)
        self._keep(self._riders, client, ride)

    def update(self, sights: tuple[Sight, ...]) -> None:
        """Take in a new frame: welcome a new world, and move the cameras that follow."""
        self._sights = sights
        now = time.monotonic()
        clients = self._server.get_clients()
        entered = sights[0].picture.stage, [sight.aside.tolist() for sight in sights]
        if entered != self._entered:
            self._entered = entered
            self._enter(list(clients.values()))
        if present_height(sights[0].picture) != self._risen:
            self._risen = present_height(sights[0].picture)
            self._fit_rising(list(clients.values()))
        if now >= self._looks and "open" in sights[0].picture.frame.world.edges:
            self._looks = now + AGAIN
            self._refit(list(clients.values()))
        with self._lock:
            followed, riders = dict(self._followed), dict(self._riders)
        passed, self._last = now - self._last, now
        share = 1.0 - float(np.exp(-passed / GLIDE))
        for client_id, (side, identity) in followed.items():
            if client_id not in clients or side >= len(sights):
                continue
            picture, aside = sights[side]
            rows = np.flatnonzero(picture.frame.ids == identity)
            if len(rows):
                _glide(clients[client_id], picture, picture.at[rows[0]] + aside, share)
        for client_id, ride in riders.items():
            if client_id not in clients:
                continue
            if ride.side < len(sights) and ride.move(*sights[ride.side], passed):
                _set(clients[client_id], ride.view)
            else:
                self._forget(clients[client_id])
                _set(clients[client_id], ride.before)

    def followed(self) -> list[tuple[ClientHandle, int, int]]:
        """Of whom a camera follows or rides on: the browser, the flock's side, the agent's row."""
        with self._lock:
            agents = self._followed | {
                number: (ride.side, ride.identity) for number, ride in self._riders.items()
            }
        clients, followed_agents = self._server.get_clients(), []
        for number, (side, identity) in agents.items():
            if number in clients and side < len(self._sights):
                rows = np.flatnonzero(self._sights[side].picture.frame.ids == identity)
                followed_agents += [(clients[number], side, int(row)) for row in rows]
        return followed_agents

    def _enter(self, clients: list[ClientHandle]) -> None:
        picture = self._sights[0].picture
        start = view(
            self.first or _followed_name(picture),
            picture.stage.dim,
            *scene_corners(self._sights),
            1.0,
        )
        initial = self._server.initial_camera
        initial.position, initial.look_at = start.position, start.target
        initial.up, initial.fov, initial.near = np.array([0.0, 0.0, 1.0]), start.fov, start.near
        for client in clients:
            self.place(client, self.first or _followed_name(picture))

    def _fit_rising(self, clients: list[ClientHandle]) -> None:
        """Fit what rises into the pictures that nobody has moved: not from straight above."""
        for client in clients:
            stand = self._stands.get(client.client_id)
            if stand is None or stand.is_left(client.camera):
                continue
            if self._risen and stand.preset == "top-down":
                self._place(client, "perspective", leans=True)
            else:
                leans = stand.leans and self._risen > 0.0
                back = stand.leans and not leans
                self._place(client, "top-down" if back else stand.preset, leans)

    def _refit(self, clients: list[ClientHandle]) -> None:
        """Show the whole again where nobody has moved the camera: after a flock that has flown out
        of an open world, and a run that begins anew."""
        low, high = scene_corners(self._sights)
        homes = [longest_side(*home_corners(picture)) for picture, _ in self._sights]
        most = MOST * max(homes) * len(homes)
        for client in clients:
            stand = self._stands.get(client.client_id)
            if stand is None or stand.is_left(client.camera):
                continue
            lower, upper = stand.shows
            out = max((lower - low).max(), (high - upper).max()) > BEYOND * longest_side(
                *stand.shows
            )
            out &= longest_side(low, high) <= most
            if out or stand.run != self._sights[0].picture.frame.run:
                is_alone = bool((low > 0.0).any() or (high < 0.0).any())  # the world is around 0
                ahead = ROOM if is_alone else AHEAD
                self._place(client, stand.preset, stand.leans, ahead if out else 0.0)

    async def _add_client(self, client: ClientHandle) -> None:
        """On the event loop: on viser's thread pool it might come after the farewell."""
        if self._sights:
            self.place(client, self.first or _followed_name(self._sights[0].picture))

        async def told(camera: CameraHandle) -> None:
            self._fit(client, camera)

        client.camera.on_update(told)

    def _fit(self, client: ClientHandle, camera: CameraHandle) -> None:
        """Show the whole again when a canvas has another shape, unless its camera was moved."""
        stand = self._stands.get(client.client_id)
        if stand is None:
            return
        start = self._server.initial_camera
        if is_at(camera, start.position, start.look_at) and not stand.has(camera):
            # The browser was slow to begin: where it was asked to look is lost.
            self._place(client, stand.preset, stand.leans)
        elif stand.is_left(camera):
            with self._lock:
                self._stands.pop(client.client_id, None)
        elif abs(aspect_of(client) - stand.aspect) >= RESHAPED:
            self._place(client, stand.preset, stand.leans)

    async def _remove_client(self, client: ClientHandle) -> None:
        """On the event loop: viser's thread pool may be gone when the server stops."""
        self._forget(client)

    def _keep[T](self, entries: dict[int, T], client: ClientHandle, entry: T) -> None:
        """Keep something about a browser, unless it has gone meanwhile.

        The drawing thread places cameras of browsers that were there a moment ago. After the
        farewell nobody would forget the entry, and it holds all that viser has of the browser.
        """
        with self._lock:
            if client.client_id in self._server.get_clients():
                entries[client.client_id] = entry

    def _forget(self, client: ClientHandle) -> None:
        """Neither follow nor ride on anybody any more."""
        with self._lock:
            for entries in (self._followed, self._riders, self._stands):
                entries.pop(client.client_id, None)

    def _worth_following(self) -> tuple[int | None, int]:
        """The inspected agent, else the leader, else the first; and which flock it is in."""
        looked_at = [sight.picture.inspected is not None for sight in self._sights]
        side = looked_at.index(True) if any(looked_at) else 0
        return _worth_following(self._sights[side].picture), side


def _followed_name(picture: Picture) -> str:
    return "top-down" if picture.stage.dim == 2 and not present_height(picture) else "perspective"


def _worth_following(picture: Picture) -> int | None:
    """The inspected agent, else the leader, else the first."""
    if picture.inspected is not None:
        return picture.inspected
    if picture.leader is not None:
        return picture.leader
    return 0 if len(picture.at) else None


def scene_corners(sights: tuple[Sight, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Corners (3,) of all that the flocks are in, and of the titles over two of them."""
    low, high = zip(*(extent(picture) for picture, _ in sights), strict=True)
    aside = [sight.aside for sight in sights]
    upper = np.max(np.add(high, aside), axis=0)
    if len(sights) > 1:
        stage = sights[0].picture.stage
        upper[1 if stage.dim == 2 else 2] += TITLE[stage.dim] * stage.side
    return np.min(np.add(low, aside), axis=0), upper


def longest_side(low: np.ndarray, high: np.ndarray) -> float:
    """The longest side of a box."""
    return float((high - low).max())


def extent(picture: Picture) -> tuple[np.ndarray, np.ndarray]:
    """Corners (3,) of the world's box, its mission, and the flock where it has flown out of it; of
    the flock alone once it is so far out that all of that would be too much."""
    low, high = home_corners(picture)
    home = longest_side(low, high)
    if len(picture.at):
        some = picture.at[:: 1 + picture.count // MANY]
        flock = np.quantile(some, 0.02, axis=0), np.quantile(some, 0.98, axis=0)
        low, high = np.minimum(low, flock[0]), np.maximum(high, flock[1])
        if longest_side(low, high) > MOST * home:
            middle, half = (flock[0] + flock[1]) / 2.0, (flock[1] - flock[0]) / 2.0
            half = np.maximum(half, picture.stage.half)
            low, high = middle - half, middle + half
    if picture.leader is not None:
        low = np.minimum(low, picture.at[picture.leader])
        high = np.maximum(high, picture.at[picture.leader])
    return low, high


def home_corners(picture: Picture) -> tuple[np.ndarray, np.ndarray]:
    """Corners (3,) of the world's box and its mission."""
    low, high = -picture.stage.half, picture.stage.half.copy()
    for place in mission_places(picture):
        low, high = np.minimum(low, place), np.maximum(high, place)
    return low, high


def mission_places(picture: Picture) -> np.ndarray:
    """Where the mission takes the flock: start, waypoints and the goal's route, (K, 3)."""
    frame, corner_sets = picture.frame, [np.empty((0, picture.stage.dim))]
    if frame.room is not None:
        corner_sets.append(np.stack(frame.room))
    mission = frame.world.mission
    if mission is not None and mission.path is not None:
        corner_sets.append(np.array(mission.path.waypoints, float))
    if mission is not None and mission.goal is not None:
        corner_sets.append(np.array(mission.goal.route, float))
    return picture.stage.to_display(np.concatenate(corner_sets))


def aspect_of(client: ClientHandle) -> float:
    """Width over height of the picture in a browser, within reason."""
    camera = client.camera
    tall = max(camera.image_height, 1)
    return float(np.clip(camera.image_width / tall, 0.3, 4.0))


def _set(client: ClientHandle, view: CameraView) -> None:
    with client.atomic():
        client.camera.up_direction = np.array([0.0, 0.0, 1.0])
        client.camera.fov = view.fov
        client.camera.near = view.near
        client.camera.position = view.position
        client.camera.look_at = view.target


def _glide(client: ClientHandle, picture: Picture, target: np.ndarray, share: float) -> None:
    """Shift the camera towards its agent; through a seam it jumps with it."""
    camera = client.camera
    gap = target - camera.look_at
    if np.any(np.abs(gap) > 0.5 * picture.stage.period):
        share = 1.0
    if np.linalg.norm(gap) * share > 1e-4:
        with client.atomic():
            camera.position = camera.position + share * gap
