"""What a browser shows, on a sheet with what its colours mean, a scale, and which run it is."""

from __future__ import annotations

import io
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from PIL import Image

from app.viewer.pictures import key
from app.viewer.pictures.picture_sheet import Sheet
from app.viewer.pictures.plots import Plots
from app.viewer.pictures.shot import Shot
from app.viewer.scene.cameras.camera import UP, CameraView
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.shown import palette
from app.viewer.web.renders import RenderCamera

Render = Callable[[tuple[int, int]], np.ndarray]
"""Has a browser draw so many pixels, (width, height) -> (height, width, 3) uint8."""
STRAIGHT = 0.9986
"""Cosine of how far a camera may be from straight down, 3 deg, that lengths can be read off."""
TURN = np.array([[-0.574, 1.430, 0.144], [0.426, 0.430, 0.144], [0.426, 1.430, -0.856]])
"""`hue-rotate(180deg)` of CSS."""
INVERTED = 0.92
"""`invert` of the dark theme: what `static/page.css` has in `--fs-drawn`."""


def eye_of(view: CameraView) -> RenderCamera:
    """A point of view as a browser is told it."""
    back = view.position - view.target
    back = back / np.linalg.norm(back)
    right = np.cross(UP, back)
    right = right / np.linalg.norm(right)
    turn = quaternion(np.stack([right, np.cross(right, back), -back], 1))
    return RenderCamera(view.position, turn, view.fov)


def quaternion(axes: np.ndarray) -> np.ndarray:
    """The quaternion (w, x, y, z) of a rotation (3, 3).

    >>> quaternion(np.diag([1.0, -1.0, -1.0])).tolist()
    [0.0, 1.0, 0.0, 0.0]
    """
    (a, b, c), (d, e, f), (g, h, i) = axes
    form = np.array([
        [a + e + i, h - f, c - g, d - b],
        [h - f, a - e - i, b + d, c + g],
        [c - g, b + d, e - a - i, f + h],
        [d - b, c + g, f + h, i - a - e],
    ])  # fmt: skip
    largest = np.linalg.eigh(form)[1][:, -1]
    return np.where(abs(largest) < 1e-12, 0.0, largest * np.copysign(1.0, largest[np.argmax(
        abs(largest))]))  # fmt: skip


def lengths_across(stage: Stage, eye: RenderCamera) -> float | None:
    """How long the picture of a flat world is from its lower to its upper edge, length.

    None where it is not seen from straight above, or is no flat world.
    """
    w, x, y, z = eye.wxyz
    ahead = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    if stage.dim == 3 or -ahead[2] < STRAIGHT:
        return None
    return float(2.0 * eye.position[2] * np.tan(0.5 * eye.fov) / stage.scale)


class BrowserScene:
    """The scene on its axes, where a browser's picture is put."""

    def __init__(self, axes: Any, first: Shot, aspect: float, eye: RenderCamera | None):
        self.axes = axes
        self.moving: list[Any] = []
        frame, stage = first.made.frame, first.made.stage
        self.signs = key.signs_of(
            frame.world,
            bool(frame.world.obstacles),
            palette.css(palette.LEADER),
            palette.css(palette.GOAL),
        )
        across = None if eye is None else lengths_across(stage, eye)
        self.has_scale = across is not None
        tall = across or 1.0
        axes.set(xlim=(0.0, tall * aspect), ylim=(0.0, tall), aspect="equal", xticks=[], yticks=[])
        axes.spines[:].set_visible(False)
        axes.set_facecolor("none")

    def begin(self, shot: Shot) -> None:
        """The browser draws it."""

    def show(self, shot: Shot) -> None:
        """The browser draws it."""

    def rule(self, figure: Any, shot: Shot, y: float) -> None:
        """The scale bar below the scene, where lengths can be read off."""
        if self.has_scale:
            key.draw_ruler(figure, self.axes, shot, y)


class SeenSheet:
    """A sheet of `size` pixels for what a browser shows, one shot after the other.

    `eye`: from where it is seen as long as the sheet is used; None: from here and there.
    """

    def __init__(
        self,
        first: Shot,
        size: tuple[int, int],
        aspect: float,
        eye: RenderCamera | None,
        plots: Plots | None = None,
    ):
        scene = partial(BrowserScene, first=first, aspect=aspect, eye=eye)
        self.sheet = Sheet(first, size, plots=plots, scene=scene)

    def picture(self, shot: Shot, render: Render, dark: bool = False) -> np.ndarray:
        """A shot as the browser shows it now, (height, width, 3) uint8. Raises InputError."""
        left, top, wide, tall = self.sheet.box
        seen = render((wide, tall))
        self.sheet.show(shot)
        made = self.sheet.pixels().copy()
        made[top : top + tall, left : left + wide] = seen
        return darkened(made) if dark else made


def darkened(pixels: np.ndarray) -> np.ndarray:
    """What the dark theme makes of a light picture: lightness turned round, hues as they are.

    >>> darkened(np.full((1, 1, 3), 255, np.uint8)).tolist()
    [[[20, 20, 20]]]
    """
    inverted = np.column_stack([(1.0 - 2.0 * INVERTED) * TURN, np.full(3, 255.0 * INVERTED)])
    return np.asarray(Image.fromarray(pixels).convert("RGB", tuple(inverted.ravel().tolist())))


def as_png(pixels: np.ndarray) -> bytes:
    """A picture as PNG."""
    made = io.BytesIO()
    Image.fromarray(pixels).save(made, "png", optimize=False)
    return made.getvalue()
