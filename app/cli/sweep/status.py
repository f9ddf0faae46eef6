"""`flockscope sweep status`: how far a sweep is, also while another process runs it."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from app.cli.outcome_table import as_json
from app.cli.sweep.sweep_choice import kept_sweep
from worlds.number_text import duration

Name = Annotated[str, typer.Argument(help="A sweep in results/, or its folder.")]


def status(
    name: Name,
    json_asked: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """Show how many runs are done, how long the rest takes, and what failed."""
    from app.experiments.sweeps.sweep_status import status_of

    value = status_of(kept_sweep(name))
    typer.echo(as_json(value) if json_asked else in_words(value))


def in_words(value: dict[str, Any]) -> str:
    """How far it is, for people."""
    counts = value["runs"]
    said = [f"{value['title']}: {value['state']}, {value['done']} of {value['of']} runs"]
    parts = [f"{counts[one]} {word}" for one, word in WORDS.items() if counts[one]]
    if parts:
        said.append(", ".join(parts))
    if value["rate"] is not None:
        time_left = duration(value["seconds_left"])
        said.append(f"{value['rate']:.3g} runs a second, {time_left} left (pid {value['pid']})")
    if value["others"]:
        said.append(f"{value['others']} runs of other cells or versions are kept beside")
    return "\n".join(said)


WORDS = {"ok": "ok", "gave-up": "gave up", "failed": "failed", "killed": "killed"}
