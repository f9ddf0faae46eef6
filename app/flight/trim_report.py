"""A trim in words and as a value."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from agents.flight.trim import Trim, trim
from app.flight.request import SPEED, FlightRequest
from app.results_folder import make_folder
from worlds.file_writer import csv_text, write_text
from worlds.input_error import InputError

if TYPE_CHECKING:
    from agents.flight.trim import Trim


# Columns of numbers as a CSV file.


def write_sheet(path: Path, columns: Mapping[str, Sequence[Any]]) -> None:
    """Write columns of one length under their names; None stays empty. Raises InputError."""
    rows = (
        ["" if one is None else f"{float(one):.9g}" for one in row]
        for row in zip(*columns.values(), strict=True)
    )
    make_folder(path.parent)
    write_text("table", path, csv_text(columns, rows))


def beat_columns(beat: Any, frequency: float) -> dict[str, Any]:
    """Columns of one wing beat or more, angles in degrees; `beat` is a `History`."""
    import numpy as np

    made = {"time_s": beat.time, "beats": beat.time * frequency}
    for name, unit in COLUMNS.items():
        values = getattr(beat, name)
        made[f"{name}_{unit}"] = np.degrees(values) if unit.startswith("deg") else values
    return made


COLUMNS = {
    "distance": "m",
    "height": "m",
    "speed": "m_per_s",
    "climb": "m_per_s",
    "pitch": "deg",
    "pitch_rate": "deg_per_s",
    "attack": "deg",
    "flap": "deg",
    "twist": "deg",
    "lift": "N",
    "thrust": "N",
    "power": "W",
    "separated": "share",
}
"""Columns of a `History` and their units."""


def towing_power(made: Trim) -> float | None:
    """Drag of the aircraft with still wings times its speed, W; None where still wings stall."""
    from agents.flight.trim import glide

    try:
        return glide(made.aircraft, made.speed).drag * made.speed
    except InputError:
        return None


def as_value(made: Trim) -> dict[str, Any]:
    """A trim as JSON has it; angles in degrees, multipliers as [real, imaginary]."""
    towed = towing_power(made)
    return {
        "speed": made.speed,
        "frequency": made.frequency,
        "twist": math.degrees(made.controls.flapping.twist),
        "amplitude": math.degrees(made.amplitude),
        "tail": math.degrees(made.tail),
        "pitch": math.degrees(made.beat.pitch.mean()),
        "power": made.power,
        "power_without_regain": made.power_without_regain,
        "energy_per_metre": made.energy_per_metre,
        "cost_of_transport": made.cost_of_transport,
        "towing_power": towed,
        "propulsive_efficiency": None if towed is None else towed / made.power,
        "multipliers": [[one.real, one.imag] for one in made.multipliers],
        "largest_multiplier": float(np.abs(made.multipliers[0])),
        "stable": made.stable,
        "residual": made.residual,
    }


def lines(value: dict[str, Any]) -> list[str]:
    """A trim for people, from its value."""
    first = [complex(*one) for one in value["multipliers"][:4]]
    fading = "stable: a small push dies out" if value["stable"] else "unstable: a push grows"
    towed = value["towing_power"]
    made = [
        f"level flight at {value['speed']:g} m/s, {value['frequency']:g} Hz,"
        f" twist R = {value['twist']:g} deg",
        f"  flap amplitude A   {value['amplitude']:.2f} deg",
        f"  tail angle         {value['tail']:.2f} deg (nose up)",
        f"  mean pitch         {value['pitch']:.2f} deg",
        f"  power              {value['power']:.3f} W"
        f"   ({value['power_without_regain']:.3f} W if nothing is regained)",
        f"  energy per metre   {value['energy_per_metre']:.3f} J/m"
        f"   ({value['cost_of_transport']:.3f} of the weight)",
    ]
    if towed is not None:
        made.append(
            f"  towed, wings still {towed:.3f} W"
            f"   (propulsive efficiency {towed / value['power']:.2f})"
        )
    made.append(
        f"  multipliers        |mu| = {', '.join(f'{abs(one):.3f}' for one in first)}   {fading}"
    )
    return made


# Trims over speed.


def swept(
    asked: FlightRequest, speeds: list[float], at: Callable[[float], None]
) -> tuple[list[dict[str, Any]], list[float]]:
    """Values of the trims at speeds (m/s, rising), and the speeds without a level flight.

    Each is searched from its neighbour nearer to the usual speed. Raises InputError if there is no
    flight at all.
    """
    middle = min(speeds, key=lambda speed: abs(speed - SPEED))
    order = [one for one in speeds if one >= middle]
    order += [one for one in reversed(speeds) if one < middle]
    found: dict[float, Trim] = {}
    rows: dict[float, dict[str, Any]] = {}
    missing = []
    for done, speed in enumerate(order):
        near = min(found, key=lambda other: abs(other - speed), default=None)

        def share(part: float, done: int = done) -> None:
            at((done + part) / len(order))

        try:
            found[speed] = trim(
                asked.aircraft,
                speed,
                frequency=asked.frequency,
                twist=asked.twist,
                near=None if near is None else found[near],
                at=share,
            )
        except InputError:
            missing.append(speed)
            continue
        rows[speed] = as_value(found[speed])
    if not rows:
        raise InputError(
            f"no level flight was found at any speed of {', '.join(f'{one:g}' for one in speeds)}"
            " m/s: try other speeds, or another frequency or twist"
        )
    return [rows[speed] for speed in sorted(rows)], sorted(missing)
