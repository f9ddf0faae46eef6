"""How a flock begins: where its agents are, of which kind, and with which numbers of their own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from agents.engine.arrays import Arrays
from agents.engine.noise import AT_ONCE
from agents.individuals import Distribution
from agents.motion.steered_motion import SteeredMotion
from agents.spec import CompleteSpec
from agents.state.agent_rows import start_arrays
from agents.state.start import Start, given_start, random_start, spread
from worlds.input_error import InputError


class StartTable(NamedTuple):
    """What agents have at a random start, by their identities."""

    own: np.ndarray
    """Own parameters, (N, Q)."""
    kind: np.ndarray
    """Numbers of kinds, (N,) or (0,)."""
    gap: float
    """How far from what is solid they start at least, length."""
    speed: np.ndarray | None
    """Speeds, (N,), where all follow from own parameters."""


class FlockStart(SteeredMotion):
    """What is there at tick 0, at random or as given."""

    _kept_start: StartTable | None = None
    """What does not change from seed to seed."""
    options: CompleteSpec
    """The run as it began; its size is None unless it was asked for."""

    def _own_at_start(self, ids: np.ndarray) -> np.ndarray:
        """The own parameters (N, Q) of agents with which the flock begins. Raises InputError."""
        kind = self._kind_at_start(ids)
        return self._own_of(ids, self.parameters, self.individuals, self.individuals, kind)

    def _start_table(self) -> StartTable:
        """What agents have at a random start by their identities. Raises InputError.

        Where none of it is drawn it is kept for the next seed.
        """
        if self._kept_start is not None:
            return self._kept_start
        ids = np.arange(1, self.options.count + 1)
        own, kind = self._own_at_start(ids), self._kind_at_start(ids)
        speed = None
        models = self._by_models(len(ids), kind)
        if own.shape[1] and all(model.body.speed is not None for model, *_ in models):
            nowhere, still = np.empty((len(ids), 0)), np.zeros(len(ids))
            start = Start(nowhere, nowhere, still > 0.0, still, ids - 1)
            speed = self._with_start_speeds(start, True, own, kind=kind).speed
        table = StartTable(own, kind, self._start_gap(own, kind), speed)
        if not self._distributions:
            self._kept_start = table
        return table

    @property
    def _distributions(self) -> list[Distribution]:
        """What own numbers are drawn from, of all agents and of kinds."""
        of_kinds = (value for one in self.kinds.kinds for value in one.parameters.values())
        return [*self.individuals.values(), *(d for d in of_kinds if isinstance(d, Distribution))]

    @property
    def _has_lists(self) -> bool:
        """Whether numbers are given agent by agent."""
        return any(one.kind == "each" for one in self._distributions)

    def _kind_at_start(self, ids: np.ndarray) -> np.ndarray:
        """The number of the kind of each agent with which the flock begins, (N,), or (0,).

        The agents of kinds have the last identities. Raises InputError for more than there are.
        """
        kinds = self.kinds.kinds
        if not kinds:
            return np.empty(0)
        numbers = np.repeat(np.arange(len(kinds)) + 1.0, [kind.agents for kind in kinds])
        if len(numbers) > len(ids):
            raise InputError(f"kinds have {len(numbers)} agents, and the flock has {len(ids)}")
        kind: np.ndarray = np.append(np.zeros(len(ids) - len(numbers)), numbers)[ids - 1]
        return kind

    def _random_start(self, seeds: Sequence[int]) -> Arrays:
        """The arrays of a random start, with the speeds that the body begins with; of several seeds
        the rows of one after the other, where speeds are known. Raises InputError."""
        run, table = self.options, self._start_table()
        ordinary = len(table.own) - run.informed
        begin = random_start(self.world, ordinary, run.informed, seeds, run.spacing, table.gap)
        begin = self._start_kinds_in_boxes(begin, table, seeds)
        kind = table.kind[begin.number] if len(table.kind) else table.kind
        if table is self._kept_start and table.speed is not None:
            begin = replace(begin, speed=table.speed[begin.number])
            return self._arrays_of(begin, table.own[begin.number], kind)
        # Lists are in the order of rows, whichever identities stand there.
        own = self._own_at_start(1 + begin.number) if self._has_lists else table.own[begin.number]
        with_speeds = bool(begin.speed.any())
        begin = self._with_start_speeds(begin, with_speeds, own, kind=kind)
        return self._arrays_of(begin, own, kind)

    @property
    def can_begin_in_place(self) -> bool:
        """Whether `begin_in_place` can make a start of another seed: nothing is drawn for it but
        places, headings and speeds, nobody has a past, and as many agents are there as begin."""
        return (
            self._kept_start is not None
            and self._beginning[1].random is None
            and not (self.options.is_windy or self.options.is_late)
            and not (self.world.has_gates or self.kinds.with_model)
            and len(self.arrays.ids) == self.options.count
        )

    def _arrays_of(self, begin: Start, own: np.ndarray, kind: np.ndarray) -> Arrays:
        """The arrays with which a start begins, with own parameters and kinds of its agents."""
        arrays = start_arrays(begin, self.model, 1)
        return arrays._replace(own=own, kind=kind, wish=self._no_wishes(len(kind)))

    def _start_kinds_in_boxes(self, begin: Start, table: StartTable, seeds: Sequence[int]) -> Start:
        """The start, with those of a kind that has a box of its own there. Raises InputError."""
        if all(one.start is None for one in self.kinds.kinds):
            return begin
        kind = table.kind[begin.number]
        position = begin.position.copy()
        for number, one in enumerate(self.kinds.kinds, 1):
            if one.start is None:
                continue
            low, high = np.array(one.start)
            if len(low) != self.world.dim:
                raise InputError(
                    f"start of kind {one.name} has {len(low)} coordinates: the world has "
                    f"{self.world.dim}"
                )
            rows = np.flatnonzero(kind == number).reshape(len(seeds), one.agents)
            for seed, own in zip(seeds, rows, strict=True):
                ids = 1 + begin.number[own]
                position[own] = spread(self.world, low, high - low, ids, 0.0, seed, table.gap)
        return replace(begin, position=position)

    def _given_start(self, start: Mapping[str, Any]) -> Arrays:
        """The arrays of a start from arrays. Raises InputError."""
        begin, own = self._start_from_arrays(start)
        return self._arrays_of(begin, own, self._kind_at_start(1 + begin.number))

    def _start_from_arrays(
        self, start: Mapping[str, Any], first_id: int | None = None
    ) -> tuple[Start, np.ndarray]:
        """A start from arrays; without speeds with those that the body begins with; and the agents'
        own parameters. `first_id`: of agents that join. Raises InputError."""
        begin = given_start(self.world, start, bool(self.model.passing(self.parameters)))
        ids, kind = (first_id or 1) + begin.number, None
        if first_id is None:
            own, kind = self._own_at_start(ids), self._kind_at_start(ids)
        else:
            own = self._own_of_new(ids)
        return self._with_start_speeds(begin, "speed" in start, own, first_id or 1, kind), own


def begin_in_place(flocks: Sequence[FlockStart], seeds: Sequence[int]) -> None:
    """Have the arrays of flocks be, to the bit, those with which the runs of seeds begin.

    The flocks differ in nothing but their seeds, and all of them `can_begin_in_place`. All but
    seeds and arrays stays as it is until `restart` makes it: ticks, catches and members are those
    of the run before. Raises InputError.
    """
    first = flocks[0]
    table, n = first._start_table(), len(first.arrays.ids)
    together = 1 if table.speed is None else max(1, AT_ONCE // n)
    for at in range(0, len(flocks), together):
        some = slice(at, at + together)
        for flock, seed in zip(flocks[some], seeds[some], strict=True):
            flock.seed = seed
        arrays = flocks[at]._random_start(seeds[some])
        for k, flock in enumerate(flocks[some]):
            rows = slice(n * k, n * k + n)
            for column, begun in zip(flock.arrays, arrays, strict=True):
                if column.size:
                    column[...] = begun[:, rows] if begun is arrays.memory else begun[rows]
