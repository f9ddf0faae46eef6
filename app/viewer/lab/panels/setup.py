"""What takes effect at Setup: the model, its size, its world."""

from __future__ import annotations

import html
from typing import Any

import viser

from agents.catalogue import MODELS
from app.viewer.panels.style import block
from app.viewer.run.start import (
    ACTIVATIONS,
    MOST_AGENTS,
    NOISES,
    Start,
    home,
    titled,
    world_titles,
)
from app.viewer.run.state import State
from app.viewer.web.values import show
from worlds.world import World

DIMENSIONS = {"2-D": 2, "3-D": 3}
LARGEST_SEED = 2**31 - 1
NOBODY = "none"
NAMES = {
    "model": "model",
    "beside": "beside",
    "agents": "agents",
    "size": "side",
    "dim": "dimension",
    "world": "world",
    "activation": "turns",
    "noise": "noise",
    "informed": "informed",
    "spacing": "spacing",
}
"""What the fields of a start are called in the panel."""


class SetupPanel:
    """The fields of a `Start`; nothing happens until Setup is pressed."""

    def __init__(self, gui: viser.GuiApi, start: Start):
        self.running = start
        self.offered = start.world
        self.shown_run = -1
        self.worlds = world_titles()
        self.worlds.setdefault(titled(start.world), start.world)
        titles = [model.title for model in MODELS.values()]
        self.note = gui.add_html("")
        self.model = gui.add_dropdown(
            "Model", titles, initial_value=MODELS[start.model].title, hint="The rule agents follow"
        )
        self.summary = gui.add_html("")
        self.beside = gui.add_dropdown(
            "Beside",
            self.companions(start.model, start.dim),
            initial_value=NOBODY if start.beside is None else MODELS[start.beside].title,
            hint="A second model in the same world, from the same start, with the same controls",
        )
        self.agents = gui.add_number(
            "Agents",
            start.agents,
            min=1,
            max=max(MOST_AGENTS, start.agents),
            step=10,
            hint="Number of agents",
        )
        self.informed = gui.add_number(
            "Informed",
            MODELS[start.model].informed if start.informed is None else start.informed,
            min=0,
            max=100,
            step=1,
            hint="Information agents: they know the heading to take, or the path of the mission",
        )
        self.world = gui.add_dropdown(
            "World",
            list(self.worlds),
            initial_value=titled(start.world),
            hint="What stands in the world, what happens at its edges, and where the flock is to "
            "go. A model proposes the world that it is at home in",
        )
        self.dim = gui.add_dropdown(
            "Dimension",
            list(DIMENSIONS),
            initial_value=f"{start.dim}-D",
            hint="Plane or space; a world that is built in space has no other",
        )
        self.size = gui.add_number(
            "Side",
            0.0 if start.size is None else start.size,
            min=0.0,
            max=1000.0,
            step=0.5,
            hint="Side of the world (length); 0 keeps the density of the paper. A world with "
            "obstacles or a mission has its own",
        )
        self.spacing = gui.add_number(
            "Spacing",
            0.0,
            min=0.0,
            max=100.0,
            step=0.1,
            hint="At the start, least distance between two agents and of an agent to obstacles and "
            "walls (length); 0 as in the paper: nobody starts inside an obstacle",
        )
        self.activation = gui.add_dropdown(
            "Turns",
            list(ACTIVATIONS.values()),
            initial_value=ACTIVATIONS[start.activation],
            hint="Who decides when: all on the same instant, or one after the other as in NetLogo",
        )
        self.noise = gui.add_dropdown(
            "Noise",
            list(NOISES.values()),
            initial_value=NOISES[start.noise],
            hint="Angular: an angle is added to the heading. Vectorial: a vector is added to the "
            "mean heading",
        )
        self.seed = gui.add_number(
            "Seed", start.seed, min=0, max=LARGEST_SEED, step=1, hint="Same seed, same run"
        )
        self.new_seed = gui.add_checkbox(
            "New seed", True, hint="Take the next seed at every Setup, for a new random start"
        )
        show(self.spacing, own_spacing(start.model) if start.spacing is None else start.spacing)
        self.fit()
        self.model.on_update(self.model_chosen)
        self.world.on_update(self.world_chosen)
        self.dim.on_update(self.dim_chosen)

    async def model_chosen(self, event: viser.GuiEvent) -> None:
        """A model brings its own number of agents, its dimensions, its world and its spacing."""
        model = MODELS[named(self.model.value)]
        show(self.informed, model.informed)
        show(self.spacing, own_spacing(model.name))
        if event.client is None:
            return
        if titled(model.world) in self.worlds:
            show(self.world, titled(model.world))
        show(self.agents, model.agents)
        show(self.dim, f"{model.dim or model.dimensions[0]}-D")
        self.fit()

    async def world_chosen(self, event: viser.GuiEvent) -> None:
        """A world may decide the dimension and the side."""
        if event.client is not None:
            self.fit()

    async def dim_chosen(self, _event: viser.GuiEvent) -> None:
        """Not every model flies in every dimension."""
        self.fit_beside()

    def fit(self) -> None:
        """Let the world and the model decide what is theirs to decide, and say what it is."""
        model = MODELS[named(self.model.value)]
        self.summary.content = block(f'<div class="fs-quiet">{html.escape(model.summary)}</div>')
        own = home(self.worlds[self.world.value])
        self.informed.disabled = not model.rule.led
        self.size.disabled = own.sized
        self.dim.disabled = own.dim == 3
        if own.dim is not None:
            show(self.dim, f"{own.dim}-D")
        self.fit_beside()

    def fit_beside(self) -> None:
        """Offer the models that can fly beside the chosen one; nobody if the chosen one cannot."""
        options = self.companions(named(self.model.value), DIMENSIONS[self.dim.value])
        if tuple(self.beside.options) != options:
            chosen = self.beside.value
            self.beside.options = options
            show(self.beside, chosen if chosen in options else NOBODY)

    @staticmethod
    def companions(model: str, dim: int) -> tuple[str, ...]:
        """Titles of the models that can fly beside one in so many dimensions, after nobody."""
        others = (one for name, one in MODELS.items() if name != model)
        return (NOBODY, *(one.title for one in others if dim in one.dimensions))

    def chosen(self) -> Start:
        """The start as the fields have it, with the running seed and no parameters."""
        model = named(self.model.value)
        return Start(
            model=model,
            agents=self.agents.value,
            seed=self.running.seed,
            size=None if self.size.disabled else self.size.value or None,
            dim=DIMENSIONS[self.dim.value],
            world=self.worlds[self.world.value],
            activation=key_of(ACTIVATIONS, self.activation.value),
            noise=key_of(NOISES, self.noise.value),
            informed=None if self.informed.value == MODELS[model].informed else self.informed.value,
            spacing=None if self.spacing.value == own_spacing(model) else self.spacing.value,
            threads=self.running.threads,
            beside=None if self.beside.value == NOBODY else named(self.beside.value),
        )

    def next_start(self, values: dict[str, Any], beside_values: dict[str, Any]) -> Start:
        """The start for Setup; models that stay keep their parameters' values."""
        start = self.chosen()
        if self.new_seed.value and self.seed.value == self.running.seed:
            show(self.seed, (self.seed.value + 1) % LARGEST_SEED)
        kept = dict(values) if start.model == self.running.model else {}
        stays = kept and start.beside == self.running.beside
        own = dict(beside_values) if stays else {}
        return start.but(seed=self.seed.value, parameters=kept, beside_parameters=own)

    def catch_up(self, start: Start) -> None:
        """Choose the running world if it has become another since Setup, as by the World tab."""
        if start.world is not self.offered:
            self.offered = start.world
            self.offer(start.world)

    def offer(self, world: str | World) -> None:
        """Let a world that is none of the built-in ones be chosen, and choose it."""
        words = titled(world)
        self.worlds[words] = world
        self.world.options = tuple(self.worlds)
        show(self.world, words)
        self.fit()

    def refresh(self, state: State) -> None:
        """Say what differs from the running flock; after a set-up nothing does."""
        self.running = state.start
        if state.run != self.shown_run:
            self.shown_run = state.run
            show(self.seed, state.start.seed)
        changed = self.chosen().differs(state.start)
        named_ones = ", ".join(NAMES[name] for name in changed)
        self.note.content = block(
            f'<div class="fs-note">Changed: <b>{named_ones}</b>. Press Setup to use it.</div>'
            if changed
            else '<div class="fs-quiet">Takes effect at Setup.</div>'
        )


def own_spacing(model: str) -> float:
    """The spacing at which a flock of that model starts by itself, length."""
    return MODELS[model].spacing or 0.0


def named(title: str) -> str:
    """Name of the model with that title."""
    return next(name for name, model in MODELS.items() if model.title == title)


def key_of(choices: dict[str, str], words: str) -> str:
    """The choice that is worded so."""
    return next(key for key, value in choices.items() if value == words)
