"""The sheet of a picture or of a film: title, caption, scene, legend and scale, once laid out."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from app.figure import write_figure
from app.viewer.pictures import key
from app.viewer.pictures.plane import Plane
from app.viewer.pictures.plots import TALL, Plots
from app.viewer.pictures.shot import Shot
from app.viewer.pictures.space import Space
from app.viewer.scene.shown.look import MEASURED
from app.worlds.colours import INK, LOOK

USUAL = 1200.0 * 800.0
"""Pixels of a sheet at which a point of type is a hundredth of an inch and a third."""
SIDE, ABOVE, BELOW = 0.34, 0.84, 0.62
"""Inches around the scene."""
COLUMN, ENTRY, ROW, SIGN = 2.35, 2.0, 0.23, 1.25
"""Inches: the column of the legend, the width of an entry below the scene, its height, a wheel."""
SCALES = ("speed", MEASURED)
"""Colourings whose numbers change from tick to tick."""
SPACE_ASPECT = 1.12
"""Width over height of what is shown in space, about."""


class Sheet:
    """A figure of `size` pixels on which shots of one run are shown, one after the other.

    `follow`: the identity of an agent that the camera follows. `plots` are drawn below. Raises
    Refusal.
    """

    def __init__(
        self,
        first: Shot,
        size: tuple[int, int],
        follow: int | None = None,
        plots: Plots | None = None,
    ):
        import matplotlib
        from matplotlib.backends.backend_agg import FigureCanvasAgg
        from matplotlib.figure import Figure

        self.size, self.follow = size, follow
        self.dots = max(20, round(100.0 * (size[0] * size[1] / USUAL) ** 0.5))
        self.inches = np.array([(side + 0.01) / self.dots for side in size])
        self.plots, self.room = plots, TALL if plots else 0.0
        self.background: Any = None
        """What does not move, as it was drawn last."""
        self.look = {**LOOK, "svg.fonttype": "path"}
        with matplotlib.rc_context(self.look):  # type: ignore[arg-type]
            self.figure: Any = Figure(figsize=tuple(self.inches), dpi=self.dots)
            self.canvas = FigureCanvasAgg(self.figure)
            self.lay_out(first)
            if plots:
                plots.draw(self.figure, first.now)
            self.show(first)

    def lay_out(self, first: Shot) -> None:
        """Make the scene as large as it can be, the legend beside or below it."""
        figure, world = self.figure, first.now.world
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        flat = world.dim == 2
        self.scene: Any = (
            Plane(axes, world, self.follow)
            if flat
            else Space(axes, world, SPACE_ASPECT, self.follow)
        )
        self.scene.begin(first)
        low, high = axes.get_xlim(), axes.get_ylim()
        aspect = (low[1] - low[0]) / (high[1] - high[0])
        signs = key.signs(first, self.scene.signs)
        wide, tall = self.inches
        columns = max(1, int((wide - 2.0 * SIDE - key.has_wheel(first) * SIGN) / ENTRY))
        rows = -(-len(signs) // columns)
        strip = max(rows * ROW + 0.3, key.has_wheel(first) * SIGN)
        heights = tall - ABOVE - BELOW - self.room
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
        self.head(first)
        axes.apply_aspect()
        if self.follow is not None:
            self.scene.show(first)
        self.rule(first, bottom)

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
            key.draw_wheel(figure.add_axes(box), first.now.world.dim)
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

    def head(self, first: Shot) -> None:
        """Title and caption, and on the right the moment."""
        figure, (wide, tall) = self.figure, self.inches
        y = (tall - 0.24) / tall
        figure.text(SIDE / wide, y, key.title(first), va="top", fontsize=14, color=INK,
                    weight="bold")  # fmt: skip
        figure.text(SIDE / wide, (tall - 0.53) / tall, key.caption(first), va="top", fontsize=10,
                    color=key.GREY)  # fmt: skip
        self.moment = figure.text((wide - SIDE) / wide, y, "", va="top", ha="right", fontsize=14,
                                  color=INK)  # fmt: skip

    def rule(self, first: Shot, bottom: float) -> None:
        """The scale bar, below the scene."""
        tall = self.inches[1]
        axes, world = self.scene.axes, first.now.world
        if world.dim == 2:
            key.draw_ruler(self.figure, axes, first, (bottom - 0.24) / tall)
        elif self.follow is None:
            self.scene.rule(*key.ruler(first, 0.3 * max(world.size[:2])))

    @property
    def moving(self) -> list[Any]:
        """What has to be drawn again for each shot."""
        return [*self.scene.moving, self.moment, *(self.plots.lines if self.plots else ())]

    def show(self, shot: Shot) -> None:
        """Show another shot of the run. Raises Refusal if the followed agent is gone."""
        self.scene.show(shot)
        self.moment.set_text(key.moment(shot))
        words = [words for words, _ in shot.entries]
        for text, word in zip(self.words, words, strict=False):
            if text.get_text() != word and shot.made.look.colour in SCALES:
                text.set_text(word)
                self.background = None

    def is_outgrown_by(self, shot: Shot) -> bool:
        """Whether a shot has more colours to explain than the legend has."""
        return len(shot.entries) > self.explained

    def pixels(self) -> np.ndarray:
        """The sheet as it is, (height, width, 3) uint8; what does not move is drawn once."""
        import matplotlib

        with matplotlib.rc_context(self.look):  # type: ignore[arg-type]
            if self.background is None or self.follow is not None:
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
        """Write it as its ending says: PNG, SVG or PDF. Raises Refusal."""
        import matplotlib

        with matplotlib.rc_context(self.look):  # type: ignore[arg-type]
            write_figure(self.figure, path, self.dots)
