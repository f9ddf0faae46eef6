"""A control for every parameter that the rule and the body declare."""

from __future__ import annotations

import html
import math
import re
import time
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Any

import viser

from agents.catalogue import MODELS, PLAYED
from agents.individuals import Distribution
from agents.models.declare import DeclaredParameter, NumberParameter, Parameters, declared
from agents.models.model import Model
from app.viewer.panels.dials import Dials, decimals, plain_symbol, set_visible, step_of
from app.viewer.panels.followed_value import DRAG, FollowedValue
from app.viewer.panels.shell import block, table
from app.viewer.run.paired_run import shared_model_parameters
from app.viewer.run.simulation import Models, Simulation
from app.viewer.run.simulation_state import SimulationState
from worlds.input_error import InputError

UNDO, ALL_BACK = "Undo", "All back"
OF_TRACKS = "Tracks follow no rule. The tab Tracks starts a model from their places."
REMEMBERED = 100
"""Changes that can be undone."""


@dataclass
class Step:
    """A parameter, or what else is undone with them, before it was changed."""

    name: str
    beside: bool
    value: Any
    when: float
    put_back: Callable[[Any], Any] | None = None
    """What gives it the value again; None: it is a parameter of all agents."""


class ParametersPanel:
    """Sliders, switches and choices that act on the running flock at once."""

    def __init__(self, gui: viser.GuiApi, simulation: Simulation):
        self.gui = gui
        self.simulation = simulation
        self.changed = gui.add_html("")
        self.back = gui.add_button_group("Changes", (UNDO, ALL_BACK), visible=False)
        self.back.on_click(self.restore_values)
        self.past: list[Step] = []
        self.followed: dict[tuple[str, bool], FollowedValue] = {}
        """What keeps each control at the flock's value, by name and whether of the model beside."""
        self.begun: dict[str, Any] = {}
        """What the parameters were when the scene was opened: what a scene sets is no change."""
        self.last_run: int | None = -1
        """The last run of the scene before, until the first of another is seen."""
        self.changes: dict[str, Any] = {}
        """Parameters that are changed -> what they were, as they are shown."""
        self.dials = Dials(gui)
        self.folder = gui.add_folder(None)
        self.controls: dict[str, Any] = {}
        self.beside_controls: dict[str, Any] = {}
        """Of what only the second of two models has."""
        self.models: Models | None = None
        self.declaring: list[type[Parameters]] = []
        """What declares their parameters: others once a rule's file is taken anew."""
        self.shown_run = -1

    def expect_scene(self) -> None:
        """Runs after this one are of another scene: nothing of it is changed."""
        self.last_run = self.simulation.state.run

    def refresh(self, state: SimulationState) -> None:
        """Follow a new set-up, and say what is changed."""
        if not state.values:
            return
        if state.run != self.shown_run:
            self.shown_run = state.run
            declaring = [MODELS[name].parameters for name in state.models if name is not None]
            is_new = self.last_run is not None and state.run > self.last_run
            if is_new or state.models != self.models or declaring != self.declaring:
                self.models, self.past = state.models, []
                self.last_run = None if is_new else self.last_run
                self.declaring = declaring
                self.begun = dict(state.values)
                self.rebuild(state)
        self.follow_flock(state)
        is_played = state.spec.model in PLAYED
        fixed = state.line is not None and (bool(state.line.recording) or state.line.looks_back)
        idle = MODELS[state.spec.model].idle(state.values)
        for controls in (self.controls, self.beside_controls):
            stands = fixed and not (is_played and controls is self.beside_controls)
            for name, control in controls.items():
                if control.disabled != (stands or name in idle):
                    control.disabled = stands or name in idle
        self.show_own()
        own = () if is_played else declared(MODELS[state.spec.model].parameters)
        changed = [one for one in own if state.values.get(one.name) != self.begun.get(one.name)]
        text = describe_changes(changed, self.begun, state.values)
        self.changes = {one.name: self.begun[one.name] for one in changed}
        self.back.visible = bool(self.changes or self.past) and (is_played or not fixed)
        if text != self.changed.content:
            self.changed.content = text
        self.dials.refresh()

    def show_own(self) -> None:
        """Hide what whoever plays a kind of agents cannot change."""
        played = self.simulation.played
        set_visible(self.folder, played is None or bool(played.own))
        for name, control in self.controls.items():
            set_visible(control, played is None or name in played.own)
        for control in self.beside_controls.values():
            set_visible(control, played is None)

    async def restore_values(self, _event: viser.GuiEvent) -> None:
        """Undo the last change, or give every parameter the value that it began with."""
        if self.back.value == UNDO:
            self.undo()
            return
        if self.past:
            self.past[-1].when = -math.inf
        for name, value in self.changes.items():
            self.remember_value(name, False)
            self.set_parameter(name, value, False)

    def remember_value(self, name: str, beside: bool) -> None:
        """Keep what a parameter is before it is changed; of a drag only what was before it."""
        now = time.monotonic()
        state = self.simulation.state
        value = (state.beside_values if beside else state.values).get(name)
        self.remember(Step(name, beside, value, now))

    def remember(self, step: Step) -> None:
        """Keep a step; of a drag only the first."""
        last = self.past[-1] if self.past else None
        same = last is not None and (last.name, last.beside) == (step.name, step.beside)
        if last is not None and same and step.when - last.when < DRAG:
            last.when = step.when
            return
        self.past = [*self.past[1 - REMEMBERED :], step]

    def undo(self) -> None:
        """Give what was changed last the value that it had."""
        if self.past:
            last = self.past.pop()
            if last.put_back is None:
                self.set_parameter(last.name, last.value, last.beside)
            else:
                last.put_back(last.value)

    def set_parameter(self, name: str, value: Any, beside: bool) -> Future:
        """Give a parameter a value or a distribution, and show it; on viser's thread."""
        answer = self.simulation.set(name, value, beside, self.models)
        self.followed[name, beside].give(slider_value(value), answer)
        return answer

    def move_parameter(self, name: str, value: Any, beside: bool) -> Future:
        """Give a parameter the value of a slider, about which agents keep their spread, and show
        it; on viser's thread."""
        answer = self.simulation.move(name, value, beside, self.models)
        self.followed[name, beside].give(value, answer)
        return answer

    def follow_flock(self, state: SimulationState) -> None:
        """Have controls show what the flock has."""
        if state.busy or state.models != self.models:
            return
        for (name, beside), followed in self.followed.items():
            values = state.beside_values if beside else state.values
            if name in values:
                followed.follow(slider_value(values[name]))

    def rebuild(self, state: SimulationState) -> None:
        """Controls for the model's parameters, and for those that only the one beside it has."""
        for child in tuple(self.folder._children.values()):
            child.remove()
        self.dials.clear()
        name, beside = state.models
        model = MODELS[name]
        own = declared(model.parameters)
        both = frozenset(state.values) if beside is None else shared_model_parameters(name, beside)
        others = () if beside is None else declared(MODELS[beside].parameters)
        values, beside_values = state.values, state.beside_values or {}
        self.controls, self.beside_controls, self.followed = {}, {}, {}
        if name in PLAYED:
            own = ()
        with self.folder:
            if name in PLAYED and beside is None:
                self.gui.add_html(block(f'<div class="fs-quiet">{html.escape(OF_TRACKS)}</div>'))
            elif beside is not None and name not in PLAYED:
                self.gui.add_html(block('<div class="fs-quiet">These act on both models.</div>'))
            titles = "Rule", f"Body: {model.body.title}"
            for title, part in zip(titles, sides(model, own), strict=True):
                if shared := [parameter for parameter in part if parameter.name in both]:
                    self.gui.add_html(block(f'<h2 class="fs-head">{html.escape(title)}</h2>'))
                    self.controls |= self.controls_of(shared, values)
            if alone := [parameter for parameter in own if parameter.name not in both]:
                with self.gui.add_folder(f"Only {model.title}"):
                    self.controls |= self.controls_of(alone, values)
            if alone := [parameter for parameter in others if parameter.name in beside_values]:
                with self.gui.add_folder(f"Only {MODELS[beside or name].title}"):
                    self.beside_controls = self.controls_of(alone, beside_values, beside=True)

    def controls_of(
        self, some: list[DeclaredParameter], values: dict[str, Any], beside: bool = False
    ) -> dict[str, Any]:
        """The controls of some parameters by name, of the model beside alone if so."""
        return {
            parameter.name: self.control(parameter, values[parameter.name], beside)
            for parameter in some
        }

    def control(self, parameter: DeclaredParameter, value: Any, beside: bool = False) -> Any:
        """The control of one parameter, of the model beside alone if so."""
        value = slider_value(value)
        handle = add_control(self.gui, parameter, value)
        self.dials.add(parameter, handle)
        models = self.models

        def send(value: Any, _event: viser.GuiEvent) -> Future:
            self.remember_value(parameter.name, beside)
            return self.simulation.move(parameter.name, value, beside, models)

        def now() -> Any:
            state = self.simulation.state
            values = state.beside_values if beside else state.values
            return slider_value(values.get(parameter.name, value))

        self.followed[parameter.name, beside] = FollowedValue(handle, send, now)
        return handle


