"""`--cluster` and what is asked of its queue: options, over the table [cluster] of the file."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer
from pydantic import ValidationError

from worlds.input_error import InputError, needed
from worlds.number_text import counted

if TYPE_CHECKING:
    from app.studies.cluster.cluster_options import Cluster
    from app.studies.sweeps.checked_sweep import Sweep

PANEL = "On a cluster"
OnCluster = Annotated[
    str,
    typer.Option(
        "--cluster",
        metavar="local|dask:HOST:PORT|slurm|pbs",
        help="What makes the runs, through Dask.",
        rich_help_panel=PANEL,
    ),
]
DryRun = Annotated[
    bool,
    typer.Option(
        "--dry-run", help="Print the job that the queue would get.", rich_help_panel=PANEL
    ),
]
Jobs = Annotated[
    int | None, typer.Option(help="Jobs. \\[default: 1]", rich_help_panel=PANEL)
]  # fmt: skip
Cores = Annotated[
    int | None, typer.Option(help="Cores of a job. \\[default: 1]", rich_help_panel=PANEL)
]
Memory = Annotated[
    str, typer.Option(help="Of a job, as '4 GB'.", rich_help_panel=PANEL)
]  # fmt: skip
Walltime = Annotated[
    str,
    typer.Option(
        help="Of a job, HH:MM:SS or D-HH:MM:SS. \\[default: 01:00:00]", rich_help_panel=PANEL
    ),
]
Queue = Annotated[
    str,
    typer.Option("--queue", "--partition", help="SLURM's partition, PBS's queue.",
                 rich_help_panel=PANEL),
]  # fmt: skip
Account = Annotated[str, typer.Option(help="Who pays.", rich_help_panel=PANEL)]


def read_cluster_options(
    sweep: Sweep, kind: str, workers: int | None, dry: bool, **options: Any
) -> Cluster | None:
    """The cluster of the file with what the options change; None: this machine. Raises
    InputError."""
    from app.studies.cluster.cluster_options import Cluster

    given_options = {name: value for name, value in options.items() if value not in (None, "")}
    values = sweep.file.cluster.model_dump() | given_options
    if kind:
        values["kind"] = kind
    try:
        cluster = Cluster(**values)
    except ValidationError as error:
        first = error.errors()[0]
        name = str(first["loc"][0]) if first["loc"] else "cluster"
        option = "--cluster" if name == "kind" else f"--{name}"
        reason = first.get("ctx", {}).get("error") or (
            f"{values.get(name)!r} is not allowed: {needed(first)}"
        )
        raise InputError(f"{option}: {reason}") from None
    if not cluster.queued:
        for name in given_options:
            raise InputError(
                f"--{name} is of a queue: give --cluster slurm or --cluster pbs with it"
            )
        if dry:
            raise InputError(
                "--dry-run prints a job: give --cluster slurm or --cluster pbs with it"
            )
    if workers is not None and cluster.kind not in ("", "local"):
        raise InputError("--workers is of this machine: a queue has --jobs and --cores")
    return cluster if cluster.kind else None


def describe_cluster(cluster: Cluster, records: bool = False) -> str:
    """A cluster for people; `records`: whether runs are recorded."""
    if not cluster.queued:
        text = f"runs are made by {cluster.kind}"
    else:
        jobs = f"{counted(cluster.jobs, 'job')} of {counted(cluster.cores, 'core')}"
        text = f"{jobs} asked of {cluster.kind}, for {cluster.walltime} each"
    if records and cluster.kind != "local":
        text += "; recordings are written by the nodes, into a folder that they have to share"
    return text
