"""Flocks of which no agent can be told apart, as each browser sees them: a picture of their density
in what its camera has in sight, and from near the agents themselves.
"""

from __future__ import annotations

import io
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from PIL import Image
from viser import CameraHandle, ClientHandle, ImageHandle, ViserServer

from app.front.viser_internals import add_jpeg, is_connected, show_jpeg
from app.viewer.scene.cameras.flock_in_sight import MARGIN, FlockInSight
from app.viewer.scene.cameras.space_density import DensityBackdrop, Files, SpaceFlockInSight
from app.viewer.scene.cameras.viewpoints import Sight
from app.viewer.scene.draw.density import (
    DensityPicture,
    PlaneRegion,
    count_within,
    density_picture,
    fill_rows_within,
    flock_region,
    grid_shape,
)
from app.viewer.scene.draw.drawn_frame import Picture
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.shown import drawing_style

# What of a flat world a camera has in sight.

FARTHEST = 100.0
"""How far a camera sees, in sides of the world: it may look at the horizon."""
LOOSE = 2.5
"""How many times as large as it would be made now the region that is drawn may become."""


def region_in_sight(camera: CameraHandle, picture: Picture, aside: np.ndarray) -> PlaneRegion:
    """The part of the world of a picture, whose room stands `aside` (3,), that a camera may see:
    a rectangle around it."""
    eye = np.asarray(camera.position, float) - aside
    farthest = FARTHEST * picture.stage.side
    with np.errstate(all="ignore"):  # a browser may say what it likes of its camera
        ahead = np.asarray(camera.look_at, float) - camera.position
        ahead /= max(float(np.linalg.norm(ahead)), 1e-9)
        right = np.cross(ahead, np.asarray(camera.up_direction, float))
        right /= max(float(np.linalg.norm(right)), 1e-9)
        over = np.cross(right, ahead)
        tall = np.tan(0.5 * camera.fov)
        wide = tall * camera.image_width / max(camera.image_height, 1)
        ways = np.array(
            [ahead + x * wide * right + y * tall * over for x in (-1, 1) for y in (-1, 1)]
        )
        away = -eye[2] / ways[:, 2]
        away = np.where((away > 0.0) & (away < farthest), away, farthest)
        corners = picture.stage.world(eye + away[:, None] * ways)
    return PlaneRegion(tuple(corners.min(axis=0).tolist()), tuple(corners.max(axis=0).tolist()))


def camera_state(camera: CameraHandle) -> bytes:
    """All that says what a camera has in sight; bytes, as a browser may say that it is nan."""
    vectors = camera.position, camera.look_at, camera.up_direction
    numbers = camera.fov, camera.image_width, camera.image_height
    return np.concatenate([*vectors, numbers], dtype=float).tobytes()


class JpegFile(NamedTuple):
    """The file of a picture of density."""

    data: bytes
    region: PlaneRegion
    typical: float
    """See `DensityPicture`."""


QUALITY = 85
"""Of the files, as JPEG counts it."""


def jpeg_file(made: DensityPicture) -> JpegFile:
    """The file of a picture."""
    buffer = io.BytesIO()
    Image.fromarray(made.pixels).save(buffer, "jpeg", quality=QUALITY)
    return JpegFile(buffer.getvalue(), made.region, made.typical)


@dataclass
class DenseFlock:
    """A flock that is drawn so, at one tick."""

    sight: Sight
    region: PlaneRegion
    """All of it."""
    files: dict[tuple[PlaneRegion, tuple[int, int]], JpegFile] = field(default_factory=dict)
    """Browsers that look from where they were put share them."""

    def file(self, region: PlaneRegion, count: int) -> JpegFile:
        """The picture of a region with so many agents in sight."""
        key = region, grid_shape(region, count)
        if key not in self.files:
            frame = self.sight.picture.frame
            rows = slice(None) if frame.active is None else frame.active
            made = density_picture(frame.position[rows], frame.heading[rows], region, count)
            self.files[key] = jpeg_file(made)
        return self.files[key]


# What one browser draws of one flock.

FLOOR = -0.005
"""Height of a picture of density: over the floor, and under all that stands on it."""