def slider_value(value: Any) -> Any:
    """Where the slider of a parameter stands: at the centre of what differs."""
    return value.centre if isinstance(value, Distribution) else value


def add_control(gui: viser.GuiApi, parameter: DeclaredParameter, value: Any) -> Any:
    """A switch, a choice, or a slider with a box, which takes all that is allowed."""
    label, hint = parameter_label(parameter)
    if parameter.kind == "number":
        hint += f" Double click: back to {format_value(value)}."
    if parameter.kind == "switch":
        return gui.add_checkbox(label, bool(value), hint=hint)
    if parameter.kind == "choice":
        return gui.add_dropdown(label, parameter.choices, initial_value=value, hint=hint)
    if not isinstance(parameter, NumberParameter):
        raise InputError(f"{parameter.name} has no range for a slider: declare its low and high")
    low, high = parameter.bounds
    slider = gui.add_slider(
        label, float(low), float(high), step_of(parameter), float(value), hint=hint
    )
    slider.precision = decimals(parameter)
    return slider


def sides(
    model: Model, own: Iterable[DeclaredParameter]
) -> tuple[list[DeclaredParameter], list[DeclaredParameter]]:
    """The parameters of a model's rule, and those of its body."""
    wants = model.rule.parameters.model_fields
    return [parameter for parameter in own if parameter.name in wants], [
        parameter for parameter in own if parameter.name not in wants
    ]


