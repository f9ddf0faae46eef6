"""What all commands that make runs have in common: their options, and how they are carried out."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.cli.error_messages import INTERRUPTED
from app.cli.outcome_table import tell
from app.cli.progress import Progress
from app.cli.stop_signals import StopSignals
from app.settings import at_least

if TYPE_CHECKING:
    from app.experiments.cluster.cluster_options import Cluster
    from app.experiments.sweeps.checked_sweep import Sweep
    from app.experiments.sweeps.sweep_runner import SweepReport

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
AsJson = Annotated[bool, typer.Option("--json", help="Print JSON.")]
Quiet = Annotated[bool, typer.Option("--quiet", help="No messages while it runs.")]


def demand_sound(workers: int | None, nice: int, limit: int | None) -> None:
    """Refuse numbers that cannot be. Raises InputError."""
    at_least("--workers", workers, 1, MOST_WORKERS)
    at_least("--nice", nice, 0, 19)
    at_least("--limit", limit, 1)


@contextmanager
def under_way(folder: Path, quiet: bool) -> Iterator[Progress]:
    """A bar while runs are made; after Ctrl-C a line tells how to go on."""
    again = f"flockscope {shlex.join(sys.argv[1:])}"
    stopped = f"flockscope: stopped; finished runs are in {folder}; go on with: {again}"
    try:
        with StopSignals(at_once=stopped), Progress(folder.name, quiet) as progress:
            yield progress
    except KeyboardInterrupt:
        tell(stopped)
        raise typer.Exit(INTERRUPTED) from None


def warn(sweep: Sweep) -> None:
    """Warn of worlds that are not those of the papers."""
    from app.experiments.sweeps.estimate import other_worlds

    for line in other_worlds(sweep):
        tell(f"flockscope: {line}")


def carried_out(
    sweep: Sweep,
    folder: Path,
    workers: int | None,
    nice: int,
    retry: bool,
    limit: int | None,
    quiet: bool,
    cluster: Cluster | None = None,
) -> SweepReport:
    """Carry out the sweep."""
    from app.experiments.sweeps.sweep_runner import conduct
    from app.experiments.workers.processes import cores

    if cluster is not None and not quiet:
        from app.cli.sweep.clusters import in_words

        tell(in_words(cluster, bool(sweep.file.record)))
    with under_way(folder, quiet) as progress:
        return conduct(
            sweep,
            folder,
            workers=workers or cores(),
            nice=nice,
            retry=retry,
            limit=limit,
            cluster=cluster,
            tell=None if quiet else tell,
            at=progress.at,
        )
