"""The time line: drag it to look back at a run, or to any tick of a recording."""

from __future__ import annotations

import html
import time

import viser

from app.front.controls import set_value
from app.viewer.panels.shell import block
from app.viewer.run.simulation import Simulation
from app.viewer.run.simulation_state import SimulationState, TimeLineState
from app.viewer.scene.shown.frame import Frame

GO_ON, TO_NOW = "Go on from here", "Back to now"
HELD = 0.5
"""Time after somebody has moved it for which nothing else moves it, s."""


class TimeLinePanel:
    """A slider over the ticks that can be shown; buttons while it is not the present."""

    def __init__(self, gui: viser.GuiApi, simulation: Simulation):
        self.time_line = simulation.time_line
        self.moved = 0.0
        self.slider = gui.add_slider(
            "Tick",
            0,
            1,
            1,
            0,
            disabled=True,
            hint="Drag to look back at this run, or to any tick of a recording",
        )
        self.words = gui.add_html("", visible=False)
        self.actions = gui.add_button_group(
            "Past",
            (GO_ON, TO_NOW),
            visible=False,
            hint="Go on makes the tick that is shown the present: what came after it is given up",
        )
        self.slider.on_update(self.drag_slider)
        self.actions.on_click(self.press_button)

    async def drag_slider(self, event: viser.GuiEvent) -> None:
        if event.client is not None:
            self.moved = time.monotonic()
            self.time_line.seek(int(self.slider.value))

    async def press_button(self, event: viser.GuiEvent) -> None:
        self.moved = 0.0
        if event.target.value == GO_ON:
            self.time_line.go_on()
        else:
            self.time_line.to_now()

    def refresh(self, state: SimulationState, frame: Frame | None) -> None:
        """Follow the run; what is being dragged is left where it is."""
        line = state.line
        usable = line is not None and line.last > line.first and frame is not None
        if self.slider.disabled == usable:
            self.slider.disabled = not usable
        recorded = line is not None and bool(line.recording)
        past = recorded or (line is not None and line.looks_back)
        if self.words.visible != past:
            self.words.visible = self.actions.visible = past
        offered = (GO_ON,) if recorded else (GO_ON, TO_NOW)
        if past and tuple(self.actions.options) != offered:
            self.actions.options = offered
        if line is None or frame is None:
            return
        if past:
            self.words.content = block(describe_time_line(line, frame))
        for name, value in (("min", line.first), ("max", max(line.last, line.first + 1))):
            if getattr(self.slider, name) != value:
                setattr(self.slider, name, value)
        if time.monotonic() - self.moved > HELD and self.slider.value != line.at:
            set_value(self.slider, line.at)


def describe_time_line(line: TimeLineState, frame: Frame) -> str:
    """What is shown, and what can be done about it, HTML."""
    when = clock(line.at, frame)
    if line.recording:
        name = html.escape(line.recording)
        return (
            f'<div class="fs-quiet">Recording <b>{name}</b>: {when} of '
            f"{clock(line.last, frame, '')}. Setup begins a new run from its spec.</div>"
        )
    return f'<div class="fs-quiet">Looking back at {when}; now is {clock(line.last, frame)}.</div>'


def clock(tick: int, frame: Frame, word: str = "tick ") -> str:
    """A tick, with its time where time is not counted in ticks."""
    return f"{word}{tick}" + ("" if frame.unit == "ticks" else f" ({tick * frame.dt:.1f} s)")
