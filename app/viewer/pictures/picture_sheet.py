"""The sheet of a picture or of a film: title, caption, scene, legend and scale, once laid out."""

from __future__ import annotations

import io
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from app.figure import save_figure, write_figure
from app.viewer.pictures import key
from app.viewer.pictures.picture_camera import Camera
from app.viewer.pictures.plane import TALL, Plane, Plots
from app.viewer.pictures.shot import Shot
from app.viewer.pictures.space_picture import SpacePicture
from app.viewer.scene.shown.colouring import COLOURINGS
from app.worlds.world_picture import INK, LOOK
from worlds.world import World

USUAL = 1200.0 * 800.0
"""Pixels of a sheet at which a point of type is a hundredth of an inch and a third."""
SIDE, ABOVE, BELOW = 0.34, 0.84, 0.62
"""Inches around the scene."""
LINE, LETTER = 0.19, 0.075
"""Inches: a line of the caption, and a letter of it."""
COLUMN, ENTRY, ROW, SIGN = 2.35, 2.0, 0.23, 1.25
"""Inches: the column of the legend, the width of an entry below the scene, its height, a wheel."""
SPACE_ASPECT = 1.12
"""Width over height of what is shown in space, about."""


class Sheet:
    """A figure of `size` pixels on which shots of one run are shown, one after the other.

    `camera`: from where it is seen, unless from where is usual. `plots` are drawn below. `scene`
    makes what the axes hold; otherwise it is drawn here. Raises InputError.
    """

    def __init__(
        self,
        first: Shot,
        size: tuple[int, int],
        camera: Camera | None = None,
        plots: Plots | None = None,
        scene: Callable[[Any], Any] | None = None,
    ):
        import matplotlib
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self.size, self.camera = size, camera or Camera.of(first)
        self.dots = max(20, round(100.0 * (size[0] * size[1] / USUAL) ** 0.5))
        self.inches = np.array([(side + 0.01) / self.dots for side in size])
        self.scene_on = scene or partial(draw_world, first.now.world, self.camera)
        self.plots, self.room = plots, TALL if plots else 0.0
        self.background: Any = None
        """What does not move, as it was drawn last."""
        self.look = {**LOOK, "svg.fonttype": "path"}
        with matplotlib.rc_context(self.look):  # type: ignore[arg-type]
            self.figure: Any = Figure(figsize=tuple(self.inches), dpi=self.dots)
            self.canvas = FigureCanvasAgg(self.figure)
            self.lay_out(first)
            if plots:
                plots.draw(self.figure, first.now.model)
            self.show(first)

    def lay_out(self, first: Shot) -> None:
        """Make the scene as large as it can be, the legend beside or below it."""
        figure = self.figure
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        self.scene: Any = self.scene_on(axes)
        self.scene.begin(first)
        low, high = axes.get_xlim(), axes.get_ylim()
        aspect = (low[1] - low[0]) / (high[1] - high[0])
        signs = key.signs(first, self.scene.signs)
        wide, tall = self.inches
        columns = max(1, int((wide - 2.0 * SIDE - key.has_wheel(first) * SIGN) / ENTRY))
        rows = -(-len(signs) // columns)
        strip = max(rows * ROW + 0.3, key.has_wheel(first) * SIGN)
        changes = key.changes(first)
        heights = tall - ABOVE - (LINE if changes else 0.0) - BELOW - self.room
        beside = min(wide - 2.0 * SIDE - COLUMN, heights * aspect)
        below = min(wide - 2.0 * SIDE, (heights - strip) * aspect)
        is_beside = beside >= below
        width = max(beside if is_beside else below, 0.1)
        height = width / aspect
        block = width + (COLUMN if is_beside else 0.0)
        left = max(SIDE, 0.5 * (wide - block)) if is_beside else 0.5 * (wide - width)
        free = heights - height - (0.0 if is_beside else strip)
        bottom = self.room + BELOW + (0.0 if is_beside else strip) + 0.5 * max(free, 0.0)
        axes.set_position((left / wide, bottom / tall, width / wide, height / tall))
        top = bottom + height
        if is_beside:
            self.legend(signs, first, (left + width + 0.16, top), 1)
        else:
            self.legend(signs, first, (left, bottom - BELOW + 0.08), columns)
        self.head(first, changes)
        axes.apply_aspect()
        if self.camera.moves:
            self.scene.show(first)
        self.scene.rule(self.figure, first, (bottom - 0.24) / tall)

    def legend(self, signs: list[Any], first: Shot, at: tuple[float, float], columns: int) -> None:
        """The legend with its upper left corner at a place, inches."""
        figure, (wide, tall) = self.figure, self.inches
        x, y = at
        name = key.coloured_by(first)
        if name:
            figure.text(x / wide, y / tall, f"colour: {name}", va="top", color=INK, fontsize=10,
                        weight="bold")  # fmt: skip
            y -= 0.24
        if key.has_wheel(first):
            box = (x / wide, (y - SIGN) / tall, SIGN / wide, SIGN / tall)
            key.draw_wheel(figure.add_axes(box), first.now.world.dim, first.made.shows_density)
            x, y = (x, y - SIGN - 0.05) if columns == 1 else (x + SIGN + 0.1, y)
        self.explained, self.words = len(first.entries), []
        if signs:
            made = figure.legend(
                handles=signs, loc="upper left", bbox_to_anchor=(x / wide, y / tall),
                ncols=min(columns, len(signs)), fontsize=9.5, labelcolor=INK, borderpad=0.0,
                borderaxespad=0.0, handletextpad=0.5, handlelength=1.5, columnspacing=1.6,
                labelspacing=0.45,
            )  # fmt: skip
            self.words = list(made.get_texts())[: self.explained]

    def head(self, first: Shot, changes: str) -> None:
        """Title, caption and what of the parameters is changed; on the right the moment."""
        figure, (wide, tall) = self.figure, self.inches
        y = (tall - 0.24) / tall
        figure.text(SIDE / wide, y, key.title(first), va="top", fontsize=14, color=INK,
                    weight="bold")  # fmt: skip
        figure.text(SIDE / wide, (tall - 0.53) / tall, key.caption(first), va="top", fontsize=10,
                    color=key.GREY)  # fmt: skip
        if changes:
            room = max(int((wide - 2.0 * SIDE) / LETTER), 8)
            text = changes if len(changes) <= room else f"{changes[: room - 4]} ..."
            figure.text(SIDE / wide, (tall - 0.53 - LINE) / tall, text, va="top", fontsize=10,
                        color=key.GREY)  # fmt: skip
        self.moment = figure.text((wide - SIDE) / wide, y, "", va="top", ha="right", fontsize=14,
                                  color=INK)  # fmt: skip

    @property
    def box(self) -> tuple[int, int, int, int]:
        """Where the scene is: left, top, width and height, whole pixels."""
        at = self.scene.axes.get_position()
        wide, tall = self.size
        left, top = round(at.x0 * wide), round((1.0 - at.y1) * tall)
        return (
            left,
            top,
            max(round(at.x1 * wide) - left, 1),
            max(round(at.y1 * tall) - round(at.y0 * tall), 1),
        )

    @property
    def moving(self) -> list[Any]:
        """What has to be drawn again for each shot."""
        return [*self.scene.moving, self.moment, *(self.plots.lines if self.plots else ())]

    def show(self, shot: Shot) -> None:
        """Show another shot of the run. Raises InputError if the followed agent is gone."""
        self.scene.show(shot)
        self.moment.set_text(key.moment(shot))
        words = [words for words, _ in shot.entries]
        for text, word in zip(self.words, words, strict=False):
            if text.get_text() != word and COLOURINGS[shot.made.look.colour].rescales:
                text.set_text(word)
                self.background = None

    def is_outgrown_by(self, shot: Shot) -> bool:
        """Whether a shot has more colours to explain than the legend has."""
        return len(shot.entries) > self.explained

    def pixels(self) -> np.ndarray:
        """The sheet as it is, (height, width, 3) uint8; what does not move is drawn once."""
        import matplotlib

        with matplotlib.rc_context(self.look):  # type: ignore[arg-type]
            if self.background is None or self.camera.moves:
                for one in self.moving:
                    one.set_animated(True)
                self.canvas.draw()
                self.background = self.canvas.copy_from_bbox(self.figure.bbox)
            else:
                self.canvas.restore_region(self.background)
            for one in sorted(self.moving, key=lambda one: one.get_zorder()):
                self.figure.draw_artist(one)
        return np.asarray(self.canvas.buffer_rgba())[..., :3]

    def write(self, path: Path) -> None:
        """Write it as its ending says: PNG, SVG or PDF. Raises InputError."""
        import matplotlib

        with matplotlib.rc_context(self.look):  # type: ignore[arg-type]
            write_figure(self.figure, path, self.dots)

    def as_bytes(self, ending: str) -> bytes:
        """The same as bytes."""
        import matplotlib

        made = io.BytesIO()
        with matplotlib.rc_context(self.look):  # type: ignore[arg-type]
            save_figure(self.figure, made, ending, self.dots)
        return made.getvalue()


def draw_world(world: World, camera: Camera, axes: Any) -> Plane | SpacePicture:
    """A world and the flock in it, drawn on axes."""
    if world.dim == 2:
        return Plane(axes, world, camera.follow)
    return SpacePicture(axes, world, SPACE_ASPECT, camera)
