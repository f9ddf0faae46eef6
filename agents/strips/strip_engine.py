"""Run a flock in strips: each rank, a worker of Dask, has the agents between two lines across x."""

from __future__ import annotations

import asyncio
import weakref
from collections.abc import Callable
from contextlib import suppress
from types import ModuleType
from typing import Any

import numpy as np

from agents.engine.arrays import Arrays, Context, WorldContext
from agents.engine.runner import Engine, NotANumber, SynchronousEngine
from agents.models.model import Model, reads
from agents.option import whole_number
from agents.state.agent_rows import select_rows
from agents.strips.strip_rank import StripRank, StripRows, StripTask, wrap_positions
from worlds.input_error import InputError
from worlds.plug_ins import demand
from worlds.world import World

EXTRA = "cluster"
MOST_RANKS = 1024
BALANCED_FOR = 1000
"""Ticks after which the strips are laid anew, with as many agents in each."""
EXCHANGE = 3.0
"""What an exchange costs a rank, in ticks without one, about, measured for vem."""
LOOK = 0.5
"""Seconds between two looks whether all processes live."""


def checked_ranks(ranks: Any) -> Any:
    """A number of ranks, or a client of Dask as it is. Raises InputError."""
    return (
        ranks if hasattr(ranks, "scheduler_info") else whole_number("ranks", ranks, 1, MOST_RANKS)
    )


def reason_for_one_process(model: Model, nearest: int, options: Any) -> str:
    """Why a flock cannot be run in strips, in a few words, or an empty string.

    A strip knows what stands within reach of its agents, as it is at the beginning of a tick.
    """
    if options.activation != "synchronous":
        return f"with activation = {options.activation!r} agents see what others have just done"
    if options.is_late:
        return "what agents know of each other is late or inexact"
    if nearest:
        return "the nearest agents may be anywhere"
    if model.rule.prepare is not None:
        return f"the rule {model.rule.name} looks at the whole flock at each tick"
    rule, body = model.rule, model.body
    functions = rule.perceive, rule.decide, rule.answer, rule.show, rule.remember
    if any(reads("flock_size", one) for one in (*functions, body.move, body.measure, body.touches)):
        return f"the model {model.name} asks how large the whole flock is"
    return ""


def longest_stride(model: Model, parameters: Any, world: World, options: Any) -> float:
    """How far along x agents can go in a tick, length; infinite where nothing declares it."""
    body = model.body
    if body.speed is None or not model.is_of_pairs or options.is_windy or not all(world.wraps):
        return float("inf")
    # A body's speed is for a tick or for a unit of time, as its paper has it.
    return float(body.speed(parameters)) * max(1.0, float(body.lasts(parameters)))


class RankProcesses:
    """Workers of Dask, one for each rank: so many processes of this machine, or those of a client.

    Raises InputError without Dask, or where a client has no worker.
    """

    def __init__(self, ranks: Any):
        demand("distributed", "ranks", EXTRA)
        from distributed import Client

        self.cluster: Any = None
        self.futures: list[Any] = []
        if isinstance(ranks, Client):
            self.client = ranks
        else:
            demand("cryptography", "ranks", EXTRA)
            from distributed import Security

            from agents.strips.tls_cluster import local_cluster, silence_dask

            silence_dask()
            security = Security.temporary()
            self.cluster = local_cluster(ranks, security)
            self.client = Client(
                self.cluster, security=security, set_as_default=False, direct_to_workers=True
            )
        own = [self.client, self.cluster] if self.cluster is not None else []
        self.close = weakref.finalize(self, close_all, own)

    def place_ranks(self, build: Any, kind: type, place: WorldContext) -> list[Any]:
        """A `StripRank` on each worker that there is now, as Dask's actors that know each other."""
        addresses = sorted(self.client.scheduler_info(n_workers=-1)["workers"])
        if not addresses:
            raise InputError("ranks: the client of Dask has no worker; begin one for each rank")
        futures = [
            self.client.submit(
                StripRank, number, build, kind, place, actor=True, workers=[address], pure=False
            )
            for number, address in enumerate(addresses)
        ]
        ranks = [future.result() for future in futures]
        self.futures = futures  # Dask keeps an actor as long as its future is kept
        self.call_all(ranks, [("meet", ranks)] * len(ranks))
        return ranks

    def call_all(self, ranks: list[Any], calls: list[tuple[Any, ...]]) -> list[Any]:
        """Call a method of every rank: calls are names and arguments; what they answer.

        Raises what a rank raises, and OSError where a process has ended.
        """
        return self.client.sync(self._call_all, ranks, calls)

    async def _call_all(self, ranks: list[Any], calls: list[tuple[Any, ...]]) -> list[Any]:
        with self.client.as_current():  # or an actor does not know whom to ask
            tasks = [
                asyncio.ensure_future(wait_for(getattr(rank, name)(*arguments)))
                for rank, (name, *arguments) in zip(ranks, calls, strict=True)
            ]
        waiting = set(tasks)
        while waiting:
            done, waiting = await asyncio.wait(
                waiting, timeout=LOOK, return_when=asyncio.FIRST_EXCEPTION
            )
            raise_first(done)
            # A call to a worker that is gone may never be answered.
            if any(future.status != "finished" for future in self.futures):
                raise OSError("its worker is gone")
        return [task.result() for task in tasks]

    def stop(self, ranks: list[Any]) -> None:
        """Tell all ranks to stop, and wait for none of them."""
        for rank in ranks:
            with suppress(RuntimeError), self.client.as_current():  # it says so of one that is gone
                rank.stop()
        self.futures = []


