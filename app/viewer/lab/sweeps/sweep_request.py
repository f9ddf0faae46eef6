"""A sweep as the page asks for it: over one parameter or two of the running flock, as a file."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Protocol

import numpy as np
import tomlkit

from agents.catalogue import FILES, MODELS
from agents.kinds import kind_table
from agents.models.declare import NumberParameter
from agents.observables.catalogue import OBSERVABLES
from agents.policies import known_policy
from agents.spec import CompleteSpec, Spec
from app.studies.run_axes import (
    AGENTS,
    MEAN,
    SPREAD,
    AxisModels,
    RunAxis,
    allowed_span,
    axis_parameter,
    is_whole_axis,
    read_axis,
    spec_with,
    value_of,
)
from app.studies.workers.process_executor import cores
from app.viewer.panels.dials import plain_symbol
from app.viewer.panels.parameters import parameter_label
from worlds.input_error import InputError, unknown
from worlds.world import World

# How much a browser may have this machine do by a sweep, in numbers and in words.

MOST_VALUES = 50
"""Of an axis."""
MOST_CELLS, MOST_RUNS_OF_CELL, MOST_RUNS = 400, 100, 5_000
MOST_AGENTS, MOST_TICKS = 3_000, 20_000
"""Of a run."""
MOST_STEPS = 10**10
"""Agents times ticks times runs."""
MOST_BEGUN = 100
"""Sweeps that a laboratory begins."""
MOST_WORKERS = 4
NICE = 10
"""How far the processes of a sweep give way to the laboratory's own."""


def workers() -> int:
    """Processes of a sweep: a core is left to the laboratory, where there are several."""
    return max(1, min(MOST_WORKERS, cores() - 1))


def describe_limits() -> str:
    """What may be begun, for people."""
    one = workers() == 1
    processes = "1 process that gives" if one else f"{workers()} processes that give"
    return (
        f"From the page at most {MOST_CELLS} cells, {MOST_RUNS:,} runs, {MOST_AGENTS:,} agents, "
        f"{MOST_TICKS:,} ticks and 10 billion steps of an agent; one sweep at a time, in "
        f"{processes} way to the laboratory. "
        "More: <code>flockscope sweep run FILE.toml</code>"
    )


def demand(cells: int, each: int, agents: int, ticks: int) -> None:
    """Refuse what is more than a browser may begin: `each` runs of each cell. Raises InputError."""
    for name, value, most in (
        ("cells", cells, MOST_CELLS),
        ("runs of a cell", each, MOST_RUNS_OF_CELL),
        ("runs", cells * each, MOST_RUNS),
        ("agents", agents, MOST_AGENTS),
        ("ticks", ticks, MOST_TICKS),
        ("steps of an agent", cells * each * agents * ticks, MOST_STEPS),
    ):
        if value > most:
            raise InputError(
                f"{value:,} {name} are not allowed from the page: {most:,} at most; "
                "`flockscope sweep run FILE.toml` takes more"
            )


WORLD = "world.toml"
"""The file of a world that is none of the built-in ones, beside the sweep's."""


@dataclass(frozen=True)
class Axis:
    """So many values of a parameter, or numbers of agents, from one to another."""

    name: str
    low: float
    high: float
    count: int
    log: bool = False

    def values(self, model: str) -> list[Any]:
        """Each once, rising or falling, round to two figures of their distance.

        `model`: of the agents that the axis is about. Raises InputError.

        >>> Axis("eta", 1.0, 5.0, 7).values("vem")
        [1.0, 1.67, 2.33, 3.0, 3.67, 4.33, 5.0]
        """
        low, high = allowed(model, self.name)
        if not 2 <= self.count <= MOST_VALUES:
            raise InputError(
                f"{self.count} values of {self.name} are not allowed: 2 to {MOST_VALUES} are"
            )
        for end in (self.low, self.high):
            if not low <= end <= high:
                raise InputError(f"{self.name} = {end:g} is not in [{low:g}, {high:g}]")
        if self.low == self.high:
            raise InputError(f"{self.name} is swept from {self.low:g} to itself: a range is needed")
        if self.log and min(self.low, self.high) <= 0.0:
            raise InputError(f"{self.name} is swept by logarithms from 0: begin above it")
        between = np.geomspace if self.log else np.linspace
        made = between(self.low, self.high, self.count).tolist()
        if is_whole_axis(model, self.name):
            return list(dict.fromkeys(round(one) for one in made))
        inner = [
            round(one, 1 - math.floor(math.log10(abs(following - one))))
            for one, following in pairwise(made[1:])
        ]
        return [self.low, *inner, self.high]


