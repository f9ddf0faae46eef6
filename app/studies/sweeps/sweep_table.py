"""The runs of a sweep as a table, in the order of its plan, or by cell, as charts take them."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from agents.spec import Spec
from app.studies.charts.run_group import CellRuns
from app.studies.run_axes import AxisModels, spec_with
from app.studies.runs.database import BROKEN, FIXED
from app.studies.runs.store import is_locked
from app.studies.runs.store_reader import StoreReader
from app.studies.sweeps.sweep_file import Condition
from app.studies.sweeps.sweep_job import HEADS
from worlds.file_writer import csv_text, writing
from worlds.input_error import InputError, shorten, unknown
from worlds.plug_ins import demand


def status_of(folder: Path) -> dict[str, Any]:
    """How far the sweep of a folder is. Raises InputError."""
    reader = StoreReader(folder)
    state, counts = reader.state, reader.counts
    running = is_locked(folder)
    progress = state.get("progress") if running else None
    return {
        "folder": str(folder),
        "title": state.get("title", ""),
        "state": "running" if running else "stopped" if is_unfinished(state, counts) else "done",
        "runs": counts,
        "done": sum(counts.values()),
        "of": state.get("runs"),
        "others": reader.others,
        "rate": progress and progress.get("rate"),
        "seconds_left": progress and progress.get("seconds_left"),
        "workers": progress and progress.get("workers"),
        "pid": progress and progress.get("pid"),
    }


def is_unfinished(state: dict[str, Any], counts: dict[str, int]) -> bool:
    """Whether there are runs to make."""
    return bool(state.get("runs", 0) > sum(counts.values()))


Columns = dict[str, list[Any]]
ENDINGS = (".csv", ".parquet", ".pq")
CELL = "place"
"""The column of a cell's place in the plan, from 1."""


def wide_table(reader: StoreReader, times: bool = False) -> Columns:
    """A row for each run: its cell and axes, seed and status, and what was measured.

    `times`: with the seconds that it took, which are others every time.
    """
    columns, axes = measured_columns(reader), axes_of(reader)
    cells, places = reader.cells, places_of(reader)
    table: Columns = {name: [] for name in (CELL, *axes, *FIXED[1:], *columns)}
    for cell, *row in reader.runs(columns):
        table[CELL].append(places[cell])
        for axis in axes:
            table[axis].append(cells[cell]["axes"].get(axis))
        for name, value in zip((*FIXED[1:], *columns), row, strict=True):
            table[name].append(value)
    if not times:
        del table["seconds"]
    return table


def long_table(reader: StoreReader) -> Columns:
    """A row for each value: of a run at its end, and of a series at each of its ticks."""
    columns, axes = measured_columns(reader), axes_of(reader)
    cells, places = reader.cells, places_of(reader)
    table: Columns = {
        name: [] for name in (CELL, *axes, "seed", "status", "observable", "tick", "value")
    }
    at = {name: number for number, name in enumerate((*FIXED, *columns))}
    statuses: dict[tuple[int, int], str] = {}

    def add(cell: int, seed: int, name: str, tick: int, value: Any) -> None:
        table[CELL].append(places[cell])
        for axis in axes:
            table[axis].append(cells[cell]["axes"].get(axis))
        row = (seed, statuses[cell, seed], name, tick, value)
        for column, entry in zip(
            ("seed", "status", "observable", "tick", "value"), row, strict=True
        ):
            table[column].append(entry)

    for row in reader.runs(columns):
        cell, seed = row[0], row[1]
        statuses[cell, seed] = row[at["status"]]
        for name in columns:
            add(cell, seed, name, row[at["ticks"]], row[at[name]])
    for cell, seed, name, ticks, values in reader.series():
        if (cell, seed) not in statuses:  # of a run that came after the runs were read
            continue
        for tick, value in zip(ticks.tolist(), values.tolist(), strict=True):
            add(cell, seed, name, tick, None if value != value else value)
    return table


def measured_columns(reader: StoreReader) -> list[str]:
    """What the runs of the plan have one value of, in its order."""
    columns = reader.columns
    return [name for name in reader.state.get("columns", columns) if name in columns]


def axes_of(reader: StoreReader) -> list[str]:
    """The axes of the plan, in its order. Raises InputError for one that is named as a column
    is."""
    axes = list(reader.state.get("axes", []))
    for axis in axes:
        if axis in HEADS or axis in reader.columns:
            raise InputError(
                f"{str(reader.path)!r} makes no table: its axis {shorten(axis)} has the name of "
                "another column"
            )
    return axes


