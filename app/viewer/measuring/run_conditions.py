"""The conditions of a run: as it began, and from which tick on they were others."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from agents.flock import Flock
from agents.flock_world import complete_spec
from agents.kinds import ALIASES, ALL, NO_KINDS, KindTable, Relation
from agents.models.model import Model
from agents.spec import CompleteSpec, Spec
from app.viewer.measuring.observable_format import format_short
from worlds.world import World

TOLD = 3
"""Differences between two runs that are told; of more, that there are others."""
MOST = 1000
"""Stretches of one run that are kept. Of more, the two shortest neighbours become one."""
SEVERAL = None
"""The value of a parameter in a stretch that was two of different values."""
BY_HAND = "moved by hand"

Steps = tuple[tuple[int, Any], ...]
"""The values that one thing had in a run, each with the tick from which on it had it."""


@dataclass(frozen=True)
class RunConditions:
    """What a run is made of: all by which it may differ from another one of its model."""

    model: Model
    seed: int
    agents: int
    world: World
    options: Mapping[str, Any]
    parameters: Mapping[str, Any]
    """Distributions where agents differ."""
    dt: float
    """Time that a tick stands for."""
    asked: CompleteSpec = field(compare=False)
    """The run as it was asked for; its parameters and its world may be others by now."""
    by_hand: bool = False
    """Whether somebody has put agents elsewhere."""
    kinds: KindTable = NO_KINDS
    """The kinds of agents, with their parameters and relations."""
    clock_unit: str = ""
    """The unit of `dt` where that is not the model's own: a model beside tracks goes by theirs."""

    @classmethod
    def of(cls, flock: Flock, by_hand: bool = False) -> RunConditions:
        """Those of a flock, with its parameters as they are now."""
        dt, unit = getattr(flock, "clock", (flock.dt, ""))
        options, agents = flock.options, len(flock.ids)
        if flock.kinds.kinds:  # who is caught changes nothing in what a run is made of
            agents = options.agents + options.informed
        return cls(
            flock.model,
            flock.seed,
            agents,
            flock.world,
            flock.options.chosen,
            flock.all_parameters,
            dt,
            flock.options,
            by_hand,
            flock.kinds,
            unit,
        )

    @property
    def unit(self) -> str:
        """That of its time: ticks, or s."""
        return self.clock_unit or self.model.body.unit

    @property
    def values(self) -> dict[str, Any]:
        """Everything by its name; options and parameters share no names."""
        values = {"seed": self.seed, "world": self.world, "agents": self.agents}
        kinds = kind_values(self.kinds)
        return {**values, **self.options, **self.parameters, **kinds, BY_HAND: self.by_hand}

    def join(self, later: RunConditions) -> RunConditions:
        """Those of a stretch that had these first and then others: what differs is SEVERAL."""
        parameters = {
            name: value if self.parameters.get(name) == value else SEVERAL
            for name, value in later.parameters.items()
        }
        return replace(later, parameters=parameters, asked=self.asked)


def kind_values(kinds: KindTable) -> dict[str, Any]:
    """All by which kinds may differ, by names that tell them from options and parameters.

    >>> from agents.kinds import Kind, chase, kind_table
    >>> kind_values(kind_table((Kind("shark", 2, v0=0.05, to={"flock": chase(2.0, 5.0)}),), {}))
    {'agents of shark': 2, 'v0 of shark': 0.05, 'shark to flock': 'chase 2, radius 5'}
    """
    values: dict[str, Any] = {}
    for kind in kinds.kinds:
        values[f"agents of {kind.name}"] = kind.agents
        if kind.model:
            values[f"model of {kind.name}"] = kind.model
        values |= {f"{name} of {kind.name}": value for name, value in kind.parameters.items()}
        if kind.start is not None:
            values[f"start of {kind.name}"] = f"{kind.start[0]} to {kind.start[1]}"
    told = {(kinds.names[0], ALIASES.get(other, other)) for other in kinds.to}
    told |= {(one.name, ALIASES.get(other, other)) for one in kinds.kinds for other in one.to}
    for (name, other), relation in kinds.relations.items():
        if {(name, other), (name, ALL)} & told:
            values[f"{name} to {other}"] = describe_relation(relation)
    return values


