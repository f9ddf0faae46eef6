"""The tab Sweep: many runs over a parameter of the running flock, while it goes on."""

from __future__ import annotations

import asyncio
import html
import json
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import viser

from agents.catalogue import MODELS, PLAYED
from agents.models.slider_range import is_wide
from agents.observables.catalogue import OBSERVABLES, default_charts
from agents.spec import Spec
from app.front.controls import set_value
from app.front.viser_internals import identifier
from app.studies.run_axes import (
    AGENTS,
    MEAN,
    AxisModels,
    RunAxis,
    axis_parameter,
    is_whole_axis,
    number_parameters,
    numeric_axes,
    read_axis,
)
from app.viewer.lab.sweeps import sweep_request
from app.viewer.lab.sweeps.laboratory_sweeps import SweepPanelState, Sweeps
from app.viewer.lab.sweeps.stored_sweeps import (
    PICTURES,
    SPEC,
    TABLES,
    ListedSweep,
    content,
)
from app.viewer.lab.sweeps.sweep_request import (
    Axis,
    SweepRequest,
    allowed,
    axis_title,
    proposed_span,
)
from app.viewer.measuring.observable_format import format_thousands, observable_words
from app.viewer.panels.dials import decimals, set_visible, step_of
from app.viewer.panels.shell import GREEN, GREY, ORANGE, block
from app.viewer.run.simulation import Simulation
from app.viewer.run.simulation_state import SimulationState
from worlds.input_error import InputError
from worlds.number_text import counted, duration

NOBODY, NOTHING = "no sweep yet", "nothing else"
ALONG, BESIDE = 9, 7
"""Values of an axis, of a curve and of a map, as they are proposed."""
RUNS, TICKS = 4, 500
MOST_FAULTS = 3
"""Sweeps of which it is said why they are not shown."""


class AxisForm:
    """The controls of an axis."""

    def __init__(self, gui: viser.GuiApi, label: str, count: int, none: bool, hint: str):
        self.names: dict[str, str] = {}
        self.models = AxisModels("")
        self.ranges: dict[str, tuple[float, float]] = {}
        self.none = none
        self.over = gui.add_dropdown(label, (NOTHING,), hint=hint)
        self.low = gui.add_number("From", 0.0, min=0.0, max=1.0, step=0.1)
        self.high = gui.add_number("To", 1.0, min=0.0, max=1.0, step=0.1)
        self.count = gui.add_number("Values", count, min=2, max=sweep_request.MOST_VALUES, step=1)
        self.log = gui.add_checkbox(
            "By logarithms", False, hint="Each value is so many times the one before it"
        )
        self.over.on_update(self.fit)

    def offer(self, spec: Spec, reach: float) -> None:
        """Let be chosen what is a number of a run: parameters, agents, and what kinds have.

        `reach`: how far its rule looks, length.
        """
        before, self.models = self.models, AxisModels.of_run(spec)
        axes = numeric_axes(spec)
        self.names = {
            axis_title(self.models.of_axis(axis.name), axis.name): axis.name for axis in axes
        }
        self.ranges = {axis.name: proposed_span(spec, axis, reach) for axis in axes}
        options = ((NOTHING,) if self.none else ()) + tuple(self.names)
        chosen = self.over.value
        if chosen not in options:
            noises = [one.name for one in number_parameters(spec.model) if one.noise]
            first = [title for title, name in self.names.items() if name in noises]
            chosen = (options if self.none else first or options)[0]
        name = self.names.get(chosen, "")
        is_other_model = before.of_axis(name) != self.models.of_axis(name)
        is_other = is_other_model or self.over.value != chosen
        self.over.options = options
        set_value(self.over, chosen)
        if is_other:
            self.propose()

    def choose(self, name: str) -> bool:
        """Choose an axis, or the mean of what agents differ in; whether it is offered."""
        names = (name, f"{name}.{MEAN}")
        label = next((label for label, one in self.names.items() if one in names), None)
        if label is not None:
            set_value(self.over, label)
            self.propose()
        return label is not None

    async def fit(self, event: viser.GuiEvent) -> None:
        """Another axis brings its own range."""
        if event.client is not None:
            self.propose()

    def propose(self) -> None:
        """The part of an axis that a slider spans."""
        name = self.names.get(self.over.value)
        for handle in (self.low, self.high, self.count, self.log):
            set_visible(handle, name is not None)
        if name is None:
            return
        model = self.models.of_axis(name)
        low, high = allowed(model, name)
        first, last = self.ranges[name]
        step, precision = self.step_of(name, last)
        for control, value in ((self.low, first), (self.high, last)):
            control.min, control.max = float(low), float(high)
            control.step, control.precision = step, precision
            set_value(control, float(value))
        set_value(self.log, is_wide(first, last))
        if is_whole_axis(model, name):
            set_value(self.count, min(self.count.value, max(2, int(last - first) + 1)))

    def step_of(self, name: str, last: float) -> tuple[float, int]:
        """The step of an axis up to `last`, and how many decimals it needs."""
        model = self.models.of_axis(name)
        if is_whole_axis(model, name):
            return 1, 0
        found = axis_parameter(model, name)
        if found is not None:
            return step_of(found), decimals(found)
        places = max(0, 2 - math.floor(math.log10(max(last, 1e-9))))
        return 10.0**-places, places

    def axis(self) -> Axis | None:
        """What is chosen; None for nothing."""
        name = self.names.get(self.over.value)
        if name is None:
            return None
        return Axis(name, self.low.value, self.high.value, int(self.count.value), self.log.value)


