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
        ["" if value is None else f"{float(value):.9g}" for value in row]
        for row in zip(*columns.values(), strict=True)
    )
    make_folder(path.parent)
    write_text("table", path, csv_text(columns, rows))


def beat_columns(beat: Any, frequency: float) -> dict[str, Any]:
    """Columns of one wing beat or more, angles in degrees; `beat` is a `History`."""
    import numpy as np

    columns = {"time_s": beat.time, "beats": beat.time * frequency}
    for name, unit in COLUMNS.items():
        values = getattr(beat, name)
        columns[f"{name}_{unit}"] = np.degrees(values) if unit.startswith("deg") else values
    return columns


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


def towing_power(trim: Trim) -> float | None:
    """Drag of the aircraft with still wings times its speed, W; None where still wings stall."""
    from agents.flight.trim import glide

    try:
        return glide(trim.aircraft, trim.speed).drag * trim.speed
    except InputError:
        return None


def as_value(trim: Trim) -> dict[str, Any]:
    """A trim as JSON has it; angles in degrees, multipliers as [real, imaginary]."""
    towed = towing_power(trim)
    return {
        "speed": trim.speed,
        "frequency": trim.frequency,
        "twist": math.degrees(trim.controls.flapping.twist),
        "amplitude": math.degrees(trim.amplitude),
        "tail": math.degrees(trim.tail),
        "pitch": math.degrees(trim.beat.pitch.mean()),
        "power": trim.power,
        "power_without_regain": trim.power_without_regain,
        "energy_per_metre": trim.energy_per_metre,
        "cost_of_transport": trim.cost_of_transport,
        "towing_power": towed,
        "propulsive_efficiency": None if towed is None else towed / trim.power,
        "multipliers": [[multiplier.real, multiplier.imag] for multiplier in trim.multipliers],
        "largest_multiplier": float(np.abs(trim.multipliers[0])),
        "stable": trim.stable,
        "residual": trim.residual,
    }


def lines(value: dict[str, Any]) -> list[str]:
    """A trim for people, from its value."""
    first = [complex(*multiplier) for multiplier in value["multipliers"][:4]]
    fading = "stable: a small push dies out" if value["stable"] else "unstable: a push grows"
    towed = value["towing_power"]
    lines = [
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
        lines.append(
            f"  towed, wings still {towed:.3f} W"
            f"   (propulsive efficiency {towed / value['power']:.2f})"
        )
    lines.append(
        f"  multipliers        |mu| = {', '.join(f'{abs(mu):.3f}' for mu in first)}   {fading}"
    )
    return lines


# Trims over speed.


def sweep_speeds(
    request: FlightRequest, speeds: list[float], at: Callable[[float], None]
) -> tuple[list[dict[str, Any]], list[float]]:
    """Values of the trims at speeds (m/s, rising), and the speeds without a level flight.

    Each is searched from its neighbour nearer to the usual speed. Raises InputError if there is no
    flight at all.
    """
    middle = min(speeds, key=lambda speed: abs(speed - SPEED))
    order = [speed for speed in speeds if speed >= middle]
    order += [speed for speed in reversed(speeds) if speed < middle]
    trims: dict[float, Trim] = {}
    rows: dict[float, dict[str, Any]] = {}
    missing = []
    for done, speed in enumerate(order):
        near = min(trims, key=lambda other: abs(other - speed), default=None)

        def share(part: float, done: int = done) -> None:
            at((done + part) / len(order))

        try:
            trims[speed] = trim(
                request.aircraft,
                speed,
                frequency=request.frequency,
                twist=request.twist,
                near=None if near is None else trims[near],
                at=share,
            )
        except InputError:
            missing.append(speed)
            continue
        rows[speed] = as_value(trims[speed])
    if not rows:
        raise InputError(
            "no level flight was found at any speed of "
            f"{', '.join(f'{speed:g}' for speed in speeds)}"
            " m/s: try other speeds, or another frequency or twist"
        )
    return [rows[speed] for speed in sorted(rows)], sorted(missing)
