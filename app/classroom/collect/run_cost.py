"""What a result that is handed in may cost, in numbers and in words.

Most of a tick is spent on pairs: each agent looks at all others in the cells around it, so that
2 000 agents on a side as long as their reach are 4 million looks a tick. How many a run needs is
told before it is made, for a flock spread evenly; one that crowds together needs more, and its run
is ended by its worker.
"""

from __future__ import annotations

import math

from agents.catalogue import MODELS
from agents.flock_world import complete_spec, find_world
from agents.individuals import split_individuals
from agents.kinds import kind_table
from agents.models.declare import checked
from agents.models.model import Model
from agents.observables.catalogue import OBSERVABLES
from agents.spec import CompleteSpec
from worlds.input_error import InputError
from worlds.world import World

MOST_TICKS = 20_000
"""Of a run."""
MOST_AGENTS = 5_000
MOST_STEPS = 5_000_000
"""Agents times ticks: a second or two of a core."""
MOST_PAIRS = 300_000_000
"""Agents times those that each looks at times ticks: less than the 8 s of a core that a run has, as
a pair of a crowd takes 1 to 25 ns (`benchmarks/pages/collect.py --pairs` prints it by model)."""
ALONE = 8
"""Pairs that an agent's own work in a tick is worth."""
MOST_SEEN = 200_000
"""Agents times looks at what takes longer than a look at each agent."""


def demand_cheap(spec: CompleteSpec, ticks: int, observable: str, looks: int) -> None:
    """Refuse a run of so many ticks that would take too long for one of a class. Raises InputError.

    `looks`: at how many of its ticks the observable is measured.
    """
    agents = spec.count
    if agents > MOST_AGENTS:
        raise InputError(f"{agents:,} agents are too many to hand in: at most {MOST_AGENTS:,}")
    if agents * ticks > MOST_STEPS:
        raise InputError(
            f"{agents:,} agents for {ticks:,} ticks take too long: agents times ticks may be "
            f"{MOST_STEPS:,} at most, here {MOST_STEPS // ticks:,} agents"
        )
    one = OBSERVABLES[observable]
    if not one.quick and agents * looks > MOST_SEEN and one.over is None:
        raise InputError(
            f"{one.name} of {agents:,} agents at each of {looks:,} ticks takes too long: agents "
            f"times ticks may be {MOST_SEEN:,} at most for it"
        )
    neighbours = mean_neighbours(spec)
    if agents * neighbours * ticks > MOST_PAIRS:
        raise InputError(
            f"{agents:,} agents that each look at {neighbours:,.0f} take too long for {ticks:,} "
            f"ticks: {agents * neighbours * ticks:.2g} pairs, at most {MOST_PAIRS:.2g}. Take fewer "
            "agents or a larger world"
        )


def estimate_pairs(spec: CompleteSpec, ticks: int) -> float:
    """How much work a run of so many ticks is, in pairs. Raises InputError."""
    return spec.count * (ALONE + mean_neighbours(spec)) * ticks


def mean_neighbours(spec: CompleteSpec) -> float:
    """How many others an agent looks at in a tick, of a flock spread evenly. Raises InputError.

    They are those in the 3^dim cells around it, which are as wide as its reach; where the nearest k
    are its neighbours, cells are so wide that each holds k + 1.
    """
    model = MODELS[spec.model]
    parameters = checked(model.parameters, spec.parameters)
    world = world_of(spec, model)
    agents, nearest = spec.count, model.nearest(parameters)
    around = (
        (nearest + 1) * 3.0**world.dim
        if nearest
        else agents * math.prod(min(1.0, 3.0 * look_radius(spec) / side) for side in world.size)
    )
    return min(float(agents), around)


def look_radius(spec: CompleteSpec) -> float:
    """How far the agents of a run look, length: those of the kind that looks furthest."""
    model, table = MODELS[spec.model], kind_table(spec.kinds, spec.to)
    shared = checked(model.parameters, spec.parameters)
    radii = [table.radius, float(getattr(shared, model.rule.reach))]
    for kind in table.kinds:
        own = MODELS[kind.model or spec.model]
        numbers = split_individuals(kind.parameters)[0]
        given = numbers if kind.model else shared.model_dump() | numbers
        radii.append(float(getattr(checked(own.parameters, given), own.rule.reach)))
    return max(radii)


def world_of(spec: CompleteSpec, model: Model) -> World:
    """The world of a run. Raises InputError."""
    return find_world(complete_spec(spec, model), model)
