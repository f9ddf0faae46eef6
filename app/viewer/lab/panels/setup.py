"""What takes effect at Setup: the model, its size, its world."""

from __future__ import annotations

import html
from collections.abc import Iterable
from typing import Any

import viser

from agents.catalogue import MODELS, PLAYED
from agents.conditions import Conditions
from agents.individuals import Distribution
from agents.kinds import NO_KINDS
from agents.models.model import Model
from agents.spec import DEFAULT, OPTIONS, CompleteSpec, Options, Spec
from app.front.controls import set_value
from app.viewer.panels.dials import handle, set_visible
from app.viewer.panels.shell import block
from app.viewer.run.run_preset import (
    MOST_AGENTS,
    preset_spec,
    world_defaults,
    world_title,
    world_titles,
)
from app.viewer.run.simulation_state import SimulationState
from app.viewer.scene.shown.control import Control
from worlds.world import World

DIMENSIONS = {"2-D": 2, "3-D": 3}
LARGEST_SEED = 2**31 - 1
MOST_SIDE = 1000
NOBODY = "none"
Pairing = tuple[CompleteSpec, Spec | None]
"""A run, and the one beside it."""


class SetupPanel:
    """The next run, and what is beside it; nothing happens until Setup is pressed."""

    def __init__(self, gui: viser.GuiApi, state: SimulationState):
        spec = state.spec
        self.running: Pairing = spec, state.beside
        self.offered = spec.world
        self.shown_run = -1
        self.worlds = world_titles()
        self.worlds.setdefault(world_title(spec.world), spec.world)
        titles = [model.title for model in MODELS.values()]
        model, beside = state.models
        self.note = gui.add_html("")
        self.model = gui.add_dropdown(
            "Model",
            titles,
            initial_value=MODELS[DEFAULT if model in PLAYED else model].title,
            hint="The rule agents follow",
        )
        self.summary = gui.add_html("")
        self.beside = gui.add_dropdown(
            "Beside",
            self.companions(model, spec.dim),
            initial_value=NOBODY if beside is None or model in PLAYED else MODELS[beside].title,
            hint="A second model in the same world, from the same start, with the same controls",
        )
        self.agents = add_number_control(gui, "agents", spec.agents, 1, MOST_AGENTS)
        self.world = handle(gui, choice_control("world", self.worlds), world_title(spec.world))
        self.dim = handle(gui, choice_control("dim", DIMENSIONS), f"{spec.dim}-D")
        self.size = add_number_control(
            gui, "size", spec.size, 0, MOST_SIDE, "; 0 keeps the density"
        )
        acts = [name for name in Options.model_fields if name not in Conditions.model_fields]
        self.plain = {name: add_plain_control(gui, name, getattr(spec, name)) for name in acts}
        self.conditions = gui.add_folder(
            "Messages and wind", expand_by_default=spec.is_late or spec.is_windy
        )
        with self.conditions:
            self.plain |= {
                name: add_plain_control(gui, name, getattr(spec, name))
                for name in Conditions.model_fields
            }
        self.seed = add_number_control(gui, "seed", spec.seed, 0, LARGEST_SEED)
        self.new_seed = gui.add_checkbox(
            "New seed", True, hint="Take the next seed at every Setup, for a new random start"
        )
        self.fit()
        self.model.on_update(self.choose_model)
        self.world.on_update(self.choose_world)
        self.dim.on_update(self.choose_dimensions)

    async def choose_model(self, event: viser.GuiEvent) -> None:
        """A model brings its own number of agents, its dimensions, its world and its options."""
        model = MODELS[model_titled(self.model.value)]
        for name, control in self.plain.items():
            set_value(control, control_value(name, default_value(name, model)))
        if event.client is None:
            return
        if world_title(model.world) in self.worlds:
            set_value(self.world, world_title(model.world))
        set_value(self.agents, model.agents)
        set_value(self.dim, f"{model.dim or model.dimensions[0]}-D")
        self.fit()

    async def choose_world(self, event: viser.GuiEvent) -> None:
        """A world may decide the dimension and the side."""
        if event.client is not None:
            self.fit()

    async def choose_dimensions(self, _event: viser.GuiEvent) -> None:
        """Not every model flies in every dimension."""
        self.fit_beside()

    def fit(self) -> None:
        """Let the world and the model decide what is theirs to decide, and say what it is."""
        model = MODELS[model_titled(self.model.value)]
        self.summary.content = block(f'<div class="fs-quiet">{html.escape(model.summary)}</div>')
        own = world_defaults(self.worlds[self.world.value])
        self.plain["informed"].disabled = not model.rule.led
        self.size.disabled = own.sized
        self.dim.disabled = own.dim == 3
        if own.dim is not None:
            set_value(self.dim, f"{own.dim}-D")
        self.fit_beside()

    def fit_beside(self) -> None:
        """Offer the models that can fly beside the chosen one; nobody if the chosen one cannot."""
        options = self.companions(model_titled(self.model.value), DIMENSIONS[self.dim.value])
        if tuple(self.beside.options) != options:
            chosen = self.beside.value
            self.beside.options = options
            set_value(self.beside, chosen if chosen in options else NOBODY)

    @staticmethod
    def companions(model: str, dim: int) -> tuple[str, ...]:
        """Titles of the models that can fly beside one in so many dimensions, after nobody."""
        others = (candidate for name, candidate in MODELS.items() if name != model)
        return (NOBODY, *(other.title for other in others if dim in other.dimensions))

    def chosen_pairing(self) -> Pairing:
        """The run as the panel has it, and what is beside it; running seed, no parameters."""
        model = MODELS[model_titled(self.model.value)]
        spec = preset_spec(
            model.name,
            agents=self.agents.value,
            seed=self.running[0].seed,
            size=None if self.size.disabled else self.size.value or None,
            dim=DIMENSIONS[self.dim.value],
            world=self.worlds[self.world.value],
            **{
                name: option_value(name, handle.value, model) for name, handle in self.plain.items()
            },
        )
        return spec, None if self.beside.value == NOBODY else Spec(model_titled(self.beside.value))

    def next_pairing(self, state: SimulationState) -> Pairing:
        """The run for Setup, and what is beside it; models that stay keep their parameters."""
        spec, beside = self.chosen_pairing()
        if self.new_seed.value and self.seed.value == self.running[0].seed:
            set_value(self.seed, (self.seed.value + 1) % LARGEST_SEED)
        stays = spec.model == self.running[0].model
        if beside is not None and stays and (spec.model, beside.model) == state.models:
            beside = beside.with_parameters(state.beside_values)
        values, kinds = (state.values, state.kinds) if stays else ({}, NO_KINDS)
        spec = spec.with_parameters(values, kinds=kinds.kinds, to=kinds.to, seed=self.seed.value)
        return spec, beside

    @staticmethod
    def dropped_differences(state: SimulationState, pairing: Pairing) -> str:
        """What is said of differences between agents, and of kinds of them, that the next run does
        not have, as of another model; empty: it has all of them."""
        spec, beside = pairing
        taken = spec.individuals | ({} if beside is None else beside.individuals)
        lost = [
            f"{name} = {value}"
            for name, value in (state.beside_values | state.values).items()
            if isinstance(value, Distribution) and name not in taken
        ]
        names = {kind.name for kind in spec.kinds}
        lost += [f"kind {kind.name}" for kind in state.kinds.kinds if kind.name not in names]
        return f"Not taken over into the new run: {', '.join(lost)}" if lost else ""

    def catch_up(self, spec: CompleteSpec) -> None:
        """Choose the running world if it has become another since Setup, as by the World tab."""
        if spec.world is not self.offered:
            self.offered = spec.world
            self.offer(spec.world)

    def follow(self, spec: CompleteSpec, beside: Spec | None) -> None:
        """Choose what a run has that is set up from elsewhere."""
        model = MODELS[spec.model]
        if model.title not in self.model.options:
            self.model.options = (*self.model.options, model.title)
        set_value(self.model, model.title)
        self.offered = spec.world
        self.offer(spec.world)
        set_value(self.dim, f"{spec.dim}-D")
        self.fit_beside()
        set_value(self.beside, NOBODY if beside is None else MODELS[beside.model].title)
        for name, control in {"agents": self.agents, "size": self.size, **self.plain}.items():
            set_value(control, control_value(name, getattr(spec, name)))

    def offer(self, world: str | World) -> None:
        """Let a world that is none of the built-in ones be chosen, and choose it."""
        words = world_title(world)
        self.worlds[words] = world
        self.world.options = tuple(self.worlds)
        set_value(self.world, words)
        self.fit()

    def refresh(self, state: SimulationState, played: bool = False) -> None:
        """Say what differs from the running flock; after a set-up nothing does.

        `played`: whether who sits before it plays a kind of agents: then the seed alone is theirs.
        """
        for control in (self.model, self.summary, self.beside, self.agents, self.world, self.dim,
                        self.size, self.conditions, *self.plain.values()):  # fmt: skip
            set_visible(control, not played)
        self.running = state.spec, state.beside
        if state.run != self.shown_run:
            self.shown_run = state.run
            set_value(self.seed, state.spec.seed)
        changed = ", ".join(describe_differences(self.chosen_pairing(), self.running))
        self.note.content = block(
            f'<div class="fs-note">Changed: <b>{changed}</b>. Press Setup to use it.</div>'
            if changed
            else '<div class="fs-quiet">Takes effect at Setup.</div>'
        )


