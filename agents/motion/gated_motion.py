"""Agents that come and go: who enters at a source and leaves at an exit, between two ticks."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from agents.engine.arrays import Arrays
from agents.engine.noise import BEYOND, uniform_numbers
from agents.kind_models import evaluate_parameters
from agents.models.declare import Parameters
from agents.models.model import Model
from agents.motion.motion import Motion
from agents.observables.neighbours import separation
from agents.state.agent_rows import (
    demand_memory_for,
    join_arrays,
    resize_past,
    select_rows,
    start_arrays,
)
from agents.state.passages import Passages
from agents.state.start import (
    FIRST,
    SPEED,
    Start,
    random_headings,
    region_velocities,
    start_gap,
)
from worlds.input_error import InputError
from worlds.mission import ExitRegion, Mission, SourceRegion
from worlds.queries.clearance import clearance
from worlds.world import World

ENTRIES = 4 * BEYOND
"""The first of the ticks of places where agents enter, one for each tick of a run: see
`agents.engine.noise.BEYOND`."""
PLACES = 16
"""Places that an agent which is due tries in a tick before it waits for the next one."""
MOST_AT_ONCE = 1000
"""Agents that a source may have due in one tick: more is no rate, but a start."""
NO_MISSION = Mission()


class GatedMotion(Motion):
    """State and ticks of a flock in a world with sources and exits.

    At the end of a tick those who are in an exit leave, then those who are due enter. Nothing of it
    is in the compiled loop: a flock in any other world runs as it did.
    """

    def _as_ordinary(self, arrays: Arrays, own: np.ndarray) -> Arrays:
        """The arrays of agents that join, of the ordinary kind, with their own parameters."""
        n = len(own)
        kind = np.zeros(n if self.kinds.kinds else 0)
        return arrays._replace(own=own, kind=kind, wish=self._no_wishes(n))

    def _start_gap(self, own: np.ndarray, kind: np.ndarray | None = None) -> float:
        """How far from what is solid agents with these own parameters start at least, length.

        `kind`: the number of each agent's; by default they are ordinary.
        """
        gaps = [0.0]
        for model, parameters, rows in self._by_models(len(own), kind):
            gap = start_gap(model.body)
            if gap is not None:
                columns = self._columns_of(own[rows])
                gaps += evaluate_parameters(
                    gap, model, parameters, columns, int(rows.sum())
                ).tolist()
        return max(gaps)

    def _by_models(
        self, n: int, kind: np.ndarray | None
    ) -> Iterator[tuple[Model, Parameters, np.ndarray]]:
        """The models of agents of these kinds, what they share, and which of n they move."""
        others = np.zeros(n, bool)
        numbers = np.zeros(n) if kind is None else kind
        for one in self.kind_models:
            rows = numbers == one.number
            others |= rows
            yield one.model, one.parameters, rows
        yield self.model, self.parameters, ~others

    def _columns_of(self, own: np.ndarray) -> dict[str, np.ndarray]:
        """Own parameters (N, Q) by name, those that differ."""
        differing = self.differing if own.shape[1] else ()
        return {name: own[:, self.own_columns.index(name)] for name in differing}

    def _with_start_speeds(
        self,
        begin: Start,
        with_speeds: bool,
        own: np.ndarray,
        first_id: int = 1,
        kind: np.ndarray | None = None,
    ) -> Start:
        """The start with the one speed of the body, or, without speeds, those it begins with.

        `own`: the agents' own parameters. `kind`: the number of each one's kind, by default that of
        the ordinary ones.
        """
        speed = begin.speed.copy()
        for model, parameters, rows in self._by_models(len(speed), kind):
            body, columns = model.body, self._columns_of(own[rows])
            if body.speed is not None:
                speed[rows] = evaluate_parameters(
                    body.speed, model, parameters, columns, int(rows.sum())
                )
            elif not with_speeds and body.begins is not None:
                ids = first_id + begin.number[rows]
                chance = uniform_numbers(self.seed, FIRST, ids, 1, SPEED)[:, 0]
                speed[rows] = begin_speeds(model, parameters, columns, chance)
        return replace(begin, speed=speed)

    @property
    def _gates(self) -> Mission:
        return self.world.mission or NO_MISSION

    def _demand_gates(self, world: World) -> None:
        """Raise InputError for a source that has too many due in one tick."""
        for number, source in enumerate(world.mission.sources if world.mission else ()):
            at_once = most_at_once(source, self.dt)
            if at_once > MOST_AT_ONCE:
                raise InputError(
                    f"mission.sources[{number}] has {at_once} agents due in one tick of "
                    f"{self.dt:g} {self.model.body.unit}: {MOST_AT_ONCE} at most ({world.name})"
                )

    def _begin_gates(self) -> None:
        """Nobody has come or gone yet, and those enter who are due at once."""
        self.entries = self.exits = Passages.none(self.world.dim)
        if self.world.has_gates:
            self._demand_gates(self.world)
            self._let_in(self.arrays)

    def _ticks_to_gates(self, ticks: int) -> int:
        if (self._gates.exits and len(self.ids)) or self.waiting:
            return 1
        due = min((source.next_due(number) for source, number in self._entered), default=np.inf)
        # A billionth less, for rounding: one tick more is run then by itself.
        least = due / self.dt * (1.0 - 1e-9) - self.tick
        return ticks if least >= ticks else max(1, int(least))

    def _pass_gates(self) -> None:
        """Let out who is in an exit, then let in who is due."""
        exits, arrays = self._gates.exits, self.arrays
        if exits and len(arrays.ids):
            gate = exits_of(exits, arrays.position)
            gate[~self.active] = -1  # wrecks stay where they lie
            rows = np.flatnonzero(gate >= 0)
            if len(rows):
                self.exits = self.exits.with_more(
                    self.tick, arrays.ids[rows], gate[rows], arrays.position[rows]
                )
                arrays = select_rows(arrays, np.flatnonzero(gate < 0))
        self._let_in(arrays)

    def _let_in(self, arrays: Arrays) -> None:
        """Go on with these arrays, and with those who are due at a source and find a place."""
        for number, (source, entered) in enumerate(self._entered):
            waiting = source.due(self.elapsed) - entered
            if waiting > 0:
                arrays = self._enter(arrays, number, source, waiting)
        if arrays is not self.arrays:
            self._set_arrays(arrays)
            self._match_members()

    def _enter(self, arrays: Arrays, number: int, source: SourceRegion, waiting: int) -> Arrays:
        """The arrays with those of so many who find a place in a source: the others wait."""
        size = self.model.body.size
        apart = max(source.spacing, float(getattr(self.parameters, size)) if size else 0.0)
        others, places = arrays.position, np.empty((0, self.world.dim))
        while len(places) < waiting:
            taken = np.concatenate([others, places])
            place = self._free_place(source, self.next_id + len(places), taken, apart)
            if place is None:
                break
            places = np.concatenate([places, place[None]])
        if not len(places):
            return arrays
        demand_memory_for(self.model, len(others) + len(places), self.threads)
        order = np.arange(len(places))
        ids = self.next_id + order
        own = self._own_of_new(ids)
        heading, speed = random_headings(self.seed, ids, self.world.dim), np.zeros(len(ids))
        region_velocities(source, self.seed, ids, heading, speed)
        start = Start(places, heading, np.zeros(len(ids), bool), speed, order)
        start = self._with_start_speeds(start, source.speed_low is not None, own, self.next_id)
        new = start_arrays(start, self.model, self.next_id)
        new = self._as_ordinary(new, own)
        new = resize_past(new, arrays.past.shape[1], len(self.model.signals), self.tick)
        self.entries = self.entries.with_more(self.tick, ids, np.full(len(ids), number), places)
        self.next_id += len(ids)
        return join_arrays(arrays, new)

    def _free_place(
        self, source: SourceRegion, identity: int, taken: np.ndarray, apart: float
    ) -> np.ndarray | None:
        """A place (dim,) in a source for an agent, clear of what is solid and `apart`, length, from
        the places (N, dim) that are taken; None if there is none among those that it tries."""
        world = self.world
        low, high = np.array(source.low), np.array(source.high)
        numbers = identity * PLACES + np.arange(PLACES)
        tried = uniform_numbers(self.seed, ENTRIES + self.tick, numbers, world.dim)
        tried = low + tried * (high - low)
        is_free = np.ones(PLACES, bool)
        if world.is_solid:
            gap = self._start_gap(self._own_of_new(np.array([identity])))
            is_free = clearance(world, tried) > gap
        if apart > 0.0 and len(taken):
            if not world.images.any():  # in a crowd most are far from the source
                is_near = np.all((taken > low - apart) & (taken < high + apart), axis=1)
                taken = taken[is_near]
            away = separation(tried[:, None], taken[None], world.size, world.images)
            is_free &= ~(np.linalg.norm(away, axis=2) < apart).any(axis=1)
        return tried[np.argmax(is_free)] if is_free.any() else None


def begin_speeds(
    model: Model, parameters: Parameters, columns: dict[str, np.ndarray], chance: np.ndarray
) -> np.ndarray:
    """The speeds (N,) that agents of a body begin with, by numbers uniform in [0, 1).

    `columns`: the parameters that differ among them, by name, (N,) each.
    """
    begins = model.body.begins
    assert begins is not None
    names = [name for name in columns if name in model.individual]
    if not names:
        return np.broadcast_to(begins(parameters, chance), len(chance))
    numbers = zip(*(columns[name].tolist() for name in names), strict=True)
    return np.array(
        [
            begins(parameters.model_copy(update=dict(zip(names, row, strict=True))), number)
            for row, number in zip(numbers, chance, strict=True)
        ],
        float,
    )


def exits_of(exits: tuple[ExitRegion, ...], position: np.ndarray) -> np.ndarray:
    """The number of the first exit that each of the places (N, dim) is in, -1 for none, (N,)."""
    gate = np.full(len(position), -1)
    for number in reversed(range(len(exits))):
        gate[exits[number].contains(position)] = number
    return gate


def most_at_once(source: SourceRegion, dt: float) -> int:
    """The most agents that a source has due in one tick of `dt`."""
    if source.rate is not None:
        return int(np.ceil(source.rate * dt))
    tick = np.ceil(np.array(source.times) / dt * (1.0 - 1e-9))
    return int(np.unique(tick, return_counts=True)[1].max())
