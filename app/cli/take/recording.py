"""`flockscope recording`: what a recording holds, and its numbers as CSV."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from app.cli.outcome_table import as_json, tell_written
from app.cli.terminal import visible
from worlds.file_writer import demand_writable
from worlds.input_error import InputError
from worlds.number_text import counted
from worlds.plug_ins import demand_parquet

if TYPE_CHECKING:
    from app.live.recording.recording_replay import StoredRecording


def recording(
    file: Annotated[
        Path, typer.Argument(help="A recording or saved state; of a live run its folder.")
    ],
    csv: Annotated[
        Path | None, typer.Option(help="Write its numbers as CSV, columns as they are listed.")
    ] = None,
    table: Annotated[
        str | None, typer.Option(help="Of a live run: which of its tables to list and to write.")
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Let --csv replace a file.")
    ] = False,
    json_asked: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Show what a recording holds: run, ticks, world, columns with units."""
    demand_parquet(f"reading {str(file)!r}")
    if csv is not None:
        demand_writable("--csv", csv, overwrite, (".csv",))
    if file.is_dir():
        of_live_run(file, table, csv, overwrite, json_asked)
        return
    if table is not None:
        raise InputError(f"--table {table} is not allowed: {str(file)!r} is one table")
    from agents.recordings.recording import Recording

    found = Recording(file)
    made = found.described()
    if csv is not None:
        found.to_csv(csv, overwrite)
    if json_asked:
        typer.echo(as_json(made | ({"csv": str(csv)} if csv else {})))
    else:
        show(made)
    tell_written(csv)


def tell_out(line: str) -> None:
    """A line on stdout with texts of a file in it."""
    typer.echo(visible(line))


def show(made: dict[str, Any]) -> None:
    """Print for people what a recording of a simulation holds."""
    first, last = made["first_tick"], made["last_tick"]
    unit = made["time_unit"]
    seconds = "" if unit == "ticks" else f" = {made['lasts']:g} {unit}"
    a_tick = "" if unit == "ticks" else f", {made['time_per_tick']:g} {unit} a tick"
    size = " x ".join(f"{side:g}" for side in made["size"])
    length = "" if made["length_unit"] == "length" else f" {made['length_unit']}"
    tell_out(
        f"{made['title']} ({made['model']}): {counted(made['agents'], 'agent')} in "
        f"{made['world']} {size}{length}, seed {made['seed']}"
    )
    tell_out(
        f"{counted(made['frames'], 'frame')} of ticks {first} to {last}{seconds}{a_tick}; "
        f"{counted(made['rows'], 'row')}"
    )
    least, most = made["ticks_apart"]
    if least < most:
        tell_out(f"frames are {least} to {most} ticks apart; the end of a run is always recorded")
    show_columns(made["columns"])


def show_columns(columns: dict[str, dict[str, str]]) -> None:
    """Print columns with their units and meanings."""
    wide = max(map(len, columns))
    units = max(len(one["unit"]) for one in columns.values())
    for name, one in columns.items():
        unit = "" if one["unit"] == "1" else one["unit"]
        tell_out(f"  {name:<{wide}}  {unit:<{units}}  {one['meaning']}")


def of_live_run(
    folder: Path, table: str | None, csv: Path | None, overwrite: bool, json_asked: bool
) -> None:
    """The same of a recording of real cars, a folder of tables. Raises InputError."""
    from app.live.recording.recording_replay import read
    from app.live.recording.recording_writer import columns_of

    recorded = read(folder)
    if table is not None:
        recorded.demand_table(table)
    if csv is not None:
        if table is None:
            raise InputError(f"--csv {csv}: which --table? One of {', '.join(recorded.tables)}")
        recorded.to_csv(table, csv, overwrite)
    made = about(recorded)
    shown = [table] if table else list(recorded.tables)
    if json_asked:
        typer.echo(as_json(made | ({"csv": str(csv)} if csv else {})))
    else:
        low, high = recorded.lab.area.low, recorded.lab.area.high
        tell_out(
            f"{recorded.lab.title or folder}: {counted(len(recorded.lab.cars), 'car')}, rule "
            f"{recorded.lab.rule}, {high[0] - low[0]:g} x {high[1] - low[1]:g} m, "
            f"{made['time_per_tick']:g} s a tick"
        )
        for name in shown:
            typer.echo(f"{name}: {counted(made['tables'][name]['rows'], 'row')}")
            show_columns(columns_of(name))
    tell_written(csv)


def about(recorded: StoredRecording) -> dict[str, Any]:
    """What a recording of real cars holds, as JSON has it."""
    from app.live.recording.recording_writer import columns_of, described

    return {
        "recording": str(recorded.folder),
        **described(recorded.lab),
        "began": recorded.began,
        "parts": len(recorded.parts),
        "cars": list(recorded.lab.cars),
        "tables": {
            name: {"rows": recorded.rows(name), "columns": columns_of(name)}
            for name in recorded.tables
        },
        "laboratory": recorded.lab.to_toml(),
    }
