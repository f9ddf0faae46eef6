"""Go, pause, step, set up, how fast, and the time line."""

from __future__ import annotations

import html
import math
import time
from collections.abc import Iterable

import viser

from agents.catalogue import MODELS, PLAYED, short_model_name
from app.front.controls import set_value
from app.front.viser_internals import control_loop
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.lab.panels.setup import SetupPanel
from app.viewer.measuring.observable_format import format_thousands
from app.viewer.panels.shell import GREEN, GREY, ORANGE, VIOLET, block
from app.viewer.run.run_preset import lively_speed
from app.viewer.run.simulation import Simulation
from app.viewer.run.simulation_state import SimulationState, TimeLineState
from app.viewer.scene.shown.frame import Frame
from worlds.number_text import counted

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
        if lost := self.setup.dropped_differences(state, (spec, beside)):
            self.simulation.notices.put(lost)
        self.simulation.setup(spec, beside)

    def pace(self, speed: float, is_exact: bool = False) -> None:
        """Go to the speed of the list that is nearest to one (ticks per second, or inf); if it is
        to be exact, it comes into the list."""
        if is_exact and speed_text(speed) not in self.speeds:
            self.speeds = {speed_text(one): one for one in sorted({*SPEEDS, speed})}
            self.speed.options = tuple(self.speeds)
        finite = [choice for choice in self.speeds.values() if math.isfinite(choice)]
        nearest = speed
        if math.isfinite(speed):
            nearest = min(finite, key=lambda choice: abs(math.log(choice / speed)))
        set_value(self.speed, speed_text(nearest))
        self.simulation.run_at(nearest)

    def change_speed(self, by: int) -> None:
        """Go to a faster or slower speed of the list."""
        names = list(self.speeds)
        place = names.index(self.speed.value) + by
        set_value(self.speed, names[min(max(place, 0), len(names) - 1)])
        self.simulation.run_at(self.speeds[self.speed.value])

    def refresh(
        self,
        state: SimulationState,
        scene: SavedScene | None = None,
        by_hand: Iterable[int] = (),
    ) -> None:
        """Show how the simulation stands, what there is to see in a scene, and which agents people
        steer, by their identities."""
        title = MODELS[state.spec.model].title if scene is None else scene.title
        self.status.content = block(status(state, title=title) + describe_steered(by_hand))
        self.story.content = "" if scene is None else describe_scene(scene)
        self.switch.label = "Pause" if state.running else "Go"
        self.switch.icon = viser.Icon.PLAYER_PAUSE if state.running else viser.Icon.PLAYER_PLAY
        self.switch.color = "blue" if state.running else "green"


def describe_steered(by_hand: Iterable[int]) -> str:
    """Which agents people steer, HTML; nothing if nobody does."""
    named = ", ".join(map(str, sorted(by_hand)))
    return f'<div class="fs-quiet">Steered by hand: agent {named}</div>' if named else ""


def speed_text(speed: float) -> str:
    """A speed as the list has it."""
    return "as fast as it goes" if math.isinf(speed) else f"{speed:g} ticks/s"


def status(state: SimulationState, mend: str = "Press Setup.", title: str = "") -> str:
    """The state in a line, with a coloured dot; `mend` says what to do when it has stopped, `title`
    what the browser's tab is called."""
    if state.error:
        why = html.escape(state.error)
        return f'<div class="fs-error"><b>Stopped.</b> {why}<br>{mend}</div>'
    model, beside = state.models
    words = MODELS[model].title if beside is None else f"{short_model_name(model)} beside {beside}"
    told = "" if state.busy else f" · {html.escape(words)}"
    line = state.line
    colour, words = GREY, "paused"
    if line is not None and line.looks_back:
        colour, words = VIOLET, "looking back"
    if state.compiling is not None:
        colour, words = (VIOLET, "preview") if state.preview else (ORANGE, "waiting")
        told += compile_bar(state)
    elif state.busy:
        colour, words = ORANGE, "setting up …"
    elif state.running:
        colour, words = GREEN, "playing" if line is not None and line.recording else "running"
    dot = f'<span class="fs-dot" style="background:{colour}"></span>'
    named = f' data-scene="{html.escape(title)}"' if title else ""
    return f'<div class="fs-status"{named}>{dot}<span><b>{words}</b>{told}</span></div>'


