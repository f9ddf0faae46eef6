"""Write recordings: positions and headings per tick as Parquet, or as CSV.

The metadata has spec, units and world. While a run lasts its frames go to `NAME.part`, an Arrow
stream that holds every frame written even if the process is killed; at the end it becomes the
Parquet file, or the CSV file, in one move. `recover` does the same for a `.part` that a kill has
left. The columns, what each holds and in which unit, stand first.
"""

from __future__ import annotations

import json
import os
from collections.abc import Collection, Mapping
from contextlib import suppress
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple, Protocol

import numpy as np

from agents.engine.arrays import Arrays
from agents.kind_models import kind_models, own_columns, shared_numbers
from agents.kinds import NO_KINDS, KindTable
from agents.models.declare import NumberParameter, Parameters, declared, describe
from agents.models.model import Model
from agents.recordings.part_stream import PartStream
from agents.snapshot import Snapshot
from agents.spec import CompleteSpec
from agents.state.agent_rows import demand, no_crashes
from agents.state.passages import Passages
from worlds.file_writer import demand_writable, writing
from worlds.input_error import InputError
from worlds.number_text import counted
from worlds.plug_ins import demand_parquet
from worlds.world import World

AXES = "xyz"
PAST = "past"
"""The column of a saved state that holds what messages on their way tell."""
LEG = "leg"
KIND = "kind"
"""The column of the number of each agent's kind, where there are kinds."""
OWN = "own_"
"""Before the name of a parameter: the column that holds each agent's own number of it."""
ENTRIES, EXITS, CATCHES = "entries", "exits", "catches"
"""Keys of the metadata that hold who has come, gone and been caught, where agents do and are."""
MOST_PASSAGES = 300_000
"""Of one file: its metadata stay below what is read of one."""


class Column(NamedTuple):
    """A column, a value for each agent and tick."""

    name: str
    unit: str
    """1 for pure numbers, names and yes or no."""
    meaning: str


def crash_columns(dim: int) -> list[str]:
    """Columns of a crash record: the tick of the crash or -1, what it touched, and where."""
    return ["crash_tick", "crash_cause", *("crash_" + letter for letter in AXES[:dim])]


def columns_of(
    model: Model,
    world: World,
    with_past: bool = False,
    individuals: Collection[str] = (),
    kinds: KindTable = NO_KINDS,
) -> list[Column]:
    """The columns that a run of a model in a world is recorded in, in their order.

    `individuals`: the parameters that differ from agent to agent, or that some have not. `kinds`:
    all kinds of agents.
    """
    length, axes = model.in_units("length"), AXES[: world.dim]
    columns = [
        Column("tick", "ticks", "ticks done since the start"),
        Column("id", "1", "identity of the agent, which keeps it for the whole run"),
        *(Column(axis, length, f"position along {axis}") for axis in axes),
        *(Column("u" + axis, "1", f"heading, a unit vector, along {axis}") for axis in axes),
        Column("speed", model.in_units("length/time"), "speed along the heading"),
        Column("informed", "1", "whether it is an information agent"),
    ]
    if world.mission is not None and world.mission.path is not None:
        columns.append(Column(LEG, "1", "waypoints of the path that it has left behind"))
    if model.body.touches is not None:
        tick, cause, *places = crash_columns(world.dim)
        columns += [
            Column(tick, "ticks", "tick at whose beginning it crashed, -1 while it has not"),
            Column(cause, "1", "what it touched: 1 another agent, 2 an obstacle or a wall, else 0"),
            *(Column(name, length, f"where it crashed, along {name[-1]}") for name in places),
        ]
    models = kind_models(kinds)
    if kinds.kinds:
        numbers = ", ".join(f"{number} {name}" for number, name in enumerate(kinds.names))
        by_models = "".join(f"; {one.kind.name} goes by {one.model.name}" for one in models)
        meaning = f"its kind: {numbers}; -1 caught, stands still{by_models}"
        columns.append(Column(KIND, "1", meaning))
    described: set[str] = set()
    for one_model in (model, *(one.model for one in models)):
        for declaration in declared(one_model.parameters):
            if declaration.name in individuals and declaration.name not in described:
                described.add(declaration.name)
                meaning = f"the agent's own: {declaration.description}"
                if models:
                    meaning += "; nan where its model has none"
                columns.append(Column(OWN + declaration.name, declaration.unit, meaning))
    columns += [Column(name, model.unit_of(name), kind(model, name)) for name in model.columns]
    if with_past:
        columns.append(Column(PAST, "1", "what messages on their way tell"))
    return columns


