"""`flockscope sweep check`: all cells checked, and what they will take; nothing is run."""

from __future__ import annotations

from typing import Annotated

import typer

from app.cli.outcome_table import as_json
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


def check(
    what: Annotated[str, typer.Argument(help="FILE.toml, or a MODEL with --vary.")],
    vary: Vary = None,
    fixed: Fixed = None,
    runs: Runs = None,
    ticks: Ticks = None,
    seconds: Seconds = None,
    observe: Observes = "",
    over: Over = None,
    until: Until = "",
    hold: Hold = 1,
    json_asked: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Check every cell of a sweep. Print how many runs it has and how long they take.

    The first ticks of some cells are timed; nothing is kept.
    """
    at_least("--runs", runs, 1)
    from app.experiments.sweeps.estimate import estimate, other_worlds
    from app.experiments.workers.processes import cores

    sweep, _ = sweep_asked(
        what, vary, fixed, runs, ticks, seconds, observe, over, until, hold, None
    )
    made = estimate(sweep)
    warnings = other_worlds(sweep)
    if json_asked:
        value = made.value | {
            "title": sweep.title,
            "axes": sweep.axes,
            "columns": sweep.making.columns,
            "warnings": warnings,
            "cores": cores(),
        }
        typer.echo(as_json(value))
        return
    more = f" to {made.most_runs}" if made.most_runs > made.runs else ""
    least = duration(made.seconds / cores())
    typer.echo(
        f"{sweep.title}: {counted(made.cells, 'cell')}, {made.runs}{more} runs of "
        f"{sweep.making.ticks} ticks{' at most' if sweep.making.until else ''}"
    )
    typer.echo(
        f"about {least} on {counted(cores(), 'core')}"
        f"{' if no run ends before' if sweep.making.until else ''}, {size(made.bytes)} on disk"
    )
    typer.echo(f"measured: {', '.join(sweep.making.columns) or 'series only'}")
    for line in warnings:
        typer.echo(f"flockscope: {line}", err=True)


def size(count: int) -> str:
    """Bytes for people.

    >>> size(900), size(2_500_000)
    ('1 kB', '2.5 MB')
    """
    for unit, scale in (("GB", 1e9), ("MB", 1e6)):
        if count >= scale:
            return f"{count / scale:.1f} {unit}"
    return f"{max(1, round(count / 1e3))} kB"
