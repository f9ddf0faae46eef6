"""`flockscope film`: a flock in its world while it moves, as MP4, WebM or GIF."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.cli.given import Asked, with_options
from app.cli.outcome import as_json, tell_written
from app.cli.progress import Progress
from app.cli.refusals import INTERRUPTED
from app.cli.rule_option import Rules
from app.cli.run import tell
from app.cli.stopping import Stopping
from app.cli.take.source import flock_of, is_recording, pixels, recording_of
from app.settings import at_least, names
from worlds.counting import counted
from worlds.refusal import Refusal
from worlds.writing import demand_writable

if TYPE_CHECKING:
    from agents import Flock
    from agents.recording import Recording
    from agents.snapshot import Snapshot

LAST = 300
"""Tick at which the film of a run ends, unless another is asked for."""
MOST_FPS = 120.0


@dataclass(frozen=True)
class Plan:
    """Which ticks are shown, and how many of them in a second."""

    ticks: list[int]
    fps: float


def planned(
    ticks: list[int], first: int, last: int, every: int | None, speed: float, fps: float
) -> Plan:
    """The ticks to show of those that there are, rising. Raises Refusal if none is left.

    `speed` ticks are shown in a second, in at most `fps` pictures, unless `every` says otherwise.
    """
    there = [tick for tick in ticks if first <= tick <= last]
    if not there:
        raise Refusal(f"there is no tick from {first} to {last}")
    apart = max(1, (there[-1] - there[0]) // max(1, len(there) - 1))
    step = max(1, round((every if every else speed / fps) / apart))
    rate = min(MOST_FPS, speed / (step * apart))
    return Plan(there[::step], rate)


@with_options
def film(
    spec: Annotated[
        str | None,
        typer.Argument(help="A model, a spec (TOML), a recording, or a FILE.py."),
    ] = None,
    rule: Rules = None,
    *,
    asked: Asked,
    settings: Annotated[
        list[str] | None, typer.Option("--set", help="A parameter, NAME=VALUE; may be repeated.")
    ] = None,
    first: Annotated[int, typer.Option("--from", help="First tick.")] = 0,
    last: Annotated[
        int | None,
        typer.Option("--to", help="Last tick. \\[default: 300; of a recording its last]"),
    ] = None,
    every: Annotated[
        int | None,
        typer.Option(help="Ticks between pictures. \\[default: as --speed and --fps ask for]"),
    ] = None,
    speed: Annotated[float, typer.Option(help="Ticks that a second of the film shows.")] = 30.0,
    fps: Annotated[float, typer.Option(help="Pictures a second, at most.")] = 30.0,
    out: Annotated[Path, typer.Option(help="MP4, WebM or GIF file, by its ending.")] = Path(
        "flock.mp4"
    ),
    size_text: Annotated[str, typer.Option("--pixels", help="Width and height.")] = "1280x800",
    colour: Annotated[str | None, typer.Option(help="As of `flockscope picture`.")] = None,
    follow: Annotated[
        int | None, typer.Option(help="Identity of an agent that the camera follows.")
    ] = None,
    plot: Annotated[
        str | None, typer.Option(help="Observables with commas, plotted below the flock.")
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("--overwrite", help="Let --out replace a file.")
    ] = False,
    json_asked: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="No messages while it is made.")] = False,
) -> None:
    """Film a flock in its world, drawn as `flockscope picture` draws it; no browser is needed.

    What `flockscope run` takes to say which run it is, this takes too.
    """
    from app.viewer.pictures.film import CODECS, Encoder, demand_film, pictures
    from app.viewer.pictures.plots import Plots

    at_least("--from", first, 0)
    at_least("--to", last, first)
    at_least("--every", every, 1)
    for option, value, most in (("--speed", speed, 1e6), ("--fps", fps, MOST_FPS)):
        if not 0.1 <= value <= most:
            raise Refusal(f"{option} {value:g} is outside [0.1, {most:g}]")
    size = pixels(size_text)
    demand_writable("--out", out, overwrite, tuple(CODECS))
    demand_film("flockscope film")
    wanted = names(plot) if plot else []
    source: Recording | Flock
    if is_recording(spec):
        assert spec is not None
        source = recording_of(spec, asked, settings or [], rule)
        end = int(source.ticks[-1]) if last is None else last
        plan = planned(source.ticks.tolist(), first, end, every, speed, fps)
        dt, taken = source.time_per_tick, of_recording(source, plan.ticks)
    else:
        source = flock_of(spec, asked, settings or [], rule, quiet)
        end = max(LAST, first) if last is None else last
        plan = planned(list(range(first, end + 1)), first, end, every, speed, fps)
        dt, taken = source.dt, of_run(source, plan.ticks)
    plots = Plots(wanted, plan.ticks[0] * dt, plan.ticks[-1] * dt) if wanted else None
    with (
        Stopping() as stopping,
        Progress(f"film of {counted(len(plan.ticks), 'picture')}", quiet) as progress,
    ):
        try:
            with Encoder(out, size, plan.fps, overwrite) as encoder:
                made = pictures(taken, size, colour, follow, plots)
                for done, picture in enumerate(made, start=1):
                    encoder.add(picture)
                    if stopping.asked:
                        raise KeyboardInterrupt
                    progress.at(done / len(plan.ticks), text=f"tick {plan.ticks[done - 1]}")
        except KeyboardInterrupt:
            tell("flockscope: stopped; no film was written")
            raise typer.Exit(INTERRUPTED) from None
    if json_asked:
        typer.echo(
            as_json({
                "film": str(out), "pictures": len(plan.ticks), "fps": plan.fps,
                "seconds": len(plan.ticks) / plan.fps, "first_tick": plan.ticks[0],
                "last_tick": plan.ticks[-1],
            })
        )  # fmt: skip
    if not quiet:
        tell_written(out)


def of_recording(recording: Recording, ticks: list[int]) -> Iterator[Snapshot]:
    """The flock at recorded ticks."""
    return map(recording.at, ticks)


def of_run(flock: Flock, ticks: list[int]) -> Iterator[Snapshot]:
    """The flock at ticks, as it gets there."""
    for tick in ticks:
        flock.run(tick - flock.tick)
        yield flock.snapshot(signals=True)
