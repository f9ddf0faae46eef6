"""`flockscope flight`: the flapping-wing aircraft of the thesis."""

from __future__ import annotations

from app.cli.flight_aircraft import aircraft
from app.cli.flight_simulate import simulate
from app.cli.flight_sweep import sweep
from app.cli.flight_trim import trim
from app.cli.usage import grouped

flight = grouped(
    "A flapping-wing aircraft: trim it, sweep its speed, fly it.",
    {
        "trim": trim,
        "sweep": sweep,
        "simulate": simulate,
        "aircraft": aircraft,
    },
)
