"""`flockscope sweep`: many runs, over what one chooses."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from app.cli.outcome_table import as_json, tell_written
from app.cli.sweep.run import check, run
from app.cli.sweep.sweep_choice import is_sweep, kept_sweep
from app.cli.terminal import make_console, one_line
from app.cli.usage import grouped
from app.results_folder import RESULTS
from worlds.input_error import InputError
from worlds.number_text import duration

if TYPE_CHECKING:
    from app.studies.runs.store_reader import StoreReader

# `flockscope sweep list`: the sweeps in a folder, and how far each is.


def list_sweeps(
    folder: Annotated[Path, typer.Option("--in", help="Where to look.")] = RESULTS,
    json_asked: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """List sweeps and their progress."""
    from app.studies.sweeps.sweep_table import status_of

    there = sorted(folder.iterdir()) if folder.is_dir() else []
    found = []
    for sweep in filter(is_sweep, there):
        try:
            found.append(status_of(sweep))
        except Exception as error:  # whatever one store holds, the others are listed
            typer.echo(one_line(f"flockscope: {sweep} is left out: {error}"), err=True)
    if json_asked:
        typer.echo(as_json({"sweeps": found}))
        return
    if not found:
        typer.echo(f"no sweep in {folder}/")
    for one in found:
        name = one_line(Path(one["folder"]).name)
        broken = one["runs"]["failed"] + one["runs"]["killed"]
        failed = f", {broken} failed" if broken else ""
        typer.echo(f"{name}: {one['state']}, {one['done']} of {one['of']} runs{failed}")


# `flockscope sweep status`: how far a sweep is, also while another process runs it.

Name = Annotated[str, typer.Argument(help="A sweep in results/, or its folder.")]


def status(
    name: Name,
    json_asked: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Show how many runs are done, how long the rest takes, and what failed."""
    from app.studies.sweeps.sweep_table import status_of

    value = status_of(kept_sweep(name))
    typer.echo(as_json(value) if json_asked else in_words(value))


def in_words(value: dict[str, Any]) -> str:
    """How far it is, for people."""
    counts = value["runs"]
    said = [f"{value['title']}: {value['state']}, {value['done']} of {value['of']} runs"]
    parts = [f"{counts[one]} {word}" for one, word in WORDS.items() if counts[one]]
    if parts:
        said.append(", ".join(parts))
    if value["rate"] is not None:
        time_left = duration(value["seconds_left"])
        said.append(f"{value['rate']:.3g} runs a second, {time_left} left (pid {value['pid']})")
    if value["others"]:
        said.append(f"{value['others']} runs of other cells or versions are kept beside")
    return "\n".join(said)


WORDS = {"ok": "ok", "gave-up": "gave up", "failed": "failed", "killed": "killed"}


# `flockscope sweep stop`: have the process that runs a sweep stop; what is finished stays.

TIMEOUT = 30.0
"""Seconds to wait for it."""


def stop(
    name: Name,
    quiet: Annotated[bool, typer.Option("--quiet", help="Say nothing.")] = False,
) -> None:
    """Stop a sweep that another process runs; `flockscope sweep run` goes on with it."""
    from app.studies.runs.store import is_taken
    from app.studies.sweeps.sweep_runner import STOP

    folder = kept_sweep(name)
    if not is_taken(folder):
        raise InputError(f"no process runs {str(folder)!r}")
    (folder / STOP).touch()
    end = time.monotonic() + TIMEOUT
    while is_taken(folder):
        if time.monotonic() > end:
            raise InputError(
                f"{str(folder)!r} has not stopped within {TIMEOUT:g} s: it was asked to"
            )
        time.sleep(0.1)
    if not quiet:
        typer.echo(f"stopped: {folder}", err=True)


# `flockscope sweep plot`: the picture of an observable, also while the sweep runs.


