"""Flocks of which no agent can be told apart, as each browser sees them: a picture of their density
in what its camera has in sight, and from near the agents themselves.
"""

from __future__ import annotations

import io
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from PIL import Image
from viser import CameraHandle, ClientHandle, ImageHandle, ViserServer

from app.front.viser_internals import add_jpeg, camera_report, is_connected, show_jpeg
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
from app.viewer.scene.marks.agents import Agents, FlockMotion
from app.viewer.scene.shown import drawing_style

# What of a flat world a camera has in sight.

FARTHEST = 100.0
"""How far a camera sees, in sides of the world: it may look at the horizon."""
MARGIN = 0.12
"""How much more is drawn at each side than is in sight, as a share: a camera moves on at once."""
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
KEEPS = 1.1
"""Single agents are drawn until so many times as many are in sight as they begin to be drawn of."""


class FlockInSight:
    """What is drawn of a flock in one browser, below a node of its own."""

    def __init__(self, client: ClientHandle, side: int, aside: np.ndarray) -> None:
        self.client, self.aside = client, aside
        self.root = f"/sight{side}"
        self.node = client.scene.add_frame(
            self.root, show_axes=False, position=tuple(aside.tolist())
        )
        self.image: ImageHandle | None = None
        self.agents: Agents | None = None
        self.region: PlaneRegion | None = None
        """What is drawn of the world; None: the camera looks elsewhere."""
        self.as_singles = False
        self.count = 0
        """Agents in sight."""
        self.typical = 0.0
        """Their density where the picture has half its strength, per length squared."""

    def look(self, flock: DenseFlock) -> bool:
        """See what the camera has in sight now; whether another picture is to be drawn for it."""
        picture, before = flock.sight.picture, (self.as_singles, self.region)
        seen = region_in_sight(self.client.camera, picture, self.aside).intersection(flock.region)
        if seen is None:
            self.count, self.region = 0, None
            return before[1] is not None
        self.count = count_within(picture.frame.position, *seen.low, *seen.high)
        most = drawing_style.SINGLES_UP_TO * (KEEPS if self.as_singles else 1.0)
        self.as_singles = self.count <= most
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
        middle = picture.stage.to_display(0.5 * np.add(file.region.low, file.region.high))
        wide, deep = picture.stage.scale * np.array(file.region.sides)
        self.image.position = (float(middle[0]), float(middle[1]), FLOOR)
        self.image.scale = (float(wide), float(deep), 1.0)
        show_jpeg(self.image, file.data)

    def draw_singles(self, picture: Picture) -> None:
        """Show the agents of the region, or none."""
        position, region = picture.frame.position, self.region
        rows = np.empty(0, np.int64)
        if region is not None and self.as_singles:
            rows = np.empty(count_within(position, *region.low, *region.high), np.int64)
            fill_rows_within(position, *region.low, *region.high, rows)
            self.agents = self.agents or Agents(self.client.scene, self.root, FlockMotion())
        if self.agents is not None:
            for handle, name, value in self.agents.draw(picture.of_rows(rows)):
                setattr(handle, name, value)

    def end(self) -> None:
        """Draw nothing any more."""
        self.node.remove()  # With all that is below it.


@dataclass
class BrowserSights:
    """What one browser draws of all flocks."""

    client: ClientHandle
    flocks: dict[int, FlockInSight] = field(default_factory=dict)
    """By side."""
    report: object = None
    """What it had told of its camera when this was drawn."""
    due: float = 0.0
    """When it is drawn again at the soonest because its camera moves, s."""

    def draw(self, dense: Mapping[int, DenseFlock], is_new: bool) -> None:
        """Draw flocks; if they are not new, only what else a camera that has moved has in sight."""
        for side, flock in list(self.flocks.items()):
            if side not in dense or not np.array_equal(flock.aside, dense[side].sight.aside):
                flock.end()
                del self.flocks[side]
        for side, there in dense.items():
            if side not in self.flocks:
                self.flocks[side] = FlockInSight(self.client, side, there.sight.aside)
            if self.flocks[side].look(there) or is_new:
                self.flocks[side].draw(there)


class DensityViews:
    """Draws flocks of which no agent can be told apart, for each browser; for one thread."""

    def __init__(self, server: ViserServer) -> None:
        self._server = server
        # Browsers leave on viser's loop.
        self._lock = threading.Lock()
        self._views: dict[int, BrowserSights] = {}
        self._dense: dict[int, DenseFlock] = {}
        """By side."""
        server.on_client_disconnect(self._remove_client)

    def show(self, sights: tuple[Sight, ...]) -> None:
        """Draw a new frame."""
        self._dense = {
            side: DenseFlock(sight, flock_region(sight.picture.frame))
            for side, sight in enumerate(sights)
            if sight.picture.shows_density
        }
        self._draw(is_new=True)

    def follow(self) -> None:
        """Draw for cameras that have moved."""
        if self._dense:
            self._draw(is_new=False)

    def in_sight(self, client: ClientHandle) -> tuple[FlockInSight, ...]:
        """What one browser sees of such flocks; empty where all agents are drawn."""
        view = self._views.get(client.client_id)
        return () if view is None else tuple(view.flocks.values())

    def _draw(self, is_new: bool) -> None:
        if not (self._dense or self._views):
            return
        now = time.monotonic()
        for view in self._browsers():
            if not is_connected(view.client):
                continue
            report = camera_report(view.client.camera)
            if is_new or (report is not view.report and now >= view.due):
                view.report, view.due = report, now + drawing_style.DENSITY_PERIOD
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