@dataclass
class SweepPanel:
    """Shows the sweeps there are, and begins one around the run as it is now."""

    gui: viser.GuiApi
    place: viser.GuiHtmlHandle
    """Where the page is told which sliders can be swept over: it is there with them."""
    sweeps: Sweeps
    simulation: Simulation
    tell: Callable[[str], None]
    offered: tuple[AxisModels, list[RunAxis]] | None = None
    """The models of the run, and the axes that can be chosen."""
    observed: dict[str, str] = field(default_factory=dict)
    """What can be measured, words -> name."""
    busy: bool = False
    """Whether a file is being made, or a sweep begun."""

    def __post_init__(self) -> None:
        gui = self.gui
        gui.add_html('<div class="fs-sweeps"></div>')
        self.which = gui.add_dropdown("Sweep", (NOBODY,), hint="Those in results/, newest first")
        self.column = gui.add_dropdown("Shows", ("",), visible=False, hint="What was measured")
        self.status = gui.add_html("")
        self.picture = gui.add_html("")
        self.go = gui.add_button("Stop", icon=viser.Icon.PLAYER_STOP, color="gray", visible=False)
        self.table = gui.add_button_group(
            "Table as", TABLES, visible=False, hint="A row for each run, as it stands now"
        )
        self.take = gui.add_button_group(
            "Picture, file",
            (*PICTURES, SPEC),
            visible=False,
            hint="Spec: the file that makes the same sweep again, flockscope sweep run FILE.toml",
        )
        with gui.add_folder("New sweep"):
            gui.add_html('<div class="fs-new-sweep"></div>')
            self.first = AxisForm(
                gui, "Over", ALONG, False, "A parameter of the running model, or its agents"
            )
            self.second = AxisForm(gui, "And over", BESIDE, True, "A second one makes a map")
            self.observable = gui.add_dropdown("Measure", ("",), hint="What each run comes to")
            self.last = gui.add_number(
                "Averaged over", 0, min=0, max=sweep_request.MOST_TICKS, step=10,
                hint="The last so many ticks of each run; 0: the value at its end",
            )  # fmt: skip
            self.runs = gui.add_number(
                "Runs of each", RUNS, min=1, max=sweep_request.MOST_RUNS_OF_CELL, step=1,
                hint="With the seeds 1, 2, ...; the interval comes from them",
            )  # fmt: skip
            self.ticks = gui.add_number(
                "Ticks of a run", TICKS, min=1, max=sweep_request.MOST_TICKS, step=100
            )
            self.said = gui.add_html("")
            self.start = gui.add_button("Start the sweep", icon=viser.Icon.CHART_DOTS)
            gui.add_html(block(f'<div class="fs-quiet">{sweep_request.describe_limits()}.</div>'))
        self.which.on_update(self.choose_sweep)
        self.column.on_update(self.choose_sweep)
        self.start.on_click(self.begin_sweep)
        self.go.on_click(self.toggle_sweep)
        self.table.on_click(self.send_download)
        self.take.on_click(self.send_download)

    # What browsers ask for.

    async def choose_sweep(self, event: viser.GuiEvent) -> None:
        """Draw another sweep, or another column of it."""
        if event.client is not None:
            same = event.target is self.column
            self.sweeps.choose(self.which.value, self.column.value if same else None)

    async def begin_sweep(self, event: viser.GuiEvent) -> None:
        """Begin what the form says."""
        if event.client is not None:
            await self.run_aside(
                lambda: self.sweeps.begin(self.read_request(self.simulation.state))
            )

    async def toggle_sweep(self, event: viser.GuiEvent) -> None:
        """Stop the sweep that is shown, or go on with it."""
        sweep = self.sweeps.seen.of(self.which.value)
        if event.client is None or sweep is None:
            return
        await self.run_aside(
            lambda: (self.sweeps.stop if sweep.runs else self.sweeps.go_on)(sweep.name)
        )

    async def send_download(self, event: viser.GuiEvent) -> None:
        """Send a file of the sweep that is shown to the browser that asked."""
        client, kind, name = event.client, event.target.value, self.which.value
        if client is None:
            return
        download = await self.run_aside(
            lambda: content(self.sweeps.folder(name), kind, self.sweeps.column)
        )
        if download is not None:
            client.send_file_download(*download, save_immediately=True)

    async def run_aside[T](self, work: Callable[[], T]) -> T | None:
        """Do something aside, one thing at a time; what is refused is told, and gives None."""
        if self.busy:
            return None
        self.busy = True
        try:
            return await asyncio.to_thread(work)
        except (InputError, OSError) as refusal:
            self.tell(str(refusal))
            return None
        finally:
            self.busy = False

    def sweep_over(self, name: str) -> None:
        """Have the form begin with a parameter, as the mark at its slider asks. Raises
        InputError."""
        if not self.first.choose(name):
            raise InputError(f"{name[:80]!r} cannot be swept over")

    def read_request(self, state: SimulationState) -> SweepRequest:
        """What the form says, around a run. Raises InputError for tracks."""
        if state.spec.model in PLAYED:
            raise InputError("tracks follow no rule: set up a model, then sweep over it")
        axes = [axis for axis in (self.first.axis(), self.second.axis()) if axis is not None]
        return SweepRequest(
            state.current_specs()[0],
            axes,
            self.observed.get(self.observable.value, ""),
            int(self.runs.value),
            int(self.ticks.value),
            int(self.last.value),
        )

    # What the page shows.

    def refresh(
        self, state: SimulationState, offered: tuple[str, ...], controls: dict[str, Any]
    ) -> None:
        """Follow the run: its parameters by their `controls`, and what can be measured of it."""
        if not state.values:
            return
        self.offer(state, offered)
        names = self.first.names.values()
        marks = {
            identifier(control): name
            for name, control in controls.items()
            if name in names or f"{name}.{MEAN}" in names
        }
        text = html.escape(json.dumps(marks, separators=(",", ":")))
        set_html(self.place, f'<div data-sweeps="{text}" hidden></div>')
        self.follow(self.sweeps.seen)
        try:
            request = self.read_request(state)
            grid = request.grid()
        except InputError as refusal:
            set_html(self.said, block(f'<div class="fs-error">{html.escape(str(refusal))}</div>'))
            set_enabled(self.start, True)
            return
        sizes = " × ".join(str(len(values)) for values in grid.values())
        cells = 1
        for values in grid.values():
            cells *= len(values)
        is_varied = any(read_axis(name).item == AGENTS for name in grid)
        agents = "" if is_varied else f" of {counted(state.agents, 'agent')}"
        summary = (
            f"{sizes} × {request.runs} = <b>{counted(cells * request.runs, 'run')}</b>{agents}; "
        )
        set_html(self.said, block(f"{summary}all else as it is now."))
        set_enabled(self.start, self.busy or any(sweep.runs for sweep in self.sweeps.seen.sweeps))

    def offer(self, state: SimulationState, offered: tuple[str, ...]) -> None:
        """Let be chosen what a run has: an axis that it still has stays as it is."""
        model, spec = state.spec.model, state.current_specs()[0]
        if model not in PLAYED:
            axes = AxisModels.of_run(spec), numeric_axes(spec)
            if axes != self.offered:
                frame = self.simulation.frame
                for form in (self.first, self.second):
                    form.offer(spec, 1.0 if frame is None else frame.reach)
                if self.offered is None or self.offered[0].flock != model:
                    self.observed = {}
                self.offered = axes
        observed = {
            observable_words(name): name
            for name in offered
            if name in OBSERVABLES and not OBSERVABLES[name].is_table
        }
        if observed == self.observed or not observed:
            return
        usual = next((chart[0] for chart in default_charts(MODELS[model], offered) if chart), "")
        before = self.observable.value if self.observed else observable_words(usual)
        self.observed = observed
        self.observable.options = tuple(observed)
        set_value(self.observable, before if before in observed else next(iter(observed)))

    def follow(self, state: SweepPanelState) -> None:
        """Show the sweeps there are, and one of them."""
        names = tuple(sweep.name for sweep in state.sweeps) or (NOBODY,)
        if tuple(self.which.options) != names:
            self.which.options = names
        chosen = self.sweeps.chosen if self.sweeps.chosen in names else names[0]
        if self.which.value != chosen:
            set_value(self.which, chosen)
        sweep, drawing = state.of(chosen), state.shown
        set_html(self.status, block(status(sweep, state)))
        set_html(self.picture, block(state.picture) if state.picture else "")
        if drawing is not None:
            if tuple(self.column.options) != drawing.columns:
                self.column.options = drawing.columns
            if self.column.value != drawing.column:
                set_value(self.column, drawing.column)
        set_visible(self.column, drawing is not None and len(drawing.columns) > 1)
        set_visible(self.table, drawing is not None)
        set_visible(self.take, drawing is not None)
        set_visible(self.go, sweep is not None and sweep.state != "done")
        if sweep is not None:
            self.go.label = "Stop" if sweep.runs else "Go on"
            self.go.icon = viser.Icon.PLAYER_STOP if sweep.runs else viser.Icon.PLAYER_SKIP_FORWARD