def models_of(reader: StoreReader) -> AxisModels:
    """The models that all cells run; "" for flocks of several, or where a file does not say it."""
    tables = [models_of_cell(cell) for cell in reader.cells.values()]
    flocks = {models.flock for models in tables}
    kinds = {name: model for models in tables for name, model in models.kinds.items()}
    return AxisModels(flocks.pop() if len(flocks) == 1 else "", kinds)


def models_of_cell(cell: Any) -> AxisModels:
    """The models of a cell as a file has it, whoever made that file."""
    identity = cell.get("identity") if isinstance(cell, dict) else None
    return AxisModels.of_table(identity.get("spec") if isinstance(identity, dict) else None)


def places_of(reader: StoreReader) -> dict[int, int]:
    """The place of each cell in the plan, from 1."""
    return {number: place for place, number in enumerate(reader.cells, 1)}


def as_csv(columns: Mapping[str, list[Any]]) -> str:
    """A table as CSV: floats so that they come back to the bit, nothing where there is no value."""
    return csv_text(columns, zip(*columns.values(), strict=True))


def as_arrow(columns: Mapping[str, list[Any]]) -> Any:
    """A table as pyarrow has it. Raises InputError where that is not installed."""
    demand("pyarrow", "a table of runs", "experiments")
    import pyarrow as pa

    return pa.table({name: array_of(values) for name, values in columns.items()})


def array_of(values: list[Any]) -> Any:
    """A column as an array: whole numbers become numbers where there are both, else text."""
    import pyarrow as pa

    kinds = {type(value) for value in values if value is not None}
    if kinds == {int, float}:
        return pa.array([None if value is None else float(value) for value in values], pa.float64())
    if len(kinds) > 1:
        return pa.array([None if value is None else str(value) for value in values], pa.string())
    return pa.array(values)


def write_table(columns: Mapping[str, list[Any]], path: Path, overwrite: bool) -> None:
    """Write a table as its ending says. Raises InputError."""
    if path.suffix.lower() == ".csv":
        data = as_csv(columns).encode()
        with writing("table", path, overwrite, ENDINGS) as file:
            file.write(data)
        return
    if path.suffix.lower() not in ENDINGS:
        raise InputError(
            f"table {str(path)!r} is not allowed: its name has to end in {', '.join(ENDINGS)}"
        )
    table = as_arrow(columns)
    import pyarrow.parquet as pq

    with writing("table", path, overwrite, ENDINGS) as file:
        pq.write_table(table, file)


def spec_at(reader: StoreReader, place: int, seed: int) -> Spec:
    """The run of a cell by its place in the plan. Raises InputError."""
    cells = list(reader.cells.values())
    if not 1 <= place <= len(cells):
        raise InputError(f"cell {place} is not allowed: a number from 1 to {len(cells)} is needed")
    state = reader.state
    if "base" not in state:
        raise InputError(
            f"{str(reader.folder)!r} is no sweep but a paper's table: its runs have no spec"
        )
    base = Spec.from_toml(state["base"], f"base of {reader.folder}")
    return spec_with(base, cells[place - 1]["axes"]).but(seed=seed)


# The runs of a sweep cell by cell, for charts and tables of means.


def groups_of(
    reader: StoreReader, observable: str | None, where: str = ""
) -> tuple[str, list[CellRuns]]:
    """The observable that is shown, the first by default, and the cells with runs. Or
    InputError."""
    columns, axes = measured_columns(reader), axes_of(reader)
    if not columns:
        raise InputError("there is nothing with one value for each run: export the series instead")
    name = columns[0] if observable is None else observable
    if name not in columns:
        raise unknown("observable", name, columns, str(reader.folder))
    condition = Condition(where, axes) if where else None
    values, seeds = defaultdict(list), defaultdict(list)
    gave_up, broken = Counter[int](), Counter[int]()
    for cell, seed, status, *_, value in reader.runs([name]):
        if status in BROKEN:
            broken[cell] += 1
        elif status == "gave-up":
            gave_up[cell] += 1
        elif value is not None:
            values[cell].append(float(value))
            seeds[cell].append(seed)
    groups = [
        CellRuns(
            {axis: cell["axes"][axis] for axis in axes if axis in cell["axes"]},
            number,
            values[number],
            seeds[number],
            gave_up[number],
            broken[number],
        )
        for number, cell in reader.cells.items()
    ]
    drawn_groups = [
        group
        for group in groups
        if group.has_runs and (condition is None or condition.holds(group.axes))
    ]
    if not drawn_groups:
        raise InputError(f"there is no run to draw yet ({reader.folder})")
    return name, drawn_groups