def plot(
    name: Name,
    observable: Annotated[
        str | None, typer.Option(help="What is shown. \\[default: the first that is measured]")
    ] = None,
    kind: Annotated[
        str | None,
        typer.Option(
            help="lines, map, points, distribution or scaling. \\[default: what suits the axes]"
        ),
    ] = None,
    x: Annotated[str | None, typer.Option(help="The axis along the picture.")] = None,
    y: Annotated[str | None, typer.Option(help="The axis up a map.")] = None,
    where: Annotated[
        str, typer.Option(help="Only cells for which this holds: 'agents == 50'.")
    ] = "",
    snapshots: Annotated[
        bool, typer.Option("--snapshots", help="Draw the flock of each cell into a map.")
    ] = False,
    beta: Annotated[
        float | None, typer.Option(help="Exponent of the collapse in a picture of scaling.")
    ] = None,
    nu: Annotated[float | None, typer.Option(help="The other exponent.")] = None,
    critical: Annotated[
        float | None,
        typer.Option(
            help="Where the transition is. \\[default: where Binder's cumulants of the two largest "
            "sizes cross]"
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(help="PNG, SVG or PDF by its ending. \\[default: a PNG beside the runs]"),
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace the file that --out names.")
    ] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="Do not name the file.")] = False,
) -> None:
    """Draw lines with 95 % bands, a map over two axes, a sample's points, or distributions.

    Cells with runs that gave up or failed are marked; such runs are in no mean. Scaling takes an
    axis 'agents': a line for each size, Binder's cumulant if 'binder' is observed, and with --beta
    and --nu the collapse.
    """
    from app.studies.charts.scaling import Scaling
    from app.studies.runs.store_reader import StoreReader
    from app.studies.sweeps.sweep_picture import draw
    from app.studies.sweeps.sweep_table import measured

    if (beta is None) != (nu is None) or (critical is not None and beta is None):
        raise InputError("a collapse takes --beta and --nu, and --critical beside them")
    scaling = None if beta is None or nu is None else Scaling(beta, nu, critical)
    kept = StoreReader(kept_sweep(name))
    shown = observable or next(iter(measured(kept)), "picture")
    path = out or kept.folder / f"{shown.replace('/', '-')}.png"
    draw(
        kept, path, observable,
        kind=kind, x=x, y=y, where=where, snapshots=snapshots, scaling=scaling,
        overwrite=overwrite or out is None,
    )  # fmt: skip
    if not quiet:
        tell_written(path)


# `flockscope sweep export`: the runs as CSV or Parquet, in the order of the plan.


def export(
    name: Name,
    out: Annotated[
        Path | None,
        typer.Argument(help="FILE.csv or FILE.parquet. \\[default: CSV on stdout]"),
    ] = None,
    long: Annotated[
        bool, typer.Option("--long", help="A row for each value and tick, series among them.")
    ] = False,
    times: Annotated[
        bool, typer.Option("--times", help="With the seconds that each run took.")
    ] = False,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace the file.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="Do not name the file.")] = False,
) -> None:
    """Write the runs as a table: a row for each run, or with --long for each value.

    Without --times the same runs are the same bytes, however often the sweep was stopped.
    """
    from app.studies.runs.store_reader import StoreReader
    from app.studies.sweeps.sweep_table import as_csv, write_table
    from app.studies.sweeps.sweep_table import long as in_long
    from app.studies.sweeps.sweep_table import wide as in_wide

    if long and times:
        raise InputError(
            "--times cannot be given with --long: seconds are of a run, not of a value"
        )
    kept = StoreReader(kept_sweep(name))
    columns = in_long(kept) if long else in_wide(kept, times)
    if out is None:
        typer.echo(as_csv(columns), nl=False)
        return
    write_table(columns, out, overwrite)
    if not quiet:
        tell_written(out)


# `flockscope sweep show`: what the runs say cell by cell, which failed, and one run as a spec.

MOST = 60
"""Cells that are shown to people."""
FAULTS = 20
"""Failed runs that are named to people."""