def show_file(image: ImageHandle, file: JpegFile, stage: Stage) -> None:
    """Show the picture of a region where the region is."""
    middle = stage.to_display(0.5 * np.add(file.region.low, file.region.high))
    wide, deep = stage.scale * np.array(file.region.sides)
    image.position = (float(middle[0]), float(middle[1]), FLOOR)
    image.scale = (float(wide), float(deep), 1.0)
    show_jpeg(image, file.data)


class PlaneFlockInSight(FlockInSight):
    """What is drawn of a flock in the plane in one browser."""

    typical: float | None = 0.0
    image: ImageHandle | None = None
    region: PlaneRegion | None = None
    """What is drawn of the world; None: the camera looks elsewhere."""

    def look(self, flock: DenseFlock) -> bool:
        """See what the camera has in sight now; whether another picture is to be drawn for it."""
        picture, before = flock.sight.picture, (self.as_singles, self.region)
        seen = region_in_sight(self.client.camera, picture, self.aside).intersection(flock.region)
        if seen is None:
            self.count, self.region = 0, None
            return before[1] is not None
        self.count = count_within(picture.frame.position, *seen.low, *seen.high)
        self.as_singles = self.are_few(self.count)
        wider = seen.grown(MARGIN).intersection(flock.region) or seen
        if (
            self.region is None
            or not self.region.contains(seen)
            or self.region.area > LOOSE * wider.area
            or self.as_singles != before[0]
        ):
            self.region = wider
        return before != (self.as_singles, self.region)

    def draw(self, flock: DenseFlock) -> None:
        """Draw it."""
        with self.client.atomic():
            if self.region is not None and not self.as_singles:
                self.draw_density(flock.file(self.region, self.count), flock.sight.picture)
            if self.image is not None:
                self.image.visible = self.region is not None and not self.as_singles
            self.draw_singles(flock.sight.picture)

    def draw_density(self, file: JpegFile, picture: Picture) -> None:
        """Show a picture."""
        if self.image is None:
            self.image = add_jpeg(self.client.scene, f"{self.root}/density", file.data)
        self.typical = file.typical
        show_file(self.image, file, picture.stage)

    def draw_singles(self, picture: Picture) -> None:
        """Show the agents of the region, or none."""
        position, region = picture.frame.position, self.region
        rows = np.empty(0, np.int64)
        if region is not None and self.as_singles:
            rows = np.empty(count_within(position, *region.low, *region.high), np.int64)
            fill_rows_within(position, *region.low, *region.high, rows)
        self.draw_rows(picture, rows)


@dataclass
class DenseFlocks:
    """The flocks that are drawn so, at one tick."""

    plane: dict[int, DenseFlock] = field(default_factory=dict)
    """Those in the plane, by side."""
    space: dict[int, Sight] = field(default_factory=dict)
    """Those in space, by side."""
    files: Files = field(default_factory=dict)
    """Pictures of those in space."""

    @staticmethod
    def of(sights: tuple[Sight, ...]) -> DenseFlocks:
        """Those of all flocks that are drawn so."""
        dense = DenseFlocks()
        for side, sight in enumerate(sights):
            if sight.picture.shows_density and sight.picture.stage.dim == 2:
                dense.plane[side] = DenseFlock(sight, flock_region(sight.picture.frame))
            elif sight.picture.shows_density:
                dense.space[side] = sight
        return dense

    def __bool__(self) -> bool:
        """Whether there are any."""
        return bool(self.plane or self.space)


class BrowserSights:
    """What one browser draws of all flocks."""

    def __init__(self, client: ClientHandle) -> None:
        self.client = client
        self.plane: dict[int, PlaneFlockInSight] = {}
        """By side."""
        self.space: dict[int, SpaceFlockInSight] = {}
        """By side."""
        self.backdrop = DensityBackdrop(client)
        self.camera = b""
        """The `camera_state` that this was drawn for."""
        self.due = 0.0
        """When it is drawn again at the soonest because its camera moves, s."""

    @property
    def flocks(self) -> tuple[FlockInSight, ...]:
        """All of them."""
        return *self.plane.values(), *self.space.values()

    def draw(self, dense: DenseFlocks, is_new: bool) -> None:
        """Draw flocks; if they are not new, only what else a camera that has moved has in sight."""
        keep_those_there(self.plane, {side: flock.sight for side, flock in dense.plane.items()})
        keep_those_there(self.space, dense.space)
        for side, there in dense.plane.items():
            if side not in self.plane:
                self.plane[side] = PlaneFlockInSight(self.client, side, there.sight.aside)
            if self.plane[side].look(there) or is_new:
                self.plane[side].draw(there)
        self.draw_space(dense, is_new)

    def draw_space(self, dense: DenseFlocks, is_new: bool) -> None:
        """Draw the flocks in space."""
        for side, sight in dense.space.items():
            if side not in self.space:
                self.space[side] = SpaceFlockInSight(self.client, side, sight.aside)
        moved = [self.space[side].look(sight) for side, sight in dense.space.items()]
        if not (any(moved) or is_new):
            return
        with self.client.atomic():
            for side, sight in dense.space.items():
                self.space[side].count_agents(sight)
                self.space[side].draw_singles(sight.picture)
            many = {
                side: sight
                for side, sight in dense.space.items()
                if not self.space[side].as_singles
            }
            self.backdrop.draw(many, self.space, dense.files)


