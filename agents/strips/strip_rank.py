"""One strip of a flock: the agents that stand in it, and ghosts of those around it.

A rank runs ticks over its own agents and over ghosts, agents of other ranks that its own can meet.
What ticks make of a ghost is thrown away: the rank whose agent it is sends it anew. The ranks lay
the same cells over the whole flock, and rows stand in the order of the whole flock's rows, so that
each sum adds the same numbers in the same order as in one process.

Ghosts of one tick are those of the next cells. Where agents go no farther than a stride in a tick,
a wider halo serves several: who stands beyond it can be wrong by one reach and a stride more with
each tick, and has not come within reach of an agent of the strip by the last.
"""

from __future__ import annotations

import asyncio
from collections import defaultdict
from collections.abc import Awaitable, Callable, Sequence
from functools import reduce
from types import ModuleType
from typing import Any, NamedTuple, Protocol

import numpy as np

from agents.engine.arrays import Arrays, Context, WorldContext, empty_grid
from agents.engine.cells import Space, plan
from agents.engine.runner import SynchronousEngine
from agents.state.agent_rows import join_arrays, select_rows
from worlds.compilation import plain_python
from worlds.input_error import InputError

ROUNDING = 1e-6
"""Cells by which a ghost may be farther off than it need be, so that rounding leaves nobody out."""


class StripTask(NamedTuple):
    """What all ranks are to run, each with agents of its own."""

    edges: np.ndarray
    """Where a strip ends and the next begins, length, (ranks - 1,), ascending."""
    agents: int
    """Of the whole flock."""
    context: Context
    """Its `parameters` and `unbounded` are plain tuples: the loop's class is made by each rank."""
    seed: int
    tick: int
    ticks: int
    together: int
    """Ticks between two exchanges, >= 1."""
    stride: float
    """How far an agent goes in a tick at most, length; infinite where only one is together."""

    @property
    def halo(self) -> float:
        """How far beyond the next cells ghosts are needed, length."""
        more = self.together - 1
        return more * (self.context.reach + 2.0 * self.stride) if more else 0.0


class StripRows(NamedTuple):
    """Some agents of a flock, in the order of the whole flock's rows."""

    order: np.ndarray
    """Their rows in the whole flock, int64 (N,), ascending."""
    arrays: Arrays

    def select(self, rows: np.ndarray) -> StripRows:
        """Some of them, by an ascending index."""
        return StripRows(self.order[rows], select_rows(self.arrays, rows))

    def merge(self, kept: np.ndarray, others: Sequence[StripRows]) -> StripRows:
        """Some of these rows, by an ascending index, and all of the others', in order."""
        order = np.concatenate([rows.order for rows in others]) if others else self.order[:0]
        if not len(order):
            return self.select(kept)
        arrays = reduce(join_arrays, [rows.arrays for rows in others])
        by_order = np.argsort(order)
        places = np.searchsorted(self.order[kept], order[by_order])
        index = np.insert(kept, places, len(self.order) + by_order)
        joined = StripRows(np.append(self.order, order), join_arrays(self.arrays, arrays))
        return joined.select(index)


class StripColumns(NamedTuple):
    """The cells along x at one tick, for all ranks the same."""

    origin: float
    inverse: float
    number: int
    length: float
    """Of the ring that they form, or 0 where the last is not next to the first."""

    def is_met(self, x: np.ndarray, low: float, high: float, halo: float) -> np.ndarray:
        """Which agents those of the strip [low, high) can meet, themselves among them, (N,) bool.

        These are all that stand in its cells, in the next on either side, and in a halo beyond.
        """
        if self.number == 1:
            return np.ones(len(x), bool)
        ends = (np.array([low, high]) - self.origin) * self.inverse
        left, right = np.clip(ends, 0.0, self.number - 1.0)
        first = self.origin + (np.floor(left - ROUNDING) - 1.0 - ROUNDING) / self.inverse - halo
        end = self.origin + (np.floor(right + ROUNDING) + 2.0 + ROUNDING) / self.inverse + halo
        met = (x >= first) & (x < end)
        if self.length:
            met |= (x >= first + self.length) | (x < end - self.length)
        return met


