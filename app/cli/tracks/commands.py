"""`flockscope tracks`: what trackers of animals, people and robots write, read and looked at."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from app.cli.terminal.console import visible
from app.cli.terminal.outcome_table import as_json, print_written_files
from app.cli.terminal.usage import Overwrite, PrintJson, Quiet, command_group, with_option_groups
from app.cli.tracks.reading_choice import Files, ReadingChoice
from worlds.number_text import counted


@with_option_groups
def info(
    files: Files,
    reading: ReadingChoice,
    json_asked: PrintJson = False,
) -> None:
    """Show what tracks hold: individuals, frames, rate, unit, extent, gaps.

    The format is told by what is in the file. What it does not say is asked for.
    """
    from app.tracks.track_checks import describe_tracks

    told = describe_tracks(reading.read(files, json_asked))
    if json_asked:
        typer.echo(as_json(told))
    else:
        show_info(told)


def show_info(told: dict[str, Any]) -> None:
    """Print for people what tracks hold."""
    from app.tracks.readers.reader_catalogue import readers

    unit = told["unit"]
    typer.echo(visible(f"{told['name']}: {readers()[told['format']].title}"))
    first, last, seconds = told["first_frame"], told["last_frame"], told["seconds"]
    rate = "" if told["rate"] is None else f"{told['rate']:.6g} a second"
    uneven = "" if told["even"] else ", not evenly apart"
    typer.echo(
        f"{counted(told['individuals'], 'individual')}, {counted(told['frames'], 'frame')} "
        f"({first} to {last}, {seconds:.6g} s, {rate}{uneven})"
    )
    sides = " x ".join(
        f"{low:.5g} to {high:.5g}" for low, high in zip(told["low"], told["high"], strict=True)
    )
    more = ["heading"] * told["heading"] + ["confidence"] * told["confidence"]
    more += ["boundary"] * told["boundary"] + ["a box that wraps"] * bool(told["period"])
    typer.echo(f"places in {unit}: {sides}{'; with ' + ', '.join(more) if more else ''}")
    least, median, most = told["seen_at_once"]
    typer.echo(
        f"{told['seen']:.1%} of the table is filled; {least} to {most} at once, {median:g} in the "
        "median"
    )
    typer.echo(
        f"{counted(told['gaps'], 'gap')}, the longest of {counted(told['longest_gap'], 'frame')}; "
        f"{told['filled']} places interpolated"
    )
    for row in told["dropped"]:
        typer.echo(visible(f"dropped: {counted(row['rows'], 'row')}, {row['reason']}"))
    for note in told["notes"]:
        typer.echo(visible(f"note: {note}"))


# `flockscope tracks check`: what may be wrong.


@with_option_groups
def check(
    files: Files,
    reading: ReadingChoice,
    json_asked: PrintJson = False,
) -> None:
    """Flag what may be wrong: swaps, jumps, two names on one body, rows at rest.

    Nothing is changed, and what is flagged may be right: look at the video.
    """
    from dataclasses import asdict

    from app.tracks.track_checks import check_tracks

    report = check_tracks(reading.read(files, json_asked))
    if json_asked:
        flags = [asdict(flag) for flag in report.flags]
        typer.echo(as_json({"name": report.tracks.name, "flags": flags, "info": report.values}))
    else:
        show_info(report.values)
        for flag in report.flags:
            typer.echo(visible(f"{flag.kind}: {flag.text}"))
            for case in flag.cases:
                typer.echo(visible(f"  {case_text(case)}"))
        if report.is_sound:
            typer.echo("nothing is flagged")


def case_text(case: dict[str, Any]) -> str:
    """A case for people.

    >>> case_text({"frame": 7, "ids": ["a", "b"], "apart": 2.5})
    'frame 7: a and b, apart 2.5'
    """
    words = []
    if "ids" in case:
        words.append(" and ".join(map(str, case["ids"])))
    words += [f"{name} {value:g}" for name, value in case.items() if name not in ("frame", "ids")]
    start = f"frame {case['frame']}: " if "frame" in case else ""
    return start + ", ".join(words)


# `flockscope tracks convert`: the same tracks as a table that needs no option.


@with_option_groups
def convert(
    files: Files,
    reading: ReadingChoice,
    out: Annotated[
        Path,
        typer.Option(help="FILE.csv or FILE.parquet, or FILE.sqlite for JuPedSim."),
    ],
    overwrite: Overwrite = False,
    json_asked: PrintJson = False,
    quiet: Quiet = False,
) -> None:
    """Write tracks as a table that is read again without options.

    y points up in it, z in space. Units, rate and world are in its first line or metadata.
    """
    from app.tracks.written_tracks import ENDINGS, write_tracks
    from worlds.file_writer import demand_writable

    demand_writable("--out", out, overwrite, ENDINGS)
    tracks = reading.read(files, json_asked or quiet)
    rows = write_tracks(tracks, out, overwrite)
    if json_asked:
        typer.echo(as_json({"out": str(out), "rows": rows, "unit": tracks.unit}))
    elif not quiet:
        for note in tracks.notes:
            typer.echo(visible(f"note: {note}"), err=True)
        print_written_files(out)


# `flockscope tracks formats`: what can be read.


def formats(json_asked: PrintJson = False) -> None:
    """List the formats that are read, and what each does not say itself."""
    from app.tracks.readers.reader_catalogue import readers

    rows = [
        {
            "name": reader.name,
            "title": reader.title,
            "extensions": list(reader.extensions),
            "needs": list(reader.needs),
            "several": reader.takes_several,
        }
        for reader in readers().values()
    ]
    if json_asked:
        typer.echo(as_json({"formats": rows}))
        return
    wide = max(len(reader.name) for reader in readers().values())
    for reader in readers().values():
        needs = f"; needs {', '.join(reader.needs)}" if reader.needs else ""
        endings = " ".join(reader.extensions)
        typer.echo(f"{reader.name:<{wide}}  {reader.title} ({endings}){needs}")


tracks = command_group(
    "Tracks of real animals, people and robots: read them, look at them, convert them.",
    {
        "info": info,
        "check": check,
        "convert": convert,
        "formats": formats,
    },
)