def kind(model: Model, name: str) -> str:
    """What one of a model's own columns is."""
    if name in model.signals:
        return "what agents tell each other"
    return "what an agent keeps to itself" if name in model.rule.memory else "measured of the agent"


KEY = b"flockscope"
FORMAT = 2
"""1 had no units, no time of a tick and only the name of a built-in world."""
STATES = (".parquet", ".pq")
"""Endings of states, which hold the run's spec too."""
SHEET = ".csv"
"""The ending of a recording as plain numbers, without the spec: no run can go on from it."""
RECORDINGS = (*STATES, SHEET)
FLUSH_ROWS = 20_000
"""Rows that may be in flight before they are written to the disk."""


class RecordableFlock(Protocol):
    """What a recorder needs of a flock."""

    @property
    def spec(self) -> CompleteSpec: ...
    def snapshot(self, copy: bool = True, signals: bool = False) -> Snapshot: ...


class Recorder:
    """Writes frames of a flock to a Parquet or a CSV file; a context manager.

    `path` ends in one of `endings`; a file is replaced if `overwrite`. `with_past`: whether what is
    on its way is written too, where messages take time. Leaving it by an exception other than
    KeyboardInterrupt removes the `.part` and leaves no file. Raises InputError if the file cannot
    be written. When the disk is full the frames that fitted are kept: as the recording, or in the
    `.part` if there is no room for it beside.
    """

    def __init__(
        self,
        path: str | Path,
        flock: RecordableFlock,
        overwrite: bool = True,
        endings: Collection[str] = RECORDINGS,
        with_past: bool = False,
    ):
        self.path = Path(path)
        self.part = self.path.with_name(self.path.name + ".part")
        self.flock = flock
        self.overwrite = overwrite
        self.endings = endings
        self.with_past = with_past
        self.waiting: list = []
        self.rows = 0
        self.frames = 0
        self.flushed = 0, 0, 0
        """What is on the disk: frames, their last tick, bytes of the `.part`."""
        self.over = False

    def __enter__(self) -> Recorder:
        demand_parquet(f"recording {str(self.path)!r}")
        import pyarrow as pa

        snapshot = self.snapshot()
        schema = batch_of(snapshot, self.with_past).schema
        meta = metadata(self.flock.spec, snapshot, schema.names)
        schema = schema.with_metadata({KEY: json.dumps(meta).encode()})
        demand_writable("recording", self.path, self.overwrite, self.endings)
        if self.part.exists():
            raise InputError(
                f"{self.part} is left from a run that was killed: "
                f"`flockscope recover {self.part}` makes a recording of it, or delete it"
            )
        try:
            self.file = open(self.part, "xb")
        except OSError as error:
            raise refused(self.path, error) from None
        self.stream = pa.ipc.new_stream(self.file, schema)
        return self

    def __exit__(self, kind, error, trace) -> None:
        if self.over:
            return
        if kind is not None and not issubclass(kind, KeyboardInterrupt):
            self.discard()
            return
        try:
            self.flush()
            self.stream.close()
            self.file.close()
        except OSError as failure:
            raise self.cut_off(failure) from None
        try:
            finish(self.part, self.path, self.overwrite, describe_passages(self.snapshot()))
        except InputError as failure:
            raise InputError(
                f"{failure}; every frame is in {self.part}: `flockscope recover {self.part}` once "
                "that is mended"
            ) from None

    def cut_off(self, failure: OSError) -> InputError:
        """End the recording where the disk took no more; returns the line that reports it."""
        self.over = True
        with suppress(OSError):
            self.file.close()
        reason = refused(self.path, failure)
        frames, tick, size = self.flushed
        if not frames:
            self.discard()
            return reason
        remainder = f"{counted(frames, 'frame')} that fitted, the last of tick {tick}"
        try:
            with open(self.part, "r+b") as file:
                file.truncate(size)
            passages = describe_passages(self.snapshot(), tick)
            finish(self.part, self.path, self.overwrite, passages)
        except (OSError, InputError):
            return InputError(
                f"{reason}; {self.part} holds {remainder}: `flockscope recover {self.part}` "
                "makes a recording of them once there is room"
            )
        return InputError(f"{reason}; it holds {remainder}")

    def discard(self) -> None:
        """Delete the unfinished recording."""
        with suppress(OSError):
            self.file.close()
        self.part.unlink(missing_ok=True)

    def snapshot(self) -> Snapshot:
        """The flock now, with what agents tell each other; its arrays are the flock's own."""
        return self.flock.snapshot(copy=False, signals=True)

    def write(self) -> None:
        """Record the flock as it is now. Raises InputError."""
        batch = batch_of(self.snapshot(), self.with_past)
        self.waiting.append(batch)
        self.rows += batch.num_rows
        self.frames += 1
        if self.rows >= FLUSH_ROWS:
            try:
                self.flush()
            except OSError as error:
                raise self.cut_off(error) from None

    def flush(self) -> None:
        """Write waiting frames to the disk."""
        import pyarrow as pa

        if self.waiting:
            table = pa.Table.from_batches(self.waiting).combine_chunks()
            self.stream.write_table(table)
            self.file.flush()
            last = self.waiting[-1].column("tick")[0].as_py()
            self.flushed = self.frames, last, self.file.tell()
        self.waiting, self.rows = [], 0


