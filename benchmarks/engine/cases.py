"""The flocks whose speed is compared between two states of this tree."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from crowds import grove_in_square, scattered_start

from agents import Flock
from agents.catalogue import model
from agents.flock_world import complete_spec, find_world
from agents.spec import Spec
from worlds.generators import generate
from worlds.mission import Goal, Mission
from worlds.world import World


@dataclass(frozen=True)
class Case:
    """A model with so many agents, and the ticks of a round."""

    model: str
    agents: int
    ticks: int
    makes: Callable[[Case], Mapping[str, Any]] = lambda case: {"agents": case.agents}
    """How its flock is made."""
    words: Mapping[str, Any] = field(default_factory=dict)

    def flock(self) -> Flock:
        """The flock at tick 0, the same in every process."""
        return Flock(self.model, rng=1, **self.makes(self), **self.words)


def density_box(dim: int, density: float) -> Callable[[Case], Mapping[str, Any]]:
    """A box of `density` agents per unit of area or volume."""

    def made(case: Case) -> Mapping[str, Any]:
        return {"agents": case.agents, "dim": dim, "size": (case.agents / density) ** (1 / dim)}

    return made


def mixed_rows(case: Case) -> Mapping[str, Any]:
    """The same box with rows in no order, as agents are after a long run; size for density 4."""
    size = math.sqrt(case.agents / 4.0)
    flock = Flock(case.model, agents=case.agents, size=size, rng=1)
    rows = np.random.default_rng(1).permutation(case.agents)
    return {
        "start": {"position": flock.position[rows], "heading": flock.heading[rows]},
        "size": size,
    }


def home(name: str) -> World:
    """The world that a model is at home in."""
    spec = Spec(name, seed=1)
    return find_world(complete_spec(spec, model(name)), model(name))


def lattice(low: float, gap: float) -> Callable[[Case], Mapping[str, Any]]:
    """A square lattice in the world of the model, for flocks that its own start has no room for."""

    def made(case: Case) -> Mapping[str, Any]:
        side = math.isqrt(case.agents - 1) + 1
        k = np.arange(case.agents)
        position = low + gap * np.stack([k % side, k // side], axis=1)
        return {"start": {"position": position, "heading": np.tile([1.0, 0.0], (len(k), 1))}}

    return made


def free_start(case: Case) -> Mapping[str, Any]:
    """A start all over what is free of the model's world, not only where its mission starts."""
    world = home(case.model)
    empty_world = dataclasses.replace(world, mission=None)
    return {"start": scattered_start(empty_world, case.agents), "world": world}


def grove(case: Case) -> Mapping[str, Any]:
    """The clearing of `crowds.py`: 80 discs, 10 240 edges."""
    world = grove_in_square(40.0, 80, 1.0)
    return {"start": scattered_start(world, case.agents), "world": world}


def discs(case: Case) -> Mapping[str, Any]:
    """Discs and agents as dense as in `crowds.py`, and a goal beyond them."""
    side = 12.0 * math.sqrt(case.agents)
    world = generate(
        "discs",
        1,
        (side, side),
        edges="open",
        count=case.agents // 10,
        radius_low=2.0,
        radius_high=5.0,
    )
    goal = Mission(goal=Goal(route=((side + 50.0, 0.5 * side),)))
    return {
        "start": scattered_start(world, case.agents),
        "world": dataclasses.replace(world, mission=goal),
    }


VICSEK = {"r": 1.0, "v0": 0.03, "eta": 0.3}
CASES = {
    "vem": Case("vem", 100_000, 40, density_box(2, 4.0), VICSEK),
    "vem-mixed": Case("vem", 100_000, 20, mixed_rows, VICSEK),
    "topological": Case("topological", 10_000, 60),
    "couzin-3d": Case("couzin", 100_000, 8, density_box(3, 100 / 40.0**3)),
    "inertial-spin": Case("inertial-spin", 100_000, 10, density_box(2, 4.0)),
    "hwvem": Case("hwvem", 10_000, 60),
    "hwvem-nav": Case("hwvem-nav", 1_000, 500),
    "hwvem-nav-grove": Case("hwvem-nav", 1_000, 300, grove),
    "boundary-points": Case("boundary-points", 60, 10_000),
    "boundary-points-box": Case(
        "boundary-points", 100_000, 10, density_box(2, 0.1), {"world": "wrap"}
    ),
    "boundary-points-discs": Case("boundary-points", 10_000, 40, discs),
    "guarded": Case("guarded", 500, 80),
    "pedestrian": Case("pedestrian", 250, 400),
    "squashing": Case("squashing", 100, 3_000, lattice(-2.5, 0.5)),
    "reynolds": Case("reynolds", 1_000, 500, free_start),
    "olfati-saber": Case("olfati-saber", 1_000, 1_000, lattice(-50.0, 2.0)),
}
"""By name; densities, sizes and worlds as the other benchmarks have them, else the model's own."""
