"""`flockscope sensitivity`: which parameter matters, from the runs of a sweep."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from app.cli.sweep.run import (
    BROKEN,
    AsJson,
    Drawn,
    Overwrite,
    Quiet,
    RunnerOptions,
    carry_out_sweep,
    print_warnings,
)
from app.cli.terminal.console import make_console
from app.cli.terminal.outcome_table import as_json, print_stderr, print_written_files
from app.cli.terminal.usage import with_option_groups
from app.results_folder import PICTURES

if TYPE_CHECKING:
    from app.studies.sensitivity.sensitivity_result import Sensitivity


@with_option_groups
def sensitivity(
    what: Annotated[str, typer.Argument(help="FILE.toml, or a sweep to go on with.")],
    *,
    observable: Annotated[
        str | None, typer.Option(help="What is analysed. \\[default: all that is measured]")
    ] = None,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the sweep. \\[default: results/NAME]")
    ] = None,
    picture: Drawn = None,
    overwrite: Overwrite = False,
    runner: RunnerOptions,
    json_asked: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Make the missing runs of a sweep. Say which of its axes matters most.

    FILE.toml is that of a sweep, with one design of kind saltelli, for Sobol's indices, or morris,
    for elementary effects. What is measured is a mean over seeds that all cells have in common.
    """
    from app.cli.sweep.sweep_choice import read_complete_sweep
    from app.figure import ENDINGS
    from app.studies.runs.store_reader import StoreReader
    from app.studies.sensitivity.sensitivity_api import draw
    from app.studies.sensitivity.sensitivity_result import analyse, design_of
    from worlds.file_writer import demand_writable
    from worlds.input_error import unknown

    runner.check()
    sweep, own = read_complete_sweep(what, None if quiet else print_stderr)
    folder = out or own
    design_of(sweep)
    if observable is not None and observable not in sweep.making.columns:
        raise unknown("observable", observable, sweep.making.columns, what)
    if picture is not None:
        demand_writable("--picture", picture, overwrite, ENDINGS)
    if not quiet:
        print_warnings(sweep)
    done = carry_out_sweep(sweep, folder, runner, quiet)
    if done.broken:
        print_stderr(
            f"flockscope: {done.broken} runs failed: flockscope sweep show {folder} names them"
        )
        raise typer.Exit(BROKEN)
    if not done.whole:
        print_stderr(f"not all runs are made; go on with: flockscope sensitivity {folder}")
        return
    sensitivities = analyse(sweep, StoreReader(folder), observable)
    names = [f"sensitivity.{kind}" for kind in PICTURES]
    files = [picture] if picture is not None else [folder / name for name in names]
    for path in files:
        draw(sensitivities, sweep.title, path)
    if json_asked:
        value: dict[str, Any] = {
            "folder": str(folder),
            "title": sweep.title,
            "made": done.made,
            "taken": done.taken,
            "sensitivity": [sensitivity.value for sensitivity in sensitivities],
            "files": [str(path) for path in files],
        }
        typer.echo(as_json(value))
    else:
        show(sensitivities, sweep.title)
    if not quiet:
        print_written_files(*files)


def show(sensitivities: list[Sensitivity], title: str) -> None:
    """Print a table and sentences for each thing that is measured."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    from app.studies.sensitivity.sensitivity_result import describe_index

    console = make_console()
    for sensitivity in sensitivities:
        total, alone = sensitivity.symbols
        spread = ["sigma"] if sensitivity.kind == "morris" else []
        table = Table(
            "axis", total, alone, *spread, box=SIMPLE_HEAD,
            title=f"{title}: {sensitivity.observable}", title_justify="left",
        )  # fmt: skip
        for row in sensitivity.influences:
            more = [f"{row.spread:.2f}"] if row.spread is not None else []
            table.add_row(row.axis, describe_index(row.total), describe_index(row.alone), *more)
        console.print(table)
        for pair in sensitivity.pairs:
            console.print(f"S_2 of {' and '.join(pair.axes)}: {describe_index(pair.index)}")
        for line in sensitivity.words():
            console.print(line, markup=False, highlight=False, soft_wrap=True)