def batch_of(flock: Snapshot, with_past: bool = False):
    """A snapshot as a record batch with one row per agent, copies."""
    import pyarrow as pa

    n = len(flock.ids)
    columns = {"tick": np.full(n, flock.tick), "id": flock.ids.copy()}
    for axis, letter in enumerate(AXES[: flock.world.dim]):
        columns[letter] = flock.position[:, axis].copy()
    for axis, letter in enumerate(AXES[: flock.world.dim]):
        columns["u" + letter] = flock.heading[:, axis].copy()
    columns["speed"] = flock.speed.copy()
    columns["informed"] = flock.informed.copy()
    if flock.world.mission is not None and flock.world.mission.path is not None:
        columns[LEG] = flock.arrays.leg.copy()
    if flock.can_crash:
        crash_record = flock.arrays.crash_record
        columns |= {
            name: crash_record[:, k].copy() for k, name in enumerate(crash_columns(flock.world.dim))
        }
    if flock.kinds.kinds:
        columns[KIND] = flock.arrays.kind.astype(np.int8)
    own, names = flock.own, flock.own_columns
    columns |= {OWN + name: own[name].copy() for name in names if name in own}
    for name, values in zip(flock.model.columns, flock.arrays.memory, strict=True):
        columns[name] = values.copy()
    past = flock.arrays.past
    if with_past and past.size:
        flat = pa.array(past.ravel())
        columns[PAST] = pa.FixedSizeListArray.from_arrays(flat, past.shape[1] * past.shape[2])
    return pa.RecordBatch.from_pydict(columns)


def metadata(spec: CompleteSpec, snapshot: Snapshot, names: Collection[str]) -> dict[str, Any]:
    """What a reader needs beside the columns of these names: run, time, units, world."""
    return {
        "format": FORMAT,
        "spec": spec.to_toml(),
        "next_id": snapshot.next_id,
        **describe_columns(
            snapshot.model,
            snapshot.world,
            snapshot.dt,
            PAST in names,
            snapshot.differing,
            snapshot.kinds,
        ),
    }


