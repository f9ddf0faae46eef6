"""`flockscope flight sweep`: the level flights over speed, and the U curve."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from app.cli.flight.flight_options import AsJson, Frequency, Out, Overwrite, Quiet, Settings, Twist
from app.cli.outcome_table import as_json, tell_written
from app.cli.progress import Progress
from app.flight.request import FREQUENCY, TWIST, asked_speed, request
from app.results_folder import demand_folder, picture_files
from app.settings import numbers

DEFAULT = "2.5,3,3.25,3.5,4,4.5,5,6,7"


def sweep(
    speeds: Annotated[str, typer.Option(help="Mean speeds, m/s, 2 to 15.")] = DEFAULT,
    frequency: Frequency = FREQUENCY,
    twist: Twist = TWIST,
    settings: Settings = None,
    out: Out = Path("results/flight-sweep"),
    pictures: Annotated[bool, typer.Option(help="Draw the picture as PNG and SVG.")] = True,
    overwrite: Overwrite = False,
    json_asked: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Trim the aircraft at every speed and print and draw what a metre of flight costs.

    A speed at which no level flight is found is named and left out.
    """
    wanted = sorted({asked_speed("--speeds", one) for one in numbers("--speeds", speeds)})
    asked = request(frequency, twist, settings)
    demand_folder("--out", out, ("sweep.csv", *picture_files("sweep", pictures)), overwrite)
    from app.flight.flight_sheet import write_sheet
    from app.flight.trim_curve import swept

    with Progress("flight sweep", quiet) as progress:
        rows, missing = swept(asked, wanted, progress.at)
    files = {"sweep": out / "sweep.csv"}
    columns = [name for name in rows[0] if name not in ("multipliers", "stable")]
    write_sheet(files["sweep"], {name: [row[name] for row in rows] for name in columns})
    if pictures:
        from app.flight.canvas import paint
        from app.flight.curve_picture import draw_curve

        title = f"Level flight over speed: {frequency:g} Hz, R = {twist:g} deg"
        files |= paint(lambda figure: draw_curve(figure, rows), title, out, "sweep")
    if json_asked:
        made: dict[str, Any] = {"rows": rows, "without_flight": missing}
        made["files"] = {kind: str(path) for kind, path in files.items()}
        typer.echo(as_json(made))
    else:
        typer.echo("\n".join(table(rows)))
        for speed in missing:
            typer.echo(f"{speed:8.3g}    no level flight was found")
    if not quiet:
        tell_written(*files.values())


def table(rows: list[dict[str, Any]]) -> list[str]:
    """The rows for people."""
    made = ["speed m/s  A deg  tail deg  pitch deg  power W   J/m  towed W  |mu|"]
    for row in rows:
        towed = "" if row["towing_power"] is None else f"{row['towing_power']:.3f}"
        made.append(
            f"{row['speed']:8.3g} {row['amplitude']:7.2f} {row['tail']:9.2f} {row['pitch']:10.2f}"
            f" {row['power']:8.3f} {row['energy_per_metre']:6.3f} {towed:>8}"
            f" {row['largest_multiplier']:6.3f}{'' if row['stable'] else '  unstable'}"
        )
    best = min(rows, key=lambda row: row["energy_per_metre"])
    made.append(f"least: {best['energy_per_metre']:.3f} J/m at {best['speed']:g} m/s")
    return made