def set_html(place: Any, content: str) -> None:
    """Show HTML; browsers are told only what is new."""
    if place.content != content:
        place.content = content


def set_enabled(button: Any, disabled: bool) -> None:
    """Let a button be pressed, or not."""
    if button.disabled != disabled:
        button.disabled = disabled


def status(sweep: ListedSweep | None, panel_state: SweepPanelState) -> str:
    """How far a sweep is, with a bar; and what has gone wrong."""
    faults = [panel_state.fault, *panel_state.unread[:MOST_FAULTS]]
    if len(panel_state.unread) > MOST_FAULTS:
        faults.append(f"and {len(panel_state.unread) - MOST_FAULTS} more are not shown")
    fault = "".join(
        f'<div class="fs-error">{html.escape(fault)}</div>' for fault in faults if fault
    )
    if sweep is None:
        empty = "Runs over values of a parameter, kept in results/. The flock here goes on."
        return fault or f'<div class="fs-quiet">{empty}</div>'
    colour, state = {
        "running": (GREEN, "running"),
        "begins": (ORANGE, "begins"),
        "stopped": (GREY, "stopped"),
    }.get(sweep.state, (GREY, "done"))
    done, of = format_thousands(sweep.done), format_thousands(sweep.of)
    text = f"{done} of {of} runs" if sweep.of else ""
    if sweep.runs and panel_state.said and sweep.done == 0:
        text = html.escape(panel_state.said[:200])
    pace = ""
    if sweep.runs:
        pace = "&nbsp;"  # the line is there before anything is known: nothing moves then
        if sweep.left is not None and sweep.rate:
            pace = f"{sweep.rate:.3g} runs a second, {duration(sweep.left)} left"
        pace = f'<div class="fs-quiet">{pace}</div>'
    broken = sweep.counts.get("failed", 0) + sweep.counts.get("killed", 0)
    text += f", {broken} failed" if broken else ""
    text += f", {sweep.counts['gave-up']} gave up" if sweep.counts.get("gave-up") else ""
    share = 100.0 * sweep.done / sweep.of if sweep.of else 0.0
    bar = f'<div class="fs-progress"><i style="width:{share:.1f}%"></i></div>'
    dot = f'<span class="fs-dot" style="background:{colour}"></span>'
    return (
        f'{fault}<div class="fs-status">{dot}<span><b>{state}</b> · {text}</span></div>'
        f"{pace}{bar if sweep.runs or sweep.state == 'stopped' else ''}"
    )