def describe_columns(
    flock_model: Model,
    world: World,
    dt: float,
    with_past: bool,
    individuals: Collection[str] = (),
    kinds: KindTable = NO_KINDS,
) -> dict[str, Any]:
    """Model, time, units and world of a recording, as JSON has them."""
    return {
        "model": flock_model.name,
        "title": flock_model.title,
        "time_per_tick": dt,
        "time_unit": flock_model.body.unit,
        "length_unit": flock_model.in_units("length"),
        "columns": {
            name: {"unit": unit, "meaning": meaning}
            for name, unit, meaning in columns_of(flock_model, world, with_past, individuals, kinds)
        },
        "world_name": world.name,
        "world": world.to_layout(),
    }


def describe_passages(flock: Snapshot, tick: int | None = None) -> dict[str, Any]:
    """Who has come, gone and been caught by a tick, by default by now, as JSON has it; empty
    without gates and without hunters.

    Of more than can be read again it holds nothing, as if it were not known.
    """
    if len(flock.entries) + len(flock.exits) + len(flock.catches) > MOST_PASSAGES:
        return {}
    last = flock.tick if tick is None else tick
    passages: dict[str, Passages] = {}
    if flock.world.has_gates:
        passages |= {ENTRIES: flock.entries, EXITS: flock.exits}
    if flock.kinds.catchers:
        passages[CATCHES] = flock.catches
    return {name: some.until(last).to_table() for name, some in passages.items()}


def refused(path: Path, error: OSError) -> InputError:
    """The refusal for a file that cannot be written."""
    return InputError(f"recording {str(path)!r} cannot be written: {error.strerror or error}")


def finish(
    part: Path,
    path: Path,
    overwrite: bool = True,
    passages: Mapping[str, Any] = MappingProxyType({}),
) -> int:
    """Turn a `.part` stream into the file `path`, Parquet or CSV; returns the rows.

    `passages`: who has come and gone, which is known at the end alone: to be added to the metadata.
    Raises InputError if it cannot be written or is no stream of ours, or OSError if the `.part`
    cannot be read.
    """
    rows = 0
    with open(part, "rb") as source:
        stream = PartStream(part, source)
        schema = stream.schema
        if passages:
            meta = {**json.loads(schema.metadata[KEY]), **passages}
            schema = schema.with_metadata({KEY: json.dumps(meta).encode()})
        with (
            writing("recording", path, overwrite, RECORDINGS) as file,
            table_writer(path, file, schema) as writer,
        ):
            for batch in stream.batches(FLUSH_ROWS):
                writer.write_batch(batch)
                rows += batch.num_rows
    part.unlink()
    return rows


def table_writer(path: Path, file, schema):
    """What writes batches to a file in the form that its ending says."""
    if path.suffix.lower() == SHEET:
        from pyarrow.csv import CSVWriter

        return CSVWriter(file, schema)
    from pyarrow.parquet import ParquetWriter

    return ParquetWriter(file, schema, compression="zstd")


def recover(part: str | Path) -> tuple[Path, int]:
    """Make a recording of what a killed run has left; returns its path and its rows.

    Raises InputError if `part` is no such file, or the recording exists already.
    """
    demand_parquet(f"recovering {str(part)!r}")
    part = Path(part)
    path = part.with_suffix("")
    if part.suffix != ".part":
        raise InputError(f"{str(part)!r} is not a .part file of a recording")
    if os.path.lexists(path):
        raise InputError(f"{str(path)!r} exists already: move it away first")
    try:
        return path, finish(part, path, overwrite=False)
    except OSError as error:
        raise InputError(f"{str(part)!r} cannot be recovered: {error.strerror or error}") from None


