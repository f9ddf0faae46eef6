"""`flockscope picture`: a flock in its world at a tick, as PNG, SVG or PDF."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.cli.options.run_arguments import GivenOptions, with_options
from app.cli.options.tracks_options import Origin, Rate, Scale, TracksFile, Unit
from app.cli.take.renderer import AUTO, BROWSER, PLAIN, browser, camera_request, demand_renderer
from app.cli.take.source import flock_of, pixels, recorded_source
from app.cli.terminal.console import INTERRUPTED
from app.cli.terminal.outcome_table import as_json, print_written_files
from app.cli.terminal.progress import Progress, run_ticks
from app.cli.terminal.usage import Overwrite, PrintJson, Quiet, Rules, Settings
from app.settings import check_whole_number
from worlds.file_writer import demand_writable, writing
from worlds.input_error import InputError

if TYPE_CHECKING:
    from agents.snapshot import Snapshot

ENDINGS = (".png", ".svg", ".pdf")
TICK = 100
"""Of a run, unless another is asked for."""


@with_options
def picture(
    spec: Annotated[
        str | None,
        typer.Argument(help="A model, a spec (TOML), a recording or saved state, or a FILE.py."),
    ] = None,
    rule: Rules = None,
    *,
    options: GivenOptions,
    settings: Settings = None,
    tracks: TracksFile = None,
    rate: Rate = None,
    unit: Unit = None,
    scale: Scale = None,
    origin: Origin = None,
    tick: Annotated[
        int | None,
        typer.Option(help="Which tick to draw. \\[default: 100; of what is recorded the last]"),
    ] = None,
    out: Annotated[Path, typer.Option(help="PNG, SVG or PDF file, by its ending.")] = Path(
        "flock.png"
    ),
    size_text: Annotated[
        str, typer.Option("--pixels", help="Width and height of a PNG.")
    ] = "1600x1000",
    colour: Annotated[
        str | None,
        typer.Option(
            help="heading, layer, group, speed, energy saved, plain, neighbours, or a signal of "
            "the model. \\[default: layer where an information agent leads, else heading]"
        ),
    ] = None,
    renderer: Annotated[
        str,
        typer.Option(
            help="browser: as the page shows it, by a Chromium, Chrome or Edge of this machine; "
            "plain: drawn without one; auto: a PNG in space by a browser where one is found."
        ),
    ] = AUTO,
    camera: Annotated[
        str, typer.Option(help="fixed, top-down, perspective, side, or follow (an agent).")
    ] = "fixed",
    follow: Annotated[
        int | None, typer.Option(help="Identity of an agent to look at closely.")
    ] = None,
    overwrite: Overwrite = False,
    json_asked: PrintJson = False,
    quiet: Quiet = False,
) -> None:
    """Draw a flock in its world at a tick, with what colours mean, a scale and a caption.

    What `flockscope run` takes to say which run it is, this takes too.
    """
    check_whole_number("--tick", tick, 0)
    size = pixels(size_text)
    demand_renderer(renderer)
    demand_writable("--out", out, overwrite, ENDINGS)
    is_vector = out.suffix.lower() != ".png"
    if is_vector and renderer == BROWSER:
        raise InputError(f"--renderer browser is not allowed: a browser draws no {out.suffix}")
    if camera == "round":
        raise InputError("--camera round is not allowed: a picture stands still")
    aim = camera_request(camera, follow, None, 1.0, 1)
    reading = {"rate": rate, "unit": unit, "scale": scale, "origin": origin}
    recorded = recorded_source(spec, tracks, reading, options, settings or [], rule)
    if recorded is not None:
        now = recorded.at(tick)
    else:
        now = flock_to_draw(spec, rule, options, settings or [], tick, quiet)
    from app.viewer.pictures.shot import look_of, shot

    frame_shot = shot(now, look_of(now, colour))
    seen_from = aim.camera(frame_shot)
    is_plan = now.world.dim == 2 and aim.is_from_above
    if renderer == AUTO and (is_vector or is_plan or frame_shot.made.shows_density):
        renderer = PLAIN
    with browser(renderer, quiet) as window:
        if window is None:
            from app.viewer.pictures.picture_sheet import Sheet

            aim.demand_plain(now.world.dim)
            Sheet(frame_shot, size, seen_from).write(out)
        else:
            from app.viewer.pictures.film_writer import seen_picture

            with writing("--out", out, overwrite, ENDINGS) as file:
                file.write(seen_picture(frame_shot, window, size, seen_from))
    if json_asked:
        result = {"picture": str(out), "model": now.model.name,
                  "tick": now.tick, "time": now.elapsed,
                "renderer": PLAIN if window is None else BROWSER}  # fmt: skip
        typer.echo(as_json(result))
    if not quiet:
        print_written_files(out)


def flock_to_draw(
    spec: str | None,
    rule: Rules,
    options: GivenOptions,
    settings: list[str],
    tick: int | None,
    quiet: bool,
) -> Snapshot:
    """The flock to draw, of a run that is made. Raises InputError."""
    flock = flock_of(spec, options, settings, rule, quiet)
    target_tick = TICK if tick is None else tick
    with Progress(f"{flock.model.name} to tick {target_tick}", quiet) as progress:
        if target_tick and not run_ticks(flock, target_tick, progress):
            raise typer.Exit(INTERRUPTED)
    return flock.snapshot(signals=True)
