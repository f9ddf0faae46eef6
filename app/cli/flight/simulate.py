"""`flockscope flight simulate`: a flight in time, from trim and pushed."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from app.cli.flight.flight_options import AsJson, Frequency, Out, Overwrite, Quiet, Settings, Twist
from app.cli.outcome_table import as_json, tell_written
from app.cli.progress import Progress
from app.flight.request import FREQUENCY, SPEED, TWIST, asked_speed, request, within
from app.results_folder import demand_folder, picture_files
from worlds.number_text import counted

LONGEST = 120.0
"""Seconds."""


def simulate(
    speed: Annotated[float, typer.Option(help="Mean speed of the trim, m/s, 2 to 15.")] = SPEED,
    frequency: Frequency = FREQUENCY,
    twist: Twist = TWIST,
    seconds: Annotated[float, typer.Option(help="How long it flies, s, 0.1 to 120.")] = 8.0,
    push: Annotated[
        list[str] | None,
        typer.Option(
            help="At the start: u=M/S forward, w=M/S down, q=DEG/S and theta=DEG nose up;"
            " may be repeated."
        ),
    ] = None,
    settings: Settings = None,
    out: Out = Path("results/flight-simulate"),
    pictures: Annotated[bool, typer.Option(help="Draw the pictures as PNG and SVG.")] = True,
    overwrite: Overwrite = False,
    json_asked: AsJson = False,
    quiet: Quiet = False,
) -> None:
    """Fly the aircraft from its trim, with a push at the start, and see what becomes of it.

    Draws the flight over time, and lift, thrust and power averaged over its wing beats.
    """
    asked_speed("--speed", speed)
    within("--seconds", seconds, 0.1, LONGEST, "s")
    asked = request(frequency, twist, settings)
    demand_folder(
        "--out",
        out,
        ("history.csv", *picture_files("history", pictures), *picture_files("beats", pictures)),
        overwrite,
    )
    from app.flight.compared_flight import flown, pushes
    from app.flight.flight_sheet import beat_columns, write_sheet

    moved = pushes(push or [])
    with Progress("flight simulate", quiet) as progress:
        made = flown(asked, speed, seconds, moved, progress.at)
    files = {"history": out / "history.csv"}
    write_sheet(files["history"], beat_columns(made.flown, frequency))
    if pictures:
        from app.flight.beat_picture import averaged, draw_beat
        from app.flight.canvas import paint
        from app.flight.history_picture import draw_history

        said = ", ".join(push or []) or "none"
        title = f"A flight from trim at {speed:g} m/s, {frequency:g} Hz; push: {said}"
        drawn = paint(lambda f: draw_history(f, made.flown, made.level), title, out, "history")
        files |= {f"history-{kind}": path for kind, path in drawn.items()}
        if made.beats:
            mean, weight = averaged(made.flown, made.per_beat), asked.aircraft.weight
            title += f"\nmean of {counted(made.beats, 'wing beat')}, with their least and largest"
            drawn = paint(lambda f: draw_beat(f, mean, weight), title, out, "beats")
            files |= {f"beats-{kind}": path for kind, path in drawn.items()}
    value: dict[str, Any] = made.value()
    if json_asked:
        value["files"] = {kind: str(path) for kind, path in files.items()}
        typer.echo(as_json(value))
    else:
        typer.echo("\n".join(made.lines()))
    if not quiet:
        tell_written(*files.values())
