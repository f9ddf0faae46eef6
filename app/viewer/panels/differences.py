"""Which parameters differ from agent to agent, and the spread of one of them."""

from __future__ import annotations

import html
import threading
from collections.abc import Iterator
from concurrent.futures import Future
from dataclasses import dataclass, replace
from typing import Any

import viser

from agents.catalogue import MODELS, PLAYED
from agents.individuals import Distribution
from agents.models.declare import NumberParameter, declared
from agents.models.slider_range import round_up
from app.front.controls import set_value
from app.viewer.panels.dials import Dials, plain_symbol, set_visible
from app.viewer.panels.followed_value import FollowedValue
from app.viewer.panels.parameters import ParametersPanel, add_control
from app.viewer.panels.shell import block, table
from app.viewer.run.simulation import Simulation
from app.viewer.run.simulation_state import SimulationState
from worlds.number_text import counted

TITLE = "Differences between agents"
ALIKE = "All agents are alike. A spread above 0 gives each its own value."
REPLACED = "A new spread makes the chosen one a normal distribution."


@dataclass(frozen=True)
class DifferingParameter:
    """A parameter in which agents may differ."""

    parameter: NumberParameter
    beside: bool
    """Whether it is of the flock beside alone."""
    label: str
    """What it is called among the others."""

    def value(self, state: SimulationState) -> Any:
        """A number where all are alike, else a distribution."""
        values = state.beside_values if self.beside else state.values
        return values.get(self.parameter.name, self.parameter.default)

    def spread(self, state: SimulationState) -> float:
        """The spread of its distribution; 0 where all are alike."""
        value = self.value(state)
        return value.spread if isinstance(value, Distribution) else 0.0

    def description(self, state: SimulationState) -> str:
        """What its numbers are drawn from, and how many were drawn again; empty: all are alike."""
        value = self.value(state)
        if not isinstance(value, Distribution):
            return ""
        again = state.redrawn.get((self.parameter.name, self.beside), 0)
        return f"{value}, {counted(again, 'number')} drawn again" if again else str(value)

    @property
    def of_spread(self) -> NumberParameter:
        """Its spread, as a slider has it. What is proposed goes to a quarter of what the parameter
        proposes: of a normal distribution nearly all is within four spreads."""
        one = self.parameter
        low, high = one.proposed
        widest = 0.5 * (one.high - one.low)
        return replace(
            one,
            words="Spread of",
            description="Standard deviation of the agents' values of a normal distribution. At 0 "
            "all have the same. Values out of range are drawn again",
            source="Each value follows from the seed and the agent",
            low=0.0,
            high=widest,
            default=0.0,
            step=None if one.step is None else 0.1 * one.step,
            proposed=(0.0, min(widest, round_up(0.25 * (high - low)))),
        )


class DifferencesPanel:
    """A folder below the parameters, closed at first: which differ, and a slider of the spread."""

    def __init__(self, gui: viser.GuiApi, simulation: Simulation, parameters: ParametersPanel):
        self.gui = gui
        self.simulation = simulation
        self.parameters = parameters
        self.offered: dict[str, DifferingParameter] = {}
        """By what they are called."""
        self.folder = gui.add_folder(TITLE, expand_by_default=False, visible=False)
        with self.folder:
            self.dials = Dials(gui)
            self.said = gui.add_html("")
            self.which = gui.add_dropdown(
                "Parameter", ("",), hint="Whose spread the slider below sets"
            )
            self.place = gui.add_folder(None)
        self.which.on_update(self.choose)
        self.lock = threading.Lock()
        """Held while the slider is made or followed: browsers choose another on viser's thread."""
        self.slider: Any = None
        self.followed: FollowedValue | None = None
        self.declaring: list[Any] = []
        """What declares the parameters that are offered."""

    @property
    def chosen(self) -> DifferingParameter:
        """The parameter whose spread the slider sets."""
        return self.offered[self.which.value]

    async def choose(self, event: viser.GuiEvent) -> None:
        """Show the spread of another parameter."""
        if event.client is not None:
            with self.lock:
                self.show_slider()

    def refresh(self, state: SimulationState) -> None:
        """Follow the flock: what can differ, what does, and the spread of what is chosen."""
        if state.values:
            with self.lock:
                self.follow(state)

    def follow(self, state: SimulationState) -> None:
        """The same, while nobody else changes what is there."""
        if self.parameters.declaring != self.declaring:
            self.declaring = self.parameters.declaring
            self.offer(state)
        played = self.parameters.simulation.played
        set_visible(self.folder, bool(self.offered) and (played is None or bool(played.own)))
        if self.slider is None or self.followed is None:
            return
        rows = {
            html.escape(label): html.escape(words)
            for label, one in self.offered.items()
            if (words := one.description(state))
        }
        content = block(table(rows) if rows else f'<div class="fs-quiet">{ALIKE}</div>')
        chosen = self.chosen.value(state)
        if isinstance(chosen, Distribution) and chosen.kind != "normal":
            content = block(f'{table(rows)}<div class="fs-quiet">{REPLACED}</div>')
        if content != self.said.content:
            self.said.content = content
        label = f"{TITLE}: {len(rows)}" if rows else TITLE
        if self.folder.label != label:
            self.folder.label = label
        self.followed.follow(self.chosen.spread(state))
        name, beside = self.chosen.parameter.name, self.chosen.beside
        controls = self.parameters.beside_controls if beside else self.parameters.controls
        stands = name in controls and controls[name].disabled
        if self.slider.disabled != stands:
            self.slider.disabled = stands
        self.dials.refresh()

    def offer(self, state: SimulationState) -> None:
        """Let be chosen what may differ in these models; first what does."""
        found = sorted(differing_parameters(state), key=lambda one: not one.spread(state))
        self.offered = {one.label: one for one in found}
        self.which.options = tuple(self.offered) or ("",)
        set_value(self.which, self.which.options[0])
        self.show_slider()

    def show_slider(self) -> None:
        """Make the slider of the chosen parameter's spread in place of the one before."""
        if self.slider is not None:
            self.slider.remove()
            self.slider = self.followed = None
        self.dials.clear()
        if not self.offered:
            return
        chosen = self.chosen
        name, beside, models = chosen.parameter.name, chosen.beside, self.simulation.state.models
        with self.place:
            spread = chosen.spread(self.simulation.state)
            self.slider = add_control(self.gui, chosen.of_spread, spread)
        self.dials.add(chosen.of_spread, self.slider)

        def send(value: Any, _event: viser.GuiEvent) -> Future:
            self.parameters.remember_value(name, beside)
            return self.simulation.spread(name, value, beside, models)

        def now() -> Any:
            return chosen.spread(self.simulation.state)

        self.followed = FollowedValue(self.slider, send, now)


def differing_parameters(state: SimulationState) -> Iterator[DifferingParameter]:
    """The parameters in which agents of a run may differ; those of the flock beside last."""
    name, beside = state.models
    for model_name, values, is_beside in (
        (name, state.values, False),
        (beside, state.beside_values, True),
    ):
        if model_name is None or model_name in PLAYED:
            continue
        model = MODELS[model_name]
        for one in declared(model.parameters):
            if one.name not in model.individual or one.name not in values:
                continue
            assert isinstance(one, NumberParameter)
            label = f"{one.words} {plain_symbol(one.symbol)}"
            label += f" ({model.title})" if is_beside else ""
            yield DifferingParameter(one, is_beside, label)
