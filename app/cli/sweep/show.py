"""`flockscope sweep show`: what the runs say cell by cell, which failed, and one run as a spec."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any

import typer

from app.cli.sweep.sweep_choice import Name, find_sweep_folder
from app.cli.terminal.console import make_console
from app.cli.terminal.outcome_table import as_json
from app.cli.terminal.usage import PrintJson
from worlds.input_error import InputError

if TYPE_CHECKING:
    from app.studies.runs.store_reader import StoreReader

MOST = 60
"""Cells that are shown to people."""
FAULTS = 20
"""Failed runs that are named to people."""


def show(
    name: Name,
    cell: Annotated[int | None, typer.Option(help="A cell, by its number in the table.")] = None,
    seed: Annotated[int | None, typer.Option(help="A seed: print this run as a spec.")] = None,
    json_asked: PrintJson = False,
) -> None:
    """Show the mean and interval of each cell, and the runs that failed.

    With --cell and --seed it prints the spec of that run: `flockscope run FILE.toml` repeats it.
    """
    from app.studies.runs.store_reader import StoreReader
    from app.studies.sweeps.sweep_table import spec_at

    reader = StoreReader(find_sweep_folder(name))
    if seed is not None:
        if cell is None:
            raise InputError("--seed needs --cell: of which cell is the run?")
        typer.echo(spec_at(reader, cell, seed).to_toml(), nl=False)
        return
    rows = summaries(reader)
    if cell is not None:
        if not 1 <= cell <= len(rows):
            raise InputError(
                f"--cell {cell} is not allowed: a number from 1 to {len(rows)} is needed"
            )
        rows = [rows[cell - 1]]
    if json_asked:
        typer.echo(as_json({"folder": str(reader.folder), "cells": rows, "failed": faults(reader)}))
    else:
        show_cells(reader, rows)


def summary_of(reader: StoreReader) -> None:
    """Print what the runs say, for people."""
    show_cells(reader, summaries(reader))


def summaries(reader: StoreReader) -> list[dict[str, Any]]:
    """Each cell with the mean and the interval of what was measured, and runs without a value."""
    from app.studies.sweeps.sweep_table import groups_of, measured_columns, places_of

    places = places_of(reader)
    rows: list[dict[str, Any]] = [
        {"cell": places[number], "axes": cell["axes"], "runs": 0, "gave_up": 0, "failed": 0}
        for number, cell in reader.cells.items()
    ]
    at = dict(zip(reader.cells, rows, strict=True))
    for column in measured_columns(reader):
        try:
            groups = groups_of(reader, column)[1]
        except InputError:
            break
        for group in groups:
            row = at[group.number]
            row["gave_up"], row["failed"] = group.gave_up, group.broken
            row["runs"] = max(row["runs"], len(group.values))
            row[column] = {"mean": group.mean, "half_interval": group.half}
    return rows


def faults(reader: StoreReader) -> list[dict[str, Any]]:
    """The runs that failed or were killed: cell, seed, why."""
    from app.studies.runs.database import BROKEN
    from app.studies.sweeps.sweep_table import places_of

    places = places_of(reader)
    return [
        {"cell": places[cell], "seed": seed, "status": status, "reason": reason}
        for cell, seed, status, reason, *_ in reader.runs([])
        if status in BROKEN
    ]


def show_cells(reader: StoreReader, rows: list[dict[str, Any]]) -> None:
    """Print the cells as a table, and the runs that failed."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    from app.studies.sweeps.sweep_table import axes_of, measured_columns

    axes, columns = axes_of(reader), measured_columns(reader)
    extra = [key for key in ("gave_up", "failed") if any(row[key] for row in rows)]
    table = Table(
        "cell", *axes, "runs", *(key.replace("_", " ") for key in extra), *columns,
        title=str(reader.state.get("title", "")), title_justify="left", box=SIMPLE_HEAD,
    )  # fmt: skip
    for row in rows[:MOST]:
        cells = [str(row["cell"]), *(format_axis_value(row["axes"].get(axis)) for axis in axes)]
        cells += [str(row["runs"]), *(str(row[key] or "") for key in extra)]
        cells += [interval(row.get(column)) for column in columns]
        table.add_row(*cells)
    console = make_console()
    console.print(table)
    for line in describe_axes(reader, axes):
        console.print(line, markup=False)
    if len(rows) > MOST:
        console.print(f"and {len(rows) - MOST} more cells: `flockscope sweep export` has them all")
    failures = faults(reader)
    for failure in failures[:FAULTS]:
        console.print(
            f"cell {failure['cell']}, seed {failure['seed']}: {failure['status']}: "
            f"{failure['reason']}",
            markup=False,
        )
    if len(failures) > FAULTS:
        console.print(f"and {len(failures) - FAULTS} more failed runs")


def describe_axes(reader: StoreReader, axes: list[str]) -> Iterator[str]:
    """What each axis is that is no plain option or parameter, with its unit."""
    from app.studies.run_axes import axis_label
    from app.studies.sweeps.sweep_table import models_of

    models = models_of(reader)
    for axis in axes:
        label = axis_label(models.of_axis(axis), axis)
        if label:
            yield f"{axis}: {label}"


def format_axis_value(value: Any) -> str:
    """A value of an axis."""
    if isinstance(value, float):
        return f"{value:.6g}"
    return "" if value is None else str(value)


def interval(summary: dict[str, float] | None) -> str:
    """A mean with half of its interval."""
    if summary is None or summary["mean"] != summary["mean"]:
        return "-"
    half = summary["half_interval"]
    return f"{summary['mean']:.4g}" + (f" ± {half:.2g}" if half == half else "")
