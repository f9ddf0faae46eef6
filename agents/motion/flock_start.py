"""How a flock begins: where its agents are, of which kind, and with which numbers of their own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from agents.individuals import Distribution
from agents.motion.steered_motion import SteeredMotion
from agents.spec import CompleteSpec
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
        table = StartTable(own, kind, self._start_gap(own, kind))
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

    def _random_start(self) -> tuple[Start, np.ndarray]:
        """A random start, with the speeds that the body begins with, and the agents' own
        parameters. Raises InputError."""
        run, table = self.options, self._start_table()
        ordinary = run.count - run.informed
        begin = random_start(self.world, ordinary, run.informed, self.seed, run.spacing, table.gap)
        begin = self._start_kinds_in_boxes(begin, table)
        # Lists are in the order of rows, whichever identities stand there.
        own = self._own_at_start(1 + begin.number) if self._has_lists else table.own[begin.number]
        kind = table.kind[begin.number] if len(table.kind) else table.kind
        with_speeds = bool(begin.speed.any())
        return self._with_start_speeds(begin, with_speeds, own, kind=kind), own

    def _start_kinds_in_boxes(self, begin: Start, table: StartTable) -> Start:
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
            rows = np.flatnonzero(kind == number)
            ids = 1 + begin.number[rows]
            position[rows] = spread(self.world, low, high - low, ids, 0.0, self.seed, table.gap)
        return replace(begin, position=position)

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
