"""Simulated cars beside real ones: of glass, with their outlines drawn."""

from __future__ import annotations

import numpy as np
from viser import BatchedMeshHandle, SceneApi

from app.viewer.scene.draw.agent_meshes import (
    HEIGHT,
    TREAD,
    WHEEL,
    cabin,
    hubs,
    hull,
    outline,
    wheel,
)
from app.viewer.scene.draw.attitude import attitude, quantise_attitudes, rounded_places
from app.viewer.scene.draw.drawn_frame import PALE, Changes, Picture
from app.viewer.scene.draw.line_segments import add_lines, segments
from app.viewer.scene.draw.shapes import Mesh
from app.viewer.scene.shown import palette
from app.viewer.scene.shown.drawing_style import SHADOWS_UP_TO
from app.viewer.scene.shown.frame import LOST, SIMULATED

# The agents as cars: hull, cabin and four wheels, meshes with an instance for each car.

HUBS = hubs()


class CarMeshes:
    """Any number of cars; nodes are called `name`/..."""

    def __init__(self, scene: SceneApi, name: str) -> None:
        self._hulls = add_cars(scene, f"{name}/hulls", hull())
        self._cabins = add_cars(scene, f"{name}/cabins", cabin())
        self._wheels = add_cars(scene, f"{name}/wheels", wheel())

    def draw(
        self,
        at: np.ndarray,
        azimuth: np.ndarray,
        steering: np.ndarray,
        size: np.ndarray,
        colour: np.ndarray,
        shadows: bool,
        pale: np.ndarray | None = None,
    ) -> Changes:
        """Draw N cars on the road: their middles `at` (N, 3) on the display, headings `azimuth`
        (N,) and angles of the front wheels `steering` (N,), rad, lengths and widths `size` (N, 2)
        on the display, colours (N, 3) sRGB of their hulls, and the share `pale` (N,) of the floor
        in those of their windows and wheels."""
        if not len(at):
            return self.hide()
        bodies = np.column_stack([size, HEIGHT * size[:, 1]])
        ahead, length = facing(azimuth), float(size[0, 0])
        hub, rolling = wheels(at, azimuth, steering, size)
        tyres = np.column_stack([WHEEL * size[:, 0], TREAD * size[:, 1], WHEEL * size[:, 0]])
        paleness = np.zeros((len(at), 1)) if pale is None else pale[:, None]
        dark = palette.GLASS + paleness * (palette.FLOOR - palette.GLASS)
        rubber = palette.TYRE + paleness.repeat(4, axis=0) * (palette.FLOOR - palette.TYRE)
        changes: Changes = []
        for node, place, wxyz, scale, paint in (
            (self._hulls, at, ahead, bodies, colour),
            (self._cabins, at, ahead, bodies, dark),
            (self._wheels, hub, rolling, np.repeat(tyres, 4, axis=0), rubber),
        ):
            changes += [
                (node, "batched_positions", rounded_places(place, length)),
                (node, "batched_wxyzs", quantise_attitudes(wxyz)),
                (node, "batched_scales", scale.astype(np.float32)),
                (node, "batched_colors", palette.lit_bytes(paint)),
                (node, "cast_shadow", shadows),
                (node, "visible", True),
            ]
        return changes

    def hide(self) -> Changes:
        """Draw none."""
        return [(node, "visible", False) for node in (self._hulls, self._cabins, self._wheels)]


class Fleet:
    """A flock of cars; beside real ones those that are simulated are `Ghosts`."""

    def __init__(self, scene: SceneApi, root: str) -> None:
        self._cars = CarMeshes(scene, f"{root}/flock/cars")

    def draw(self, picture: Picture, rows: np.ndarray | slice) -> Changes:
        """Draw the agents of some rows as cars."""
        cars, live = picture.frame.cars, picture.live
        rows = np.arange(len(picture.at))[rows]
        if live is not None:
            rows = rows[~live.is_in_state(SIMULATED)[rows]]
        at = picture.at[rows]
        if cars is None or not len(at):
            return self._cars.hide()
        heading = picture.frame.heading[rows]
        length = picture.length * picture.size[rows]
        road = at.copy()
        road[:, 2] = 0.0
        return self._cars.draw(
            road,
            np.arctan2(heading[:, 1], heading[:, 0]),
            cars.steering[rows],
            np.column_stack([length, length * cars.width / cars.length]),
            picture.colour[rows],
            picture.look.shadows and len(at) <= SHADOWS_UP_TO,
            None if live is None else PALE * live.is_in_state(LOST)[rows],
        )


