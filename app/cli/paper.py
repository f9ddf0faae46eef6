"""`flockscope paper`: a table or a figure of a paper, measured beside published."""

from __future__ import annotations

import shlex
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from app.cli.lookout import ASTRAY
from app.cli.outcome import as_json, tell_written
from app.cli.progress import Progress, duration
from app.cli.refusals import INTERRUPTED
from app.cli.stopping import Stopping
from app.results import demand_folder, picture_files
from app.settings import at_least, names, whole_numbers
from worlds.counting import counted

MOST_RUNS = 100_000
MOST_WORKERS = 1024
RUNS = "runs.csv"

if TYPE_CHECKING:
    from app.experiments.conduct import Done
    from app.experiments.experiment import Experiment


def paper(
    name: Annotated[str, typer.Argument(help="Which one, see `flockscope list papers`.")],
    runs: Annotated[int | None, typer.Option(help="Runs per row. \\[default: the paper's]")] = None,
    agents: Annotated[str, typer.Option(help="Only these sizes of flock: 100,200.")] = "",
    models: Annotated[str, typer.Option(help="Only these models: vem,hwvem.")] = "",
    seed: Annotated[
        int,
        typer.Option(help="Seed of the first run of each row."),
    ] = 1,
    out: Annotated[
        Path | None, typer.Option(help="Folder for runs and pictures. \\[default: results/NAME]")
    ] = None,
    workers: Annotated[int | None, typer.Option(help="Runs at a time. \\[default: cores]")] = None,
    pictures: Annotated[bool, typer.Option(help="Draw the picture as PNG and SVG.")] = True,
    overwrite: Annotated[
        bool,
        typer.Option("--overwrite", help="Replace files of these names that are not of such runs."),
    ] = False,
    json_asked: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="No messages while it runs.")] = False,
) -> None:
    """Repeat a table or a figure of a paper and print it beside the published numbers.

    Finished runs are kept in FOLDER/runs.csv: what is there is not run again. The exit code is 4 if
    an agent of a run was seen inside an obstacle or beyond a solid edge.
    """
    at_least("--seed", seed, 0)
    at_least("--workers", workers, 1, MOST_WORKERS)
    from app.experiments.experiment import read_experiment

    whole = read_experiment(name)
    at_least("--runs", runs, min(2, whole.runs), MOST_RUNS)
    experiment = whole.narrowed(names(models), whole_numbers("--agents", agents))
    folder = out or Path("results") / name
    demand_results(folder, experiment.name, pictures, overwrite)
    begun = time.monotonic()
    done = carried_out(experiment, folder, runs or experiment.runs, seed, workers, quiet)
    seconds = time.monotonic() - begun
    files = {"runs": folder / RUNS, "summary": folder / "summary.csv"}
    report(experiment, done, seed, files, seconds, pictures, json_asked, quiet)
    for line in done.astray:
        tell(f"flockscope: {line}")
    if done.astray:
        raise typer.Exit(ASTRAY)


def demand_results(folder: Path, name: str, pictures: bool, overwrite: bool) -> None:
    """Refuse a folder that cannot be written, before anything is run. Raises Refusal.

    Summary and pictures beside the runs that they are made of are made anew at every call.
    """
    runs = folder / RUNS
    demand_folder("--out", folder, (RUNS,), overwrite=True)
    theirs = ("summary.csv", *picture_files(name, pictures))
    demand_folder("--out", folder, theirs, overwrite or runs.is_file())


def carried_out(
    experiment: Experiment, folder: Path, runs: int, seed: int, workers: int | None, quiet: bool
) -> Done:
    """Carry out the experiment; after Ctrl-C tell how to go on."""
    from app.experiments.conduct import conduct
    from app.experiments.workers.pool import cores

    begun = time.monotonic()
    try:
        with Stopping(at_once=True), Progress(experiment.name, quiet) as progress:
            done = conduct(
                experiment,
                folder,
                runs=runs,
                seed=seed,
                workers=workers or cores(),
                tell=None if quiet else tell,
                at=progress.at,
            )
    except KeyboardInterrupt:
        again = f"flockscope {shlex.join(sys.argv[1:])}"
        kept = folder / RUNS
        tell(f"flockscope: stopped; finished runs are in {kept}; go on with: {again}")
        raise typer.Exit(INTERRUPTED) from None
    if not quiet:
        spent = duration(time.monotonic() - begun)
        made = counted(done.made, "run")
        tell(f"{made} made in {spent}, {done.taken} taken from {folder / RUNS}")
    return done


def report(
    experiment: Experiment,
    done: Done,
    seed: int,
    files: dict[str, Path],
    seconds: float,
    pictures: bool,
    json_asked: bool,
    quiet: bool,
) -> None:
    """Write the files and print the outcome."""
    from app.experiments.reports.report import as_value, show, write_summary
    from app.experiments.verdicts.claims import claims
    from app.experiments.verdicts.verdict import verdicts

    made = verdicts(experiment, done.measured)
    said = claims(made, experiment.said)
    write_summary(files["summary"], made)
    if pictures:
        from app.experiments.pictures.draw import draw

        files |= draw(experiment, made, files["summary"].parent, seed)
    if json_asked:
        value: dict[str, Any] = as_value(experiment, made, said)
        value["seconds"] = round(seconds, 3)
        value["runs"] = {"made": done.made, "taken": done.taken}
        value["files"] = {kind: str(path) for kind, path in files.items()}
        typer.echo(as_json(value))
    else:
        from rich.console import Console

        show(Console(), experiment, made, said)
    if not quiet:
        tell_written(*files.values())


def tell(line: str) -> None:
    """A line on stderr."""
    typer.echo(line, err=True)
