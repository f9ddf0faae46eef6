"""Building the world while the flock runs: obstacles, the goal, and layout files."""

from __future__ import annotations

import asyncio
import html
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import viser

from app.front.controls import set_value
from app.viewer.editing.editor import CORNERS, Editor, disc, polygon
from app.viewer.editing.free_places import floor_place, obstacle_hit
from app.viewer.editing.layout_file import ENDINGS
from app.viewer.lab.panels.plan_questions import PlanQuestions
from app.viewer.panels.shell import block
from app.viewer.run.edits import ignoring_gone
from app.viewer.run.simulation import Simulation
from app.viewer.scene.marks.handles import Drag, Marks
from app.viewer.scene.marks.obstacle_marks import drawn_height
from worlds.obstacles import rectangle
from worlds.world import World

# The controls of the World tab, and what they show of the world.

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
        self.opening = gui.add_folder(None)
        """With the button in it: viser hides a folder, but no button that takes a file."""
        with self.opening:
            self.open = gui.add_upload_button(
                "Open layout ...",
                icon=viser.Icon.UPLOAD,
                color="gray",
                mime_type=",".join(ENDINGS),
                hint="TOML, a drawing (DXF, SVG, GeoJSON, WKT) or a map (Vadere, MovingAI, ROS as "
                "ZIP) of up to 5 MB; builds a new flock in it",
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
            set_value(slider, round(round(share * short / step) * step, 9))

    def measure(self, obstacle: Any, resting: bool) -> None:
        """Show the measures of the selected obstacle, or those that the next one will have."""
        now = {} if obstacle is None else obstacle.measures()
        for name, slider in self.sliders.items():
            set_property(slider, "visible", name in now or name in MEASURES[self.tool.value])
            if name in now and resting:
                set_value(slider, float(np.clip(round(now[name], 9), slider.min, slider.max)))

    def list(self, editor: Editor, selected: int) -> None:
        """The obstacles by number, shape and name."""
        options = (
            NONE,
            *(f"{n} · {obstacle.label}" for n, obstacle in enumerate(editor.world.obstacles, 1)),
        )
        if tuple(self.which.options) != options:
            self.which.options = options
        keys = editor.now.keys
        chosen = options[keys.index(selected) + 1] if selected in keys else NONE
        set_value(self.which, chosen)


def set_property(control: Any, name: str, value: Any) -> None:
    """Give a control's property a value, if it has another."""
    if getattr(control, name) != value:
        setattr(control, name, value)


def describe_tools(editor: Editor, tool: str, obstacle: Any, corners: int) -> str:
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
    count_text = f"{count} obstacle{'s' * (count != 1)}{changes}"
    return f'<div class="fs-quiet">{count_text}</div><div class="fs-quiet">{words}</div>'


CLOSE = 0.02
"""A click so near to a polygon's first or last corner closes it, as a share of the longest side."""
PAUSE = 1.0
"""A slider that rests so long begins another step of the history, s."""


class WorldPanel(WorldControls):
    """One tool, one selection and one open polygon, shared by all browsers like the flock."""

    def __init__(
        self,
        server: viser.ViserServer,
        simulation: Simulation,
        show_marks: Callable[[Marks], None],
    ):
        super().__init__(server.gui)
        self.simulation = simulation
        self.questions = PlanQuestions(server, simulation)
        self.show_marks = show_marks
        self.selected = 0
        """Key of the selected obstacle; 0 for none."""
        self.corners: list[tuple[float, float]] = []
        self.shown: tuple[Any, ...] = ()
        """What the marks and the list show."""
        self.touched = 0.0
        self.slide = 0
        self.saving = False
        self.tool.on_update(self.choose_tool)
        self.which.on_update(self.select_listed)
        self.acts.on_click(self.press_button)
        self.close.on_click(self.close_polygon)
        self.goal.on_update(self.switch_goal)
        self.clear.on_click(self.clear_world)
        self.save.on_click(self.send_layout)
        self.open.on_upload(self.open_upload)
        for name, slider in self.sliders.items():
            slider.on_update(self.slider_action(name))

    @property
    def editor(self) -> Editor | None:
        """The world with its history."""
        return self.simulation.edits.editor

    @property
    def obstacle(self) -> Any:
        """The selected obstacle; None if there is none."""
        editor = self.editor
        if editor is None or self.selected not in editor.now.keys:
            return None
        return editor.now.obstacle(self.selected)

    # What browsers ask for; all of it on viser's event loop.

    def handle_click(self, origin: np.ndarray, direction: np.ndarray) -> bool:
        """A click into the picture, a ray (3,) and (3,) in the world; whether it was for a tool."""
        editor = self.editor
        if editor is None or self.tool.value == SELECT:
            return False
        floor = floor_place(editor.world, origin, direction)
        if floor is None:
            return True
        place = float(floor[0]), float(floor[1])
        if self.tool.value == POLYGON:
            self.add_corner(place, editor.world)
        elif self.tool.value == DISC:
            radius = float(self.sliders["radius"].value)
            self.add(lambda: disc(place, radius))
        else:
            width, depth, turn = (
                float(self.sliders[name].value) for name in ("width", "depth", "turn")
            )
            self.add(lambda: rectangle(place, width, depth, turn))
        return True

    def select_at(self, origin: np.ndarray, direction: np.ndarray) -> None:
        """Select the obstacle that a ray meets first, or none."""
        editor = self.editor
        if editor is None:
            return
        world = editor.world
        hit = obstacle_hit(world, origin, direction, drawn_height(world))
        self.select(0 if hit is None else editor.now.keys[hit])

    def select(self, key: int) -> None:
        """Select an obstacle; 0 for none."""
        self.selected = key
        self.touched = 0.0
        self.refresh()

    def handle_drag(self, drag: Drag) -> None:
        """Move what a gizmo is on; the drag's last change says what was refused."""

        def change(editor: Editor) -> Editor:
            if drag.thing:
                return editor.move(drag.thing, drag.by, drag.degrees, drag.gesture)
            return editor.move_goal(drag.by, drag.gesture)

        if drag.done:
            self.simulation.edits.change(ignoring_gone(change))
        else:
            self.simulation.edits.drag(drag.gesture, change)

    async def choose_tool(self, _event: viser.GuiEvent) -> None:
        self.corners.clear()
        played = self.simulation.played
        if played is not None and self.tool.value != SELECT:
            self.simulation.notices.put(str(played.refuse("the world")))
            set_value(self.tool, SELECT)
        if self.tool.value != SELECT:
            self.selected = 0
            self.simulation.edits.prepare()
        self.refresh()

    async def select_listed(self, event: viser.GuiEvent) -> None:
        editor = self.editor
        if event.client is None or editor is None:
            return
        number = self.which.options.index(self.which.value)
        if self.which.value != NONE and number <= len(editor.now.keys):
            set_value(self.tool, SELECT)
            self.select(editor.now.keys[number - 1])
        else:
            self.select(0)

    async def press_button(self, event: viser.GuiEvent) -> None:
        match event.target.value:
            case "Undo":
                self.undo()
            case "Redo":
                self.redo()
            case "Delete":
                self.delete()

    def undo(self) -> None:
        """Take the last corner of an open polygon back, or the last change."""
        if self.corners:
            self.corners.pop()
        else:
            self.simulation.edits.change(Editor.undo)

    def redo(self) -> None:
        """Do again what was taken back."""
        self.simulation.edits.change(Editor.redo)

    def delete(self) -> None:
        """Take the selected obstacle away."""
        key = self.selected
        if key:
            self.simulation.edits.change(ignoring_gone(lambda editor: editor.delete(key)))

    def drop_tool(self) -> None:
        """Let a click select again."""
        set_value(self.tool, SELECT)
        self.corners.clear()

    async def clear_world(self, _event: viser.GuiEvent) -> None:
        self.simulation.edits.change(Editor.clear)

    async def close_polygon(self, event: viser.GuiEvent) -> None:
        if event.target.value == "Close":
            self.add_polygon()
        self.corners.clear()
        self.refresh()

    async def switch_goal(self, _event: viser.GuiEvent) -> None:
        self.refresh()

    def slider_action(self, name: str) -> Callable:
        """What a slider does: to the selected obstacle, or to the next one."""

        async def on_update(event: viser.GuiEvent) -> None:
            obstacle, key = self.obstacle, self.selected
            if event.client is None or obstacle is None or name not in obstacle.measures():
                return
            now = time.monotonic()
            self.slide += now - self.touched > PAUSE
            self.touched = now
            gesture, value = f"{name} {key} {self.slide}", float(event.target.value)
            self.simulation.edits.drag(
                gesture, lambda editor: editor.resize(key, gesture, **{name: value})
            )

        return on_update

    async def send_layout(self, event: viser.GuiEvent) -> None:
        """Send the layout to the browser that asked; one at a time."""
        if event.client is None or self.saving:
            return
        self.saving = True
        try:
            answer = asyncio.wrap_future(self.simulation.edits.layout())
            content = await asyncio.wait_for(answer, timeout=60)
        except Exception:
            return  # What was refused has become a notice.
        finally:
            self.saving = False
        name = self.editor.world.name if self.editor is not None else "world"
        event.client.send_file_download(f"{name}.toml", content, save_immediately=True)

    async def open_upload(self, event: viser.GuiEvent) -> None:
        file = event.target.value
        self.questions.open_layout(event.client, file.name, file.content)

    # Drawing.

    def add(self, make: Callable[[], Any]) -> None:
        """Add an obstacle."""
        self.simulation.edits.change(lambda editor: editor.add(make()))

    def add_corner(self, corner: tuple[float, float], world: World) -> None:
        """One more corner of the polygon; near its first or its last one it is closed."""
        ends = [self.corners[0], self.corners[-1]] if len(self.corners) > 2 else []
        near = CLOSE * max(world.size)
        if any(np.hypot(corner[0] - x, corner[1] - y) < near for x, y in ends):
            self.add_polygon()
            self.corners.clear()
        elif len(self.corners) >= CORNERS:
            self.simulation.notices.put(f"a polygon has {CORNERS} corners at most")
        else:
            self.corners.append(corner)
        self.refresh()

    def add_polygon(self) -> None:
        """Make an obstacle of the corners."""
        corners = tuple(self.corners)
        self.add(lambda: polygon(corners))

    # What the panel shows.

    def refresh(self) -> None:
        """Show the world as it is now; costs next to nothing while nothing changes."""
        editor = self.editor
        if editor is None:
            return
        played = self.simulation.played
        if played is not None:  # what was chosen before has no control any more
            self.selected = 0
            self.corners.clear()
            for control, value in ((self.tool, SELECT), (self.goal, False)):
                set_property(control, "value", value)
        resting = time.monotonic() - self.touched > PAUSE
        corners = tuple(self.corners)
        now = (editor, self.selected, self.tool.value, self.goal.value, corners, resting, played)
        if len(now) == len(self.shown) and all(
            a is b or (k and a == b) for k, (a, b) in enumerate(zip(now, self.shown, strict=True))
        ):
            return
        self.shown = now
        obstacle = self.obstacle
        if obstacle is None:
            self.selected = 0
        mission = editor.world.mission
        goal = mission is not None and mission.goal is not None
        self.fit(editor.world)
        for tool in (self.tool, self.which, self.acts, self.clear, self.opening):
            set_property(tool, "visible", played is None)
        self.measure(obstacle, resting)
        self.list(editor, self.selected)
        set_property(self.goal, "visible", goal and played is None)
        set_property(self.close, "visible", self.tool.value == POLYGON)
        set_property(self.clear, "disabled", not editor.now.keys)
        told = describe_tools(editor, self.tool.value, obstacle, len(corners))
        if played is not None:
            told = f'<div class="fs-quiet">{html.escape(str(played.refuse("the world")))}</div>'
        self.note.content = block(told)
        self.show_marks(Marks(self.selected, obstacle, goal and self.goal.value, corners))
