"""Read the flock at a tick of a recording, from where it lies in the file, never all of it."""

from __future__ import annotations

from collections import OrderedDict
from typing import Any

import numpy as np

from agents.individuals import BY_HAND
from agents.kind_models import demand_kind_models, kind_models
from agents.kinds import kind_table
from agents.models.declare import checked
from agents.models.model import Model
from agents.recordings.parquet_table import BATCH, MOST_NUMBERS, ParquetTable
from agents.recordings.recorder import AXES, PAST, arrays_of, kind_of, own_names, own_of
from agents.snapshot import NOBODY, Snapshot
from agents.spec import CompleteSpec
from agents.state.agent_rows import LARGEST, demand_usable
from agents.state.passages import Passages
from worlds.input_error import InputError
from worlds.world import World

AT_HAND = 64 * 2**20
"""Bytes of decoded rows that are kept."""


MOST = 2**24
"""Ticks of a recording, and agents in it: what is kept of each is kept together."""


class TickIndex:
    """Where each tick of a recording begins, found by a look at every row, a piece at a time.

    The rows of a tick follow each other in the file, and ticks rise in it, as recordings are
    written. Raises InputError for any other file.

    Attributes
    ----------
    ticks: those that are recorded, rising, int. starts: the first row of each. ends: behind the
    last. agents: how many there are, those that came and went among them.
    """

    def __init__(self, file: ParquetTable):
        self.file = file
        ticks, starts = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
        agent_ids, pieces, many = np.empty(0, np.int64), [], 0
        last, row, frames = -1, 0, 0
        open_ids = np.empty(0, np.int64)
        """Of the tick that the last piece ends in."""
        most_rows = MOST_NUMBERS // max(len(file.names), 1)
        for batch in file.batches(("tick", "id")):
            tick, ids = (
                self.whole_numbers(batch["tick"], "ticks"),
                self.whole_numbers(batch["id"], "identities"),
            )
            step = np.diff(tick, prepend=last)
            if (tick < 0).any() or (tick >= LARGEST).any():
                raise InputError(f"{file.origin} holds ticks outside [0, 2^53)")
            if (step < 0).any():
                raise InputError(f"{file.origin} is no recording: its ticks do not rise")
            first = np.flatnonzero(step)
            ticks.append(tick[first])
            starts.append(first + row)
            frames += len(first)
            open_ids = self.unique(
                np.concatenate([np.full(len(open_ids), last), tick]),
                np.concatenate([open_ids, ids]),
            )
            pieces.append(batch["id"].unique().to_numpy().astype(np.int64))
            many += len(pieces[-1])
            if many > max(BATCH, len(agent_ids)):
                agent_ids, pieces, many = np.unique(np.concatenate([agent_ids, *pieces])), [], 0
            row += len(tick)
            last = int(tick[-1])
            if max(frames, len(agent_ids)) > MOST or len(open_ids) > most_rows:
                raise file.size_error(f"{row} rows and more that are looked up together")
        self.ticks, self.starts = np.concatenate(ticks), np.concatenate(starts)
        self.ends = np.append(self.starts[1:], row)
        self.agents = len(np.unique(np.concatenate([agent_ids, *pieces])))

    def whole_numbers(self, column: Any, name: str) -> np.ndarray:
        """A column of whole numbers, int64. Raises InputError."""
        import pyarrow as pa

        if not pa.types.is_integer(column.type) or column.null_count:
            raise InputError(f"{self.file.origin} is no recording: its {name} are no whole numbers")
        numbers: np.ndarray = column.to_numpy().astype(np.int64)
        return numbers

    def unique(self, tick: np.ndarray, ids: np.ndarray) -> np.ndarray:
        """The identities of the last tick. Raises InputError where one is twice in a tick."""
        step, same_tick = np.diff(ids), np.diff(tick) == 0
        if (step[same_tick] <= 0).any():  # mostly they rise
            order = np.lexsort((ids, tick))
            is_repeated = (np.diff(ids[order]) == 0) & (np.diff(tick[order]) == 0)
            if is_repeated.any():
                at = tick[order][np.argmax(is_repeated)]
                raise InputError(
                    f"{self.file.origin} has two agents of one identity at one tick ({at})"
                )
        return ids[tick == tick[-1]]

    def place(self, tick: int) -> int | None:
        """Which of the recorded ticks it is; None for another."""
        place = int(np.searchsorted(self.ticks, tick))
        return place if place < len(self.ticks) and self.ticks[place] == tick else None


