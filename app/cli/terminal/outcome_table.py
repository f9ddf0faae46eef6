"""The outcome of a run on stdout: a table for people, or JSON."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from worlds.number_text import counted

if TYPE_CHECKING:
    from agents import Flock
    from agents.run_records import Series
    from agents.state.agent_rows import StrayAgents

CRASHES = 10
"""Crashes that are shown to people one by one."""
CELLS = 12
"""Entries of a table that are shown to people."""


def print_stderr(line: str) -> None:
    """A line on stderr."""
    typer.echo(line, err=True)


def print_written_files(*files: Path | None) -> None:
    """Name the files that were written on stderr; None is left out."""
    named = [str(path) for path in files if path is not None]
    if named:
        print_stderr("written: " + ", ".join(named))


def json_value(value: Any) -> Any:
    """A value as JSON has it: NumPy numbers as numbers, what is not finite as null."""
    if isinstance(value, dict):
        return {str(key): json_value(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [json_value(item) for item in value]
    if hasattr(value, "tolist"):
        return json_value(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def as_json(values: Any) -> str:
    """Values as one line of JSON, which any terminal can show: of ASCII, without DEL."""
    return json.dumps(json_value(values), allow_nan=False).replace("\x7f", "\\u007f")


def outcome(
    flock: Flock, observe: list[str], ticks: int, seconds: float, series: Series | None = None
) -> dict[str, Any]:
    """What a run has given, as one value; `series` of its last ticks, if there is one."""
    from agents.observables.catalogue import OBSERVABLES

    result = {
        "spec": flock.spec.model_dump(mode="json"),
        "tick": flock.tick,
        "time": flock.elapsed,
        "time_unit": flock.model.body.unit,
        "ticks": ticks,
        "seconds": round(seconds, 6),
        "observables": {
            name: series.over(name) if series and OBSERVABLES[name].over else flock.observe(name)
            for name in observe
        },
    }
    if series is not None:
        result["over"] = course(series)
    if flock.can_crash:
        result["crashes"] = crash_list(flock)
    if flock.passing:
        result["passes_solids"] = flock.passing
    return result


def course(series: Series) -> dict[str, Any]:
    """Mean and standard deviation of each observable over the last ticks."""
    import numpy as np

    with np.errstate(invalid="ignore"):
        deviation = {name: float(values.std()) for name, values in series.values.items()}
    return {
        "ticks": len(series.tick),
        "mean": {name: float(values.mean()) for name, values in series.values.items()},
        "deviation": deviation,
    }


def crash_list(flock: Flock) -> list[dict[str, Any]]:
    """Who has crashed, when, where and against what, in the order of ticks."""
    from agents.state.agent_rows import CAUSES

    crashes = flock.crashes
    return [
        {
            "tick": int(tick),
            "id": int(crash),
            "place": place.tolist(),
            "against": CAUSES[int(cause)],
        }
        for tick, crash, place, cause in zip(
            crashes.tick, crashes.id, crashes.place, crashes.cause, strict=True
        )
    ]


def show(result: dict[str, Any], flock: Flock) -> None:
    """Print the outcome for people."""
    from agents.observables.catalogue import OBSERVABLES

    spec = result["spec"]
    size = " x ".join(f"{side:g}" for side in spec["size"])
    typer.echo(
        f"{flock.model.title}: {counted(spec['agents'], 'agent')}"
        + (f" and {counted(spec['informed'], 'information agent')}" if spec["informed"] else "")
        + "".join(f", {kind['agents']} of kind {kind['name']}," for kind in spec["kinds"])
        + f" in {spec['world']} {size}, seed {spec['seed']}"
    )
    rate = result["ticks"] * len(flock.ids) / max(result["seconds"], 1e-9)
    now = "" if result["time_unit"] == "ticks" else f" = {result['time']:g} {result['time_unit']}"
    typer.echo(
        f"tick {result['tick']}{now}; {counted(result['ticks'], 'tick')} took "
        f"{result['seconds']:.3g} s"
        f" ({rate:.2g} agent-steps per second)"
    )
    wide = max((len(name) for name in result["observables"]), default=0)
    for name, value in result["observables"].items():
        observable = OBSERVABLES[name]
        unit = (
            ""
            if observable.unit == "1" or observable.is_table
            else f" {flock.model.in_units(observable.unit)}"
        )
        typer.echo(f"  {name:<{wide}} {format_value(value)}{unit}   in {observable.range}")
    for name, mean in result.get("over", {}).get("mean", {}).items():
        off = format_value(result["over"]["deviation"][name])
        last = counted(result["over"]["ticks"], "tick")
        typer.echo(f"  {name:<{wide}} {format_value(mean)} +- {off} over the last {last}")
    show_crashes(result.get("crashes", []))


def show_crashes(crashes: list[dict[str, Any]]) -> None:
    """Print the first crashes, and how many more there are."""
    for crash in crashes[:CRASHES]:
        place = ", ".join(f"{x:.2f}" for x in crash["place"])
        typer.echo(
            f"  tick {crash['tick']}: agent {crash['id']} crashed against {crash['against']} "
            f"at ({place})"
        )
    if len(crashes) > CRASHES:
        typer.echo(f"  and {len(crashes) - CRASHES} more; --json has all of them")


def format_value(value: Any) -> str:
    """A measured value for people."""
    if isinstance(value, dict):
        cells = [f"{key}: {format_item(item)}" for key, item in value.items()]
        more = [f"and {len(cells) - CELLS} more; --json has all of them"][: len(cells) > CELLS]
        return ", ".join([*cells[:CELLS], *more])
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def format_item(value: Any) -> str:
    """A value within a table for people; a row of a table in brackets."""
    return f"({format_value(value)})" if isinstance(value, dict) else format_value(value)


# Tells at once when agents are where they cannot be, and lets the exit code say so at the end.

ASTRAY = 4
"""Exit code of a run in which an agent was inside an obstacle or beyond a solid edge."""


class StrayAgentCheck:
    """Looks now and then whether an agent of a flock is where it cannot be."""

    def __init__(self, flock: Flock):
        self.flock = flock
        self.found: StrayAgents | None = None
        """The first that was seen."""

    def check(self) -> None:
        """Look now; the first time that one is found, tell."""
        if self.found is None:
            self.found = self.flock.stray()
            if self.found is not None:
                typer.echo(f"flockscope: {self.found}", err=True)

    def exit_if_found(self) -> None:
        """Stop with ASTRAY if one was found."""
        if self.found is not None:
            raise typer.Exit(ASTRAY)
