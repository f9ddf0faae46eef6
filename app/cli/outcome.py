"""The outcome of a run on stdout: a table for people, or JSON."""

from __future__ import annotations

import json
import math
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from agents import Flock


def telling(flock: Flock) -> list[str]:
    """The observables that tell how a flock does in its world."""
    names = ["polarisation", "consistency"]
    mission = flock.world.mission
    if flock.world.is_solid:
        names += ["nearest-neighbour", "obstacle-distance", "inside-obstacles"]
    if mission is not None and (mission.goal is not None or mission.path is not None):
        names += ["goal-distance"]
    if mission is not None and mission.path is not None and flock.informed.any():
        names += ["following"]
    return names


def plain(value: Any) -> Any:
    """A value as JSON has it: NumPy numbers as numbers, what is not finite as null."""
    if isinstance(value, dict):
        return {str(key): plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [plain(one) for one in value]
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def as_json(values: Any) -> str:
    """Values as one line of JSON."""
    return json.dumps(plain(values), allow_nan=False)


def outcome(flock: Flock, observe: list[str], ticks: int, seconds: float) -> dict[str, Any]:
    """What a run has given, as one value."""
    return {
        "spec": flock.spec.model_dump(mode="json"),
        "tick": flock.tick,
        "time": flock.elapsed,
        "time_unit": flock.model.body.unit,
        "ticks": ticks,
        "seconds": round(seconds, 6),
        "observables": {name: flock.observe(name) for name in observe},
    }


def show(made: dict[str, Any], flock: Flock) -> None:
    """Print the outcome for people."""
    from agents.observables.catalogue import OBSERVABLES

    spec = made["spec"]
    size = " x ".join(f"{side:g}" for side in spec["size"])
    typer.echo(
        f"{flock.model.title}: {spec['agents']} agents"
        + (f" and {spec['informed']} information agent(s)" if spec["informed"] else "")
        + f" in {spec['world']} {size}, seed {spec['seed']}"
    )
    rate = made["ticks"] * len(flock.ids) / max(made["seconds"], 1e-9)
    now = "" if made["time_unit"] == "ticks" else f" = {made['time']:g} {made['time_unit']}"
    typer.echo(
        f"tick {made['tick']}{now}; {made['ticks']} ticks took {made['seconds']:.3g} s"
        f" ({rate:.2g} agent-steps per second)"
    )
    for name, value in made["observables"].items():
        one = OBSERVABLES[name]
        unit = "" if one.unit == "1" else f" {one.unit}"
        typer.echo(f"  {name:<18} {shown(value)}{unit}   in {one.range}")


def shown(value: Any) -> str:
    """A measured value for people."""
    if isinstance(value, dict):
        return ", ".join(f"{key}: {one}" for key, one in value.items())
    return f"{value:.6g}" if isinstance(value, float) else str(value)