def parameter_label(parameter: DeclaredParameter) -> tuple[str, str]:
    """Label and hint of a parameter: of a number words, symbol and unit, of all else words."""
    allowed = f"{parameter.allowed[:1].upper()}{parameter.allowed[1:]}"
    hint = f"{parameter.description}. {allowed}. {parameter.source}."
    if parameter.kind != "number":
        return parameter.words, hint
    unit = "" if parameter.unit == "1" else f", {raised_powers(parameter.unit)}"
    return f"{parameter.words} {plain_symbol(parameter.symbol)}{unit}", hint


def raised_powers(unit: str) -> str:
    """A unit with its exponents in small figures.

    >>> raised_powers("m/s^2")
    'm/s²'
    """
    return re.sub(r"\^(\d)", raised_figure, unit)


def raised_figure(match: re.Match[str]) -> str:
    """An exponent in a small figure."""
    return match[1].translate(str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹"))


def describe_changes(
    changed: list[DeclaredParameter], begun: dict[str, Any], values: dict[str, Any]
) -> str:
    """What is changed, what it was, and what it is now: a line each."""
    rows = {
        html.escape(f"{parameter.words} {plain_symbol(parameter.symbol)}"): html.escape(
            f"{format_value(begun[parameter.name])} \u2192 {format_value(values[parameter.name])}"
        )
        for parameter in changed
    }
    title = f'<h2 class="fs-head">Changed: {len(rows)}</h2>'
    return block(f'{title}<div class="fs-changed">{table(rows)}</div>') if rows else ""


def format_value(value: Any) -> str:
    """A parameter's value for people."""
    return f"{value:g}" if isinstance(value, float) else str(value)
