"""`flockscope paper`: a table or a figure of a paper, measured beside published."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from app.cli.terminal.console import make_console
from app.cli.terminal.outcome_table import (
    ASTRAY,
    as_json,
    print_stderr,
    print_written_files,
)
from app.cli.terminal.progress import runs_progress
from app.cli.terminal.usage import PrintJson, Quiet
from app.results_folder import demand_folder, picture_files
from app.settings import check_whole_number, names, whole_numbers
from worlds.input_error import InputError
from worlds.number_text import counted, duration

if TYPE_CHECKING:
    from app.studies.claims.claims import Claim
    from app.studies.experiment import Experiment
    from app.studies.experiment_runner import ExperimentReport
    from app.studies.judge.verdict import Verdict

MOST_RUNS = 100_000
MOST_WORKERS = 1024
RUNS = "runs.sqlite"
DIFFERS = 3
"""Exit code of `--strict` if anything differs or does not hold; and if any run failed."""


def paper(
    name: Annotated[
        str | None,
        typer.Argument(help="Which one, see `flockscope list papers`; or FILE.toml of your own."),
    ] = None,
    everything: Annotated[
        bool, typer.Option("--all", help="All of them, and a table of verdicts at the end.")
    ] = False,
    runs: Annotated[int | None, typer.Option(help="Runs per row. \\[default: the paper's]")] = None,
    agents: Annotated[str, typer.Option(help="Only these sizes of flock: 100,200.")] = "",
    models: Annotated[str, typer.Option(help="Only these models: vem,hwvem.")] = "",
    seed: Annotated[
        int,
        typer.Option(help="Seed of the first run of each row."),
    ] = 1,
    out: Annotated[
        Path | None,
        typer.Option(
            help="Folder for runs and pictures; with --all for a folder of each. "
            "\\[default: results/NAME, with --all results]"
        ),
    ] = None,
    workers: Annotated[int | None, typer.Option(help="Runs at a time. \\[default: cores]")] = None,
    pictures: Annotated[bool, typer.Option(help="Draw the picture as PNG and SVG.")] = True,
    strict: Annotated[
        bool,
        typer.Option("--strict", help="Exit code 3 if anything differs or does not hold."),
    ] = False,
    retry_failed: Annotated[
        bool, typer.Option("--retry-failed", help="Make runs that failed or were killed again.")
    ] = False,
    overwrite: Annotated[
        bool,
        typer.Option("--overwrite", help="Replace files of these names that are not of such runs."),
    ] = False,
    json_asked: PrintJson = False,
    quiet: Quiet = False,
) -> None:
    """Repeat a table or a figure of a paper and print it beside the published numbers.

    Finished runs are kept in FOLDER/runs.sqlite: what is there is not run again. A run that fails
    is named, and its seed left out. The exit code is 4 if an agent of a run was seen inside an
    obstacle or beyond a solid edge, 3 if a run failed.
    """
    check_whole_number("--seed", seed, 0)
    check_whole_number("--workers", workers, 1, MOST_WORKERS)
    if everything == (name is not None):
        raise InputError("say which paper, or --all: see `flockscope list papers`")
    if everything and (agents or models):
        raise InputError("--all takes all sizes and models: leave --agents and --models out")
    from app.studies.experiment_reader import experiment_names, find_experiment

    wholes = [
        find_experiment(paper_name) for paper_name in ([name] if name else experiment_names())
    ]
    check_whole_number(
        "--runs", runs, min(2, *(experiment.runs for experiment in wholes)), MOST_RUNS
    )
    experiments = [
        experiment.select(names(models), whole_numbers("--agents", agents)) for experiment in wholes
    ]
    base = out or Path("results")
    folders = {
        experiment.name: out if name and out else base / experiment.name
        for experiment in experiments
    }
    for experiment in experiments:
        demand_results(folders[experiment.name], experiment.name, pictures, overwrite)
    outcomes = []
    for experiment in experiments:
        started = time.monotonic()
        count = runs or experiment.runs
        if not quiet:
            print_prospects(experiment, count)
        done = carry_out_paper(
            experiment, folders[experiment.name], count, seed, workers, quiet, retry_failed
        )
        seconds = time.monotonic() - started
        outcomes.append(
            outcome_of(experiment, done, folders[experiment.name], seed, seconds, pictures)
        )
    report(outcomes, everything, json_asked, quiet)
    astray = [line for outcome in outcomes for line in outcome.done.astray]
    failed = [line for outcome in outcomes for line in outcome.done.failed]
    for line in astray + failed:
        print_stderr(f"flockscope: {line}")
    if astray:
        raise typer.Exit(ASTRAY)
    if failed or (strict and any(outcome.differs for outcome in outcomes)):
        raise typer.Exit(DIFFERS)


def print_prospects(experiment: Experiment, runs: int) -> None:
    """Say which of its claims so many runs can decide."""
    from app.studies.claims.prospects import describe_prospects

    text = describe_prospects(experiment, runs)
    if text:
        print_stderr(f"{experiment.name}: {text}")


def demand_results(folder: Path, name: str, pictures: bool, overwrite: bool) -> None:
    """Refuse a folder that cannot be written, before anything is run. Raises InputError.

    Summary and pictures beside the runs that they are made of are made anew at every call.
    """
    runs = folder / RUNS
    demand_folder("--out", folder, (RUNS,), overwrite=True)
    file_names = ("summary.csv", *picture_files(name, pictures))
    demand_folder("--out", folder, file_names, overwrite or runs.is_file())


def carry_out_paper(
    experiment: Experiment,
    folder: Path,
    runs: int,
    seed: int,
    workers: int | None,
    quiet: bool,
    retry: bool,
) -> ExperimentReport:
    """Carry out the experiment; after Ctrl-C tell how to go on."""
    from app.studies.experiment_runner import run_experiment
    from app.studies.workers.process_executor import cores

    started = time.monotonic()
    with runs_progress(experiment.name, folder / RUNS, quiet) as progress:
        done = run_experiment(
            experiment,
            folder,
            runs=runs,
            seed=seed,
            workers=workers or cores(),
            tell=None if quiet else print_stderr,
            at=progress.update,
            retry=retry,
        )
    if not quiet:
        spent = duration(time.monotonic() - started)
        runs_text = counted(done.made, "run")
        print_stderr(f"{runs_text} made in {spent}, {done.taken} taken from {folder / RUNS}")
    return done


@dataclass(frozen=True)
class PaperOutcome:
    """An experiment carried out, with its verdicts and the files that it has left."""

    experiment: Experiment
    done: ExperimentReport
    made: list[Verdict]
    said: list[Claim]
    files: dict[str, Path]
    seconds: float

    @property
    def differs(self) -> bool:
        """Whether anything differs from what was published, or does not hold."""
        words = [verdict.word for verdict in self.made] + [claim.word for claim in self.said]
        return "differs" in words or "does not hold" in words

    @property
    def value(self) -> dict[str, Any]:
        """As a value for JSON."""
        from app.studies.reports.report_formats import as_value

        return as_value(self.experiment, self.made, self.said) | {
            "seconds": round(self.seconds, 3),
            "runs": {"made": self.done.made, "taken": self.done.taken},
            "failed": self.done.failed,
            "files": {kind: str(path) for kind, path in self.files.items()},
        }


def outcome_of(
    experiment: Experiment,
    done: ExperimentReport,
    folder: Path,
    seed: int,
    seconds: float,
    pictures: bool,
) -> PaperOutcome:
    """Judge what was measured, and write summary and picture."""
    from app.studies.claims.claims import claims, verdicts
    from app.studies.reports.report_formats import write_summary

    rows = verdicts(experiment, done.measured)
    files = {"runs": folder / RUNS, "summary": folder / "summary.csv"}
    write_summary(files["summary"], rows)
    if pictures:
        from app.studies.figures import draw

        files |= draw(experiment, rows, folder, seed)
    return PaperOutcome(experiment, done, rows, claims(rows, experiment.said), files, seconds)


def report(outcomes: list[PaperOutcome], everything: bool, json_asked: bool, quiet: bool) -> None:
    """Print the outcomes."""
    if json_asked:
        values = [outcome.value for outcome in outcomes]
        typer.echo(as_json({"papers": values} if everything else values[0]))
    else:
        from app.studies.reports.overview import overview
        from app.studies.reports.report_formats import show

        console = make_console()
        for outcome in outcomes:
            show(console, outcome.experiment, outcome.made, outcome.said)
        if everything:
            console.print(
                overview([(outcome.experiment, outcome.made, outcome.said) for outcome in outcomes])
            )
    if not quiet:
        print_written_files(
            *(outcomes[0].files.values() if not everything else folders_of(outcomes))
        )


def folders_of(outcomes: list[PaperOutcome]) -> list[Path]:
    """The folders that files were written to."""
    return list(dict.fromkeys(outcome.files["runs"].parent for outcome in outcomes))
