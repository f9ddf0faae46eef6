"""`flockscope flight trim`: the level flight at a speed."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from app.cli.flight.flight_options import AsJson, Frequency, Out, Overwrite, Quiet, Settings, Twist
from app.cli.outcome_table import as_json, tell_written
from app.cli.progress import Progress
from app.flight.request import FREQUENCY, SPEED, TWIST, asked_speed, request
from app.results_folder import demand_folder, picture_files


def trim(
    speed: Annotated[float, typer.Option(help="Mean speed, m/s, 2 to 15.")] = SPEED,
    frequency: Frequency = FREQUENCY,
    twist: Twist = TWIST,
    settings: Settings = None,
    out: Out = Path("results/flight-trim"),
    pictures: Annotated[bool, typer.Option(help="Draw the picture as PNG and SVG.")] = True,
    overwrite: Overwrite = False,
    json_asked: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Find flap amplitude and tail angle at which the aircraft flies level at a speed.

    Prints them with power, energy per metre and stability, and draws lift, thrust and power over
    a wing beat.
    """
    asked_speed("--speed", speed)
    asked = request(frequency, twist, settings)
    demand_folder("--out", out, ("beat.csv", *picture_files("beat", pictures)), overwrite)
    from agents.flight.trim import trim as search
    from app.flight.flight_sheet import beat_columns, write_sheet
    from app.flight.trim_report import as_value, lines

    with Progress("flight trim", quiet) as progress:
        made = search(asked.aircraft, speed, frequency=frequency, twist=asked.twist, at=progress.at)
        value = as_value(made)
    files = {"beat": out / "beat.csv"}
    write_sheet(files["beat"], beat_columns(made.beat, frequency))
    if pictures:
        from app.flight.beat_picture import draw_beat, one_beat
        from app.flight.canvas import paint

        title = (
            f"One wing beat in level flight at {speed:g} m/s, {frequency:g} Hz\n"
            f"A = {value['amplitude']:.1f} deg, R = {twist:g} deg,"
            f" {value['energy_per_metre']:.3g} J/m"
        )
        weight = asked.aircraft.weight
        files |= paint(lambda f: draw_beat(f, one_beat(made.beat), weight), title, out, "beat")
    if json_asked:
        value["files"] = {kind: str(path) for kind, path in files.items()}
        typer.echo(as_json(value))
    else:
        typer.echo("\n".join(lines(value)))
    if not quiet:
        tell_written(*files.values())