def lacking_kind(name: str, kinds: KindTable) -> str:
    """The kind that something of `kind_values` is of, if it is none of these; else empty.

    >>> lacking_kind("v0 of shark", NO_KINDS), lacking_kind("flock to shark", NO_KINDS)
    ('shark', 'shark')
    """
    _, of_kind, kind = name.partition(" of ")
    first, to_kind, second = name.partition(" to ")
    named = [kind] if of_kind else [first, second] if to_kind else []
    return next((one for one in named if one not in kinds.names), "")


def describe_relation(relation: Relation) -> str:
    """A relation in few words.

    >>> described = Relation("ignore"), Relation("chase", 2.0, catch=0.3)
    >>> tuple(map(describe_relation, described))
    ('ignore', 'chase 2, catch 0.3, taken')
    """
    deed, *details = relation.to_value().items()
    parts = [deed[0] if deed[1] is True else f"{deed[0]} {deed[1]:g}"]
    for name, value in details:
        if isinstance(value, bool | str):
            parts.append(name if value is True else str(value))
        else:
            parts.append(f"{name} {value:g}")
    return ", ".join(parts)


@dataclass(frozen=True)
class Stretch:
    """A part of a run that was made under one set of conditions."""

    begin: int
    """The tick at which it begins: the next one is the first that is made so."""
    conditions: RunConditions


