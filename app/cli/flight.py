"""`flockscope flight`: the flapping-wing aircraft of the thesis."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from app.cli.terminal.outcome_table import as_json, print_written_files
from app.cli.terminal.progress import Progress
from app.cli.terminal.usage import PrintJson, Quiet, command_group
from app.flight.request import FREQUENCY, SPEED, TWIST, check_range, check_speed, request
from app.results_folder import demand_folder, picture_files
from app.settings import numbers
from worlds.number_text import counted

if TYPE_CHECKING:
    from app.flight.load import Battery

# The options that the flight commands share.

Frequency = Annotated[float, typer.Option(help="Of flap and twist, Hz, 0.5 to 6.")]
Twist = Annotated[float, typer.Option(help="R of the wing tip, deg, 0 to 45.")]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        help="Of the aircraft (flight aircraft lists them), NAME=VALUE; may be repeated.",
    ),
]
Out = Annotated[Path, typer.Option(help="Folder for numbers and pictures.")]
Overwrite = Annotated[
    bool, typer.Option("--overwrite", help="Replace what the folder has of these results.")
]
AsJson = PrintJson
Quiet = Quiet


# `flockscope flight aircraft`: the aircraft's values, and who says so.


def aircraft(json_asked: AsJson = False) -> None:
    """List what --set can change: value, range, meaning, and whether the thesis says so."""
    from agents.flight.aircraft import Aircraft
    from agents.models.declare import declared

    values = declared(Aircraft)
    if json_asked:
        names = ("name", "symbol", "unit", "default", "low", "high", "description", "source")
        typer.echo(
            as_json([{name: getattr(parameter, name) for name in names} for parameter in values])
        )
        return
    for parameter in values:
        typer.echo(
            f"{parameter.name:<15} {parameter.default:<7.4g} in {parameter.allowed:<18}"
            f" {parameter.description} ({parameter.source})"
        )


# `flockscope flight trim`: the level flight at a speed.


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
    check_speed("--speed", speed)
    flight_request = request(frequency, twist, settings)
    demand_folder("--out", out, ("beat.csv", *picture_files("beat", pictures)), overwrite)
    from agents.flight.trim import trim as search
    from app.flight.trim_report import as_value, beat_columns, lines, write_sheet

    with Progress("flight trim", quiet) as progress:
        trim = search(
            flight_request.aircraft,
            speed,
            frequency=frequency,
            twist=flight_request.twist,
            at=progress.update,
        )
        value = as_value(trim)
    files = {"beat": out / "beat.csv"}
    write_sheet(files["beat"], beat_columns(trim.beat, frequency))
    if pictures:
        from app.flight.flight_pictures import draw_beat, single_beat, write_figures

        title = (
            f"One wing beat in level flight at {speed:g} m/s, {frequency:g} Hz\n"
            f"A = {value['amplitude']:.1f} deg, R = {twist:g} deg,"
            f" {value['energy_per_metre']:.3g} J/m"
        )
        weight = flight_request.aircraft.weight
        files |= write_figures(
            lambda f: draw_beat(f, single_beat(trim.beat), weight), title, out, "beat"
        )
    if json_asked:
        value["files"] = {kind: str(path) for kind, path in files.items()}
        typer.echo(as_json(value))
    else:
        typer.echo("\n".join(lines(value)))
    if not quiet:
        print_written_files(*files.values())


# `flockscope flight sweep`: the level flights over speed, and the U curve.

SPEEDS = "2.5,3,3.25,3.5,4,4.5,5,6,7"


def sweep(
    speeds: Annotated[str, typer.Option(help="Mean speeds, m/s, 2 to 15.")] = SPEEDS,
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
    speeds_asked = sorted({check_speed("--speeds", value) for value in numbers("--speeds", speeds)})
    flight_request = request(frequency, twist, settings)
    demand_folder("--out", out, ("sweep.csv", *picture_files("sweep", pictures)), overwrite)
    from app.flight.trim_report import sweep_speeds, write_sheet

    with Progress("flight sweep", quiet) as progress:
        rows, missing = sweep_speeds(flight_request, speeds_asked, progress.update)
    files = {"sweep": out / "sweep.csv"}
    columns = [name for name in rows[0] if name not in ("multipliers", "stable")]
    write_sheet(files["sweep"], {name: [row[name] for row in rows] for name in columns})
    if pictures:
        from app.flight.flight_pictures import draw_curve, write_figures

        title = f"Level flight over speed: {frequency:g} Hz, R = {twist:g} deg"
        files |= write_figures(lambda figure: draw_curve(figure, rows), title, out, "sweep")
    if json_asked:
        result: dict[str, Any] = {"rows": rows, "without_flight": missing}
        result["files"] = {kind: str(path) for kind, path in files.items()}
        typer.echo(as_json(result))
    else:
        typer.echo("\n".join(speed_table(rows)))
        for speed in missing:
            typer.echo(f"{speed:8.3g}    no level flight was found")
    if not quiet:
        print_written_files(*files.values())


def speed_table(rows: list[dict[str, Any]]) -> list[str]:
    """The rows for people."""
    lines = ["speed m/s  A deg  tail deg  pitch deg  power W   J/m  towed W  |mu|"]
    for row in rows:
        towed = "" if row["towing_power"] is None else f"{row['towing_power']:.3f}"
        lines.append(
            f"{row['speed']:8.3g} {row['amplitude']:7.2f} {row['tail']:9.2f} {row['pitch']:10.2f}"
            f" {row['power']:8.3f} {row['energy_per_metre']:6.3f} {towed:>8}"
            f" {row['largest_multiplier']:6.3f}{'' if row['stable'] else '  unstable'}"
        )
    best = min(rows, key=lambda row: row["energy_per_metre"])
    lines.append(f"least: {best['energy_per_metre']:.3f} J/m at {best['speed']:g} m/s")
    return lines


# `flockscope flight simulate`: a flight in time, from trim and pushed.

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
    check_speed("--speed", speed)
    check_range("--seconds", seconds, 0.1, LONGEST, "s")
    flight_request = request(frequency, twist, settings)
    demand_folder(
        "--out",
        out,
        ("history.csv", *picture_files("history", pictures), *picture_files("beats", pictures)),
        overwrite,
    )
    from app.flight.compared_flight import fly_pushed, parse_pushes
    from app.flight.trim_report import beat_columns, write_sheet

    moved = parse_pushes(push or [])
    with Progress("flight simulate", quiet) as progress:
        flight = fly_pushed(flight_request, speed, seconds, moved, progress.update)
    files = {"history": out / "history.csv"}
    write_sheet(files["history"], beat_columns(flight.flown, frequency))
    if pictures:
        from app.flight.flight_pictures import draw_beat, draw_history, mean_beat, write_figures

        text = ", ".join(push or []) or "none"
        title = f"A flight from trim at {speed:g} m/s, {frequency:g} Hz; push: {text}"
        more_files = write_figures(
            lambda f: draw_history(f, flight.flown, flight.level), title, out, "history"
        )
        files |= {f"history-{kind}": path for kind, path in more_files.items()}
        if flight.beats:
            mean, weight = mean_beat(flight.flown, flight.per_beat), flight_request.aircraft.weight
            title += f"\nmean of {counted(flight.beats, 'wing beat')}, with their least and largest"
            more_files = write_figures(lambda f: draw_beat(f, mean, weight), title, out, "beats")
            files |= {f"beats-{kind}": path for kind, path in more_files.items()}
    value: dict[str, Any] = flight.value()
    if json_asked:
        value["files"] = {kind: str(path) for kind, path in files.items()}
        typer.echo(as_json(value))
    else:
        typer.echo("\n".join(flight.lines()))
    if not quiet:
        print_written_files(*files.values())


# `flockscope flight payload`: speed, power and endurance over the mass that is carried.

LOADS = "0,50,100,150,200"
ENERGY, EFFICIENCY = 5.0, 0.45
"""Wh, a free choice; the share that the thesis quotes of SmartBird, section 1.2.1."""
HEAVIEST = 4950.0
"""g."""


def payload(
    loads: Annotated[str, typer.Option(help="Carried masses, g.")] = LOADS,
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
        {check_range("--loads", value, 0.0, HEAVIEST, "g") for value in numbers("--loads", loads)}
    )
    if speed is not None:
        check_speed("--speed", speed)
    check_range("--battery", battery, 0.01, 1000.0, "Wh")
    check_range("--efficiency", efficiency, 0.01, 1.0, "")
    flight_request = request(frequency, twist, settings)
    demand_folder("--out", out, ("payload.csv", *picture_files("payload", pictures)), overwrite)
    from app.flight.load import Battery, compute_loads, load_aircraft
    from app.flight.trim_report import write_sheet

    kilograms = [load / 1000.0 for load in grams]
    for load in kilograms:
        load_aircraft(flight_request.aircraft, load, "--loads")
    source = Battery(battery, efficiency)
    with Progress("flight payload", quiet) as progress:
        rows, missing = compute_loads(flight_request, kilograms, source, speed, progress.update)
    files = {"payload": out / "payload.csv"}
    columns = [name for name in rows[0] if name not in ("multipliers", "stable")]
    write_sheet(files["payload"], {name: [row[name] for row in rows] for name in columns})
    if pictures:
        from app.flight.flight_pictures import draw_load, write_figures

        where = "at the speed of least power" if speed is None else f"at {speed:g} m/s"
        title = f"Level flight {where} over the load: {frequency:g} Hz, R = {twist:g} deg"
        files |= write_figures(
            lambda f: draw_load(f, rows, describe_battery(source)), title, out, "payload"
        )
    if json_asked:
        result: dict[str, Any] = {
            "battery": battery,
            "efficiency": efficiency,
            "rows": rows,
            "without_flight": [1000.0 * load for load in missing],
        }
        result["files"] = {kind: str(path) for kind, path in files.items()}
        typer.echo(as_json(result))
    else:
        typer.echo("\n".join(load_table(rows)))
        for load in missing:
            typer.echo(f"{1000.0 * load:6.4g}    no level flight was found")
        typer.echo(f"endurance and range: {describe_battery(source)}")
    if not quiet:
        print_written_files(*files.values())


def describe_battery(battery: Battery) -> str:
    """What drives the shafts."""
    return f"{battery.energy:g} Wh, of which {battery.efficiency:.0%} come to the shafts"


def load_table(rows: list[dict[str, Any]]) -> list[str]:
    """The rows for people."""
    lines = ["load g  mass kg  speed m/s  A deg  power W    J/m  endurance h  range km  |mu|"]
    lines += [
        f"{row['load']:6.4g} {row['mass']:8.3f} {row['speed']:10.3g} {row['amplitude']:6.2f}"
        f" {row['power']:8.3f} {row['energy_per_metre']:6.3f} {row['endurance']:12.3f}"
        f" {row['range']:9.2f} {row['largest_multiplier']:5.3f}"
        f"{'' if row['stable'] else '  unstable'}"
        for row in rows
    ]
    return lines


flight = command_group(
    "A flapping-wing aircraft: trim it, sweep its speed, load it, fly it.",
    {
        "trim": trim,
        "sweep": sweep,
        "payload": payload,
        "simulate": simulate,
        "aircraft": aircraft,
    },
)
