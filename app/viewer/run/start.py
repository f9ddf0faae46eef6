"""What a flock is set up from."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

from agents.catalogue import MODELS
from agents.flock import Flock
from worlds.layout import layout_names, own_dim, read_layout
from worlds.world import World

MOST_AGENTS = 200_000
"""More agents than this are set up from the command line or a script, not from a browser."""
COMMON_SPEED, HURRY = 15.0, 5.0
"""Ticks per second for bodies that count ticks; seconds per second for those that count seconds."""
WORLDS = {
    "wrap": "wraps around",
    "wrap-plain": "wraps, seam is a wall",
    "open": "open plane",
    "thesis-sky": "thesis: empty, wraps",
    "thesis-blocks": "thesis: 20 blocks, solid walls",
}
"""Short words for some worlds; the others go by their titles."""
ACTIVATIONS = {
    "synchronous": "all at once",
    "random": "random order",
    "sequential": "one by one",
}
NOISES = {"angular": "angular", "vectorial": "vectorial"}


@dataclass(frozen=True)
class Start:
    """Everything that Setup decides; the same start gives the same run, to the bit."""

    model: str = "hwvem"
    agents: int = 100
    seed: int = 1
    size: float | None = None
    """Side of the world, length; None for the layout's own, or the model's own density."""
    dim: int = 2
    world: str | World = "wrap"
    """A built-in layout or a TOML file by name, or a world that has been built here."""
    activation: str = "synchronous"
    noise: str = "angular"
    informed: int | None = None
    """Number of information agents; None for the model's own."""
    spacing: float | None = None
    """Least distance at the start between agents and of agents to what is solid, length; None for
    the model's own."""
    threads: int = 1
    parameters: dict[str, Any] = field(default_factory=dict)
    beside: str | None = None
    """A second model, whose flock flies in the same world from the same start."""
    beside_parameters: dict[str, Any] = field(default_factory=dict)
    """What the second model does not share with the first."""

    def build(self) -> Flock:
        """The flock at tick 0. Raises Refusal if something is out of range."""
        return Flock(
            self.model,
            agents=self.agents,
            size=self.size,
            dim=self.dim,
            world=self.world,
            activation=self.activation,
            noise=self.noise,
            informed=self.informed,
            spacing=self.spacing,
            rng=self.seed,
            threads=self.threads,
            **self.parameters,
        )

    def but(self, **changes: Any) -> Start:
        """The same start with some things changed."""
        return replace(self, **changes)

    def differs(self, other: Start) -> list[str]:
        """Names of what differs from another start, seed and parameters left out."""
        where = ("model", "beside", "agents", "size", "dim", "world")
        how = ("activation", "noise", "informed", "spacing")
        return [one for one in (*where, *how) if getattr(self, one) != getattr(other, one)]


@dataclass(frozen=True)
class Home:
    """What a world decides by itself."""

    dim: int | None
    """Dimensions that it is written in, None where it fits both."""
    sized: bool
    """Whether it has a size of its own."""


def home(world: str | World) -> Home:
    """What a world decides by itself. Raises Refusal for a file that cannot be read."""
    if isinstance(world, World):
        return Home(world.dim, True)
    layout = read_layout(world)
    return Home(own_dim(layout, world), "size" in layout)


def at_home(model: str = "hwvem", **given: Any) -> Start:
    """A start of a model in the world that it is at home in, where nothing else is `given`.

    What is None counts as not given. Raises Refusal for a world that cannot be read.

    >>> at_home("hwvem").world, at_home("hwvem", world="open").world
    ('wrap', 'open')
    """
    given = {name: value for name, value in given.items() if value is not None}
    own = MODELS[model]
    world = given.pop("world", own.world)
    dim = home(world).dim or own.dim or own.dimensions[0]
    proposed = {"agents": own.agents, "dim": dim, "world": world}
    return Start(model, **(proposed | given))


def lively_speed(start: Start) -> float:
    """Ticks per second at which a run can be watched: five times as fast as a body's seconds pass.

    >>> lively_speed(Start("hwvem"))
    15.0
    """
    model = MODELS[start.model]
    if model.body.unit == "ticks":
        return COMMON_SPEED
    known = {k: v for k, v in start.parameters.items() if k in model.parameters.model_fields}
    return HURRY / model.body.lasts(model.parameters(**known))


def world_titles() -> dict[str, str | World]:
    """The built-in worlds by what a person may call them, the empty ones first."""
    names = [*WORLDS, *(name for name in layout_names() if name not in WORLDS)]
    return {titled(name): name for name in names}


def titled(world: str | World) -> str:
    """What a person may call a world."""
    if isinstance(world, World):
        return world.title or world.name
    return WORLDS.get(world) or str(read_layout(world).get("title", "")) or world
