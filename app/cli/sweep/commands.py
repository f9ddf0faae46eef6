"""`flockscope sweep`: many runs, over what one chooses."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated, Any

import typer

from app.cli.sweep.run import run
from app.cli.sweep.show import show
from app.cli.sweep.sweep_choice import Name, SweepOptions, find_sweep_folder, is_sweep
from app.cli.terminal.console import one_line
from app.cli.terminal.outcome_table import as_json, print_written_files
from app.cli.terminal.usage import PrintJson, command_group, with_option_groups
from app.results_folder import RESULTS
from worlds.input_error import InputError
from worlds.number_text import counted, duration

# `flockscope sweep check`: all cells checked, and what they will take; nothing is run.


@with_option_groups
def check(
    what: Annotated[str, typer.Argument(help="FILE.toml, or a MODEL with --vary.")],
    options: SweepOptions,
    json_asked: PrintJson = False,
) -> None:
    """Check every cell of a sweep. Print how many runs it has and how long they take.

    The first ticks of some cells are timed; nothing is kept.
    """
    from app.studies.sweeps.estimate import describe_other_worlds, estimate
    from app.studies.workers.process_executor import cores

    sweep, _ = options.read(what, None)
    result = estimate(sweep)
    warnings = describe_other_worlds(sweep)
    if json_asked:
        value = result.value | {
            "title": sweep.title,
            "axes": sweep.axes,
            "columns": sweep.making.columns,
            "warnings": warnings,
            "cores": cores(),
        }
        typer.echo(as_json(value))
        return
    more = f" to {result.most_runs}" if result.most_runs > result.runs else ""
    least = duration(result.seconds / cores())
    typer.echo(
        f"{sweep.title}: {counted(result.cells, 'cell')}, {result.runs}{more} runs of "
        f"{sweep.making.ticks} ticks{' at most' if sweep.making.until else ''}"
    )
    typer.echo(
        f"about {least} on {counted(cores(), 'core')}"
        f"{' if no run ends before' if sweep.making.until else ''}, {size(result.bytes)} on disk"
    )
    typer.echo(f"measured: {', '.join(sweep.making.columns) or 'series only'}")
    for line in warnings:
        typer.echo(f"flockscope: {line}", err=True)


def size(count: int) -> str:
    """Bytes for people.

    >>> size(900), size(2_500_000)
    ('1 kB', '2.5 MB')
    """
    for unit, scale in (("GB", 1e9), ("MB", 1e6)):
        if count >= scale:
            return f"{count / scale:.1f} {unit}"
    return f"{max(1, round(count / 1e3))} kB"


# `flockscope sweep list`: the sweeps in a folder, and how far each is.


def list_sweeps(
    folder: Annotated[Path, typer.Option("--in", help="Where to look.")] = RESULTS,
    json_asked: PrintJson = False,
) -> None:
    """List sweeps and their progress."""
    from app.studies.sweeps.sweep_table import status_of

    paths = sorted(folder.iterdir()) if folder.is_dir() else []
    statuses = []
    for sweep in filter(is_sweep, paths):
        try:
            statuses.append(status_of(sweep))
        except Exception as error:  # whatever one store holds, the others are listed
            typer.echo(one_line(f"flockscope: {sweep} is left out: {error}"), err=True)
    if json_asked:
        typer.echo(as_json({"sweeps": statuses}))
        return
    if not statuses:
        typer.echo(f"no sweep in {folder}/")
    for status in statuses:
        name = one_line(Path(status["folder"]).name)
        broken = status["runs"]["failed"] + status["runs"]["killed"]
        failed = f", {broken} failed" if broken else ""
        typer.echo(f"{name}: {status['state']}, {status['done']} of {status['of']} runs{failed}")


# `flockscope sweep status`: how far a sweep is, also while another process runs it.


def status(
    name: Name,
    json_asked: PrintJson = False,
) -> None:
    """Show how many runs are done, how long the rest takes, and what failed."""
    from app.studies.sweeps.sweep_table import status_of

    value = status_of(find_sweep_folder(name))
    typer.echo(as_json(value) if json_asked else describe_progress(value))


def describe_progress(value: dict[str, Any]) -> str:
    """How far it is, for people."""
    counts = value["runs"]
    lines = [f"{value['title']}: {value['state']}, {value['done']} of {value['of']} runs"]
    parts = [
        f"{counts[status_name]} {word}"
        for status_name, word in WORDS.items()
        if counts[status_name]
    ]
    if parts:
        lines.append(", ".join(parts))
    if value["rate"] is not None:
        time_left = duration(value["seconds_left"])
        lines.append(f"{value['rate']:.3g} runs a second, {time_left} left (pid {value['pid']})")
    if value["others"]:
        lines.append(f"{value['others']} runs of other cells or versions are in the store too")
    return "\n".join(lines)


WORDS = {"ok": "ok", "gave-up": "gave up", "failed": "failed", "killed": "killed"}


# `flockscope sweep stop`: have the process that runs a sweep stop; what is finished stays.

TIMEOUT = 30.0
"""Seconds to wait for it."""


def stop(
    name: Name,
    quiet: Annotated[bool, typer.Option("--quiet", help="Say nothing.")] = False,
) -> None:
    """Stop a sweep that another process runs; `flockscope sweep run` goes on with it."""
    from app.studies.runs.store import is_locked
    from app.studies.study_runner import STOP

    folder = find_sweep_folder(name)
    if not is_locked(folder):
        raise InputError(f"no process runs {str(folder)!r}")
    (folder / STOP).touch()
    end = time.monotonic() + TIMEOUT
    while is_locked(folder):
        if time.monotonic() > end:
            raise InputError(f"{str(folder)!r} has not stopped within {TIMEOUT:g} s")
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
    from app.studies.sweeps.sweep_table import measured_columns

    if (beta is None) != (nu is None) or (critical is not None and beta is None):
        raise InputError("a collapse takes --beta and --nu, and --critical beside them")
    scaling = None if beta is None or nu is None else Scaling(beta, nu, critical)
    reader = StoreReader(find_sweep_folder(name))
    column = observable or next(iter(measured_columns(reader)), "picture")
    path = out or reader.folder / f"{column.replace('/', '-')}.png"
    draw(
        reader, path, observable,
        kind=kind, x=x, y=y, where=where, snapshots=snapshots, scaling=scaling,
        overwrite=overwrite or out is None,
    )  # fmt: skip
    if not quiet:
        print_written_files(path)


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
    from app.studies.sweeps.sweep_table import long_table as in_long
    from app.studies.sweeps.sweep_table import wide_table as in_wide

    if long and times:
        raise InputError(
            "--times cannot be given with --long: seconds are of a run, not of a value"
        )
    reader = StoreReader(find_sweep_folder(name))
    columns = in_long(reader) if long else in_wide(reader, times)
    if out is None:
        typer.echo(as_csv(columns), nl=False)
        return
    write_table(columns, out, overwrite)
    if not quiet:
        print_written_files(out)


sweep = command_group(
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