async def wait_for(call: Any) -> Any:
    """What a call of an actor answers."""
    return await call


def raise_first(tasks: set[asyncio.Task[Any]]) -> None:
    """Raise what a task has raised: what a rule or a user has done before what follows from it."""
    errors = [error for task in tasks if (error := task.exception()) is not None]
    errors.sort(key=lambda error: not isinstance(error, NotANumber | InputError))
    if errors:
        raise errors[0]


def close_all(own: list[Any]) -> None:
    """Close a client and its cluster, whatever has become of them."""
    for one in own:
        with suppress(Exception):
            one.close()


class StripEngine(Engine):
    """An engine whose ticks are run in strips, to the same bits; `whole` is that of one process.

    The arrays stay here: a run sends each rank its agents, and brings them back. `stride` is how
    far an agent goes in a tick at most, length, or infinite where nothing is known of that.
    """

    most_together = BALANCED_FOR

    def __init__(
        self,
        whole: SynchronousEngine,
        processes: RankProcesses,
        build: Callable[[], ModuleType],
        stride: float,
    ):
        self.whole, self.stride = whole, stride
        self.arrays, self.module, self.seed = whole.arrays, whole.module, whole.seed
        self.space, self.surroundings = whole.space, whole.surroundings
        self.processes, self.build = processes, build
        self.ranks: list[Any] = []
        """Placed by the first run, and anew after one that failed."""

    def open(self, context: Context, tick: int) -> None:
        """Begin a tick in which agents step one by one: it needs no ranks."""
        self.whole.open(context, tick)

    def one(self, context: Context, tick: int, row: int) -> None:
        """Let the agent of one row of an opened tick decide and move."""
        self.whole.one(context, tick, row)

    def run_ticks(self, context: Context, tick: int, ticks: int) -> None:
        """Run ticks without looking at the flock between them.

        Raises InputError where a process has ended; the flock is then as it was.
        """
        try:
            if not self.ranks:
                place = WorldContext(self.space, self.surroundings)
                self.ranks = self.processes.place_ranks(self.build, type(self.whole), place)
            strips = self.processes.call_all(self.ranks, self.calls(context, tick, ticks))
        except BaseException as error:
            self.processes.stop(self.ranks)
            self.ranks = []
            if isinstance(error, NotANumber | InputError) or not isinstance(error, Exception):
                raise
            raise InputError(
                f"ranks: a process has ended in ticks {tick} to {tick + ticks} ({error}); "
                f"the flock is as it was at tick {tick}"
            ) from error
        for strip in strips:
            put_rows(self.arrays, strip)

    def calls(self, context: Context, tick: int, ticks: int) -> list[tuple[Any, ...]]:
        """What each rank is asked for, strips holding as many agents each."""
        x = wrap_positions(self.space, self.arrays.position[:, 0])
        edges = np.quantile(x, np.arange(1, len(self.ranks)) / len(self.ranks))
        owner = np.searchsorted(edges, x, side="right")
        sent = context._replace(
            parameters=tuple(context.parameters), unbounded=tuple(context.unbounded)
        )
        together = self.ticks_together(context)
        task = StripTask(edges, len(x), sent, self.seed, tick, ticks, together, self.stride)
        calls: list[tuple[Any, ...]] = []
        for rank in range(len(self.ranks)):
            rows = np.flatnonzero(owner == rank)
            calls.append(("run", task, StripRows(rows, select_rows(self.arrays, rows))))
        return calls

    def ticks_together(self, context: Context) -> int:
        """Ticks between two exchanges: those at which the halo costs about what they save."""
        if not self.stride < np.inf:
            return 1
        width = self.space.size[0] / len(self.ranks)
        wider = 2.0 * (context.reach + 2.0 * self.stride)
        return max(1, int(np.sqrt(EXCHANGE * width / wider)))


def put_rows(arrays: Arrays, strip: StripRows) -> None:
    """Write the agents of a strip into their rows of the whole flock's arrays."""
    for name, column, part in zip(Arrays._fields, arrays, strip.arrays, strict=True):
        if name == "memory":
            column[:, strip.order] = part
        elif len(column):
            column[strip.order] = part
