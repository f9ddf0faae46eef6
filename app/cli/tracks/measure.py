"""`flockscope tracks measure`: all that is measured of tracks, as a report in a folder."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import typer

from app.cli.terminal.console import visible
from app.cli.terminal.outcome_table import as_json, print_stderr, print_written_files
from app.cli.terminal.progress import Progress
from app.cli.terminal.usage import PrintJson, Quiet, with_option_groups
from app.cli.tracks.reading_choice import Files, ReadingChoice
from worlds.input_error import InputError
from worlds.number_text import duration

LONG = 5.0
"""Seconds from which an estimate is told before the work."""


@dataclass(frozen=True)
class MeasuringOptions:
    """How tracks are measured, as options."""

    window: Annotated[
        float | None,
        typer.Option(
            help="s, window of velocities and headings; 0: differences between frames. "
            "\\[default: 5 frames]"
        ),
    ] = None
    least: Annotated[int, typer.Option(help="Individuals that a frame's value is of.")] = 5
    least_speed: Annotated[
        float, typer.Option(help="Below it an individual has no heading, unit/s.")
    ] = 0.0
    headings: Annotated[
        Literal["velocity", "file"], typer.Option(help="Where headings are from.")
    ] = "velocity"
    reach: Annotated[
        float | None,
        typer.Option(help="Who is of one group. \\[default: 3 distances to the nearest neighbour]"),
    ] = None
    map_reach: Annotated[
        float | None,
        typer.Option(help="Half the side of the maps. \\[default: 6 of these distances]"),
    ] = None
    longest_delay: Annotated[float, typer.Option(help="s, up to which followers are seen.")] = 2.0
    neighbours: Annotated[int, typer.Option(help="Ranks of neighbours in the structure.")] = 20
    walkable: Annotated[
        str, typer.Option(metavar="WKT", help="Where people walk, m. \\[default: from the file]")
    ] = ""
    area: Annotated[
        str, typer.Option(metavar="WKT", help="Where density is measured. \\[default: the same]")
    ] = ""
    line: Annotated[str, typer.Option(metavar="WKT", help="Across which flow is counted.")] = ""


@with_option_groups
def measure(
    files: Files,
    *,
    all_asked: Annotated[
        bool, typer.Option("--all", help="Measure all that these tracks have. \\[default]")
    ] = False,
    only: Annotated[
        str | None, typer.Option(metavar="NAMES", help="Only these, as polarisation,leadership.")
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(help="Folder for page, PDF and tables. \\[default: numbers on the screen]"),
    ] = None,
    options: MeasuringOptions,
    reading: ReadingChoice,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Replace a report in --out.")
    ] = False,
    json_asked: PrintJson = False,
    quiet: Quiet = False,
) -> None:
    """Measure tracks: order, spacing, maps, leaders, structure; of crowds density and flow.

    A value of a frame is of those who are seen in it; how many there are stands beside it, and so
    do the window and the noise of velocities. What these tracks do not have is named.
    """
    from app.tracks.measure_report import (
        demand_report_folder,
        describe_report,
        json_value,
        measure_tracks,
        write_report,
    )
    from app.tracks.measures.measure_catalogue import choose_measures
    from app.tracks.measures.track_measure import MeasureOptions

    names = [name.strip() for name in only.split(",")] if only is not None else None
    if names is not None and all_asked:
        raise InputError(f"--all and --only {only} are not allowed together")
    chosen = [measure.name for measure in choose_measures(names)]
    if out is not None:
        demand_report_folder(out, chosen, overwrite)
    tracks = reading.read(files, json_asked or quiet)
    is_told = False

    def tell(share: float, left: float, name: str) -> None:
        nonlocal is_told
        if not is_told and left > LONG and not quiet:
            print_stderr(f"measuring {tracks.name}: about {duration(left)}")
        is_told = True
        progress.update(share, None if share > 0.02 else left, name)

    with Progress(tracks.name, quiet) as progress:
        report = measure_tracks(
            tracks, names,
            MeasureOptions(
                options.least, options.reach, options.map_reach, options.longest_delay,
                options.neighbours, options.walkable, options.area, options.line,
            ),
            window=options.window, least_speed=options.least_speed,
            use_file_headings=options.headings == "file", tell=tell,
        )  # fmt: skip
        written: list[Path] = []
        if out is not None:
            progress.begun = progress.told  # of the charts alone
            written = write_report(report, out, overwrite, tell)
    if json_asked:
        value = json_value(report.value())
        typer.echo(as_json(value | {"files": [str(path) for path in written]}))
    else:
        typer.echo("\n".join(map(visible, describe_report(report))))
    if out is not None and not quiet:
        print_written_files(out / "report.html", out / "report.pdf")
