"""`flockscope sweep export`: the runs as CSV or Parquet, in the order of the plan."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from app.cli.outcome_table import tell_written
from app.cli.sweep.status import Name
from app.cli.sweep.sweep_choice import kept_sweep
from worlds.input_error import InputError


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
    from app.experiments.runs.store_reader import StoreReader
    from app.experiments.sweeps.sweep_table import as_csv, write_table
    from app.experiments.sweeps.sweep_table import long as in_long
    from app.experiments.sweeps.sweep_table import wide as in_wide

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
