"""`flockscope sweep run`: make the runs that are not there yet."""

from __future__ import annotations

import shlex
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from app.cli.outcome_table import as_json, tell
from app.cli.sweep.clusters import (
    Account,
    Cores,
    DryRun,
    Jobs,
    Memory,
    OnCluster,
    Queue,
    Walltime,
    cluster_asked,
    in_words,
)
from app.cli.sweep.run_options import (
    BROKEN,
    AsJson,
    Limit,
    Nice,
    Quiet,
    RetryFailed,
    Workers,
    carried_out,
    demand_sound,
    warn,
)
from app.cli.sweep.sweep_choice import (
    Fixed,
    Hold,
    Observes,
    Over,
    Runs,
    Seconds,
    Ticks,
    Until,
    Vary,
    sweep_asked,
)
from app.settings import at_least
from worlds.number_text import counted, duration

if TYPE_CHECKING:
    from app.experiments.cluster.cluster_options import Cluster
    from app.experiments.sweeps.checked_sweep import Sweep
    from app.experiments.sweeps.sweep_runner import SweepReport


def run(
    what: Annotated[
        str, typer.Argument(help="FILE.toml, a MODEL with --vary, or a sweep to go on with.")
    ],
    vary: Vary = None,
    fixed: Fixed = None,
    runs: Runs = None,
    ticks: Ticks = None,
    seconds: Seconds = None,
    observe: Observes = "",
    over: Over = None,
    until: Until = "",
    hold: Hold = 1,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the sweep. \\[default: results/NAME]")
    ] = None,
    workers: Workers = None,
    nice: Nice = 0,
    retry_failed: RetryFailed = False,
    limit: Limit = None,
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
    json_asked: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Make the missing runs of a sweep. Call it again to go on after a stop.

    The exit code is 3 if any run failed or was killed: `flockscope sweep show` names them.
    """
    at_least("--runs", runs, 1)
    at_least("--over", over, 1)
    at_least("--hold", hold, 1)
    demand_sound(workers, nice, limit)
    heard = None if quiet else tell
    sweep, own = sweep_asked(
        what, vary, fixed, runs, ticks, seconds, observe, over, until, hold, heard
    )
    folder = out or own
    asked = {"jobs": jobs, "cores": cores, "memory": memory, "walltime": walltime}
    asked |= {"queue": queue, "account": account}
    made_on = cluster_asked(sweep, cluster, workers, dry_run, **asked)
    if dry_run and made_on is not None:
        print_job(made_on, quiet)
        return
    if not quiet:
        warn(sweep)
    began = time.monotonic()
    done = carried_out(sweep, folder, workers, nice, retry_failed, limit, quiet, made_on)
    files = draw_all(sweep, folder) if plot and done.made + done.taken else []
    report(sweep, folder, done, files, time.monotonic() - began, json_asked, quiet)
    if done.broken:
        raise typer.Exit(BROKEN)


def print_job(cluster: Cluster, quiet: bool) -> None:
    """Print what a queue would be asked for. Raises InputError."""
    from app.experiments.cluster.cluster_connection import job_script

    typer.echo(job_script(cluster), nl=False)
    if not quiet:
        tell(f"flockscope: nothing is run; without --dry-run {in_words(cluster)}")


def draw_all(sweep: Sweep, folder: Path) -> list[Path]:
    """Draw a picture of each thing that is measured. Raises InputError."""
    from app.experiments.runs.store_reader import StoreReader
    from app.experiments.sweeps.pictures.sweep_picture import draw
    from app.results_folder import PICTURES

    files = [folder / f"{column}.{kind}" for column in sweep.making.columns for kind in PICTURES]
    for path in files:
        draw(StoreReader(folder), path, path.stem)
    return files


def report(
    sweep: Sweep,
    folder: Path,
    done: SweepReport,
    files: list[Path],
    seconds: float,
    json_asked: bool,
    quiet: bool,
) -> None:
    """Print what has come of it."""
    from app.cli.sweep.show import summary_of
    from app.experiments.runs.store_reader import StoreReader

    kept = StoreReader(folder)
    if json_asked:
        value: dict[str, Any] = {
            "folder": str(folder),
            "title": sweep.title,
            "made": done.made,
            "taken": done.taken,
            "whole": done.whole,
            "runs": kept.counts,
            "seconds": round(seconds, 3),
            "files": [str(path) for path in files],
        }
        typer.echo(as_json(value))
    else:
        summary_of(kept)
    if quiet:
        return
    if done.made:
        rate = done.made / max(seconds, 1e-9)
        tell(
            f"{counted(done.made, 'run')} made in {duration(seconds)} ({rate:.3g} a second), "
            f"{done.taken} taken from {folder}"
        )
    else:
        tell(f"no run made, {done.taken} taken from {folder}")
    if not done.whole:
        tell(f"not all runs are made; go on with: flockscope sweep run {shlex.quote(str(folder))}")
    if files:
        tell("written: " + ", ".join(map(str, files)))
