"""A flock frozen at a tick: what observables, the inspector, recordings and pictures take."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np

from agents.engine.arrays import Arrays
from agents.engine.heeding import OWN
from agents.individuals import Distribution, each
from agents.kind_models import KindModel, evaluate_parameters, kind_models, own_columns
from agents.kinds import INFORMED, NO_KINDS, Kind, KindTable
from agents.models.declare import Parameters
from agents.models.model import Model
from agents.observables.array_checks import finite_rows, is_finite, warn_of_omitted
from agents.observables.neighbours import (
    groups_within,
    layers,
    links,
    nearest_links,
    separation,
)
from agents.state.agent_rows import Crashes, active, crashes, select_rows
from agents.state.passages import Passages
from worlds.input_error import InputError, unknown
from worlds.mission import SourceRegion, along_route
from worlds.world import World

NOBODY = Passages.none(2)
"""The passages of a flock through which nobody comes or goes."""
ALIKE: Mapping[str, Distribution] = MappingProxyType({})
"""The parameters that differ in a flock whose agents are alike."""


class FlockState:
    """What follows from a model, its parameters, a world and the agents' arrays at one tick.

    A flock has it as it is now, a `Snapshot` as it was.

    Attributes
    ----------
    position, heading: (N, dim) float64, length and unit vectors. speed: (N,), length/tick.
    informed: (N,) bool, information agents. ids: (N,) int, identities, which no row ever shares.
    tick: int, ticks done. seed: int. parameters: those of the rule and the body.
    """

    model: Model
    world: World
    parameters: Parameters
    arrays: Arrays
    tick: int
    seed: int
    next_id: int
    """The identity that the next agent will have."""
    seen: np.ndarray | None = None
    """Of tracks that are played: which individuals are seen at this tick, (N,) bool. None: all."""
    hollow: np.ndarray | None = None
    """Of these: who is in a gap between two times that it is seen, (N,) bool; it has its last
    place."""
    usual: int = 0
    """Of these: how many are seen at a time as a rule."""
    apart: float = math.inf
    """Of these: the median distance to the nearest other, length."""
    paired: np.ndarray | None = None
    """The places (N, dim) of the agents of another flock, with which these are compared one by one;
    NaN for those that are not. None: there is no such flock."""
    entries: Passages = NOBODY
    """Who has entered so far, at which tick, where and through which source of the mission."""
    exits: Passages = NOBODY
    """Who has left so far, at which tick, where and through which exit of the mission."""
    individuals: Mapping[str, Distribution] = ALIKE
    """The parameters that differ from agent to agent, and what they were drawn from."""
    kinds: KindTable = NO_KINDS
    """The kinds of agents beside the ordinary ones, and whom each heeds."""
    catches: Passages = NOBODY
    """Who was caught so far: when, its identity, that of the catcher (`gate`), and where."""
    viewed_kind: int = 0
    """The number of the kind whose own model `model`, `parameters` and `own` are of, as if all went
    by it: see `Snapshot.by_kind_model`. 0: they are the flock's."""

    @property
    def kind_models(self) -> tuple[KindModel, ...]:
        """The models that kinds have of their own; none where all are taken to go by `model`."""
        return () if self.viewed_kind else kind_models(self.kinds)

    @property
    def own_columns(self) -> tuple[str, ...]:
        """The parameters that the columns of `arrays.own` hold, where agents differ."""
        return own_columns(self.model, self.kind_models)

    @property
    def parameter_names(self) -> set[str]:
        """Those of all models that its agents go by."""
        models = (self.model, *(one.model for one in self.kind_models))
        return {name for model in models for name in model.parameters.model_fields}

    @property
    def goes_by_model(self) -> np.ndarray:
        """Which agents go by `model`, and not by one that their kind has of its own, (N,) bool."""
        if not self.kinds.with_model:
            return np.ones(len(self.arrays.ids), bool)
        if self.viewed_kind:
            return self.arrays.kind == self.viewed_kind
        return ~np.isin(self.arrays.kind, list(self.kinds.with_model))

    def kind_model_of(self, row: int) -> KindModel | None:
        """The own model of the kind of a row's agent; None where it goes by `model`."""
        models = self.kind_models
        if not models:
            return None
        number = int(self.arrays.kind[row])
        return next((one for one in models if one.number == number), None)

    @property
    def kind_numbers(self) -> np.ndarray:
        """The number of each agent's kind, int (N,): of the ordinary ones 0, then in the order of
        `kinds`; -1 of who was caught and stands still."""
        if not self.kinds.kinds:
            return np.zeros(len(self.ids), int)
        return self.arrays.kind.astype(int)

    @property
    def kind_names(self) -> np.ndarray:
        """The name of each agent's kind, str (N,); `caught` of who was caught and stands still."""
        names = np.array([*self.kinds.names, "caught"])
        if not self.kinds.kinds:
            return np.full(len(self.ids), names[0])
        name: np.ndarray = names[self.kind_numbers]
        return name

    @property
    def differing(self) -> tuple[str, ...]:
        """The parameters that differ from agent to agent, or from kind to kind."""
        if self.viewed_kind:
            return self.model.individual
        of_kinds = [name for one in self.kinds.kinds if not one.model for name in one.parameters]
        of_kinds += [name for one in self.kind_models for name in one.model.individual]
        return tuple(dict.fromkeys([*self.individuals, *of_kinds]))

    def rows_of(self, kind: str) -> np.ndarray:
        """The rows of the agents of a kind, int (M,), without those that were caught and stand
        still; of `informed` those of the information agents. Raises InputError for a kind that
        there is not."""
        names = self.kinds.names
        if kind == INFORMED and INFORMED not in names:
            is_met = self.arrays.kind >= 0.0 if len(self.arrays.kind) else True
            return np.flatnonzero(self.informed & is_met)
        number = self.kinds.number(kind, more=(INFORMED,))
        if not self.kinds.kinds:
            return np.arange(len(self.ids))
        return np.flatnonzero(self.arrays.kind == number)

    @property
    def own(self) -> dict[str, np.ndarray]:
        """The parameters that differ, by name: the number of each agent, (N,), to be read.

        It is nan where the agent's kind has a model of its own without that parameter.

        `Flock.set` and the attributes of members change them.
        """
        columns, names = {}, self.own_columns
        for name in self.differing:
            column = self.arrays.own[:, names.index(name)].view()
            column.flags.writeable = False
            columns[name] = column
        return columns

    def heeds(self, rows: np.ndarray, others: np.ndarray) -> np.ndarray:
        """Whether the agents of rows (M,) take those of other rows as neighbours, bool (M,)."""
        if not self.kinds.kinds:
            return np.ones(np.broadcast(rows, others).shape, bool)
        own = self.kinds.to_array(0.0)[:, :, OWN] > 0.0
        kind = self.arrays.kind.astype(int)
        is_met = (kind[rows] >= 0) & (kind[others] >= 0)
        is_heeded: np.ndarray = own[kind[rows], kind[others]] & is_met
        return is_heeded

    @property
    def all_parameters(self) -> dict[str, Any]:
        """The parameters by name: a number of those that all agents share, of those that differ
        what they were drawn from; a run that is given these has the same."""
        own = self.own
        return self.parameters.model_dump() | {
            name: self._numbers_by_hand(own[name], getattr(self.parameters, name))
            if one.is_by_hand
            else one
            for name, one in self.individuals.items()
            if len(self.ids) or not one.is_by_hand
        }

    @staticmethod
    def _numbers_by_hand(numbers: np.ndarray, shared: float) -> Distribution:
        """Each agent's number; of those whose model has not this parameter the shared one."""
        return each(np.where(np.isnan(numbers), shared, numbers))

    @property
    def all_kinds(self) -> tuple[Kind, ...]:
        """The kinds with the numbers of their agents, where these were set one by one."""
        if not self.kind_models:
            return self.kinds.kinds
        own, kinds = self.own, list(self.kinds.kinds)
        for one in self.kind_models:
            numbers = {
                name: each(own[name][self.arrays.kind == one.number])
                for name, value in one.kind.parameters.items()
                if isinstance(value, Distribution) and value.is_by_hand
                if (self.arrays.kind == one.number).any()
            }
            if numbers:
                kinds[one.number - 1] = one.kind.with_parameters(numbers)
        return tuple(kinds)

    def parameters_of(self, row: int) -> Parameters:
        """The parameters of the agent of a row, of its kind's own model where it has one."""
        if not self.differing:
            return self.parameters
        one = self.kind_model_of(row)
        names = (self.model if one is None else one.model).individual
        own = {name: float(column[row]) for name, column in self.own.items() if name in names}
        parameters = self.parameters if one is None else one.parameters
        # Of who was caught and stands still nobody knows its kind, so it may lack some.
        return parameters.model_copy(
            update={name: number for name, number in own.items() if not math.isnan(number)}
        )

    def _evaluate(
        self, function: Callable[[Any], Any], table: np.ndarray | None = None
    ) -> np.ndarray:
        """What a function of the parameters gives for each agent, (N,).

        `table`: the agents' own parameters, by default as they are now. Who does not go by `model`
        is counted as if it did.
        """
        table = self.arrays.own if table is None else table
        names, differing = self.own_columns, set(self.differing)
        columns = {name: table[:, names.index(name)] for name in differing if table.shape[1]}
        return evaluate_parameters(function, self.model, self.parameters, columns, len(table))

    def _largest(self, name: str) -> float:
        """The largest number of a parameter, or of a property of parameters, among those who go by
        `model`."""
        shared = float(getattr(self.parameters, name))
        if not self.differing:
            return shared
        rows = self.goes_by_model
        if name in self.differing:
            return float(self.own[name][rows].max()) if rows.any() else shared
        computed = getattr(type(self.parameters), name, None)
        if not isinstance(computed, property) or computed.fget is None or not rows.any():
            return shared
        return float(self._evaluate(computed.fget)[rows].max())

    @property
    def has_turnover(self) -> bool:
        """Whether agents may come or go while it runs: by sources and exits, or as they are caught
        and taken."""
        takes = (relation.caught == "taken" for _, _, relation in self.kinds.catchers)
        return self.world.has_gates or any(takes)

    @property
    def _entered(self) -> list[tuple[SourceRegion, int]]:
        """The sources of the mission, and how many have entered through each."""
        sources = () if self.world.mission is None else self.world.mission.sources
        return list(zip(sources, self.entries.counts(len(sources)).tolist(), strict=True))

    @property
    def waiting(self) -> int:
        """Agents that are due at a source and have found no free place in it yet."""
        return sum(max(0, source.due(self.elapsed) - number) for source, number in self._entered)

    @property
    def has_ended(self) -> bool:
        """Whether the flock is empty for good: nobody is left, and no source has more to come."""
        is_empty = not len(self.arrays.ids)
        return is_empty and all(math.isinf(one.next_due(number)) for one, number in self._entered)

    @property
    def position(self) -> np.ndarray:
        """(N, dim), length."""
        return self.arrays.position

    @property
    def heading(self) -> np.ndarray:
        """(N, dim), unit vectors."""
        return self.arrays.heading

    @property
    def speed(self) -> np.ndarray:
        """(N,), length/tick."""
        return self.arrays.speed

    @property
    def informed(self) -> np.ndarray:
        """(N,) bool: information agents."""
        return self.arrays.informed

    @property
    def ids(self) -> np.ndarray:
        """(N,) int: identities."""
        return self.arrays.ids

    @property
    def dt(self) -> float:
        """The time that a tick stands for, in the model's unit of time."""
        return float(self.model.body.lasts(self.parameters))

    @property
    def elapsed(self) -> float:
        """Time since the start, tick * dt."""
        return self.tick * self.dt

    @property
    def reach(self) -> float:
        """The largest distance at which agents notice each other, length."""
        others = (self._by_kind_model(one).reach for one in self.kind_models)
        return max(self.reach_of_model, *others, self.kinds.radius)

    @property
    def reach_of_model(self) -> float:
        """The largest distance at which those notice others who go by `model`, length."""
        return max(self._largest(self.model.rule.reach), self.kinds.radius)

    @property
    def reaches(self) -> np.ndarray:
        """How far each agent notices others, (N,), length."""
        reaches = self._reaches_by_model()
        for one in self.kind_models:
            rows = self.arrays.kind == one.number
            reaches[rows] = self._by_kind_model(one)._reaches_by_model()[rows]
        return reaches

    def _reaches_by_model(self) -> np.ndarray:
        """How far each would notice others that goes by `model`, (N,), length."""
        name = self.model.rule.reach
        if name in self.differing:
            return self.own[name].copy()
        computed = getattr(type(self.parameters), name, None)
        if not isinstance(computed, property) or computed.fget is None:
            return np.full(len(self.ids), self._largest(name))
        return self._evaluate(computed.fget)

    def _by_kind_model(self, one: KindModel) -> Snapshot:
        """The flock as if all its agents went by the model of a kind, with the kind's parameters.

        Agents of other kinds have what those of this kind share; who stands where stays.
        """
        names, columns = one.model.individual, self.own_columns
        own = self.arrays.own[:, [columns.index(name) for name in names]]
        own[self.arrays.kind != one.number] = [getattr(one.parameters, name) for name in names]
        return Snapshot(
            one.model,
            self.world,
            one.parameters,
            self.seed,
            self.tick,
            self.arrays._replace(own=np.ascontiguousarray(own)),
            self.next_id,
            entries=self.entries,
            exits=self.exits,
            kinds=self.kinds,
            catches=self.catches,
            viewed_kind=one.number,
        )

    @property
    def nearest(self) -> int:
        """How many nearest agents are an agent's neighbours; 0 where all within reach are."""
        return self.model.nearest(self.parameters)

    @property
    def together(self) -> float:
        """The distance within which agents are of one group, length."""
        return self._largest(self.model.rule.together or self.model.rule.reach)

    @property
    def sight(self) -> float:
        """The largest distance at which agents notice obstacles, length."""
        return self._largest(self.model.body.sight or self.model.rule.reach)

    @property
    def reference(self) -> np.ndarray | None:
        """The heading that the flock is meant to take, (dim,); None for the mean of the flock."""
        if not self.model.rule.converges or not self.informed.any():
            return None
        return self.heading[np.argmax(self.informed)]

    def goal_at(self, ticks) -> np.ndarray:
        """Positions of the gamma agent at ticks (T,), (T, dim), length. Raises InputError."""
        mission = self.world.mission
        if mission is None or mission.goal is None:
            raise InputError(f"the world {self.world.name!r} has no goal")
        return along_route(mission.goal, np.asarray(ticks) * self.dt)

    @property
    def can_crash(self) -> bool:
        """Whether agents that touch something crash."""
        return self.model.body.touches is not None

    @property
    def active(self) -> np.ndarray:
        """Which agents have not crashed and were not caught, (N,) bool."""
        is_active = active(self.arrays)
        return is_active & (self.arrays.kind >= 0.0) if len(self.arrays.kind) else is_active

    @property
    def crashes(self) -> Crashes:
        """Who has crashed so far: when, where and against what."""
        return crashes(self.arrays)


