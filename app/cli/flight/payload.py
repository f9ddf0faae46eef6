"""`flockscope flight payload`: speed, power and endurance over the mass that is carried."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from app.cli.flight.flight_options import AsJson, Frequency, Out, Overwrite, Quiet, Settings, Twist
from app.cli.outcome_table import as_json, tell_written
from app.cli.progress import Progress
from app.flight.request import FREQUENCY, TWIST, asked_speed, request, within
from app.results_folder import demand_folder, picture_files
from app.settings import numbers

if TYPE_CHECKING:
    from app.flight.load import Battery

DEFAULT = "0,50,100,150,200"
ENERGY, EFFICIENCY = 5.0, 0.45
"""Wh, a free choice; the share that the thesis quotes of SmartBird, section 1.2.1."""
HEAVIEST = 4950.0
"""g."""


def payload(
    loads: Annotated[str, typer.Option(help="Carried masses, g.")] = DEFAULT,
    speed: Annotated[
        float | None,
        typer.Option(help="Mean speed of all flights, m/s, 2 to 15. \\[default: of least power]"),
    ] = None,
    battery: Annotated[
        float,
        typer.Option(help="Stored energy, Wh, 0.01 to 1000. The thesis gives none: free choice."),
    ] = ENERGY,
    efficiency: Annotated[
        float,
        typer.Option(
            help="Share of it that comes to the shafts, 0.01 to 1. The thesis quotes 0.45, of "
            "SmartBird."
        ),
    ] = EFFICIENCY,
    frequency: Frequency = FREQUENCY,
    twist: Twist = TWIST,
    settings: Settings = None,
    out: Out = Path("results/flight-payload"),
    pictures: Annotated[bool, typer.Option(help="Draw the picture as PNG and SVG.")] = True,
    overwrite: Overwrite = False,
    json_asked: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Fly level with loads, each at its speed of least power, and print what they cost.

    A load with which no level flight is found is named and left out. The load is spread over the
    body and changes its mass alone. The battery's own mass is part of the aircraft's.
    """
    grams = sorted(
        {within("--loads", one, 0.0, HEAVIEST, "g") for one in numbers("--loads", loads)}
    )
    if speed is not None:
        asked_speed("--speed", speed)
    within("--battery", battery, 0.01, 1000.0, "Wh")
    within("--efficiency", efficiency, 0.01, 1.0, "")
    asked = request(frequency, twist, settings)
    demand_folder("--out", out, ("payload.csv", *picture_files("payload", pictures)), overwrite)
    from app.flight.flight_sheet import write_sheet
    from app.flight.load import Battery, carried, loaded

    kilograms = [one / 1000.0 for one in grams]
    for load in kilograms:
        loaded(asked.aircraft, load, "--loads")
    source = Battery(battery, efficiency)
    with Progress("flight payload", quiet) as progress:
        rows, missing = carried(asked, kilograms, source, speed, progress.at)
    files = {"payload": out / "payload.csv"}
    columns = [name for name in rows[0] if name not in ("multipliers", "stable")]
    write_sheet(files["payload"], {name: [row[name] for row in rows] for name in columns})
    if pictures:
        from app.flight.canvas import paint
        from app.flight.load_picture import draw_load

        where = "at the speed of least power" if speed is None else f"at {speed:g} m/s"
        title = f"Level flight {where} over the load: {frequency:g} Hz, R = {twist:g} deg"
        files |= paint(lambda f: draw_load(f, rows, in_words(source)), title, out, "payload")
    if json_asked:
        made: dict[str, Any] = {
            "battery": battery,
            "efficiency": efficiency,
            "rows": rows,
            "without_flight": [1000.0 * one for one in missing],
        }
        made["files"] = {kind: str(path) for kind, path in files.items()}
        typer.echo(as_json(made))
    else:
        typer.echo("\n".join(table(rows)))
        for load in missing:
            typer.echo(f"{1000.0 * load:6.4g}    no level flight was found")
        typer.echo(f"endurance and range: {in_words(source)}")
    if not quiet:
        tell_written(*files.values())


def in_words(battery: Battery) -> str:
    """What drives the shafts."""
    return f"{battery.energy:g} Wh, of which {battery.efficiency:.0%} come to the shafts"


def table(rows: list[dict[str, Any]]) -> list[str]:
    """The rows for people."""
    made = ["load g  mass kg  speed m/s  A deg  power W    J/m  endurance h  range km  |mu|"]
    made += [
        f"{row['load']:6.4g} {row['mass']:8.3f} {row['speed']:10.3g} {row['amplitude']:6.2f}"
        f" {row['power']:8.3f} {row['energy_per_metre']:6.3f} {row['endurance']:12.3f}"
        f" {row['range']:9.2f} {row['largest_multiplier']:5.3f}"
        f"{'' if row['stable'] else '  unstable'}"
        for row in rows
    ]
    return made
