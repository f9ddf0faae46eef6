"""A recording or saved state read: what it holds, as a table, as CSV, or as flocks at its ticks."""

from __future__ import annotations

import json
from collections.abc import Iterable
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from agents.catalogue import model
from agents.frames import Frames
from agents.home import find_world
from agents.models.declare import checked
from agents.record import KEY, PAST, SHEET, described, table_writer
from agents.snapshot import Snapshot
from agents.spec import Spec, whole
from worlds.checks import demand_sound
from worlds.extra import demand_parquet
from worlds.layout import world_from_layout
from worlds.refusal import Refusal, unknown
from worlds.world import World
from worlds.writing import writing

if TYPE_CHECKING:
    import pandas as pd


class Recording:
    """A file of `flockscope run --record` or `--save`, or of `Flock.save`; nothing is run.

    `content`: its bytes where there is no file, as of one that a browser has sent. Positions and
    the like are read from the file as they are asked for. A recording of before units and world
    were written with it needs its model at hand for both. Raises Refusal if it is no such file.

    Attributes
    ----------
    path: Path. spec: Spec, the run. model, title: its model's name, and that for people.
    time_per_tick: the time that a tick stands for, in `time_unit` ("ticks" or "s").
    length_unit: "m", or "length" where the model's paper names none.
    columns: name -> {"unit", "meaning"}, in their order. world: World.
    """

    def __init__(self, path: str | Path, content: bytes | None = None):
        demand_parquet(f"reading {str(path)!r}")
        import pyarrow as pa
        import pyarrow.parquet as pq

        self.path = Path(path)
        self.content = content
        try:
            if content is None:
                open(path, "rb").close()  # whose errors have words of their own
            with pq.ParquetFile(self.source) as file:
                self.names: list[str] = file.schema_arrow.names
                self.rows: int = file.metadata.num_rows
                meta = json.loads((file.schema_arrow.metadata or {})[KEY])
                text, self.next_id = str(meta["spec"]), int(meta["next_id"])
            if not self.rows or not {"tick", "id"} <= set(self.names):
                raise ValueError
        except OSError as error:
            reason = " ".join(str(error.strerror or error).split())
            raise Refusal(f"recording {str(path)!r} cannot be read: {reason}") from None
        except (pa.ArrowException, KeyError, TypeError, ValueError):
            raise Refusal(
                f"{str(path)!r} is not a state or a recording of flockscope (Parquet with its spec)"
            ) from None
        self.spec = Spec.from_toml(text, str(path))
        self.spec.demand_complete(str(path))
        if meta.get("format") == 1:
            meta = self.of_before(meta)
        try:
            self.model, self.title = str(meta["model"]), str(meta["title"])
            self.time_per_tick = float(meta["time_per_tick"])
            self.time_unit, self.length_unit = str(meta["time_unit"]), str(meta["length_unit"])
            self.columns: dict[str, dict[str, str]] = {
                name: {key: str(meta["columns"][name][key]) for key in ("unit", "meaning")}
                for name in self.names
            }
            self.layout: dict[str, Any] = dict(meta["world"])
            self.world_name = str(meta["world_name"])
        except (KeyError, TypeError, ValueError) as error:
            raise Refusal(f"the metadata of {str(path)!r} is damaged: {error!r}") from None

    def __repr__(self) -> str:
        return f"<Recording {self.model}, {len(self.ticks)} frames, {self.rows} rows, {self.path}>"

    @property
    def source(self) -> Any:
        """What pyarrow reads it from."""
        import pyarrow as pa

        return self.path if self.content is None else pa.BufferReader(self.content)

    def of_before(self, meta: dict[str, Any]) -> dict[str, Any]:
        """The metadata of format 1 with what is missing there, from its model. Raises Refusal."""
        one = model(self.spec.model)
        dt = one.body.lasts(checked(one.parameters, self.spec.parameters))
        return meta | described(one, find_world(self.spec, one), dt, PAST in self.names)

    @cached_property
    def world(self) -> World:
        """The world, with all that stands in it. Raises Refusal."""
        made = world_from_layout(self.layout, self.world_name)
        demand_sound(made)
        return made

    @cached_property
    def ticks(self) -> np.ndarray:
        """The ticks that are recorded, rising, int."""
        return np.unique(self.table(["tick"])["tick"].to_numpy())

    @cached_property
    def agents(self) -> int:
        """How many agents there are in it, those that came and went among them."""
        return len(np.unique(self.table(["id"])["id"].to_numpy()))

    def at(self, tick: int | None = None) -> Snapshot:
        """The flock at a recorded tick, by default the last. Raises Refusal."""
        return self.frames.at(int(self.ticks[-1]) if tick is None else tick)

    @cached_property
    def frames(self) -> Frames:
        """The flocks at its ticks, for those who look at many. Raises Refusal."""
        import pyarrow.parquet as pq

        one, file = model(self.spec.model), pq.ParquetFile(self.source)
        return Frames(file, repr(str(self.path)), self.spec, one, self.world, self.next_id)

    def table(self, columns: Iterable[str] | None = None, ticks: Any = None) -> Any:
        """The columns of these names, by default all, as a pyarrow Table.

        `ticks`: a tick or several, by default all. Raises Refusal for what is not in it.
        """
        import pyarrow.parquet as pq

        names = self.names if columns is None else list(columns)
        for name in names:
            if name not in self.names:
                raise unknown("column", name, self.names, str(self.path))
        if ticks is None:
            return pq.read_table(self.source, columns=names)
        wanted = [whole("tick", tick, 0) for tick in np.atleast_1d(ticks).tolist()]
        for tick in wanted:
            if tick not in self.ticks:
                raise Refusal(f"tick = {tick} is not in {str(self.path)!r}")
        return pq.read_table(self.source, columns=names, filters=[("tick", "in", wanted)])

    def to_dataframe(self, columns: Iterable[str] | None = None, ticks: Any = None) -> pd.DataFrame:
        """A data frame of pandas, one row for each agent and tick, with the file's numbers.

        Columns and ticks as in `table`. `attrs` of it has `units` and `meanings` by column, the
        time of a tick, the units of time and length, the world as a layout, and the spec as TOML.
        Raises Refusal.
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
        """Write it as CSV, as `--record x.csv` does; returns the rows. Raises Refusal.

        What messages on their way tell, in saved states, is left out: it is a list in each row.
        """
        import pyarrow.parquet as pq

        names = [name for name in self.names if name != PAST]
        with (
            writing("--csv", path, overwrite, (SHEET,)) as out,
            pq.ParquetFile(self.source) as file,
        ):
            schema = file.schema_arrow
            for name in set(self.names) - set(names):
                schema = schema.remove(schema.get_field_index(name))
            with table_writer(Path(path), out, schema) as writer:
                for batch in file.iter_batches(columns=names):
                    writer.write_batch(batch.cast(schema))
        return self.rows

    def described(self) -> dict[str, Any]:
        """What it holds, as JSON has it."""
        first, last = int(self.ticks[0]), int(self.ticks[-1])
        return {
            "recording": str(self.path),
            "model": self.model,
            "title": self.title,
            "seed": self.spec.seed,
            "frames": len(self.ticks),
            "first_tick": first,
            "last_tick": last,
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
