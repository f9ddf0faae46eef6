"""Read a recording or saved state: what it holds, as a table, as CSV, or as flocks at its ticks."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from functools import cached_property
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from agents.catalogue import model
from agents.flock_world import find_world
from agents.kinds import kind_table
from agents.models.declare import checked
from agents.option import whole_number
from agents.recordings.parquet_table import ParquetTable, demand_format
from agents.recordings.recorder import (
    CATCHES,
    ENTRIES,
    EXITS,
    FORMAT,
    KEY,
    PAST,
    SHEET,
    describe_columns,
    table_writer,
)
from agents.recordings.snapshot_reader import SnapshotReader, TickIndex, demand_kinds
from agents.snapshot import Snapshot
from agents.spec import Spec
from agents.state.passages import LARGEST, Passages
from worlds.checks import demand_sound
from worlds.file_writer import writing
from worlds.input_error import InputError, demand_line, shorten, unknown
from worlds.layout import world_from_layout
from worlds.mission import Mission
from worlds.world import World

if TYPE_CHECKING:
    import pandas as pd


KIND = "a state or a recording of flockscope (Parquet with its spec)"


class Recording:
    """A file of `flockscope run --record` or `--save`, or of `Flock.save`; nothing is run.

    `content`: its bytes where there is no file, as of one that a browser has sent. Whoever made it:
    rows are read from the file as they are asked for, a piece at a time, and what cannot be a
    recording is refused. A recording of before units and world
    were written with it needs its model at hand for both. Raises InputError if it is no such file.

    Attributes
    ----------
    path: Path. spec: CompleteSpec, the run. model, title: its model's name, and that for people.
    time_per_tick: the time that a tick stands for, in `time_unit` ("ticks" or "s").
    length_unit: "m", or "length" where the model's paper names none.
    columns: name -> {"unit", "meaning"}, in their order. world: World.
    """

    def __init__(self, path: str | Path, content: bytes | None = None):
        self.path = Path(path)
        self.file = ParquetTable(path, content, KIND)
        self.names, self.rows = self.file.names, self.file.rows
        if not self.rows or not {"tick", "id"} <= set(self.names):
            raise self.file.is_none()
        demand_kinds(self.file.schema, self.file.origin)
        meta = self.file.metadata(KEY)
        if not {"spec", "next_id"} <= set(meta):
            raise self.file.is_none()
        written_in = demand_format(meta, FORMAT, self.file.origin)
        try:
            text = demand_text(meta["spec"])
            self.spec = Spec.from_toml(text, str(path)).demand_complete(str(path))
            if written_in == 1:
                meta = self.metadata_of_format_1(meta)
            self.next_id = meta["next_id"]
            if type(self.next_id) is not int or not 0 <= self.next_id <= LARGEST:
                raise ValueError(f"next_id = {shorten(self.next_id)} is outside [0, 2^53]")
            self.model, self.title = (
                demand_text_line(meta["model"]),
                demand_text_line(meta["title"]),
            )
            self.time_per_tick = float(meta["time_per_tick"])
            if not 0.0 < self.time_per_tick < math.inf:
                raise ValueError(f"a tick stands for a time of {self.time_per_tick:g}")
            self.time_unit = demand_text_line(meta["time_unit"])
            self.length_unit = demand_text_line(meta["length_unit"])
            self.columns: dict[str, dict[str, str]] = {
                name: {
                    key: demand_text_line(meta["columns"][name][key]) for key in ("unit", "meaning")
                }
                for name in self.names
            }
            self.layout: dict[str, Any] = dict(meta["world"])
            self.world_name = demand_text_line(meta["world_name"])
            self.passages = {name: meta.get(name) for name in (ENTRIES, EXITS, CATCHES)}
        except KeyError as missing:
            raise self.bad_metadata(f"it has no {missing}") from None
        except RecursionError:
            raise self.bad_metadata("it is nested too deeply") from None
        except InputError:
            raise
        except (OverflowError, TypeError, ValueError) as error:
            raise self.bad_metadata(str(error)) from None

    def bad_metadata(self, how: str) -> InputError:
        """The refusal for metadata that none can be."""
        return InputError(f"the metadata of {self.file.origin} is damaged: {how}")

    def __repr__(self) -> str:
        return f"<Recording {self.model}, {len(self.ticks)} frames, {self.rows} rows, {self.path}>"

    def metadata_of_format_1(self, meta: dict[str, Any]) -> dict[str, Any]:
        """The metadata of format 1 with what is missing there, from its model. Raises
        InputError."""
        flock_model = model(self.spec.model)
        dt = flock_model.body.lasts(checked(flock_model.parameters, self.spec.parameters))
        return meta | describe_columns(
            flock_model, find_world(self.spec, flock_model), dt, PAST in self.names
        )

    @cached_property
    def world(self) -> World:
        """The world, with all that stands in it. Raises InputError."""
        try:
            built_world = world_from_layout(self.layout, self.world_name)
            demand_sound(built_world)
        except (OverflowError, RecursionError, TypeError, ValueError) as error:
            reason = str(error) if isinstance(error, InputError) else "it cannot be read"
            raise InputError(f"the world of {self.file.origin} is none: {reason}") from None
        if built_world.dim != self.spec.dim:
            raise InputError(
                f"the world of {self.file.origin} has {built_world.dim} dimensions, "
                f"its run {self.spec.dim}"
            )
        return built_world

    @cached_property
    def index(self) -> TickIndex:
        """Where each tick lies in the file, whose rows it looks through. Raises InputError."""
        return TickIndex(self.file)

    @property
    def ticks(self) -> np.ndarray:
        """The ticks that are recorded, rising, int. Raises InputError."""
        return self.index.ticks

    @property
    def agents(self) -> int:
        """How many agents there are in it, those that came and went among them. Raises
        InputError."""
        return self.index.agents

    def at(self, tick: int | None = None) -> Snapshot:
        """The flock at a recorded tick, by default the last. Raises InputError."""
        return self.frames.at(int(self.ticks[-1]) if tick is None else tick)

    @cached_property
    def frames(self) -> SnapshotReader:
        """The flocks at its ticks, for those who look at many. Raises InputError."""
        gates = self.entries_and_exits(self.world)
        return SnapshotReader(
            self.index,
            self.spec,
            model(self.spec.model),
            self.world,
            self.next_id,
            *gates,
            self.catches,
        )

    def entries_and_exits(self, world: World) -> tuple[Passages, Passages]:
        """Who came and went in this world by the end of the file. Raises InputError."""
        mission = world.mission or Mission()
        tables = self.passages[ENTRIES], self.passages[EXITS]
        if not mission.has_gates or None in tables:
            nobody = Passages.none(world.dim, not mission.has_gates)
            return nobody, nobody
        entries, exits = (
            Passages.from_table(table, world.dim, len(gates), self.file.origin)
            for table, gates in zip(tables, (mission.sources, mission.exits), strict=True)
        )
        return entries, exits

    @property
    def catches(self) -> Passages:
        """Who was caught by the end of the file. Raises InputError."""
        table, dim = self.passages[CATCHES], self.spec.dim
        if table is None:
            return Passages.none(dim, not kind_table(self.spec.kinds, self.spec.to).catchers)
        return Passages.from_table(table, dim, LARGEST, self.file.origin)

    def state(self, tick: int | None = None) -> Snapshot:
        """The same as `at`, in the world that its spec gives a run that goes on. Raises
        InputError."""
        flock_model = model(self.spec.model)
        world = find_world(self.spec, flock_model)
        gates = self.entries_and_exits(world)
        if not gates[0].is_known:
            raise InputError(
                f"{self.file.origin} does not hold who came and went in {world.name}, since its "
                "run was killed or let too many through: no run can go on from it"
            )
        frames = SnapshotReader(
            self.index, self.spec, flock_model, world, self.next_id, *gates, self.catches
        )
        return frames.at(int(self.ticks[-1]) if tick is None else tick)

    def table(self, columns: Iterable[str] | None = None, ticks: Any = None) -> Any:
        """The columns of these names, by default all, as a pyarrow Table.

        `ticks`: a tick or several, by default all: the table is as large as what is asked for.
        Raises InputError for what is not in it.
        """
        names = self.names if columns is None else list(columns)
        for name in names:
            if name not in self.names:
                raise unknown("column", name, self.names, str(self.path))
        if ticks is None:
            return self.file.table(self.file.batches(names), names)
        wanted_ticks = [whole_number("tick", tick, 0) for tick in np.atleast_1d(ticks).tolist()]
        places = {tick: self.index.place(tick) for tick in wanted_ticks}
        for tick, place in places.items():
            if place is None:
                raise InputError(f"tick = {tick} is not in {str(self.path)!r}")
        chosen_places = np.unique(list(places.values()))
        return self.file.table(self.pieces(chosen_places, names), names)

    def pieces(self, places: np.ndarray, names: list[str]) -> Iterator[Any]:
        """Record batches with the rows of some of its ticks, by their places among `ticks`."""
        starts, ends = self.index.starts[places], self.index.ends[places]
        for k, (low, high) in enumerate(pairwise(self.file.offsets)):
            is_in_group = (starts < high) & (ends > low)
            if not is_in_group.any():
                continue
            group = self.file.group(k, names)
            for first, end in zip(starts[is_in_group], ends[is_in_group], strict=True):
                since = max(int(first - low), 0)
                yield from group.slice(since, int(min(end, high) - low) - since).to_batches()

    def to_dataframe(self, columns: Iterable[str] | None = None, ticks: Any = None) -> pd.DataFrame:
        """A data frame of pandas, one row for each agent and tick, with the file's numbers.

        Columns and ticks as in `table`. `attrs` of it has `units` and `meanings` by column, the
        time of a tick, the units of time and length, the world as a layout, and the spec as TOML.
        Raises InputError.
        """
        frame = self.table(columns, ticks).to_pandas(ignore_metadata=True)
        frame.attrs.update(self.attributes(list(frame.columns)))
        return frame

    def attributes(self, names: Iterable[str]) -> dict[str, Any]:
        """What says of a table with these columns what its numbers are, plain values."""
        return {
            "model": self.model,
            "title": self.title,
            "seed": self.spec.seed,
            "time_per_tick": self.time_per_tick,
            "time_unit": self.time_unit,
            "length_unit": self.length_unit,
            "units": {name: self.columns[name]["unit"] for name in names},
            "meanings": {name: self.columns[name]["meaning"] for name in names},
            "world_name": self.world_name,
            "world": self.layout,
            "spec": self.spec.to_toml(),
        }

    def to_csv(self, path: str | Path, overwrite: bool = False) -> int:
        """Write it as CSV, as `--record x.csv` does; returns the rows. Raises InputError.

        What messages on their way tell, in saved states, is left out: it is a list in each row.
        """
        names = [name for name in self.names if name != PAST]
        _ = self.index  # whose rows are none is refused before a file is begun
        schema = self.file.schema
        for name in set(self.names) - set(names):
            schema = schema.remove(schema.get_field_index(name))
        with (
            writing("--csv", path, overwrite, (SHEET,)) as out,
            table_writer(Path(path), out, schema) as writer,
        ):
            for batch in self.file.batches(names):
                writer.write_batch(batch.cast(schema))
        return self.rows

    def described(self) -> dict[str, Any]:
        """What it holds, as JSON has it. Raises InputError."""
        _ = self.world  # which is shown as a layout, and has to be one
        first, last = int(self.ticks[0]), int(self.ticks[-1])
        gaps = np.diff(self.ticks)
        return {
            "recording": str(self.path),
            "model": self.model,
            "title": self.title,
            "seed": self.spec.seed,
            "frames": len(self.ticks),
            "first_tick": first,
            "last_tick": last,
            "ticks_apart": [int(gaps.min()), int(gaps.max())] if len(gaps) else [0, 0],
            "time_per_tick": self.time_per_tick,
            "time_unit": self.time_unit,
            "lasts": (last - first) * self.time_per_tick,
            "agents": self.agents,
            "rows": self.rows,
            "world": self.world_name,
            "size": list(self.spec.size) if isinstance(self.spec.size, tuple) else self.spec.size,
            "length_unit": self.length_unit,
            "columns": self.columns,
            "layout": self.layout,
            "spec": self.spec.model_dump(mode="json"),
        }


def demand_text(value: Any) -> str:
    """A text of metadata. Raises TypeError for anything else."""
    if not isinstance(value, str):
        raise TypeError(f"{shorten(value)} stands where a text is needed")
    return value


def demand_text_line(value: Any) -> str:
    """A text of metadata in one line. Raises TypeError or ValueError for anything else."""
    return demand_line(demand_text(value))
