"""Go, pause, step, set up, and how fast."""

from __future__ import annotations

import html
import math
import time

import viser

from agents.catalogue import MODELS
from app.front.controls import set_value
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.lab.panels.setup import SetupPanel
from app.viewer.panels.shell import GREEN, GREY, ORANGE, VIOLET, block
from app.viewer.run.kernel_compiler import CompileEstimate
from app.viewer.run.run_preset import lively_speed
from app.viewer.run.simulation import Simulation
from app.viewer.run.simulation_state import SimulationState

SPEEDS = (0.5, 1.0, 2.0, 5.0, 10.0, 15.0, 30.0, 60.0, 200.0, 1000.0, math.inf)
"""Ticks per second to choose from."""


class RunPanel:
    """The buttons that everybody needs all the time, at the top of the controls."""

    def __init__(self, gui: viser.GuiApi, simulation: Simulation, setup: SetupPanel):
        self.simulation = simulation
        self.setup = setup
        self.status = gui.add_html("")
        self.story = gui.add_html("")
        self.switch = gui.add_button("Pause", icon=viser.Icon.PLAYER_PAUSE, color="blue")
        self.actions = gui.add_button_group(
            "Flock",
            ("Setup", "Step", "Reset"),
            hint="Setup builds a flock from the Setup tab. Step runs one tick. "
            "Reset begins the same run again.",
        )
        speed = simulation.state.speed
        self.speeds = {speed_text(value): value for value in sorted({*SPEEDS, speed})}
        self.speed = gui.add_dropdown(
            "Speed", list(self.speeds), initial_value=speed_text(speed), hint="Ticks per second"
        )
        self.switch.on_click(self.toggle_running)
        self.actions.on_click(self.press_button)
        self.speed.on_update(self.set_pace)

    async def toggle_running(self, _event: viser.GuiEvent) -> None:
        self.simulation.toggle()

    async def press_button(self, event: viser.GuiEvent) -> None:
        match event.target.value:
            case "Setup":
                self.set_up()
            case "Step":
                self.simulation.step()
            case "Reset":
                self.simulation.reset()

    async def set_pace(self, event: viser.GuiEvent) -> None:
        self.simulation.run_at(self.speeds[event.target.value])

    def set_up(self) -> None:
        """Build a flock from the Setup tab."""
        self.setup.catch_up(self.simulation.state.spec)
        state, before = self.simulation.state, self.setup.running
        spec, beside = self.setup.next_pairing(state)
        if MODELS[spec.model].body.unit != MODELS[before[0].model].body.unit:
            self.pace(lively_speed(spec))
        self.simulation.setup(spec, beside)

    def pace(self, speed: float) -> None:
        """Go to the speed of the list that is nearest to one (ticks per second)."""
        finite = [choice for choice in self.speeds.values() if math.isfinite(choice)]
        nearest = min(finite, key=lambda choice: abs(math.log(choice / speed)))
        show(self.speed, speed_text(nearest))
        self.simulation.run_at(nearest)

    def change_speed(self, by: int) -> None:
        """Go to a faster or slower speed of the list."""
        names = list(self.speeds)
        place = names.index(self.speed.value) + by
        set_value(self.speed, names[min(max(place, 0), len(names) - 1)])
        self.simulation.run_at(self.speeds[self.speed.value])

    def refresh(self, state: SimulationState, scene: SavedScene | None = None) -> None:
        """Show how the simulation stands, and what there is to see in a scene."""
        self.status.content = block(status(state))
        self.story.content = "" if scene is None else describe_scene(scene)
        self.switch.label = "Pause" if state.running else "Go"
        self.switch.icon = viser.Icon.PLAYER_PAUSE if state.running else viser.Icon.PLAYER_PLAY
        self.switch.color = "blue" if state.running else "green"


def speed_text(speed: float) -> str:
    """A speed as the list has it."""
    return "as fast as it goes" if math.isinf(speed) else f"{speed:g} ticks/s"


def status(state: SimulationState, mend: str = "Press Setup.") -> str:
    """The state in a line, with a coloured dot; `mend` says what to do when it has stopped."""
    if state.error:
        why = html.escape(state.error)
        return f'<div class="fs-error"><b>Stopped.</b> {why}<br>{mend}</div>'
    model, beside = state.models
    words = MODELS[model].title if beside is None else f"{model} beside {beside}"
    title = "" if state.busy else f" · {html.escape(words)}"
    line = state.line
    colour, words = GREY, "paused"
    if line is not None and line.looks_back:
        colour, words = VIOLET, "looking back"
    if state.compiling is not None:
        colour, words = (VIOLET, "preview") if state.preview else (ORANGE, "waiting")
        title += compile_bar(state.compiling, state.preview)
    elif state.busy:
        colour, words = ORANGE, "setting up …"
    elif state.running:
        colour, words = GREEN, "playing" if line is not None and line.recording else "running"
    dot = f'<span class="fs-dot" style="background:{colour}"></span>'
    return f'<div class="fs-status">{dot}<span><b>{words}</b>{title}</span></div>'


def describe_scene(scene: SavedScene) -> str:
    """What to watch in a scene, and what to try."""
    lines = (("Watch", scene.watch), ("Try", scene.tries))
    paragraphs = "".join(
        f"<p><b>{name}</b> {html.escape(text)}</p>" for name, text in lines if text
    )
    return block(f'<div class="fs-story">{paragraphs}</div>') if paragraphs else ""


def compile_bar(compiling: CompileEstimate, preview: bool) -> str:
    """Over the picture: what the page waits for, and how far that is."""
    now = time.monotonic()
    kind = "Preview" if preview else "Waiting"
    return (
        f'<div class="fs-compiling"><b>{kind}</b> until compiled: {compiling.describe(now)}'
        f'<i><i style="width:{100.0 * compiling.share(now):.0f}%"></i></i></div>'
    )