def describe_differences(pairing: Pairing, other: Pairing) -> list[str]:
    """What differs, as the panel calls it; seeds and parameters are left out."""
    (spec, beside), (before, beside_before) = pairing, other
    models = {
        "model": spec.model != before.model,
        "beside": (beside and beside.model) != (beside_before and beside_before.model),
    }
    options = {
        option.title.lower(): getattr(spec, name) != getattr(before, name)
        for name, option in OPTIONS.items()
        if name != "seed"
    }
    return [title for title, differ in (models | options).items() if differ]


def add_plain_control(gui: viser.GuiApi, name: str, value: Any) -> Any:
    """The control of an option that stands by itself."""
    option = OPTIONS[name]
    if option.kind in (int, float):
        return add_number_control(gui, name, value, option.least, option.most)
    return handle(gui, choice_control(name, option.words.values()), control_value(name, value))


def choice_control(name: str, choices: Iterable[str]) -> Control:
    """A list of words for an option, or a switch if there are none."""
    return Control(OPTIONS[name].title, OPTIONS[name].help, tuple(choices))


def add_number_control(
    gui: viser.GuiApi, name: str, value: Any, low: float, high: float, more: str = ""
) -> Any:
    """A box for an option that is a number, in [low, high], with `more` to say of it."""
    option, value = OPTIONS[name], control_value(name, value)
    low, high = min(low, value), max(high, value)
    control = Control(
        option.title, option.help + more, low=low, high=high, step=option.step, typed=True
    )
    return handle(gui, control, value)


def control_value(name: str, value: Any) -> Any:
    """An option as its control has it: a choice in words, 0 for none."""
    words = OPTIONS[name].words
    return words[value] if words else value or OPTIONS[name].kind()


def option_value(name: str, value: Any, model: Model) -> Any:
    """An option from its control; what shows like the default is the default."""
    words = OPTIONS[name].words
    if words:
        return next(key for key, word in words.items() if word == value)
    own = default_value(name, model)
    return own if value == control_value(name, own) else value


def default_value(name: str, model: Model) -> Any:
    """An option of a run that does not say it: the model's own, if the model has one."""
    default = Spec.model_fields[name].default
    return getattr(model, name) if default is None else default


def model_titled(title: str) -> str:
    """Name of the model with that title."""
    return next(name for name, model in MODELS.items() if model.title == title)