def facing(azimuth: np.ndarray) -> np.ndarray:
    """Attitudes (N, 4) of what stands upright and points to `azimuth` (N,), rad."""
    return attitude(np.column_stack([np.cos(azimuth), np.sin(azimuth)]))


def wheels(
    at: np.ndarray, azimuth: np.ndarray, steering: np.ndarray, size: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Where the hubs of N cars are, (4 N, 3), and the attitudes of the wheels, (4 N, 4).

    The arguments are those of `CarMeshes.draw`; the wheels of a car follow each other as `hubs`.
    """
    ahead = np.column_stack([np.cos(azimuth), np.sin(azimuth)])
    left = np.column_stack([-ahead[:, 1], ahead[:, 0]])
    x, y = HUBS[:, 0] * size[:, :1], HUBS[:, 1] * size[:, 1:]
    hub = np.zeros((len(at), 4, 3))
    hub[..., :2] = at[:, None, :2] + x[..., None] * ahead[:, None] + y[..., None] * left[:, None]
    hub[..., 2] = at[:, None, 2] + 0.5 * WHEEL * size[:, :1]
    angle = azimuth[:, None] + steering[:, None] * np.array([0.0, 0.0, 1.0, 1.0])
    return hub.reshape(-1, 3), facing(angle.ravel())


def add_cars(
    scene: SceneApi, name: str, mesh: Mesh, opacity: float | None = None
) -> BatchedMeshHandle:
    """A node of any number of parts of cars, hidden; what is not opaque casts no shadow."""
    return scene.add_batched_meshes_simple(
        name,
        *mesh,
        batched_wxyzs=np.array([[1.0, 0.0, 0.0, 0.0]]),
        batched_positions=np.zeros((1, 3)),
        batched_scales=np.ones((1, 3)),
        batched_colors=np.zeros((1, 3), dtype=np.uint8),
        flat_shading=True,
        lod="off",
        opacity=opacity,
        cast_shadow=opacity is None,
        receive_shadow=False,
        visible=False,
    )


OUTLINE = outline()
INK = palette.node_colour(palette.STATES[SIMULATED])
GLASSY = 0.35
"""Opacity of a hull."""
THICK = 1.8
"""Width of its outline, pixels."""


class Ghosts:
    """They cast no shadow: nothing stands there."""

    def __init__(self, scene: SceneApi, root: str) -> None:
        name = f"{root}/flock/simulated"
        self._hulls = add_cars(scene, f"{name}/hulls", hull(), GLASSY)
        self._cabins = add_cars(scene, f"{name}/cabins", cabin(), GLASSY)
        self._lines = add_lines(scene, f"{name}/outlines", THICK)

    def draw(self, picture: Picture) -> Changes:
        """Draw the simulated cars, if there are real ones."""
        live, cars = picture.live, picture.frame.cars
        rows = np.empty(0, int) if live is None else np.flatnonzero(live.is_in_state(SIMULATED))
        if cars is None or not len(rows):
            nodes = (self._hulls, self._cabins, self._lines)
            return [(node, "visible", False) for node in nodes]
        at, heading = picture.at[rows] * [1.0, 1.0, 0.0], picture.frame.heading[rows]
        length = picture.length * picture.size[rows]
        width = length * cars.width / cars.length
        size = np.column_stack([length, width, HEIGHT * width])
        turned = facing(np.arctan2(heading[:, 1], heading[:, 0]))
        changes: Changes = []
        for node, paint in (
            (self._hulls, picture.colour[rows]),
            (self._cabins, np.tile(palette.GLASS, (len(rows), 1))),
        ):
            changes += [
                (node, "batched_positions", at.astype(np.float32)),
                (node, "batched_wxyzs", turned),
                (node, "batched_scales", size.astype(np.float32)),
                (node, "batched_colors", palette.lit_bytes(paint)),
                (node, "visible", True),
            ]
        return [
            *changes,
            *segments(self._lines, outlines(at, heading, size), INK),
        ]


def outlines(at: np.ndarray, heading: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Outlines (K, 2, 3) of cars at (N, 3) that look along unit vectors (N, 2), with lengths,
    widths and heights (N, 3)."""
    x, y, z = np.moveaxis(OUTLINE[None] * size[:, None, None, :], -1, 0)
    (ahead_x, ahead_y) = (heading[:, axis, None, None] for axis in (0, 1))
    turned = np.stack([x * ahead_x - y * ahead_y, x * ahead_y + y * ahead_x, z], axis=-1)
    return (turned + at[:, None, None, :]).reshape(-1, 2, 3)
