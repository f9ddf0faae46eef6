"""Which run is drawn of each model, and at which ticks one sees what it does."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from agents import Flock
from agents.models.model import Model


@dataclass(frozen=True)
class Scene:
    """What is drawn of a model: a run, four ticks of it, and how much around it."""

    ticks: tuple[int, ...]
    length: float
    """Of an agent, in the world's units."""
    agents: int | None = None
    """None: as many as are at home there."""
    seed: int = 1
    size: float | None = None
    parameters: dict[str, Any] = field(default_factory=dict)
    tail: int = 0
    """Ticks that are drawn behind the agents."""
    view: tuple[tuple[float, float], tuple[float, float]] | None = None
    """Corners of what is drawn of the world; None: all of it."""
    window: tuple[float, float] | None = None
    """Sides of a close look; None: there is no map."""
    form: str = ""
    """What agents are drawn as; empty: as their rule says."""


ON_TORUS = Scene((0, 5, 15, 60), 0.36, agents=200, seed=4, size=7.0, parameters={"eta": 0.2})
"""Of models that are at home on the torus."""
LEFT_BEHIND = Scene((0, 15, 40, 80), 0.5, tail=15, view=((-9.6, -3.4), (10.4, 8.4)))
LED = Scene((60, 190, 400, 600), 0.5, tail=30, view=((-2.5, -6.6), (62.0, 13.2)), window=(11, 8.2))
SCENES = {
    "vem-a-nav": LEFT_BEHIND,
    "ivem-a-nav": LEFT_BEHIND,
    "wvem-nav": LED,
    "hwvem-nav": LED,
    "olfati-saber": Scene((0, 1000, 2000, 8000), 3.0, tail=150, view=((0.0, 0.0), (92.0, 98.0))),
    "boundary-points": Scene((0, 400, 1000, 3000), 2.2, tail=100, view=((0.0, 0.0), (88.0, 45.0))),
    "reynolds": Scene((0, 300, 900, 1800), 1.3, tail=20),
    "inertial-spin": Scene((0, 20, 60, 400), 0.36, agents=200, seed=4, size=7.0),
    "pedestrian": Scene((0, 200, 1000, 3000), 1.3),
    "vasarhelyi": Scene((0, 100, 400, 900), 7.0, tail=60),
    "cucker-smale": Scene((0, 20, 80, 400), 0.45, tail=20, view=((-2.0, -2.0), (7.0, 7.0))),
    "dorsogna": Scene((0, 50, 500, 6000), 0.24, seed=2, tail=10, view=((0.0, 0.0), (4.94, 4.94))),
    "prey-swarm": Scene((0, 50, 150, 2000), 0.13, tail=30, view=((0.0, 0.0), (4.94, 4.94))),
    "active-brownian": Scene((0, 1000, 5000, 20_000), 1.0),
    "couzin": Scene((0, 60, 200, 1200), 1.6),
    "leadership": Scene(
        (0, 40, 100, 200),
        1.3,
        tail=15,
        parameters={"omega": 0.5},
        view=((-4.0, -8.0), (52.0, 20.0)),
    ),
    "thesis": Scene((0, 100, 500, 3000), 1.6, seed=3),
    "safe": Scene((0, 100, 500, 3000), 1.6, seed=3, parameters={"alpha": 270.0, "v0": 2.0}),
    "guarded": Scene((0, 100, 500, 3000), 1.6, seed=3),
    "echelon": Scene((0, 100, 500, 2000), 4.0),
    "vasarhelyi-tenth": Scene((0, 100, 400, 900), 1.3, tail=60),
}
"""Ticks at which one sees what a model does."""


def scene_of(model: Model) -> Scene:
    """What is drawn of a model; of one without a scene of its own, its first 200 ticks."""
    usual = ON_TORUS if model.world == "wrap" else Scene((0, 50, 100, 200), 1.0)
    return SCENES.get(model.name, usual)


def flock_of(model: Model, scene: Scene | None = None) -> Flock:
    """The flock of a scene, or of the model's own, at tick 0."""
    scene = scene or scene_of(model)
    return Flock(
        model.name, agents=scene.agents, size=scene.size, rng=scene.seed, **scene.parameters
    )
