"""`flockscope flight`: the flapping-wing aircraft of the thesis."""

from __future__ import annotations

from app.cli.flight.aircraft_list import aircraft
from app.cli.flight.payload import payload
from app.cli.flight.simulate import simulate
from app.cli.flight.sweep import sweep
from app.cli.flight.trim import trim
from app.cli.usage import grouped

flight = grouped(
    "A flapping-wing aircraft: trim it, sweep its speed, load it, fly it.",
    {
        "trim": trim,
        "sweep": sweep,
        "payload": payload,
        "simulate": simulate,
        "aircraft": aircraft,
    },
)