class SweepSource(Protocol):
    """What a sweep is begun from: its file, a world beside it, and what its folder is called."""

    @property
    def name(self) -> str: ...
    def to_toml(self) -> str: ...
    def world(self) -> str: ...


@dataclass(frozen=True)
class SweepRequest:
    """A sweep around a run: `spec` with its parameters, as they are now."""

    spec: CompleteSpec
    axes: Sequence[Axis]
    observable: str
    runs: int
    ticks: int
    over: int = 0
    """The mean of so many last ticks; 0: the value at the end."""

    def values(self) -> dict[str, Any]:
        """What a file says of it, world.toml beside it. Raises InputError."""
        grid = self.grid()
        run = run_table(self.spec, self.ticks, grid)
        observe = {"name": self.observable} | ({"over": self.over} if self.over else {})
        return {
            "title": f"{MODELS[self.spec.model].title}: {', '.join(grid)}",
            "run": run,
            "design": [{"kind": "grid", "axes": grid}],
            "replicates": {"count": self.runs},
            "observe": [observe],
        }

    def to_toml(self) -> str:
        """The file. Raises InputError."""
        return tomlkit.dumps(self.values())

    def world(self) -> str:
        """What stands in world.toml; nothing where the world is a built-in one."""
        world = self.spec.world
        return world.to_toml() if isinstance(world, World) else ""

    def grid(self) -> dict[str, list[Any]]:
        """The axes with their values, all that is asked for within bounds. Raises InputError."""
        demand_sweepable(self.spec)
        grid: dict[str, list[Any]] = {}
        models = AxisModels.of_run(self.spec)
        for axis in self.axes:
            if axis.name in grid:
                raise InputError(f"{axis.name} cannot be both axes of a map")
            if axis.name in self.spec.individuals:
                raise InputError(
                    f"{axis.name} = {self.spec.individuals[axis.name]} differs from agent to agent "
                    f"and is an axis: sweep {axis.name}.{MEAN} and {axis.name}.{SPREAD}"
                )
            grid[axis.name] = axis.values(models.of_axis(axis.name))
        one = OBSERVABLES.get(self.observable)
        if one is None or one.is_table:
            raise unknown("observable", self.observable, OBSERVABLES)
        if one.over is not None and self.over < 2:
            raise InputError(
                f"{self.observable} is measured over a run: take it over 2 or more of its last "
                "ticks"
            )
        if not 0 <= self.over <= self.ticks:
            raise InputError(f"the last {self.over} ticks are more than the {self.ticks} of a run")
        for name, value in (("runs", self.runs), ("ticks", self.ticks)):
            if value < 1:
                raise InputError(f"{value} {name} are not allowed: 1 at least")
        for end in (0, -1):
            spec_with(self.spec, {name: values[end] for name, values in grid.items()})
        cells = int(np.prod([len(values) for values in grid.values()]))
        demand(cells, self.runs, most_agents(self.spec, grid), self.ticks)
        return grid

    @property
    def name(self) -> str:
        """What its folder is called, if there is none of that name yet."""
        return "-".join([self.spec.model, *(axis.name for axis in self.axes)])


def most_agents(spec: CompleteSpec, grid: Mapping[str, Sequence[Any]]) -> int:
    """The most agents that a run of a grid has, those of all kinds among them."""
    kinds = (max(grid.get(f"{one.name}.{AGENTS}", [one.agents])) for one in spec.kinds)
    return int(max(grid.get(AGENTS, [spec.agents])) + spec.informed + sum(kinds))


def demand_sweepable(spec: CompleteSpec) -> None:
    """Refuse a run that the process of a sweep cannot make: it knows no model and no policy of a
    file, and begins from random places. Raises InputError."""
    for name in spec.models:
        if name in FILES:
            raise InputError(
                f"{name} is a model of a file: its sweeps are begun on the command line,"
                " flockscope sweep run FILE.toml"
            )
    for kind in spec.kinds:
        if kind.policy:
            known_policy(kind.policy)
            raise InputError(
                f"{kind.policy} is a policy of a file: its sweeps are begun on the command line,"
                " flockscope sweep run FILE.toml --rule FILE.py"
            )
    if spec.start != "random":
        raise InputError("this run began from given places: a sweep begins from random ones")


