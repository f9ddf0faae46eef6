"""`flockscope flight aircraft`: the aircraft's values, and who says so."""

from __future__ import annotations

import typer

from app.cli.flight.flight_options import AsJson
from app.cli.outcome_table import as_json


def aircraft(json_asked: AsJson = False) -> None:
    """List what --set can change: value, range, meaning, and whether the thesis says so."""
    from agents.flight.aircraft import Aircraft
    from agents.models.declare import declared

    values = declared(Aircraft)
    if json_asked:
        names = ("name", "symbol", "unit", "default", "low", "high", "description", "source")
        typer.echo(as_json([{name: getattr(one, name) for name in names} for one in values]))
        return
    for one in values:
        typer.echo(
            f"{one.name:<15} {one.default:<7.4g} in {one.allowed:<18}"
            f" {one.description} ({one.source})"
        )
