"""A trim in words and as a value."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from worlds.input_error import InputError

if TYPE_CHECKING:
    from agents.flight.trim import Trim


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
