"""`flockscope sweep run`: make the runs that are not there yet."""

from __future__ import annotations

import shlex
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from app.cli.sweep.clusters import (
    Account,
    Cores,
    DryRun,
    Jobs,
    Memory,
    OnCluster,
    Queue,
    Walltime,
    describe_cluster,
    read_cluster_options,
)
from app.cli.sweep.sweep_choice import SweepOptions
from app.cli.terminal.outcome_table import as_json, print_stderr
from app.cli.terminal.progress import runs_progress
from app.cli.terminal.usage import PrintJson, Quiet, Rules, with_option_groups
from app.settings import check_whole_number
from worlds.number_text import counted, duration

if TYPE_CHECKING:
    from app.studies.cluster.cluster_options import Cluster
    from app.studies.study_runner import StudyReport
    from app.studies.sweeps.checked_sweep import Sweep

MOST_WORKERS = 1024
BROKEN = 3
"""Exit code if any run failed or was killed."""
Workers = Annotated[int | None, typer.Option(help="Processes. \\[default: cores]")]
Nice = Annotated[int, typer.Option(help="How far the processes give way to others, 0 to 19.")]
RetryFailed = Annotated[
    bool, typer.Option("--retry-failed", help="Make runs that failed or were killed again.")
]
Limit = Annotated[int | None, typer.Option(help="Runs to make now, at most.")]
Drawn = Annotated[
    Path | None,
    typer.Option(help="PNG, SVG or PDF by its ending. \\[default: two beside the runs]"),
]
Overwrite = Annotated[
    bool, typer.Option("--overwrite", help="Replace the file that --picture names.")
]
AsJson = PrintJson
Quiet = Quiet


@dataclass(frozen=True)
class RunnerOptions:
    """How runs are made, of every command that makes many."""

    workers: Workers = None
    nice: Nice = 0
    retry_failed: RetryFailed = False
    limit: Limit = None

    def check(self) -> None:
        """Refuse numbers that cannot be. Raises InputError."""
        check_whole_number("--workers", self.workers, 1, MOST_WORKERS)
        check_whole_number("--nice", self.nice, 0, 19)
        check_whole_number("--limit", self.limit, 1)


def print_warnings(sweep: Sweep) -> None:
    """Warn of worlds that are not those of the papers."""
    from app.studies.sweeps.estimate import describe_other_worlds

    for line in describe_other_worlds(sweep):
        print_stderr(f"flockscope: {line}")


def carry_out_sweep(
    sweep: Sweep,
    folder: Path,
    runner: RunnerOptions,
    quiet: bool,
    cluster: Cluster | None = None,
) -> StudyReport:
    """Carry out the sweep."""
    from app.studies.sweeps.sweep_runner import run_sweep
    from app.studies.workers.process_executor import cores

    if cluster is not None and not quiet:
        from app.cli.sweep.clusters import describe_cluster

        print_stderr(describe_cluster(cluster, bool(sweep.file.record)))
    with runs_progress(folder.name, folder, quiet) as progress:
        return run_sweep(
            sweep,
            folder,
            workers=runner.workers or cores(),
            nice=runner.nice,
            retry=runner.retry_failed,
            limit=runner.limit,
            cluster=cluster,
            tell=None if quiet else print_stderr,
            at=progress.update,
        )


@with_option_groups
def run(
    what: Annotated[
        str, typer.Argument(help="FILE.toml, a MODEL with --vary, or a sweep to go on with.")
    ],
    *,
    options: SweepOptions,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the sweep. \\[default: results/NAME]")
    ] = None,
    runner: RunnerOptions,
    cluster: OnCluster = "",
    dry_run: DryRun = False,
    jobs: Jobs = None,
    cores: Cores = None,
    memory: Memory = "",
    walltime: Walltime = "",
    queue: Queue = "",
    account: Account = "",
    plot: Annotated[
        bool, typer.Option("--plot", help="Draw each observable as PNG and SVG at the end.")
    ] = False,
    rule: Rules = None,  # noqa: ARG001 - taken into the catalogue before this is called
    json_asked: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Make the missing runs of a sweep. Call it again to go on after a stop.

    The exit code is 3 if any run failed or was killed: `flockscope sweep show` names them.
    """
    runner.check()
    listener = None if quiet else print_stderr
    sweep, own = options.read(what, listener)
    folder = out or own
    queue_options = {"jobs": jobs, "cores": cores, "memory": memory, "walltime": walltime}
    queue_options |= {"queue": queue, "account": account}
    made_on = read_cluster_options(sweep, cluster, runner.workers, dry_run, **queue_options)
    if dry_run and made_on is not None:
        print_job(made_on, quiet)
        return
    if not quiet:
        print_warnings(sweep)
    began = time.monotonic()
    done = carry_out_sweep(sweep, folder, runner, quiet, made_on)
    files = draw_all(sweep, folder) if plot and done.made + done.taken else []
    report(sweep, folder, done, files, time.monotonic() - began, json_asked, quiet)
    if done.broken:
        raise typer.Exit(BROKEN)


def print_job(cluster: Cluster, quiet: bool) -> None:
    """Print what a queue would be asked for. Raises InputError."""
    from app.studies.cluster.cluster_connection import job_script

    typer.echo(job_script(cluster), nl=False)
    if not quiet:
        print_stderr(f"flockscope: nothing is run; without --dry-run {describe_cluster(cluster)}")


def draw_all(sweep: Sweep, folder: Path) -> list[Path]:
    """Draw a picture of each thing that is measured. Raises InputError."""
    from app.results_folder import PICTURES
    from app.studies.runs.store_reader import StoreReader
    from app.studies.sweeps.sweep_picture import draw

    files = [folder / f"{column}.{kind}" for column in sweep.making.columns for kind in PICTURES]
    for path in files:
        draw(StoreReader(folder), path, path.stem)
    return files


def report(
    sweep: Sweep,
    folder: Path,
    done: StudyReport,
    files: list[Path],
    seconds: float,
    json_asked: bool,
    quiet: bool,
) -> None:
    """Print what has come of it."""
    from app.cli.sweep.show import summary_of
    from app.studies.runs.store_reader import StoreReader

    reader = StoreReader(folder)
    if json_asked:
        value: dict[str, Any] = {
            "folder": str(folder),
            "title": sweep.title,
            "made": done.made,
            "taken": done.taken,
            "whole": done.whole,
            "runs": reader.counts,
            "seconds": round(seconds, 3),
            "files": [str(path) for path in files],
        }
        typer.echo(as_json(value))
    else:
        summary_of(reader)
    if quiet:
        return
    if done.made:
        rate = done.made / max(seconds, 1e-9)
        print_stderr(
            f"{counted(done.made, 'run')} made in {duration(seconds)} ({rate:.3g} a second), "
            f"{done.taken} taken from {folder}"
        )
    else:
        print_stderr(f"no run made, {done.taken} taken from {folder}")
    if not done.whole:
        print_stderr(
            f"not all runs are made; go on with: flockscope sweep run {shlex.quote(str(folder))}"
        )
    if files:
        print_stderr("written: " + ", ".join(map(str, files)))
