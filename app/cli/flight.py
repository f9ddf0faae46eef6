"""`flockscope flight`: the flapping-wing aircraft of the thesis."""

from __future__ import annotations

import typer

from app.cli.flight_aircraft import aircraft
from app.cli.flight_simulate import simulate
from app.cli.flight_sweep import sweep
from app.cli.flight_trim import trim
from app.cli.refusals import told

flight = typer.Typer(
    help="A flapping-wing aircraft: trim it, sweep its speed, fly it.",
    no_args_is_help=True,
    add_completion=False,
)
flight.command("trim")(told(trim))
flight.command("sweep")(told(sweep))
flight.command("simulate")(told(simulate))
flight.command("aircraft")(told(aircraft))
