"""The run so far as curves."""

from __future__ import annotations

import numpy as np
import viser
from viser import uplot

from app.viewer.frame import Frame
from app.viewer.panels.style import BLUE, GREEN, ORANGE, VIOLET, block, key
from app.viewer.readings import Readings

HEIGHT = 160
PADDING = (10, 14, 0, 0)


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

    def refresh(self, readings: Readings, frame: Frame) -> None:
        """Draw the run as far as it has come."""
        mission = frame.world.mission
        has_goal = mission is not None and mission.goal is not None
        has_end = mission is not None and (has_goal or mission.path is not None)
        self.goal.visible = self.goal_head.visible = has_end
        if has_end:
            words = "the goal" if has_goal else "the path's end"
            self.goal_head.content = head(
                "Mission", [(f"distance of the flock's centre to {words}", VIOLET)]
            )
            draw(self.goal, readings.errand.arrays())
        draw(self.order, readings.order.arrays())
        draw(self.neighbours, readings.structure.arrays()[:2])


def head(title: str, entries: list[tuple[str, str]]) -> str:
    """A plot's title with the key to its curves."""
    return block(f'<div class="fs-head">{title}{key(entries)}</div>')


def chart(gui: viser.GuiApi, colours: tuple[str, ...], scale: uplot.Scale) -> viser.GuiUplotHandle:
    """An empty plot with a curve of each colour."""
    nothing = np.zeros(1)
    curves = tuple(
        uplot.Series(stroke=colour, width=2, points={"show": False}) for colour in colours
    )
    return gui.add_uplot(
        (nothing, *(nothing for _ in colours)),
        (uplot.Series(label="tick"), *curves),
        scales={"x": uplot.Scale(time=False), "y": scale},
        axes=(uplot.Axis(size=26), uplot.Axis(size=44)),
        legend=uplot.Legend(show=False),
        height=HEIGHT,
        padding=PADDING,
    )


def draw(plot: viser.GuiUplotHandle, columns: tuple[np.ndarray, ...]) -> None:
    """Show columns if there is anything new in them."""
    new = len(columns[0]) and (
        len(columns[0]) != len(plot.data[0])
        or any(not np.array_equal(a, b) for a, b in zip(columns, plot.data, strict=True))
    )
    if new:
        plot.data = columns
