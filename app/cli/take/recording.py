"""`flockscope recording` shows and exports a recording; `recover` saves that of a killed run."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from app.cli.terminal.console import visible
from app.cli.terminal.outcome_table import as_json, print_written_files
from app.cli.terminal.usage import PrintJson
from worlds.file_writer import demand_writable
from worlds.input_error import InputError
from worlds.number_text import counted
from worlds.plug_ins import demand_parquet

if TYPE_CHECKING:
    from app.live.recording.recording_replay import StoredRecording
import json


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
    json_asked: PrintJson = False,
) -> None:
    """Show what a recording holds: run, ticks, world, columns with units."""
    demand_parquet(f"reading {str(file)!r}")
    if csv is not None:
        demand_writable("--csv", csv, overwrite, (".csv",))
    if file.is_dir():
        show_live_recording(file, table, csv, overwrite, json_asked)
        return
    if table is not None:
        raise InputError(f"--table {table} is not allowed: {str(file)!r} is one table")
    from agents.recordings.recording import Recording

    recording = Recording(file)
    description = recording.described()
    if csv is not None:
        recording.to_csv(csv, overwrite)
    if json_asked:
        typer.echo(as_json(description | ({"csv": str(csv)} if csv else {})))
    else:
        show(description)
    print_written_files(csv)


def print_stdout(line: str) -> None:
    """A line on stdout with texts of a file in it."""
    typer.echo(visible(line))


def show(description: dict[str, Any]) -> None:
    """Print for people what a recording of a simulation holds."""
    first, last = description["first_tick"], description["last_tick"]
    unit = description["time_unit"]
    seconds = "" if unit == "ticks" else f" = {description['lasts']:g} {unit}"
    a_tick = "" if unit == "ticks" else f", {description['time_per_tick']:g} {unit} a tick"
    size = " x ".join(f"{side:g}" for side in description["size"])
    length = "" if description["length_unit"] == "length" else f" {description['length_unit']}"
    print_stdout(
        f"{description['title']} ({description['model']}): "
        f"{counted(description['agents'], 'agent')} in "
        f"{description['world']} {size}{length}, seed {description['seed']}"
    )
    print_stdout(
        f"{counted(description['frames'], 'frame')} of ticks {first} to {last}{seconds}{a_tick}; "
        f"{counted(description['rows'], 'row')}"
    )
    least, most = description["ticks_apart"]
    if least < most:
        print_stdout(
            f"frames are {least} to {most} ticks apart; the end of a run is always recorded"
        )
    show_columns(description["columns"])


def show_columns(columns: dict[str, dict[str, str]]) -> None:
    """Print columns with their units and meanings."""
    wide = max(map(len, columns))
    units = max(len(column_types["unit"]) for column_types in columns.values())
    for name, column_types in columns.items():
        unit = "" if column_types["unit"] == "1" else column_types["unit"]
        print_stdout(f"  {name:<{wide}}  {unit:<{units}}  {column_types['meaning']}")


def show_live_recording(
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
    description = describe_live_recording(recorded)
    table_names = [table] if table else list(recorded.tables)
    if json_asked:
        typer.echo(as_json(description | ({"csv": str(csv)} if csv else {})))
    else:
        low, high = recorded.lab.area.low, recorded.lab.area.high
        print_stdout(
            f"{recorded.lab.title or folder}: {counted(len(recorded.lab.cars), 'car')}, rule "
            f"{recorded.lab.rule}, {high[0] - low[0]:g} x {high[1] - low[1]:g} m, "
            f"{description['time_per_tick']:g} s a tick"
        )
        for name in table_names:
            typer.echo(f"{name}: {counted(description['tables'][name]['rows'], 'row')}")
            show_columns(columns_of(name))
    print_written_files(csv)


def describe_live_recording(recorded: StoredRecording) -> dict[str, Any]:
    """What a recording of real cars holds, as JSON has it."""
    from app.live.recording.recording_writer import columns_of, lab_metadata

    return {
        "recording": str(recorded.folder),
        **lab_metadata(recorded.lab),
        "began": recorded.began,
        "parts": len(recorded.parts),
        "cars": list(recorded.lab.cars),
        "tables": {
            name: {"rows": recorded.rows(name), "columns": columns_of(name)}
            for name in recorded.tables
        },
        "laboratory": recorded.lab.to_toml(),
    }


# `flockscope recover`: the recording of a run that was killed.


def recover(
    file: Annotated[
        Path, typer.Argument(help="The .part file that the run has left; of a live run its folder.")
    ],
    as_json: PrintJson = False,
) -> None:
    """Save the recording of a killed run from its .part file, or its folder."""
    if file.is_dir():
        from app.cli.live.commands import recover as recover_live

        recover_live(file, as_json)
        return
    from agents.recordings.recorder import recover as recover_part

    path, rows = recover_part(file)
    if as_json:
        typer.echo(json.dumps({"recording": str(path), "rows": rows}))
    else:
        typer.echo(f"{path}: {counted(rows, 'row')}")
