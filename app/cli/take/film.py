"""`flockscope film`: a flock in its world while it moves, as MP4, WebM, GIF, or HTML that plays."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.cli.options.run_arguments import GivenOptions, with_options
from app.cli.options.run_length import demand_one_length, ticks_asked
from app.cli.options.tracks_options import Origin, Rate, Scale, TracksFile, Unit
from app.cli.take.renderer import AUTO, BROWSER, PLAIN, browser, camera_request, demand_renderer
from app.cli.take.source import flock_of, pixels, recorded_source
from app.cli.terminal.console import INTERRUPTED
from app.cli.terminal.outcome_table import as_json, print_stderr, print_written_files
from app.cli.terminal.progress import Progress, StopSignals
from app.cli.terminal.usage import Overwrite, PrintJson, Rules, Settings
from app.settings import check_whole_number, names
from worlds.file_writer import demand_writable
from worlds.input_error import InputError
from worlds.number_text import counted

if TYPE_CHECKING:
    from agents import Flock
    from agents.recordings.recording import Recording
    from agents.snapshot import Snapshot
    from app.tracks.playing.played_tracks import PlayedTracks
    from app.viewer.pictures.picture_camera import CameraRequest
    from app.viewer.pictures.plane import Plots

LAST = 300
"""Tick at which the film of a run ends, unless another is asked for."""
MOST_FPS = 120.0
SPEED = 30.0
"""Ticks of a run that a second of a film shows."""
PAGE = ".html"


@dataclass(frozen=True)
class FilmPlan:
    """Which ticks are shown, and how many of them in a second."""

    ticks: list[int]
    fps: float
    left_out: int = 0
    """Ticks after the last one that is shown."""


def plan_film(
    ticks: list[int], first: int, last: int, every: int | None, speed: float, fps: float
) -> FilmPlan:
    """The ticks to show of those that there are, rising. Raises InputError if none is left.

    `speed` ticks are shown in a second, in at most `fps` pictures, unless `every` says otherwise.
    """
    in_range = [tick for tick in ticks if first <= tick <= last]
    if not in_range:
        raise InputError(f"there is no tick from {first} to {last}")
    apart = max(1, (in_range[-1] - in_range[0]) // max(1, len(in_range) - 1))
    step = max(1, round((every if every else speed / fps) / apart))
    rate = min(MOST_FPS, speed / (step * apart))
    chosen_ticks = in_range[::step]
    return FilmPlan(chosen_ticks, rate, in_range[-1] - chosen_ticks[-1])


@with_options
def film(
    spec: Annotated[
        str | None,
        typer.Argument(help="A model, a spec (TOML), a recording, or a FILE.py."),
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
    first: Annotated[int, typer.Option("--from", help="First tick.")] = 0,
    last: Annotated[
        int | None,
        typer.Option("--to", help="Last tick. \\[default: 300; of a recording its last]"),
    ] = None,
    length: Annotated[
        int | None, typer.Option("--ticks", help="Instead of --to: ticks after the first.")
    ] = None,
    seconds: Annotated[
        float | None,
        typer.Option(
            help="The same as time of the flock, of a model that counts seconds; not of the film."
        ),
    ] = None,
    every: Annotated[
        int | None,
        typer.Option(help="Ticks between pictures. \\[default: as --speed and --fps ask for]"),
    ] = None,
    speed: Annotated[
        float | None,
        typer.Option(
            help="Ticks that a second of the film shows. \\[default: 30; of tracks as time went]"
        ),
    ] = None,
    fps: Annotated[float, typer.Option(help="Pictures a second, at most.")] = 30.0,
    out: Annotated[Path, typer.Option(help="MP4, WebM, GIF or HTML file, by its ending.")] = Path(
        "flock.mp4"
    ),
    size_text: Annotated[str, typer.Option("--pixels", help="Width and height.")] = "1280x800",
    colour: Annotated[str | None, typer.Option(help="As of `flockscope picture`.")] = None,
    renderer: Annotated[
        str,
        typer.Option(
            help="browser: as the page shows it, by a Chromium, Chrome or Edge of this machine; "
            "plain: drawn without one; auto: by a browser where one is found."
        ),
    ] = AUTO,
    camera: Annotated[
        str, typer.Option(help="fixed, top-down, perspective, side, follow (an agent) or round.")
    ] = "fixed",
    turn: Annotated[
        float | None,
        typer.Option(help="Degrees a second of --camera round. \\[default: round once]"),
    ] = None,
    follow: Annotated[
        int | None, typer.Option(help="Identity of an agent that the camera follows.")
    ] = None,
    plot: Annotated[
        str | None, typer.Option(help="Observables with commas, plotted below the flock.")
    ] = None,
    overwrite: Overwrite = False,
    json_asked: PrintJson = False,
    quiet: Annotated[bool, typer.Option("--quiet", help="No messages while it is made.")] = False,
) -> None:
    """Film a flock in its world, as the page shows it where there is a browser.

    An HTML file plays the run in any browser, without a server or network: its camera is whoever's
    who watches. What `flockscope run` takes to say which run it is, this takes too.
    """
    from app.viewer.pictures.film_writer import CODECS, demand_film
    from app.viewer.pictures.plane import Plots

    check_whole_number("--from", first, 0)
    check_whole_number("--to", last, first)
    demand_one_length(length, seconds, last)
    check_whole_number("--every", every, 1)
    for option, value, most in (("--speed", speed, 1e6), ("--fps", fps, MOST_FPS)):
        if value is not None and not 0.1 <= value <= most:
            raise InputError(f"{option} {value:g} is outside [0.1, {most:g}]")
    size = pixels(size_text)
    demand_renderer(renderer)
    demand_writable("--out", out, overwrite, (*CODECS, PAGE))
    camera_request(camera, follow, turn, 1.0, 1)
    is_page = out.suffix.lower() == PAGE
    if is_page:
        demand_no_film(camera, follow, plot)
    else:
        demand_film("flockscope film")
    plot_names = names(plot) if plot else []
    taken_at: Callable[[list[int]], Iterator[Snapshot]]
    reading = {"rate": rate, "unit": unit, "scale": scale, "origin": origin}
    recorded = recorded_source(spec, tracks, reading, options, settings or [], rule)
    if recorded is not None:
        model, unit = recorded.spec.model, recorded.time_unit
        length = ticks_asked(length, seconds, model, unit, recorded.time_per_tick)
        last = last if length is None else first + length
        end = int(recorded.ticks[-1]) if last is None else last
        ticks, dt, taken_at = (
            recorded.ticks.tolist(),
            recorded.time_per_tick,
            recorded_flock_at(recorded),
        )
        agents, dim = len(recorded.at(ticks[0]).ids) if is_page else 0, recorded.world.dim
    else:
        flock = flock_of(spec, options, settings or [], rule, quiet)
        model, unit = flock.model.name, flock.model.body.unit
        length = ticks_asked(length, seconds, model, unit, flock.dt)
        last = last if length is None else first + length
        end = max(LAST, first) if last is None else last
        ticks, dt, taken_at = list(range(first, end + 1)), flock.dt, run_to(flock)
        agents, dim = len(flock.ids), flock.world.dim
    if speed is None:
        speed = SPEED if tracks is None else min(max(1.0 / dt, 0.1), 1e6)
    plan = plan_film(ticks, first, end, every, speed, fps)
    if is_page:
        plan = thin_plan(plan, agents, dim, every, quiet)
    if plan.left_out and not quiet:
        left = counted(plan.left_out, "tick")
        print_stderr(
            f"flockscope: the film ends at tick {plan.ticks[-1]}: {left} more make no picture"
        )
    span = plan.ticks[-1] - plan.ticks[0]
    apart = span / max(len(plan.ticks) - 1, 1)
    asked_of = FilmJob(
        taken_at(plan.ticks), plan, out, size, colour, renderer,
        camera_request(camera, follow, turn, max(plan.fps * apart, 1e-9), span),
        Plots(plot_names, plan.ticks[0] * dt, plan.ticks[-1] * dt) if plot_names else None,
        overwrite, quiet,
    )  # fmt: skip
    with (
        StopSignals() as stopping,
        Progress(f"film of {counted(len(plan.ticks), 'picture')}", quiet) as progress,
    ):

        def went_on(done: int) -> None:
            if stopping.asked:
                raise KeyboardInterrupt
            progress.update(done / len(plan.ticks), text=f"tick {plan.ticks[done - 1]}")

        try:
            drawn_by = write_page(asked_of, went_on) if is_page else write_film(asked_of, went_on)
        except (KeyboardInterrupt, InputError) as why:
            if isinstance(why, InputError) and not stopping.asked:
                raise
            print_stderr("flockscope: stopped; no film was written")
            raise typer.Exit(INTERRUPTED) from None
    if json_asked:
        typer.echo(
            as_json({
                "film": str(out), "pictures": len(plan.ticks), "fps": plan.fps,
                "seconds": len(plan.ticks) / plan.fps, "first_tick": plan.ticks[0],
                "last_tick": plan.ticks[-1], "renderer": drawn_by, "bytes": out.stat().st_size,
            })
        )  # fmt: skip
    if not quiet:
        print_written_files(out)


@dataclass(frozen=True)
class FilmJob:
    """A film that is to be made."""

    taken: Iterator[Snapshot]
    plan: FilmPlan
    out: Path
    size: tuple[int, int]
    colour: str | None
    renderer: str
    aim: CameraRequest
    plots: Plots | None
    overwrite: bool
    quiet: bool


def write_film(job: FilmJob, went_on: Callable[[int], None]) -> str:
    """Make a film; who has drawn it. Raises InputError."""
    from app.viewer.pictures.film_writer import Encoder, pictures, seen_pictures
    from app.viewer.pictures.shot import frame_of, look_of
    from app.viewer.scene.shown.drawing_style import shows_density

    first, renderer = next(job.taken), job.renderer
    if renderer == AUTO and shows_density(frame_of(first, look_of(first, job.colour), 0.0)):
        renderer = PLAIN
        if not job.quiet:
            print_stderr(f"flockscope: {len(first.ids)} agents: a plain film of their density")
    taken = chain([first], job.taken)
    with (
        browser(renderer, job.quiet) as window,
        Encoder(job.out, job.size, job.plan.fps, job.overwrite) as encoder,
    ):
        more = job.size, job.colour, job.aim, job.plots
        images = pictures(taken, *more) if window is None else seen_pictures(
            taken, window, *more
        )  # fmt: skip
        for done, picture in enumerate(images, start=1):
            encoder.add(picture)
            went_on(done)
    return PLAIN if window is None else BROWSER


def write_page(job: FilmJob, went_on: Callable[[int], None]) -> str:
    """Make an HTML file that plays; what it is played by. Raises InputError."""
    from app.viewer.pictures.player import page_of
    from worlds.file_writer import writing

    page = page_of(job.taken, len(job.plan.ticks), job.plan.fps, job.colour, job.aim, went_on)
    with writing("--out", job.out, job.overwrite, (PAGE,)) as file:
        file.write(page)
    return PAGE[1:]


def demand_no_film(camera: str, follow: int | None, plot: str | None) -> None:
    """Refuse what an HTML file has not. Raises InputError."""
    if follow is not None or camera in ("follow", "round"):
        what = f"--follow {follow}" if follow is not None else f"--camera {camera}"
        raise InputError(
            f"{what} is not allowed with an HTML file: who watches it moves the camera"
        )
    if plot is not None:
        raise InputError(
            f"--plot {plot} is not allowed with an HTML file: it holds the scene alone"
        )


def thin_plan(plan: FilmPlan, agents: int, dim: int, every: int | None, quiet: bool) -> FilmPlan:
    """The plan of an HTML file, of every k-th picture where it would be large. Raises
    InputError."""
    from app.viewer.pictures.player import LIGHT, agents_worth, demand_playable

    apart = -(-agents_worth(agents, dim) * len(plan.ticks) // LIGHT)
    if every is None and apart > 1:
        chosen_ticks = plan.ticks[::apart]
        left_out = plan.left_out + plan.ticks[-1] - chosen_ticks[-1]
        plan = FilmPlan(chosen_ticks, plan.fps / apart, left_out)
        if not quiet:
            print_stderr(
                f"flockscope: one of {apart} pictures is taken, so that the file stays small; "
                "--every 1 takes all ticks"
            )
    demand_playable(agents, dim, len(plan.ticks))
    return plan


def recorded_flock_at(
    recording: Recording | PlayedTracks,
) -> Callable[[list[int]], Iterator[Snapshot]]:
    """The flock at recorded ticks."""
    return lambda ticks: map(recording.at, ticks)


def run_to(flock: Flock) -> Callable[[list[int]], Iterator[Snapshot]]:
    """The flock at ticks, as it gets there."""

    def taken(ticks: list[int]) -> Iterator[Snapshot]:
        for tick in ticks:
            flock.run(tick - flock.tick)
            yield flock.snapshot(signals=True)

    return taken