class SnapshotReader:
    """Takes snapshots from a recording; the rows that lie together are kept at hand."""

    def __init__(
        self,
        index: TickIndex,
        spec: CompleteSpec,
        model: Model,
        world: World,
        next_id: int,
        entries: Passages = NOBODY,
        exits: Passages = NOBODY,
        catches: Passages = NOBODY,
    ):
        self.file, self.index = index.file, index
        self.ticks, self.starts, self.ends = index.ticks, index.starts, index.ends
        self.origin = self.file.origin
        self.spec = spec
        self.model = model
        self.world = world
        self.next_id = next_id
        self.entries, self.exits, self.catches = entries, exits, catches
        self.kinds = kind_table(spec.kinds, spec.to)
        self.parameters = checked(model.parameters, spec.parameters, self.origin)
        demand_kind_models(model, self.parameters, self.kinds, spec, world.dim)
        self.groups: OrderedDict[int, Any] = OrderedDict()

    def last_tick_until(self, tick: float) -> int:
        """The last recorded tick that is not after one; the first of all before that."""
        return int(self.ticks[max(0, int(np.searchsorted(self.ticks, tick, side="right")) - 1)])

    def at(self, tick: int) -> Snapshot:
        """The flock at a recorded tick. Raises InputError for another, and for rows that are
        none."""
        place = self.index.place(tick)
        if place is None:
            raise InputError(f"tick = {tick} is not in {self.origin}")
        table = self.rows(int(self.starts[place]), int(self.ends[place]))
        arrays = arrays_of(table, self.world.dim, self.model, self.origin)
        demand_usable(arrays, self.world, self.origin)
        kind = kind_of(table, len(self.kinds.kinds), self.origin)
        own = own_of(table, self.model, self.parameters, self.origin, self.kinds, kind)
        names = own_names(table.column_names, self.model, self.kinds)
        of_kinds = {name for one in self.kinds.kinds for name in one.parameters}
        of_kinds |= {name for one in kind_models(self.kinds) for name in one.model.individual}
        individuals = {
            name: self.spec.individuals.get(name, BY_HAND)
            for name in names
            if name in self.spec.individuals or name not in of_kinds
        }
        entries = self.entries.until(tick)
        # The newest may have left again: no identity is given twice.
        newest = max(int(arrays.ids.max()), int(entries.id.max(initial=0)))
        next_id = max(self.next_id, newest + 1)
        return Snapshot(
            self.model,
            self.world,
            self.parameters,
            self.spec.seed,
            int(tick),
            arrays._replace(own=own, kind=kind),
            next_id,
            True,
            entries=entries,
            exits=self.exits.until(tick),
            individuals=individuals,
            kinds=self.kinds,
            catches=self.catches.until(tick),
        )

    def rows(self, first: int, end: int) -> Any:
        """The rows from one up to another, a pyarrow Table. Raises InputError."""
        import pyarrow as pa

        low = int(np.searchsorted(self.file.offsets, first, side="right")) - 1
        high = int(np.searchsorted(self.file.offsets, end, side="left"))
        parts = []
        for k in range(low, high):
            offset = int(self.file.offsets[k])
            since, until = max(first - offset, 0), min(end, int(self.file.offsets[k + 1])) - offset
            parts.append(self.group(k).slice(since, until - since))
        return pa.concat_tables(parts).combine_chunks()

    def group(self, k: int) -> Any:
        """A row group of the file, decoded, a pyarrow Table. Raises InputError."""
        if k in self.groups:
            self.groups.move_to_end(k)
            return self.groups[k]
        table = self.file.group(k)
        demand_numbers(table, self.origin)
        self.groups[k] = table
        while (
            len(self.groups) > 1 and sum(loaded.nbytes for loaded in self.groups.values()) > AT_HAND
        ):
            self.groups.popitem(last=False)
        return table


def demand_numbers(table: Any, origin: str) -> None:
    """Raise InputError where a column of a table holds nothing in a row."""
    for name, column in zip(table.column_names, table.columns, strict=True):
        if column.null_count:
            raise InputError(f"{origin}: its column {name!r} holds what is no number")


def demand_kinds(schema: Any, origin: str) -> None:
    """Raise InputError for a table whose columns cannot be those of a recording by their types."""
    import pyarrow as pa

    types = pa.types
    lists = (types.is_list, types.is_large_list, types.is_fixed_size_list)
    numbers = (types.is_integer, types.is_floating, types.is_boolean)
    for field in schema:
        kind, is_axis = field.type, field.name.removeprefix("u") in tuple(AXES)
        if field.name == PAST and any(is_list(kind) for is_list in lists):
            kind = kind.value_type
        if field.name == "tick" or field.name == "id":
            is_sound, fault = types.is_integer(kind), "no whole numbers"
        elif is_axis or field.name in ("speed", PAST):
            is_sound, fault = types.is_floating(kind), "what is no number with a point"
        else:
            is_sound, fault = any(is_number(kind) for is_number in numbers), "what is no number"
        if not is_sound:
            raise InputError(f"{origin}: its column {field.name!r} holds {fault}")