def run_table(spec: CompleteSpec, ticks: int, axes: Collection[str]) -> dict[str, Any]:
    """A run as the table [run] of a file, without what `axes` set. Raises InputError.

    A world that is none of the built-in ones is in WORLD.
    """
    demand_sweepable(spec)
    run: dict[str, Any] = {"model": spec.model, "ticks": ticks} | spec.chosen
    for name in ("agents", "size", "dim"):
        if (value := getattr(spec, name)) is not None and name not in axes:
            run[name] = list(value) if isinstance(value, tuple) else value
    world = spec.world
    run["world"] = WORLD if isinstance(world, World) else world
    if isinstance(world, World):
        run.pop("size", None)
        run.pop("dim", None)
    individuals = {name: d.to_value() for name, d in spec.individuals.items()}
    own = spec.parameters | individuals
    run["parameters"] = {name: value for name, value in own.items() if name not in axes}
    if spec.kinds:
        run["kinds"] = [kind.to_value() for kind in spec.kinds]
        run["to"] = {other: relation.to_value() for other, relation in spec.to.items()}
    return run


# What an axis of a run may be, and what is proposed of it.


def allowed(model: str, name: str) -> tuple[float, float]:
    """The range of an axis. Raises InputError for what is none."""
    return allowed_span(model, name, MOST_AGENTS)


def proposed_span(spec: Spec, axis: RunAxis, reach: float) -> tuple[float, float]:
    """The part of an axis where something is to be seen; `reach`: of the rule, length."""
    model = AxisModels.of_run(spec).of_axis(axis.name)
    low, high = allowed(model, axis.name)
    found = axis_parameter(model, axis.name)
    if axis.item == AGENTS and not axis.kind:
        agents = MODELS[spec.model].agents
        first, last = max(1.0, agents / 4), 2.0 * agents
    elif axis.item == AGENTS:
        first, last = 0.0, max(4.0, 2.0 * value_of(spec, axis.name))
    elif axis.other:
        first, last = proposed_of_relation(spec, axis, reach)
    elif found is None or axis.moment == SPREAD:
        first, last = 0.0, 2.0 * value_of(spec, axis.name) or 0.25 * high
    else:
        first, last = parameter_span(found)
    return max(low, first), min(high, last)


def proposed_of_relation(spec: Spec, axis: RunAxis, reach: float) -> tuple[float, float]:
    """The same of a number of a relation, which may say nothing of how far it goes."""
    relation = kind_table(spec.kinds, spec.to).of(axis.kind, axis.other)
    radius = relation.radius or reach
    if axis.item == "radius":
        return radius / 4, 2.0 * radius
    now = float(getattr(relation, axis.item) or 0.0)
    return 0.0, 2.0 * now or (0.25 * radius if axis.item == "catch" else 2.0)


def parameter_span(parameter: NumberParameter) -> tuple[float, float]:
    """What a slider of a number spans, and what is allowed where that is nothing."""
    low, high = parameter.proposed
    return (low, high) if low < high else parameter.bounds


def axis_title(model: str, name: str, words: str = "") -> str:
    """An axis as the page calls it; a name of a user's own as it is.

    `words`: what the parameter is called; by default as its slider is.

    >>> axis_title("vem", "shark.agents"), axis_title("vem", "shark.flock.radius")
    ('shark: agents', 'shark to flock: radius, length')
    """
    axis, found = read_axis(name, model), axis_parameter(model, name)
    if axis.other:
        unit = ", length" if axis.item in ("radius", "catch") else ""
        return f"{axis.kind} to {axis.other}: {axis.item}{unit}"
    if found is None and axis.item != AGENTS:
        return name
    title = words or ("Agents" if found is None else parameter_label(found)[0])
    title = f"{axis.moment.capitalize()} of {lowered(title)}" if axis.moment else title
    return f"{axis.kind}: {lowered(title)}" if axis.kind else title


RELATION_SYMBOLS = {"weight": "w", "radius": "R", "power": "p", "catch": "c"}


def axis_symbol(model: str, name: str) -> str:
    """The symbol of an axis, as text; empty for a name of a user's own.

    >>> axis_symbol("vem", "shark.v0"), axis_symbol("vem", "shark.agents")
    ('v₀', 'N')
    """
    axis, found = read_axis(name, model), axis_parameter(model, name)
    if found is not None:
        return plain_symbol(found.symbol)
    return RELATION_SYMBOLS[axis.item] if axis.other else "N" if axis.item == AGENTS else ""


def lowered(title: str) -> str:
    """A title within a line."""
    return title[:1].lower() + title[1:]
