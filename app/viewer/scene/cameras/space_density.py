"""Flocks in space of which no agent can be told apart, as one browser sees them: a picture of their
density that its camera makes, and those near to it one by one.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from PIL import Image
from viser import CameraHandle, ClientHandle

from app.front.viser_internals import DEPTH_STEP, show_background
from app.viewer.scene.cameras.flock_in_sight import MARGIN, FlockInSight
from app.viewer.scene.cameras.viewpoints import Sight
from app.viewer.scene.draw.drawn_frame import Picture
from app.viewer.scene.draw.projected_density import (
    NEAREST,
    Lens,
    ProjectedDensity,
    count_by_depth,
    fill_rows_in_view,
    projected_density,
)
from app.viewer.scene.marks.world_box import sky, sky_rows

# What of a flock is drawn one by one.

NEAR_UP_TO = 3_000
"""As many agents near the camera are drawn one by one, in front of the density of the others."""
LARGE = 12.0
"""An agent is near that is so many pixels long."""
STEPS = 32
"""Depths that are told apart where more than `NEAR_UP_TO` would be near."""


def camera_lens(camera: CameraHandle, picture: Picture, aside: np.ndarray) -> Lens:
    """A browser's camera on the flock of a picture, whose room stands `aside` (3,)."""
    return Lens.of(
        np.asarray(camera.position, float) - aside,
        np.asarray(camera.look_at, float) - aside,
        np.asarray(camera.up_direction, float),
        camera.fov,
        camera_aspect(camera),
        picture.stage,
    )


def camera_aspect(camera: CameraHandle) -> float:
    """Width over height of what a browser's camera sees; a browser may say what it likes."""
    aspect = camera.image_width / max(camera.image_height, 1)
    return float(np.clip(aspect, 0.1, 10.0)) if np.isfinite(aspect) else 1.0


def near_within(camera: CameraHandle, picture: Picture) -> float:
    """How far ahead an agent is `LARGE`, display units; a number, whatever a browser says."""
    with np.errstate(all="ignore"):
        tall = 2.0 * np.tan(0.5 * camera.fov) * LARGE / max(camera.image_height, 1)
        reach = picture.length / tall
    return float(np.clip(reach, 2.0 * NEAREST, picture.stage.side)) if reach > 0.0 else NEAREST


class SpaceFlockInSight(FlockInSight):
    """What is drawn of a flock in space in one browser, in front of the density."""

    lens: Lens | None = None
    within = NEAREST
    """Agents are drawn one by one that are no farther ahead, display units; infinite: all."""

    def look(self, sight: Sight) -> bool:
        """See what the camera has in sight now; whether anything of it is another than before."""
        picture, camera = sight.picture, self.client.camera
        lens = camera_lens(camera, picture, self.aside)
        if self.lens is not None and np.array_equal(lens.axes, self.lens.axes, equal_nan=True):
            return False
        self.lens = lens
        return True

    def count_agents(self, sight: Sight) -> None:
        """Count who is in sight, and choose who is drawn one by one."""
        assert self.lens is not None
        counts = np.zeros(STEPS + 1, np.int64)
        step = near_within(self.client.camera, sight.picture) / STEPS
        count_by_depth(sight.picture.frame.position, self.lens.axes, NEAREST, step, counts)
        self.count = int(counts.sum())
        self.as_singles = self.are_few(self.count)
        met = np.cumsum(counts[:STEPS])
        steps = int(np.searchsorted(met, NEAR_UP_TO, side="right"))
        self.within = np.inf if self.as_singles else max(steps * step, NEAREST)
        self.near = int(met[steps - 1]) if steps and not self.as_singles else 0

    def draw_singles(self, picture: Picture) -> None:
        """Show the agents that are drawn one by one, and those just outside of the view."""
        assert self.lens is not None
        if not (self.as_singles or self.near):
            return self.draw_rows(picture, np.empty(0, np.int64))
        position, axes = picture.frame.position, self.lens.widened(MARGIN).axes
        counts = np.zeros(2, np.int64)
        count_by_depth(position, axes, NEAREST, self.within, counts)
        rows = np.empty(counts[0], np.int64)
        found = fill_rows_in_view(position, axes, NEAREST, self.within, rows)
        return self.draw_rows(picture, rows[:found])


# The picture of the density, which all flocks of a browser share.


class ViewFile(NamedTuple):
    """The files of a picture."""

    colours: bytes
    """A JPEG."""
    depth: bytes
    """A grey PNG, see `show_background`."""


QUALITY = 85
"""Of the colours, as JPEG counts it."""
BEHIND = 255
"""The grey of what is behind everything."""


def view_file(made: ProjectedDensity) -> ViewFile:
    """The files of a picture, with the sky where nobody is."""
    drawn = np.isfinite(made.depth)
    pixels = np.where(drawn[..., None], made.pixels, sky_rows(len(made.pixels))[:, None])
    steps = np.where(drawn, np.clip(made.depth / DEPTH_STEP, 1.0, BEHIND - 1.0), BEHIND)
    colours, depth = io.BytesIO(), io.BytesIO()
    Image.fromarray(pixels).save(colours, "jpeg", quality=QUALITY)
    Image.fromarray(steps.astype(np.uint8)).save(depth, "png", compress_level=1)
    return ViewFile(colours.getvalue(), depth.getvalue())


Files = dict[tuple[object, ...], ViewFile]
"""Of one frame, by what is drawn from where: browsers that look from where they were put share
them."""


@dataclass
class DensityBackdrop:
    """The picture of the density of all flocks in space that a browser shows."""

    client: ClientHandle
    is_shown: bool = False

    def draw(
        self, sights: Mapping[int, Sight], flocks: Mapping[int, SpaceFlockInSight], files: Files
    ) -> None:
        """Show the density of the flocks of some sides; of none, the sky."""
        if sights:
            aspect = camera_aspect(self.client.camera)
            file = find_file(sights, flocks, aspect, files)
            show_background(self.client.scene, file.colours, file.depth)
        elif self.is_shown:
            show_background(self.client.scene, sky())
        self.is_shown = bool(sights)


def find_file(
    sights: Mapping[int, Sight],
    flocks: Mapping[int, SpaceFlockInSight],
    aspect: float,
    files: Files,
) -> ViewFile:
    """The picture of some flocks, which is made if nobody has asked for it yet."""
    seen, count = [], 0
    key: list[object] = [aspect]
    for side, sight in sights.items():
        flock, frame = flocks[side], sight.picture.frame
        assert flock.lens is not None
        rows = slice(None) if frame.active is None else frame.active
        seen.append((frame.position[rows], frame.heading[rows], flock.lens, flock.within))
        key += [side, flock.lens.axes.tobytes(), flock.within]
        count += flock.count
    if tuple(key) not in files:
        files[tuple(key)] = view_file(projected_density(seen, aspect, count))
    return files[tuple(key)]