@dataclass(frozen=True, eq=False)
class Snapshot(FlockState):
    """A flock at one tick, or some of its agents; links, groups and layers are found once.

    `Flock.snapshot` takes it. Nobody writes to its arrays any more.
    """

    model: Model
    world: World
    parameters: Parameters
    seed: int
    tick: int
    arrays: Arrays
    next_id: int
    """The identity that the next agent will have."""
    with_signals: bool = False
    """Whether it holds what agents tell each other at this tick, and not at the one before."""
    whole: Snapshot | None = None
    """The snapshot of which these are some of the agents."""
    entries: Passages = NOBODY
    exits: Passages = NOBODY
    individuals: Mapping[str, Distribution] = field(default_factory=dict)
    kinds: KindTable = NO_KINDS
    catches: Passages = NOBODY
    viewed_kind: int = 0

    @property
    def crashes(self) -> Crashes:
        """Who had crashed: when, where and against what; of the whole flock."""
        return crashes((self.whole or self).arrays)

    def links(self) -> np.ndarray:
        """Pairs of rows (i < j) within reach of each other, int (M, 2).

        Where the nearest are neighbours, or agents differ in how far they notice each other, pairs
        of which one at least is the other's neighbour.
        """
        return self._links

    def group_labels(self) -> np.ndarray:
        """The connected group within `together` of each agent, int (N,), 0 the largest."""
        return self._group_labels

    def layers(self) -> np.ndarray:
        """Hops from an information agent plus 1, int (N,); N + 1 unknown."""
        return self._layers

    @cached_property
    def _links(self) -> np.ndarray:
        if self.nearest:
            return nearest_links(self.position, self.nearest, self.world.size, self.world.images)
        own = self.reaches if self.kind_models else self.own.get(self.model.rule.reach)
        reach = self._largest(self.model.rule.reach)
        if self.kind_models:
            reach = float(self.reaches.max(initial=0.0))
        pairs = links(self.position, reach, self.world.size, self.world.images)
        if self.kinds.kinds:
            i, j = pairs.T
            pairs = pairs[self.heeds(i, j) | self.heeds(j, i)]
        if own is None:
            return pairs
        i, j = pairs.T
        away = separation(self.position[i], self.position[j], self.world.size, self.world.images)
        hears = np.linalg.norm(away, axis=1) <= np.maximum(own[i], own[j])
        return pairs[hears]

    @cached_property
    def _group_labels(self) -> np.ndarray:
        return groups_within(self.position, self.together, self.world.size, self.world.images)

    @cached_property
    def _layers(self) -> np.ndarray:
        return layers(self._links, self.informed)

    def signal(self, name: str) -> np.ndarray:
        """A signal, memory or measure of the agents, one of `model.columns`: a copy (N,).

        A layer of N + 1 is unknown. Raises InputError for a name that is none, and for what agents
        tell each other in a snapshot that was taken without.
        """
        model = self.model
        if name not in model.columns:
            raise unknown("signal", name, model.columns)
        if name in model.signals and not self.with_signals:
            raise InputError(f"{name} is not in this snapshot: take it with signals=True")
        values = self.arrays.memory[model.columns.index(name)]
        return np.where(np.isinf(values), len(values) + 1.0, values)

    def of(self, rows: np.ndarray) -> Snapshot:
        """The agents of some rows, as if there were no others."""
        return replace(self, arrays=select_rows(self.arrays, rows), whole=self.whole or self)

    def by_model_of(self, row: int) -> Snapshot:
        """The flock as if all went by the model of a row's agent: itself, or by that of its kind.

        So what asks a flock for its model and its parameters asks for this agent's.
        """
        one = self.kind_model_of(row)
        if one is None:
            return self
        return replace(self._by_kind_model(one), with_signals=self.with_signals)

    def of_kind(self, kind: str) -> Snapshot:
        """The agents of a kind, as if there were no others, with the model that they go by. Raises
        InputError."""
        rows = self.rows_of(kind)
        models = {one.kind.name: one for one in self.kind_models}
        return (self._by_kind_model(models[kind]) if kind in models else self).of(rows)

    def measurable(self) -> Snapshot:
        """The agents that observables see: those that have not crashed.

        Agents whose position, heading or speed is no number are left out too, and a warning says
        how many (`agents.observables.array_checks.OmittedRowsWarning`).
        """
        arrays = self.position, self.heading, self.speed
        is_sound = all(map(is_finite, arrays))
        if is_sound and not self.can_crash and not self.kinds.kinds:
            return self
        is_active = self.active
        if not is_sound:
            is_finite_row = finite_rows(*arrays)
            warn_of_omitted(int((is_active & ~is_finite_row).sum()), int(is_active.sum()), "agents")
            is_active = is_active & is_finite_row
        return self if is_active.all() else self.of(np.flatnonzero(is_active))
