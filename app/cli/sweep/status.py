"""`flockscope sweep status`: how far a sweep is, also while another process runs it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from app.cli.outcome import as_json
from app.cli.sweep.asked import kept_sweep
from worlds.counting import duration

Name = Annotated[str, typer.Argument(help="A sweep in results/, or its folder.")]


def status(
    name: Name,
    json_asked: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
) -> None:
    """How many runs are done, how fast the rest comes, and what failed."""
    value = status_of(kept_sweep(name))
    typer.echo(as_json(value) if json_asked else in_words(value))


def status_of(folder: Path) -> dict[str, Any]:
    """How far the sweep of a folder is."""
    from app.experiments.runs.reading import Kept
    from app.experiments.runs.store import is_taken

    kept = Kept(folder)
    state, counts = kept.state, kept.counts
    running = is_taken(folder)
    progress = state.get("progress") if running else None
    return {
        "folder": str(folder),
        "title": state.get("title", ""),
        "state": "running" if running else "stopped" if left(state, counts) else "done",
        "runs": counts,
        "done": sum(counts.values()),
        "of": state.get("runs"),
        "others": kept.others,
        "rate": progress and progress["rate"],
        "seconds_left": progress and progress["seconds_left"],
        "workers": progress and progress["workers"],
        "pid": progress and progress["pid"],
    }


def left(state: dict[str, Any], counts: dict[str, int]) -> bool:
    """Whether there are runs to make."""
    return bool(state.get("runs", 0) > sum(counts.values()))


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