@dataclass(frozen=True)
class ConditionHistory:
    """The conditions of a run over its ticks, a value: the first stretch, and one for each change.

    Changes at one tick are one change, and those that come to nothing are none.
    """

    stretches: tuple[Stretch, ...]

    @classmethod
    def begin(cls, flock: Flock) -> ConditionHistory:
        """That of a flock which begins now."""
        return cls((Stretch(flock.tick, RunConditions.of(flock)),))

    @property
    def first(self) -> RunConditions:
        """Those with which it began."""
        return self.stretches[0].conditions

    @property
    def last(self) -> RunConditions:
        """Those of now, or of its end."""
        return self.stretches[-1].conditions

    @property
    def marks(self) -> np.ndarray:
        """The ticks (K,) at which something was changed."""
        return np.array([stretch.begin for stretch in self.stretches[1:]], float)

    def with_change(self, tick: int, conditions: RunConditions) -> ConditionHistory:
        """The same run, whose conditions are these from a tick on, the latest so far."""
        before = [stretch for stretch in self.stretches if stretch.begin < tick]
        if before and before[-1].conditions == conditions:
            return ConditionHistory(tuple(before))
        begin = tick if before else self.stretches[0].begin
        return ConditionHistory(tuple(few_stretches([*before, Stretch(begin, conditions)])))

    def cut(self, tick: int) -> ConditionHistory:
        """The run until a tick: without what was changed after it."""
        first, *others = self.stretches
        return ConditionHistory((first, *(stretch for stretch in others if stretch.begin <= tick)))

    def at_end(self, tick: int) -> ConditionHistory:
        """That of a run whose last tick it is: nothing was made of what was changed then."""
        return self.cut(tick - 1)

    def stretch_indices(self, ticks: np.ndarray) -> np.ndarray:
        """In which stretch each of some ticks (K,) was made: their places."""
        begins = [stretch.begin for stretch in self.stretches]
        return np.maximum(np.searchsorted(begins, ticks, side="left") - 1, 0)

    @cached_property
    def steps(self) -> dict[str, Steps]:
        """The values that everything had, by its name; None for an option at its default."""
        starts = [(stretch.begin, stretch.conditions.values) for stretch in self.stretches]
        names = dict.fromkeys(name for _, values in starts for name in values)
        values_by_name: dict[str, Steps] = {}
        for name in names:
            steps = [(starts[0][0], starts[0][1].get(name))]
            for begin, values in starts[1:]:
                if values.get(name) != steps[-1][1]:
                    steps.append((begin, values.get(name)))
            values_by_name[name] = tuple(steps)
        return values_by_name

    def differences(self, other: ConditionHistory) -> str:
        """What is or was other here than in another run, in few words; nothing if nothing was."""
        mine, other_steps = self.steps, other.steps
        begin = self.stretches[0].begin
        lines = [f"from {self.format_tick(begin)} on"] if begin != other.stretches[0].begin else []
        for name in dict.fromkeys([*mine, *other_steps]):
            steps = mine.get(name, ((begin, None),))
            other_values = other_steps.get(name, ((begin, None),))
            if relative_steps(steps, self) != relative_steps(other_values, other):
                lines.append(self.describe(name, steps, other_values))
        lines = list(dict.fromkeys(lines))
        return ", ".join([*lines[:TOLD], *["…"] * (len(lines) > TOLD)])

    def changes(self) -> list[str]:
        """What was changed in this run, and when, in few words each."""
        return [self.describe(name, step) for name, step in self.steps.items() if len(step) > 1]

    def departures(self) -> list[str]:
        """All that is not as the model has it by default, and all that was changed."""
        model = self.first.model
        usual = model.parameters().model_dump() | complete_spec(Spec(model.name), model).chosen
        names = self.first.options.keys() | usual.keys() | kind_values(self.first.kinds).keys()
        return [
            self.describe(name, steps)
            for name, steps in self.steps.items()
            if len(steps) > 1
            or (name in names and steps[0][1] != usual.get(name))
            or (name == BY_HAND and steps[0][1])
        ]

    def describe(self, name: str, steps: Steps, other_steps: Steps = ()) -> str:
        """The values of one thing in few words, and where another run has other ones."""
        ((_, first), *others), last = steps, steps[-1][1]
        if last is None and (kind := lacking_kind(name, self.first.kinds)):
            return f"no {kind}"
        when = "" if not others else f" at {self.format_tick(others[0][0])}"
        if len(others) > 1:
            when = f" from {self.format_tick(others[0][0])} to {self.format_tick(others[-1][0])}"
        if name == "world":
            return describe_world(first, last, when, other_steps)
        if name == BY_HAND:
            return f"agents {BY_HAND}{when}" if last else f"no agents {BY_HAND}"
        if name == "agents" and not others:
            return f"{first} agents"
        between = " → …" * (len(others) > 1)
        later = f"{between} → {format_setting(last)}" if others else ""
        return f"{name} {format_setting(first)}{later}{when}"

    def format_tick(self, tick: int) -> str:
        """A tick in the words of the run's clock."""
        of = self.first
        return f"tick {tick}" if of.unit == "ticks" else f"{format_short(tick * of.dt)} {of.unit}"


def relative_steps(steps: Steps, of: ConditionHistory) -> Steps:
    """The same with ticks counted from the beginning of the run."""
    return tuple((tick - of.stretches[0].begin, value) for tick, value in steps)


def few_stretches(stretches: list[Stretch]) -> list[Stretch]:
    """The same, at most so many: of too many, the two that are the shortest together are one."""
    if len(stretches) > MOST:
        begins = np.array([stretch.begin for stretch in stretches])
        place = int(np.argmin(begins[2:] - begins[:-2]))
        first, second = stretches[place : place + 2]
        joined = Stretch(first.begin, first.conditions.join(second.conditions))
        stretches[place : place + 2] = [joined]
    return stretches


def describe_world(first: World, last: World, when: str, other_steps: Steps) -> str:
    """The world of a run in few words."""
    if when:
        return f"{first.name} changed{when}" if first.name == last.name else f"world changed{when}"
    same = bool(other_steps) and any(world.name == first.name for _, world in other_steps)
    return f"{first.name} as it was" if same else f"world {first.name}"


def format_setting(value: Any) -> str:
    """The value of a parameter or of an option in few letters.

    >>> tuple(map(format_setting, (0.30000000000000004, "angular", True, None)))
    ('0.3', 'angular', 'on', 'as usual')
    """
    if value is None:
        return "as usual"
    if isinstance(value, bool):
        return "on" if value else "off"
    return format_short(float(value)) if isinstance(value, int | float) else str(value)
