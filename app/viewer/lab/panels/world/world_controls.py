"""The controls of the World tab, and what they show of the world."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser

from app.viewer.editing.editor import Editor
from app.viewer.editing.layout_file import ENDINGS
from app.viewer.web.values import show
from worlds.world import World

SELECT, DISC, BOX, POLYGON = "select", "place a disc", "place a box", "draw a polygon"
TOOLS = (SELECT, DISC, BOX, POLYGON)
MEASURES = {DISC: ("radius",), BOX: ("width", "depth", "turn"), POLYGON: (), SELECT: ()}
"""What of the size of the next obstacle is chosen beforehand."""
NONE = "none"
FIRST = {"radius": 0.06, "width": 0.16, "depth": 0.06, "size": 0.2}
"""Measures to begin with, as a share of the world's shorter side."""


class WorldControls:
    """A tool, measures, the list of obstacles, and buttons; what they do is the panel's affair."""

    def __init__(self, gui: viser.GuiApi):
        self.fitted: tuple[float, ...] = ()
        """Size of the world that the sliders fit."""
        self.note = gui.add_html("")
        self.tool = gui.add_dropdown(
            "A click to",
            TOOLS,
            initial_value=SELECT,
            hint="What a click into the picture does. An obstacle that comes upon agents puts them "
            "out to the nearest free place",
        )
        self.sliders = {
            name: gui.add_slider(
                name.capitalize(), 0.1, 10.0, 0.1, 1.0, visible=False, hint=f"{words}, length"
            )
            for name, words in {
                "radius": "Radius of the disc",
                "width": "First side of the box",
                "depth": "Second side of the box",
                "size": "Longest extent",
            }.items()
        }
        self.sliders["turn"] = gui.add_slider(
            "Turn", 0.0, 180.0, 1.0, 0.0, visible=False, hint="Anticlockwise, degrees"
        )
        self.close = gui.add_button_group(
            "Polygon", ("Close", "Discard"), visible=False, hint="Close it with a double click too"
        )
        self.which = gui.add_dropdown(
            "Obstacle", (NONE,), initial_value=NONE, hint="The selected one; click one to select it"
        )
        self.acts = gui.add_button_group(
            "Edit", ("Undo", "Redo", "Delete"), hint="Delete takes the selected obstacle away"
        )
        self.goal = gui.add_checkbox(
            "Move goal", False, hint="Handles on the goal: drag it about", visible=False
        )
        self.clear = gui.add_button("Remove all obstacles", icon=viser.Icon.TRASH, color="gray")
        self.save = gui.add_button("Save layout (TOML)", icon=viser.Icon.DOWNLOAD, color="gray")
        self.open = gui.add_upload_button(
            "Open layout ...",
            icon=viser.Icon.UPLOAD,
            color="gray",
            mime_type=",".join(ENDINGS),
            hint="TOML, a drawing (DXF, SVG, GeoJSON, WKT) or a map (Vadere, MovingAI, ROS as ZIP) "
            "of up to 5 MB; builds a new flock in it",
        )

    def fit(self, world: World) -> None:
        """Let the sliders fit a world of another size."""
        if world.size == self.fitted:
            return
        self.fitted = world.size
        side, short = max(world.size), min(world.size[:2])
        step = float(10.0 ** np.floor(np.log10(short / 100.0)))
        for name, share in FIRST.items():
            slider = self.sliders[name]
            slider.min, slider.step = step, step
            slider.max = round(0.5 * side if name == "radius" else side, 6)
            slider.precision = max(0, round(-np.log10(step)))
            show(slider, round(round(share * short / step) * step, 9))

    def measure(self, obstacle: Any, resting: bool) -> None:
        """Show the measures of the selected obstacle, or those that the next one will have."""
        now = {} if obstacle is None else obstacle.measures()
        for name, slider in self.sliders.items():
            put(slider, "visible", name in now or name in MEASURES[self.tool.value])
            if name in now and resting:
                show(slider, float(np.clip(round(now[name], 9), slider.min, slider.max)))

    def list(self, editor: Editor, selected: int) -> None:
        """The obstacles by number, shape and name."""
        options = (NONE, *(f"{n} · {one.label}" for n, one in enumerate(editor.world.obstacles, 1)))
        if tuple(self.which.options) != options:
            self.which.options = options
        keys = editor.now.keys
        chosen = options[keys.index(selected) + 1] if selected in keys else NONE
        show(self.which, chosen)


def put(control: Any, name: str, value: Any) -> None:
    """Give a control's property a value, if it has another."""
    if getattr(control, name) != value:
        setattr(control, name, value)


def note(editor: Editor, tool: str, obstacle: Any, corners: int) -> str:
    """What can be done now, in a line."""
    count = len(editor.world.obstacles)
    undone = len(editor.past)
    if tool == POLYGON:
        words = "Click the corners on the floor; click the last one twice to close."
        if corners:
            words = f"{corners} corner{'s' * (corners > 1)}. Click the last one twice to close."
    elif tool != SELECT:
        words = "Click on the floor. Drag to turn the view as always."
    elif obstacle is not None:
        words = "Drag it by its handles, or change its measures."
    else:
        words = "Click an obstacle to select it."
    changes = f" · {undone} change{'s' * (undone != 1)}" if undone else ""
    held = f"{count} obstacle{'s' * (count != 1)}{changes}"
    return f'<div class="fs-quiet">{held}</div><div class="fs-quiet">{words}</div>'
