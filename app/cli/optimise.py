"""`flockscope optimise`: the best values of parameters, by a search that goes on after any stop."""

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
    print_warnings,
)
from app.cli.terminal.console import make_console
from app.cli.terminal.outcome_table import as_json, print_stderr, print_written_files
from app.cli.terminal.progress import runs_progress
from app.cli.terminal.usage import with_option_groups
from app.results_folder import PICTURES

if TYPE_CHECKING:
    from app.studies.optimisation.optimisation_result import OptimisationResult
    from app.studies.optimisation.optimisation_runner import OptimisationReport
    from app.studies.optimisation.study import Study

FAULTS = 20
"""Failed runs that are named."""


@with_option_groups
def optimise(
    what: Annotated[str, typer.Argument(help="FILE.toml, or the folder of one to go on with.")],
    *,
    out: Annotated[
        Path | None, typer.Option(help="Folder of its runs. \\[default: results/NAME]")
    ] = None,
    picture: Drawn = None,
    overwrite: Overwrite = False,
    runner: RunnerOptions,
    json_asked: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Search for the values of parameters that make a measure least or most.

    Fresh seeds judge the best point, beside the default and the points that tie with it. Call it
    again to go on after a stop: finished runs come from the store. The exit code is 3 if any run
    failed.
    """
    from app.cli.sweep.sweep_choice import folder_of, is_sweep, read_sweep_folder
    from app.figure import ENDINGS
    from app.studies.optimisation.optimisation_picture import draw
    from app.studies.optimisation.study import read_study, study_of
    from worlds.file_writer import demand_writable
    from worlds.input_error import InputError

    runner.check()
    if Path(what).suffix.lower() == ".toml":
        study, own = read_study(Path(what)), folder_of(Path(what).stem)
    elif is_sweep(folder_of(what)):
        own = folder_of(what)
        study = study_of(*read_sweep_folder(own))
    else:
        raise InputError(f"{what!r} is no FILE.toml and no folder of an optimisation")
    folder = out or own
    if picture is not None:
        demand_writable("--picture", picture, overwrite, ENDINGS)
    if not quiet:
        for variant in study.variants:
            print_warnings(variant.sweep)
    done = carry_out_search(study, folder, runner, quiet)
    for line in done.broken[:FAULTS]:
        print_stderr(f"flockscope: {line}")
    if done.answer is None:
        print_stderr(f"not all points are evaluated; go on with: flockscope optimise {folder}")
        raise typer.Exit(BROKEN if done.broken else 0)
    names = [f"convergence.{kind}" for kind in PICTURES]
    files = [picture] if picture is not None else [folder / name for name in names]
    for path in files:
        draw(study, done.course, done.answer, path)
    report(study, folder, done, done.answer, files, json_asked)
    if not quiet:
        print_stderr(f"{done.made} runs made, {done.taken} taken from {folder}")
        print_written_files(*files)
    if done.broken:
        raise typer.Exit(BROKEN)


def carry_out_search(
    study: Study,
    folder: Path,
    runner: RunnerOptions,
    quiet: bool,
) -> OptimisationReport:
    """Carry out the search."""
    from app.studies.optimisation.optimisation_runner import optimise as carry_out

    with runs_progress(folder.name, folder, quiet) as progress:
        return carry_out(
            study,
            folder,
            workers=runner.workers,
            nice=runner.nice,
            retry=runner.retry_failed,
            limit=runner.limit,
            tell=None if quiet else print_stderr,
            at=lambda share, words: progress.update(share, None, words),
        )


def report(
    study: Study,
    folder: Path,
    done: OptimisationReport,
    answer: OptimisationResult,
    files: list[Path],
    json_asked: bool,
) -> None:
    """Print the answer as a table and in words, or as JSON."""
    if json_asked:
        value: dict[str, Any] = {
            "folder": str(folder),
            "title": study.title,
            "algorithm": study.file.search.algorithm,
            "made": done.made,
            "taken": done.taken,
            "failed": done.broken,
            **answer.value,
            "course": [
                {"point": point.point, "means": point.means, "is_good": point.is_good}
                for point in done.course
            ],
            "files": [str(path) for path in files],
        }
        typer.echo(as_json(value))
        return
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    from app.cli.sweep.show import format_axis_value

    table = Table(
        "", *study.default, *answer.goals, box=SIMPLE_HEAD,
        title=f"{study.title}, {answer.fresh} fresh seeds", title_justify="left",
    )  # fmt: skip
    last = [answer.ties.furthest] if answer.ties and answer.ties.furthest else []
    for point in (answer.default, *answer.best, *last):
        values = [format_axis_value(point.point[name]) for name in study.default]
        table.add_row(
            point.what, *values, *("-" if mean is None else str(mean) for mean in point.means)
        )
    console = make_console()
    console.print(table)
    for line in answer.words():
        console.print(line, markup=False, highlight=False, soft_wrap=True)