def show(
    name: Name,
    cell: Annotated[int | None, typer.Option(help="A cell, by its number in the table.")] = None,
    seed: Annotated[int | None, typer.Option(help="A seed: print this run as a spec.")] = None,
    json_asked: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Show the mean and interval of each cell, and the runs that failed.

    With --cell and --seed it prints the spec of that run: `flockscope run FILE.toml` repeats it.
    """
    from app.studies.runs.store_reader import StoreReader
    from app.studies.sweeps.sweep_table import spec_at

    kept = StoreReader(kept_sweep(name))
    if seed is not None:
        if cell is None:
            raise InputError("--seed needs --cell: of which cell is the run?")
        typer.echo(spec_at(kept, cell, seed).to_toml(), nl=False)
        return
    rows = summaries(kept)
    if cell is not None:
        if not 1 <= cell <= len(rows):
            raise InputError(
                f"--cell {cell} is not allowed: a number from 1 to {len(rows)} is needed"
            )
        rows = [rows[cell - 1]]
    if json_asked:
        typer.echo(as_json({"folder": str(kept.folder), "cells": rows, "failed": faults(kept)}))
    else:
        show_cells(kept, rows)


def summary_of(kept: StoreReader) -> None:
    """Print what the runs say, for people."""
    show_cells(kept, summaries(kept))


def summaries(kept: StoreReader) -> list[dict[str, Any]]:
    """Each cell with the mean and the interval of what was measured, and runs without a value."""
    from app.studies.sweeps.sweep_groups import groups_of
    from app.studies.sweeps.sweep_table import measured, places_of

    places = places_of(kept)
    rows: list[dict[str, Any]] = [
        {"cell": places[number], "axes": one["axes"], "runs": 0, "gave_up": 0, "failed": 0}
        for number, one in kept.cells.items()
    ]
    at = dict(zip(kept.cells, rows, strict=True))
    for column in measured(kept):
        try:
            groups = groups_of(kept, column)[1]
        except InputError:
            break
        for group in groups:
            row = at[group.number]
            row["gave_up"], row["failed"] = group.gave_up, group.broken
            row["runs"] = max(row["runs"], len(group.values))
            row[column] = {"mean": group.mean, "half_interval": group.half}
    return rows


def faults(kept: StoreReader) -> list[dict[str, Any]]:
    """The runs that failed or were killed: cell, seed, why."""
    from app.studies.runs.database import BROKEN
    from app.studies.sweeps.sweep_table import places_of

    places = places_of(kept)
    return [
        {"cell": places[cell], "seed": seed, "status": status, "reason": reason}
        for cell, seed, status, reason, *_ in kept.runs([])
        if status in BROKEN
    ]


def show_cells(kept: StoreReader, rows: list[dict[str, Any]]) -> None:
    """Print the cells as a table, and the runs that failed."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    from app.studies.sweeps.sweep_table import axes_of, measured

    axes, columns = axes_of(kept), measured(kept)
    extra = [key for key in ("gave_up", "failed") if any(row[key] for row in rows)]
    table = Table(
        "cell", *axes, "runs", *(key.replace("_", " ") for key in extra), *columns,
        title=str(kept.state.get("title", "")), title_justify="left", box=SIMPLE_HEAD,
    )  # fmt: skip
    for row in rows[:MOST]:
        cells = [str(row["cell"]), *(plain(row["axes"].get(axis)) for axis in axes)]
        cells += [str(row["runs"]), *(str(row[key] or "") for key in extra)]
        cells += [interval(row.get(column)) for column in columns]
        table.add_row(*cells)
    console = make_console()
    console.print(table)
    if len(rows) > MOST:
        console.print(f"and {len(rows) - MOST} more cells: `flockscope sweep export` has them all")
    found = faults(kept)
    for one in found[:FAULTS]:
        console.print(
            f"cell {one['cell']}, seed {one['seed']}: {one['status']}: {one['reason']}",
            markup=False,
        )
    if len(found) > FAULTS:
        console.print(f"and {len(found) - FAULTS} more failed runs")


def plain(value: Any) -> str:
    """A value of an axis."""
    if isinstance(value, float):
        return f"{value:.6g}"
    return "" if value is None else str(value)


def interval(found: dict[str, float] | None) -> str:
    """A mean with half of its interval."""
    if found is None or found["mean"] != found["mean"]:
        return "-"
    half = found["half_interval"]
    return f"{found['mean']:.4g}" + (f" ± {half:.2g}" if half == half else "")


sweep = grouped(
    "Sweeps: many runs over parameters, kept whatever happens; look at them at any time.",
    {
        "run": run,
        "check": check,
        "status": status,
        "show": show,
        "plot": plot,
        "export": export,
        "stop": stop,
        "list": list_sweeps,
    },
)
