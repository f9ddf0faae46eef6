"""`flockscope sweep stop`: have the process that runs a sweep stop; what is finished stays."""

from __future__ import annotations

import time
from typing import Annotated

import typer

from app.cli.sweep.status import Name
from app.cli.sweep.sweep_choice import kept_sweep
from worlds.input_error import InputError

TIMEOUT = 30.0
"""Seconds to wait for it."""


def stop(
    name: Name,
    quiet: Annotated[bool, typer.Option("--quiet", help="Say nothing.")] = False,
) -> None:
    """Stop a sweep that another process runs; `flockscope sweep run` goes on with it."""
    from app.experiments.runs.store import is_taken
    from app.experiments.sweeps.sweep_runner import STOP

    folder = kept_sweep(name)
    if not is_taken(folder):
        raise InputError(f"no process runs {str(folder)!r}")
    (folder / STOP).touch()
    end = time.monotonic() + TIMEOUT
    while is_taken(folder):
        if time.monotonic() > end:
            raise InputError(
                f"{str(folder)!r} has not stopped within {TIMEOUT:g} s: it was asked to"
            )
        time.sleep(0.1)
    if not quiet:
        typer.echo(f"stopped: {folder}", err=True)
