"""`flockscope fit`: parameters of models from tracks, with what the tracks can and cannot tell."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from app.cli.sweep.run import RunnerOptions
from app.cli.terminal.console import make_console
from app.cli.terminal.outcome_table import as_json, print_stderr, print_written_files
from app.cli.terminal.progress import runs_progress
from app.cli.terminal.usage import (
    PrintJson,
    Quiet,
    Rules,
    Settings,
    model_name,
    with_option_groups,
)
from app.cli.tracks.reading_choice import Files, ReadingChoice
from app.results_folder import RESULTS

if TYPE_CHECKING:
    from app.tracks.fit.fit_api import AnyResult
    from app.tracks.fit.fit_request import FitRequest

Seconds = float | None


@dataclass(frozen=True)
class FitOptions:
    """How models are fitted, as options."""

    method: Annotated[
        Literal["one-step", "likelihood", "abc"],
        typer.Option(
            help="one-step: prediction by the model's own rule; likelihood: of the Vicsek family; "
            "abc: whole runs, where frames are too far apart."
        ),
    ] = "one-step"
    length: Annotated[
        float | None,
        typer.Option(help="One length of the model, in m, or px of tracks in pixels. "
                     "\\[default: 1 m]"),
    ] = None  # fmt: skip
    tick_frames: Annotated[int, typer.Option(help="Frames that a tick takes.")] = 1
    frame_ticks: Annotated[int, typer.Option(help="Ticks that a frame takes, of abc.")] = 1
    window: Annotated[
        Seconds, typer.Option(help="s, of the smoothing; 0: none. \\[default: 7 frames]")
    ] = None
    second_window: Annotated[
        Seconds, typer.Option(help="s, of the smoothing of the second fit. \\[default: 11 frames]")
    ] = None
    least_speed: Annotated[
        float, typer.Option(help="Below it an individual has no heading, unit/s.")
    ] = 0.0
    headings: Annotated[
        Literal["velocity", "file"], typer.Option(help="Where headings are from.")
    ] = "velocity"
    fit_frames: Annotated[
        int | None,
        typer.Option(help="Frames of the fit, and as many held back. \\[default: 40; 150; 20]"),
    ] = None
    shuffles: Annotated[
        int, typer.Option(help="How often headings are shuffled in time and fitted.")
    ] = 5
    runs: Annotated[int, typer.Option(help="Runs of abc.")] = 1000
    synthetic: Annotated[
        int, typer.Option(help="Synthetic truths that are fitted at each of five noises.")
    ] = 0
    seed: Annotated[int, typer.Option(help="Of what is shuffled, drawn and simulated.")] = 1


@with_option_groups
def fit(
    files: Files,
    *,
    model: Annotated[
        list[str] | None, typer.Option("--model", help="A model; may be repeated: they compete.")
    ] = None,
    parameters: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAMES",
            help="What is looked for, as dr_o,dr_a or dr_o=0:15:16 (low, high, steps).",
        ),
    ] = None,
    settings: Settings = None,
    rule: Rules = None,
    options: FitOptions,
    reading: ReadingChoice,
    out: Annotated[
        Path | None,
        typer.Option(help="Folder of evaluations and pictures. \\[default: results/fit-NAME]"),
    ] = None,
    runner: RunnerOptions,
    json_asked: PrintJson = False,
    quiet: Quiet = False,
) -> None:
    """Fit models to tracks, and say what the tracks can tell of their parameters.

    The rule that everybody keeps its heading stands beside each model, and so do headings shuffled
    in time: a model that does not beat both, on frames held back, explains nothing. Call it again
    to go on after a stop.
    """
    from app.results_folder import demand_folder
    from app.settings import assignment
    from app.studies.workers.process_executor import cores
    from app.tracks.fit.fit_api import fit_request, split_names
    from app.tracks.fit.fit_files import write_fit
    from app.tracks.fit.fit_request import FitRequest
    from app.tracks.fit.fit_study import FitStoppedError, RunnerSettings

    runner.check()
    request = FitRequest(
        models=tuple(str(model_name(name)) for name in (model or rule or ())),
        parameters=split_names(parameters or ()),
        settings=dict(map(assignment, settings or ())),
        method=options.method,
        every=options.tick_frames,
        ticks=options.frame_ticks,
        length=options.length,
        window=options.window,
        second_window=options.second_window,
        frames=options.fit_frames,
        least_speed=options.least_speed,
        use_file_headings=options.headings == "file",
        shuffles=options.shuffles,
        runs=options.runs,
        seed=options.seed,
    )
    request.fitted()  # a wrong name is told before a large file is read
    tracks = reading.read(files, quiet)
    stem = re.sub(r"[^\w.-]+", "-", Path(tracks.name).stem) or "tracks"
    folder = out or RESULTS / f"fit-{stem}"
    demand_folder("--out", folder, (), True)
    told = None if quiet else print_stderr
    with runs_progress(folder.name, folder, quiet) as progress:
        try:
            result = fit_request(
                tracks,
                request,
                folder,
                RunnerSettings(
                    runner.workers or cores(), runner.nice, runner.limit, told, progress.update
                ),
                options.synthetic,
            )
        except FitStoppedError:
            print_stderr(f"not all cells are evaluated; the same command goes on in {folder}")
            return
    written = write_fit(result, folder)
    report(result, request, json_asked, written)
    if not quiet:
        print_stderr(f"{result.evaluated} cells evaluated, {result.taken} taken from {folder}")
        print_written_files(*written)


def report(result: AnyResult, request: FitRequest, json_asked: bool, written: list[Path]) -> None:
    """Print the sentences and the table, or all as JSON."""
    if json_asked:
        values = result.to_dict() | {
            "settings": dict(request.settings),
            "files": [str(path) for path in written],
        }
        typer.echo(as_json(values))
        return
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    from app.tracks.fit.fit_files import format_table

    head, *rows = format_table(result)
    table = Table(*head, box=SIMPLE_HEAD, title="on frames held back", title_justify="left")
    for row in rows:
        table.add_row(*row)
    console = make_console()
    for line in result.sentences():
        console.print(line, markup=False, highlight=False, soft_wrap=True)
    console.print(table)
