"""The run so far as curves."""

from __future__ import annotations

import numpy as np
import viser
from viser import uplot

from app.viewer.beside import ratio
from app.viewer.frame import Frame
from app.viewer.panels.style import BLUE, GREEN, ORANGE, VIOLET, block, key
from app.viewer.readings import Course, Readings

HEIGHT = 160
PADDING = (10, 14, 0, 0)
DASH = (6.0, 5.0)


class Plots:
    """Order and structure of the flock over time."""

    def __init__(self, gui: viser.GuiApi):
        gui.add_html(head("Order", [("polarisation", BLUE), ("consistency", GREEN)]))
        self.order = chart(gui, (BLUE, GREEN), uplot.Scale(range=(0.0, 1.02)))
        gui.add_html(head("Neighbours", [("mean number within r", ORANGE)]))
        self.neighbours = chart(gui, (ORANGE,), uplot.Scale(range=(0.0, None)))
        self.goal_head = gui.add_html("", visible=False)
        self.goal = chart(gui, (VIOLET,), uplot.Scale(range=(0.0, None)))
        self.goal.visible = False

    def refresh(self, readings: Readings, frame: Frame, beside: Readings | None = None) -> None:
        """Draw the run as far as it has come; dashed, that of the flock beside."""
        second = frame.beside
        if beside is None or second is None:
            beside, each = None, 1.0
        else:
            each = ratio(second.dt, second.unit, frame.dt, frame.unit)
        mission = frame.world.mission
        has_goal = mission is not None and mission.goal is not None
        has_end = mission is not None and (has_goal or mission.path is not None)
        self.goal.visible = self.goal_head.visible = has_end
        if has_end:
            words = "the goal" if has_goal else "the path's end"
            self.goal_head.content = head(
                "Mission", [(f"distance of the flock's centre to {words}", VIOLET)]
            )
            both = both_runs(readings.errand, None if beside is None else beside.errand, each)
            draw(self.goal, both)
        draw(self.order, both_runs(readings.order, None if beside is None else beside.order, each))
        found = both_runs(readings.structure, None if beside is None else beside.structure, each)
        few = len(readings.structure.names)
        draw(self.neighbours, (found[0], found[1], found[1 + few]))


def both_runs(first: Course, second: Course | None, each: float) -> tuple[np.ndarray, ...]:
    """Ticks of the first run, its values, then those of the second one at the same times.

    `each` is how many of the first flock's ticks last as long as one of the second's. Without a
    second, its curves are hidden under those of the first: a plot has no scale for empty ones.
    """
    ticks, *values = first.arrays()
    others, *more = (first if second is None else second).arrays()
    if second is None or not len(others):
        return ticks, *values, *values
    return ticks, *values, *(np.interp(ticks, others * each, value) for value in more)


def head(title: str, entries: list[tuple[str, str]]) -> str:
    """A plot's title with the key to its curves."""
    return block(f'<div class="fs-head">{title}{key(entries)}</div>')


def chart(gui: viser.GuiApi, colours: tuple[str, ...], scale: uplot.Scale) -> viser.GuiUplotHandle:
    """An empty plot with a curve of each colour, and a dashed one for a flock beside."""
    nothing = np.zeros(1)
    solid = [uplot.Series(stroke=one, width=2, points={"show": False}) for one in colours]
    dashed = [
        uplot.Series(stroke=one, width=2, dash=DASH, points={"show": False}) for one in colours
    ]
    return gui.add_uplot(
        (nothing, *(nothing for _ in (*solid, *dashed))),
        (uplot.Series(label="tick"), *solid, *dashed),
        scales={"x": uplot.Scale(time=False), "y": scale},
        axes=(uplot.Axis(size=26), uplot.Axis(size=44)),
        legend=uplot.Legend(show=False),
        height=HEIGHT,
        padding=PADDING,
    )


def draw(plot: viser.GuiUplotHandle, columns: tuple[np.ndarray, ...]) -> None:
    """Show columns if there is anything new in them."""
    pairs = zip(columns, plot.data, strict=True)
    if len(columns[0]) and any(not np.array_equal(a, b) for a, b in pairs):
        plot.data = columns