def arrays_of(table, dim: int, flock_model: Model, origin: str) -> Arrays:
    """The arrays of one tick of a recording. Raises InputError if columns are missing."""
    axes = AXES[:dim]
    try:
        column = {name: table[name].to_numpy(zero_copy_only=False) for name in table.column_names}
        unrecorded = dict.fromkeys(flock_model.rule.written, np.zeros(table.num_rows))
        signals = [(unrecorded | column)[name] for name in flock_model.columns]
        mortal = flock_model.body.touches is not None
        crash_record = [column[name] for name in crash_columns(dim)] if mortal else []
        arrays = Arrays(
            np.column_stack([column[a] for a in axes]),
            np.column_stack([column["u" + a] for a in axes]),
            column["speed"].copy(),
            column["informed"].astype(np.bool_),
            column["id"].copy(),
            column.get(LEG, np.zeros(table.num_rows, np.int32)).astype(np.int32),
            np.array(signals, float).reshape(len(signals), table.num_rows),
            np.column_stack(crash_record) if mortal else no_crashes(0, dim),
            past_of(column.get(PAST), table.num_rows, 2 * dim + 1 + len(flock_model.signals)),
            own=np.empty((table.num_rows, 0)),
        )
    except KeyError as missing:
        raise InputError(f"{origin} has no column {missing}") from None
    return Arrays._make(np.ascontiguousarray(array) for array in arrays)


def own_names(names: Collection[str], model: Model, kinds: KindTable) -> tuple[str, ...]:
    """The parameters of which a table of these columns has each agent's own number."""
    return tuple(name for name in own_columns(model, kind_models(kinds)) if OWN + name in names)


def own_of(
    table: Any,
    model: Model,
    parameters: Parameters,
    origin: str,
    kinds: KindTable = NO_KINDS,
    kind: np.ndarray | None = None,
) -> np.ndarray:
    """The agents' own parameters (N, Q), `Arrays.own`, from the columns of a table.

    `kind`: the number of each agent's, of all `kinds`. Raises InputError naming the row for a
    number outside of its range, and for one of a parameter that the agent's model has not.
    """
    names = own_names(table.column_names, model, kinds)
    if not names and not kinds.kinds:
        return np.empty((table.num_rows, 0))
    models, n = kind_models(kinds), table.num_rows
    numbers = np.zeros(n) if kind is None or not len(kind) else kind
    own = shared_numbers(model, parameters, kinds, numbers)
    columns = own_columns(model, models)
    of_others = np.isin(numbers, [one.number for one in models])
    # Of who was caught and stands still nobody knows which kind it was of.
    is_caught = (numbers < 0.0) & bool(models)
    for name in names:
        column = table[OWN + name].to_numpy(zero_copy_only=False).astype(float)
        is_sound = np.isnan(column) | (is_caught & np.isfinite(column))
        allowed = ""
        for one, rows in (
            (model, ~of_others & ~is_caught),
            *((each.model, numbers == each.number) for each in models),
        ):
            if name in one.individual:
                declaration = describe(name, one.parameters.model_fields[name])
                assert isinstance(declaration, NumberParameter)
                low, high = declaration.bounds
                is_sound[rows] = ((column >= low) & (column <= high))[rows]
                allowed = allowed or declaration.allowed
        demand(is_sound, f"a {name} outside of {allowed}", origin)
        own[:, columns.index(name)] = column
    return own


def kind_of(table, kinds: int, origin: str) -> np.ndarray:
    """The number of each agent's kind (N,), of so many beside the ordinary one, or (0,).

    Raises InputError for a number that is none, and where the column is missing.
    """
    if not kinds:
        return np.empty(0)
    if KIND not in table.column_names:
        raise InputError(f"{origin} has no column {KIND!r}")
    kind: np.ndarray = table[KIND].to_numpy(zero_copy_only=False).astype(float)
    demand(np.isin(kind, np.arange(-1, kinds + 1)), "a kind that there is not", origin)
    return kind


def past_of(rows, n: int, size: int) -> np.ndarray:
    """The flock's past (n, ticks, size) from its column, no ticks without one. Raises KeyError."""
    if rows is None:
        return np.empty((n, 0, 0))
    try:
        return np.stack(rows).reshape(n, -1, size)
    except ValueError:
        raise KeyError(f"{PAST!r} of {size} numbers a tick") from None
