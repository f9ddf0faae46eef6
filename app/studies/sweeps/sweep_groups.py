"""The runs of a sweep cell by cell, for charts and tables of means."""

from __future__ import annotations

from collections import Counter, defaultdict

from app.studies.charts.run_group import CellRuns
from app.studies.runs.database import BROKEN
from app.studies.runs.store_reader import StoreReader
from app.studies.sweeps.sweep_file import Condition
from app.studies.sweeps.sweep_table import axes_of, measured_columns
from worlds.input_error import InputError, unknown


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