def keep_those_there(flocks: dict[int, Any], sights: Mapping[int, Sight]) -> None:
    """Drop flocks of sides that are drawn so no more, or stand elsewhere."""
    for side, flock in list(flocks.items()):
        if side not in sights or not np.array_equal(flock.aside, sights[side].aside):
            flock.end()
            del flocks[side]


class DensityViews:
    """Draws flocks of which no agent can be told apart, for each browser; for one thread."""

    def __init__(self, server: ViserServer) -> None:
        self._server = server
        # Browsers leave on viser's loop.
        self._lock = threading.Lock()
        self._views: dict[int, BrowserSights] = {}
        self._dense = DenseFlocks()
        server.on_client_disconnect(self._remove_client)

    def show(self, sights: tuple[Sight, ...]) -> None:
        """Draw a new frame."""
        self._dense = DenseFlocks.of(sights)
        self._draw(is_new=True)

    def follow(self) -> None:
        """Draw for cameras that have moved."""
        if self._dense:
            self._draw(is_new=False)

    def in_sight(self, client: ClientHandle) -> tuple[FlockInSight, ...]:
        """What one browser sees of such flocks; empty where all agents are drawn."""
        view = self._views.get(client.client_id)
        return () if view is None else view.flocks

    def _draw(self, is_new: bool) -> None:
        if not (self._dense or self._views):
            return
        now = time.monotonic()
        for view in self._browsers():
            if not is_connected(view.client):
                continue
            # Before it is drawn: a script on another thread may be moving the camera meanwhile.
            camera = camera_state(view.client.camera)
            if is_new or (camera != view.camera and now >= view.due):
                view.camera, view.due = camera, now + drawing_style.DENSITY_PERIOD
                view.draw(self._dense, is_new)

    def _browsers(self) -> list[BrowserSights]:
        clients = self._server.get_clients()
        with self._lock:
            for number, client in clients.items():
                # One that has left meanwhile would never be forgotten.
                if number not in self._views and is_connected(client):
                    self._views[number] = BrowserSights(client)
            return list(self._views.values())

    async def _remove_client(self, client: ClientHandle) -> None:
        """On the event loop: viser's thread pool may be gone when the server stops."""
        with self._lock:
            self._views.pop(client.client_id, None)


class RecordedDensity:
    """Draws flocks in the plane of which no agent can be told apart for a recording: all of them,
    since whoever watches it moves a camera of their own."""

    def __init__(self, server: ViserServer) -> None:
        self._scene = server.scene
        self._images: dict[int, ImageHandle] = {}
        """By side."""

    def show(self, sights: tuple[Sight, ...]) -> None:
        """Draw a new frame."""
        for side, sight in enumerate(sights):
            if not sight.picture.shows_density:
                continue
            region = flock_region(sight.picture.frame)
            file = DenseFlock(sight, region).file(region, sight.picture.count)
            if side not in self._images:
                root = f"/sight{side}"
                self._scene.add_frame(root, show_axes=False, position=tuple(sight.aside.tolist()))
                self._images[side] = add_jpeg(self._scene, f"{root}/density", file.data)
            show_file(self._images[side], file, sight.picture.stage)

    def follow(self) -> None:
        """No camera is followed."""

    def in_sight(self, _client: ClientHandle) -> tuple[FlockInSight, ...]:
        """Nobody watches while it is recorded."""
        return ()