def describe_scene(scene: SavedScene) -> str:
    """What a scene is called, what to watch in it, and what to try, if no steps say that."""
    lines = (("Watch", scene.watch), ("Try", "" if scene.steps else scene.tries))
    paragraphs = "".join(
        f"<p><b>{name}</b> {html.escape(text)}</p>" for name, text in lines if text
    )
    title = f"<h2>{html.escape(scene.title)}</h2>"
    return block(f'<div class="fs-story">{title}{paragraphs}</div>') if paragraphs else ""


def compile_bar(state: SimulationState) -> str:
    """Over the picture: what the page waits for, how far that is, and what a preview leaves out."""
    compiling, now = state.compiling, time.monotonic()
    if compiling is None:
        return ""
    kind = "Preview" if state.preview else "Waiting"
    moving, agents = format_thousands(state.moving), format_thousands(state.agents)
    part = f" of {moving} of {agents} agents" if state.moving < state.agents else ""
    return (
        f'<div class="fs-compiling"><b>{kind}</b>{part} until compiled: {compiling.describe(now)}'
        f'<i><i style="width:{100.0 * compiling.share(now):.0f}%"></i></i></div>'
    )


# The time line: drag it to look back at a run, or to any tick of a recording.


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
            hint="Go on from the tick that you see; the page forgets what came after it",
        )
        self.loop = control_loop(self.slider)
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
        goes_on = past and state.spec.model not in PLAYED
        if self.words.visible != past:
            self.words.visible = past
        if self.actions.visible != goes_on:
            self.actions.visible = goes_on
        offered = (GO_ON,) if recorded else (GO_ON, TO_NOW)
        if past and tuple(self.actions.options) != offered:
            self.actions.options = offered
        if frame is None:
            return
        if past and line is not None:
            self.words.content = block(describe_time_line(line, frame))
        if line is None:  # a preview: nothing to move along yet
            line = TimeLineState(0, frame.tick, frame.tick)
        for name, value in (("min", line.first), ("max", max(line.last, line.first + 1))):
            if getattr(self.slider, name) != value:
                setattr(self.slider, name, value)
        if self.slider.value != line.at:
            self.loop.call_soon_threadsafe(self.show_tick, line.at)

    def show_tick(self, tick: int) -> None:
        """On viser's thread, where a drag is stored and sent in one piece: move the slider."""
        if time.monotonic() - self.moved > HELD:
            set_value(self.slider, tick)


def describe_time_line(line: TimeLineState, frame: Frame) -> str:
    """What is shown, and what can be done about it, HTML."""
    when = clock(line.at, frame)
    if frame.seen is not None:
        seen = f"{int(frame.seen.sum())} of {counted(len(frame.seen), 'individual')} seen"
        gaps = 0 if frame.hollow is None else int(frame.hollow.sum())
        hollow = f", {gaps} in a gap (hollow)" if gaps else ""
        return (
            f'<div class="fs-quiet">Tracks <b>{html.escape(line.recording)}</b>: '
            f"{line.at * frame.dt:.2f} s of {line.last * frame.dt:.2f} s. {seen}{hollow}.</div>"
        )
    kept = ""
    if line.sought is not None:
        kept = f" Tick {line.sought} is not kept: this is the last one before it that is."
    if line.recording:
        name = html.escape(line.recording)
        return (
            f'<div class="fs-quiet">Recording <b>{name}</b>: {when} of '
            f"{clock(line.last, frame, '')}.{kept} Setup begins a new run from its spec.</div>"
        )
    now = clock(line.last, frame)
    return f'<div class="fs-quiet">Looking back at {when}; now is {now}.{kept}</div>'


def clock(tick: int, frame: Frame, word: str = "tick ") -> str:
    """A tick, with its time where time is not counted in ticks."""
    return f"{word}{tick}" + ("" if frame.unit == "ticks" else f" ({tick * frame.dt:.1f} s)")
