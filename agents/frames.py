"""The flocks of a recording by their ticks: read where they lie in the file, never all of it."""

from __future__ import annotations

from collections import OrderedDict
from typing import Any

import numpy as np

from agents.models.declare import checked
from agents.models.model import Model
from agents.record import arrays_of
from agents.snapshot import Snapshot
from agents.spec import Spec
from agents.state.usable import LARGEST, demand_usable
from worlds.refusal import Refusal
from worlds.world import World

AT_HAND = 64 * 2**20
"""Bytes of decoded rows that are kept."""


class Frames:
    """Takes snapshots from an open Parquet file; those that lie together are kept at hand.

    `ticks` are those that are recorded, rising. The rows of a tick follow each other in the file,
    and ticks rise in it, as recordings are written. Raises Refusal for any other file.
    """

    def __init__(self, file: Any, origin: str, spec: Spec, model: Model, world: World, ids: int):
        self.file = file
        self.origin = origin
        self.spec = spec
        self.model = model
        self.world = world
        self.next_id = ids
        self.parameters = checked(model.parameters, spec.parameters, origin)
        self.groups: OrderedDict[int, Any] = OrderedDict()
        sizes = [file.metadata.row_group(k).num_rows for k in range(file.num_row_groups)]
        self.offsets = np.concatenate([[0], np.cumsum(sizes)])
        """Of each row group of the file the first row, and the number of all rows."""
        tick = self.tick_column()
        self.starts = np.flatnonzero(np.diff(tick, prepend=-1))
        """The first row of each tick."""
        self.ends = np.append(self.starts[1:], len(tick))
        """Behind the last."""
        self.ticks = tick[self.starts]
        if (np.diff(self.ticks) <= 0).any():
            raise Refusal(f"{origin} is no recording: its ticks do not rise")
        if self.ticks[-1] >= LARGEST or self.ticks[0] < 0:
            raise Refusal(f"{origin} holds ticks outside [0, 2^53)")

    def tick_column(self) -> np.ndarray:
        """The tick of every row of the file, int. Raises Refusal."""
        import pyarrow as pa

        try:
            column = self.file.read(columns=["tick"], use_threads=False)["tick"]
            whole = pa.types.is_integer(column.type) and not column.null_count
        except (pa.ArrowException, OSError):
            raise Refusal(f"{self.origin} is damaged: its ticks cannot be read") from None
        if not whole or len(column) == 0:
            raise Refusal(f"{self.origin} is no recording: its ticks are no whole numbers")
        return column.to_numpy().astype(np.int64)

    def before(self, tick: float) -> int:
        """The last recorded tick that is not after one; the first of all before that."""
        return int(self.ticks[max(0, int(np.searchsorted(self.ticks, tick, side="right")) - 1)])

    def at(self, tick: int) -> Snapshot:
        """The flock at a recorded tick. Raises Refusal for another, and for rows that are none."""
        place = int(np.searchsorted(self.ticks, tick))
        if place == len(self.ticks) or self.ticks[place] != tick:
            raise Refusal(f"tick = {tick} is not in {self.origin}")
        table = self.rows(int(self.starts[place]), int(self.ends[place]))
        arrays = arrays_of(table, self.world.dim, self.model, self.origin)
        demand_usable(arrays, self.world, self.origin)
        next_id = max(self.next_id, int(arrays.ids.max()) + 1)
        seed = self.spec.seed or 0
        return Snapshot(
            self.model, self.world, self.parameters, seed, int(tick), arrays, next_id, True
        )

    def rows(self, first: int, end: int) -> Any:
        """The rows from one up to another, a pyarrow Table. Raises Refusal."""
        import pyarrow as pa

        low = int(np.searchsorted(self.offsets, first, side="right")) - 1
        high = int(np.searchsorted(self.offsets, end, side="left"))
        parts = []
        for k in range(low, high):
            offset = int(self.offsets[k])
            since, until = max(first - offset, 0), min(end, int(self.offsets[k + 1])) - offset
            parts.append(self.group(k).slice(since, until - since))
        return pa.concat_tables(parts).combine_chunks()

    def group(self, k: int) -> Any:
        """A row group of the file, decoded, a pyarrow Table. Raises Refusal."""
        import pyarrow as pa

        if k in self.groups:
            self.groups.move_to_end(k)
            return self.groups[k]
        try:
            table = self.file.read_row_group(k, use_threads=False)
        except (pa.ArrowException, OSError):
            raise Refusal(f"{self.origin} is damaged: rows of it cannot be read") from None
        demand_numbers(table, self.origin)
        self.groups[k] = table
        while len(self.groups) > 1 and sum(one.nbytes for one in self.groups.values()) > AT_HAND:
            self.groups.popitem(last=False)
        return table


def demand_numbers(table: Any, origin: str) -> None:
    """Raise Refusal where a column of a table holds anything but numbers, or nothing."""
    import pyarrow as pa

    for name, column in zip(table.column_names, table.columns, strict=True):
        kind = column.type
        if pa.types.is_fixed_size_list(kind):
            kind = kind.value_type
        number = (pa.types.is_integer, pa.types.is_floating, pa.types.is_boolean)
        if column.null_count or not any(one(kind) for one in number):
            raise Refusal(f"{origin}: its column {name!r} holds what is no number")