class Peer(Protocol):
    """Another rank, as one may call it."""

    def deliver(self, exchange: int, sender: int, part: Any) -> Awaitable[None]:
        """See `StripRank.deliver`."""


class RankStopped(RuntimeError):
    """A rank was told to stop, since another one cannot go on."""


def own_copies(values: Any) -> Any:
    """A tuple of arrays as this rank's own: others may write to theirs, or have made them
    read-only."""
    return values._make(
        np.array(value) if isinstance(value, np.ndarray) else value for value in values
    )


def wrap_positions(space: Space, x: np.ndarray) -> np.ndarray:
    """Coordinates along x (N,), brought into the box where it wraps; a copy."""
    if not space.wraps[0]:
        return x.copy()
    length = space.size[0]
    with np.errstate(invalid="ignore"):  # the tick refuses what is no number
        return x - length * np.floor(x / length)


class StripRank:
    """The strip of one rank: made once, it runs any number of tasks one after another."""

    def __init__(
        self,
        number: int,
        build: Callable[[], ModuleType],
        kind: type[SynchronousEngine],
        place: WorldContext,
    ):
        self.number = number
        self.module, self.kind = build(), kind
        self.space, self.surroundings = own_copies(place.space), own_copies(place.surroundings)
        self.peers: Sequence[Peer] = ()
        self.exchange = 0
        """How many exchanges there have been: all ranks count alike."""
        self.parts: dict[int, dict[int, Any]] = defaultdict(dict)
        """What others have sent, by exchange and sender; some are ahead by one."""
        self.arrived = asyncio.Event()
        self.work: asyncio.Future[StripRows] | None = None
        self.room = -1
        self.engine: SynchronousEngine | None = None

    async def meet(self, peers: Sequence[Peer]) -> None:
        """Know the ranks, by number, oneself among them."""
        self.peers = peers

    async def deliver(self, exchange: int, sender: int, part: Any) -> None:
        """Take what another rank sends in an exchange."""
        self.parts[exchange][sender] = part
        self.arrived.set()

    async def stop(self) -> None:
        """Wait for nobody any more: what runs here raises RankStopped."""
        if self.work is not None:
            self.work.cancel()

    async def swap(self, parts: Sequence[Any]) -> list[Any]:
        """Send each rank its part, and return what the others have sent, in their order."""
        self.exchange += 1
        others = [rank for rank in range(len(self.peers)) if rank != self.number]
        await asyncio.gather(
            *(self.peers[rank].deliver(self.exchange, self.number, parts[rank]) for rank in others)
        )
        while len(self.parts[self.exchange]) < len(others):
            self.arrived.clear()
            await self.arrived.wait()
        received = self.parts.pop(self.exchange)
        return [received[rank] for rank in others]

    async def run(self, task: StripTask, rows: StripRows) -> StripRows:
        """Run ticks from these agents on, all those of the strip; those that then stand in it.

        Raises NotANumber, as an engine does, and RankStopped.
        """
        self.work = asyncio.ensure_future(self.run_ticks(task, rows))
        try:
            return await self.work
        except asyncio.CancelledError:
            raise RankStopped(f"rank {self.number} was stopped") from None

    async def run_ticks(self, task: StripTask, rows: StripRows) -> StripRows:
        """See `run`."""
        rows = StripRows(np.array(rows.order), own_copies(rows.arrays))
        context = task.context._replace(
            parameters=self.module.P(*task.context.parameters),
            unbounded=self.module.P(*task.context.unbounded),
            wind=np.array(task.context.wind),
        )
        grid = empty_grid(task.agents, 1)
        is_own = np.ones(len(rows.order), bool)
        last = task.tick + task.ticks
        for tick in range(task.tick, last, task.together):
            rows, is_own = await self.exchange_agents(task, rows, is_own, grid)
            if len(rows.order):
                ticks = min(task.together, last - tick)
                x, shape = rows.arrays.position[:, 0].copy(), grid.shape.copy()
                engine = self.engine_over(rows.arrays, grid, task.seed)
                await asyncio.to_thread(engine.run, context, tick, ticks)
                if not np.array_equal(shape, grid.shape):
                    raise AssertionError(f"cells {grid.shape} at tick {tick}, ghosts for {shape}")
                self.demand_strides(task, tick, ticks, rows.arrays.position[:, 0] - x)
        return rows.select(np.flatnonzero(is_own))

    def demand_strides(self, task: StripTask, tick: int, ticks: int, moved: np.ndarray) -> None:
        """Refuse agents that went farther along x than the halo allows for, (N,), length."""
        if task.together == 1:
            return
        length = self.space.size[0]  # several ticks run together where all axes wrap
        moved -= length * np.rint(moved / length)
        farthest = float(np.abs(moved).max())
        if farthest > ticks * task.stride * (1.0 + ROUNDING):
            raise InputError(
                f"ranks: an agent went {farthest:.6g} in {ticks} ticks from {tick} on, more than "
                f"{task.stride:.6g} a tick, the speed that its body declares"
            )

    async def exchange_agents(
        self, task: StripTask, rows: StripRows, is_own: np.ndarray, grid: Any
    ) -> tuple[StripRows, np.ndarray]:
        """Send what other ranks need; the rows of the next ticks, and which are the rank's own."""
        position = rows.arrays.position
        dim = position.shape[1]
        grid.corners[:] = await self.find_corners(position[is_own])
        if not np.isfinite(grid.corners[:, :dim]).all():
            return rows, is_own  # the tick refuses the row that is no number
        with plain_python():
            plan(grid, self.space, task.context.reach, grid.corners[:, :dim])
        is_ring = bool(self.space.images[0]) and grid.shape[0] > 1
        columns = StripColumns(
            float(grid.origin[0]),
            float(grid.inverse[0]),
            int(grid.shape[0]),
            float(self.space.size[0]) if is_ring else 0.0,
        )
        x = wrap_positions(self.space, position[:, 0])
        owner = np.searchsorted(task.edges, x, side="right")
        ends = [-np.inf, *task.edges, np.inf]
        needed = [
            np.flatnonzero(
                is_own
                & ((owner == rank) | columns.is_met(x, ends[rank], ends[rank + 1], task.halo))
            )
            for rank in range(len(self.peers))
        ]
        parts = [
            None if rank == self.number else rows.select(needed_rows)
            for rank, needed_rows in enumerate(needed)
        ]
        rows = rows.merge(needed[self.number], await self.swap(parts))
        x = wrap_positions(self.space, rows.arrays.position[:, 0])
        return rows, np.searchsorted(task.edges, x, side="right") == self.number

    async def find_corners(self, position: np.ndarray) -> np.ndarray:
        """The least and the largest coordinates of the whole flock along axes that do not wrap.

        Shape (2, 3); along the others, and those that a plane has not, 0.
        """
        dim = position.shape[1]
        corners = np.zeros((2, 3))
        is_open = self.space.wraps[:dim] == 0
        if not is_open.any():
            return corners
        corners[0, :dim], corners[1, :dim] = np.inf, -np.inf
        if len(position):
            corners[0, :dim], corners[1, :dim] = position.min(axis=0), position.max(axis=0)
        both = np.array([corners, *await self.swap([corners] * len(self.peers))])
        corners[0], corners[1] = both[:, 0].min(axis=0), both[:, 1].max(axis=0)
        corners[:, :dim][:, ~is_open] = 0.0
        return corners

    def engine_over(self, arrays: Arrays, grid: Any, seed: int) -> SynchronousEngine:
        """The engine over these rows; it is made anew where there are more than it has room for."""
        n, dim = arrays.position.shape
        if self.engine is None or n > self.room or self.engine.seed != seed:
            self.room = n + n // 8
            roomy = arrays._replace(position=np.empty((self.room, dim)))
            place = WorldContext(self.space, self.surroundings)
            self.engine = self.kind(self.module, roomy, place, seed)
            self.slots = self.engine.slots
        self.engine.arrays, self.engine.grid = arrays, grid
        self.engine.slots = self.slots._replace(row=self.slots.row[:n])
        return self.engine
