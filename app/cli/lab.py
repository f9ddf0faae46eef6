"""`flockscope` and `flockscope lab`: the laboratory in a browser."""

from __future__ import annotations

import time
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from agents.catalogue import FILES, MODELS
from agents.catalogue import model as find_model
from agents.flock_world import find_world
from agents.individuals import split_individuals
from agents.kinds import kind_table
from agents.models.declare import checked
from agents.spec import DEFAULT, Spec
from app.cli.options.run_arguments import (
    GivenOptions,
    demand_alone,
    demand_parameters,
    demand_policies,
    is_file,
    option_name,
    requested_run,
    with_options,
)
from app.cli.options.serving_options import AllowHost, Host, OpenBrowser, Port, announce
from app.cli.options.tracks_options import (
    Origin,
    Rate,
    Scale,
    TracksFile,
    Unit,
    demand_tracks,
    played_tracks,
)
from app.cli.terminal.progress import StopSignals, exit_process
from app.cli.terminal.usage import Controllers, Rules, first_of, model_name
from app.front.origin import parse_allowed_host
from app.results_folder import RUNS, demand_runs
from app.settings import assignment
from app.steering.controller_pilot import open_controllers
from app.viewer.run.run_preset import preset_spec
from worlds.input_error import InputError, unknown

if TYPE_CHECKING:
    from app.viewer.gallery.saved_scene import SavedScene
    from app.viewer.run.stored_flock import StoredFlock
    from app.viewer.run.stored_tracks import StoredTracks

NOISE = 0.3
"""Noise that keeps the picture alive, rad, for models that would have none."""
LOOK = 0.1
"""Time between two looks whether somebody asked it to stop, s."""


@with_options
def lab(
    model: Annotated[
        str | None,
        typer.Argument(
            help=f"Model: {', '.join(MODELS)}, or a FILE: a rule (FILE.py), a scene or a spec "
            "(TOML), a saved state or a recording (Parquet).",
            callback=model_name,
            show_default=DEFAULT,
        ),
    ] = None,
    rule: Rules = None,
    scene: Annotated[
        str | None,
        typer.Option(help="A scene: NAME of a built-in one, or FILE.toml of a scene or a spec."),
    ] = None,
    lesson: Annotated[
        str | None, typer.Option(help="A lesson: NAME, as `flockscope list lessons` has it.")
    ] = None,
    beside: Annotated[
        str | None,
        typer.Option(
            help="A second model, beside it in the same world from the same start.",
            callback=model_name,
        ),
    ] = None,
    *,
    options: GivenOptions,
    set: Annotated[
        list[str] | None,
        typer.Option("--set", help="A parameter, NAME=VALUE, of either model; may be repeated."),
    ] = None,
    steer: Controllers = None,
    tracks: TracksFile = None,
    rate: Rate = None,
    unit: Unit = None,
    scale: Scale = None,
    origin: Origin = None,
    speed: Annotated[float | None, typer.Option(min=0.1, help="Ticks per second at first.")] = None,
    threads: Annotated[int, typer.Option(min=1, help="Threads for a large flock.")] = 1,
    runs: Annotated[
        Path,
        typer.Option(
            help="The file (.jsonl) in which its runs are kept, from which the tab Runs begins.",
        ),
    ] = RUNS,
    port: Port = 8080,
    host: Host = "127.0.0.1",
    allow_host: AllowHost = None,
    open_browser: OpenBrowser = True,
) -> None:
    """Open the laboratory: watch a flock in the browser, steer it and measure it."""
    from app.front.origin import local_address
    from app.front.page_front import Front
    from app.front.server import close_server, open_server
    from app.viewer.lab.scene_requests import SCRIPTS

    names = tuple(parse_allowed_host(name) for name in allow_host or ())
    model = first_of(model, rule)
    file, model = (model, None) if is_file(model) else (None, model)
    demand_runs(runs)
    if lesson is not None:
        scene = lesson_scene(lesson, scene, file)
    reading = {"rate": rate, "unit": unit, "scale": scale, "origin": origin}
    demand_tracks(tracks, **reading)
    opened: SavedScene | StoredFlock | StoredTracks | None
    if tracks is not None:
        demand_alone(
            "--tracks",
            {
                "FILE": file,
                "MODEL": model,
                "--scene": scene,
                "--beside": beside,
                "--set": set,
                **{option_name(one): value for one, value in options.items()},
            },
        )
        from app.viewer.run.stored_tracks import StoredTracks

        opened = StoredTracks(played_tracks(tracks, **reading))
    else:
        opened = open_argument(file, scene, model, beside, options, set)
    model = model or DEFAULT
    own, others = parameters(find_model(model).name, set or [], beside)
    request, origins = requested_run(model, options, [])
    with origins.naming_origins():
        if isinstance(request.size, tuple):
            sides = list(request.size)
            raise InputError(f"size = {sides} is not allowed: here all sides are alike")
        spec = preset_spec(**{**dict(request), "parameters": own})
        find_world(spec, find_model(spec.model))
        second = None if beside is None else Spec(beside, parameters=others)
    if opened is not None:
        spec, second = opened.spec, getattr(opened, "beside", None)
    if not getattr(opened, "is_played", False):  # what is played flies by nothing any more
        demand_policies(spec.kinds)
    controllers = open_controllers(steer, kind_table(spec.kinds, spec.to))
    with StopSignals() as stopping:
        server = open_server(host, port, Front(SCRIPTS, names))
        try:  # the page is served, and loads in the browser, before what takes long to import
            if open_browser:
                webbrowser.open(local_address(host, server.get_port()))
            from agents.flock import Flock
            from app.viewer.lab.laboratory import Laboratory
            from app.viewer.lab.runs_file import RunsFile
            from app.viewer.run.paired_run import companion

            kept = RunsFile(runs)
            with origins.naming_origins():
                if not hasattr(opened, "recording"):  # which has been looked at as it was read
                    flock = Flock(spec, threads=threads)
                    if second is not None:
                        companion(flock, second)
        except BaseException:
            close_server(server)
            raise
        laboratory = Laboratory(
            spec,
            host,
            speed=speed,
            beside=second,
            threads=threads,
            server=server,
            opened=opened,
            waits=True,
            runs=kept,
            pilots=controllers,
        )
        serve(laboratory, stopping)
    exit_process()


def open_argument(
    file: str | None,
    scene: str | None,
    model: str | None,
    beside: str | None,
    options: GivenOptions,
    settings: list[str] | None,
) -> SavedScene | StoredFlock | None:
    """The file or the scene that is asked for; the first one where nothing is. Raises
    InputError."""
    from app.viewer.gallery.scene_collection import FIRST, find_scene

    given_names = [name for name, value in options.items() if value is not None]
    others = [
        *(["MODEL"] if model else []),
        *(["--beside"] if beside else []),
        *map(option_name, given_names),
    ]
    others += ["--set"] if settings else []
    if scene is not None and file is not None:
        others.insert(0, "--scene")
    if file is None and scene is None:
        return None if others else find_scene(FIRST)
    if others:
        what = "--scene" if file is None else file
        raise InputError(f"{what} has a run of its own: it cannot be given with {others[0]}")
    if file is None and not is_file(scene):
        return find_scene(scene or "")
    from app.viewer.gallery.file_opener import opened_file

    return opened_file(file or scene or "")


def lesson_scene(lesson: str, scene: str | None, file: str | None) -> str:
    """The name by which a lesson is opened as a scene. Raises InputError."""
    from app.viewer.gallery.lessons.lessons import lesson_names
    from app.viewer.gallery.scene_collection import LESSON

    if scene is not None or file is not None:
        other = file or "--scene"
        raise InputError(f"--lesson has a run of its own: it cannot be given with {other}")
    if lesson not in lesson_names():
        raise unknown("lesson", lesson, lesson_names())
    return LESSON + lesson


def parameters(
    model: str, settings: list[str], beside: str | None = None
) -> tuple[dict[str, Any], dict[str, Any]]:
    """What `--set` gives, and a little noise: for the model, and for the one beside it alone.

    A name that both have without sharing it means the first model's. Raises InputError.
    """
    values = dict(assignment(setting) for setting in settings)
    names = [model] if beside is None else [model, find_model(beside).name]
    demand_parameters(values, [find_model(name).parameters for name in names])
    if beside is None:
        return parameters_with_noise(model, values), {}
    from app.viewer.run.paired_run import shared_model_parameters

    both = shared_model_parameters(model, find_model(beside).name)
    first, second = (set(MODELS[name].parameters.model_fields) for name in (model, beside))
    others = {name: value for name, value in values.items() if name in second - first}
    own = parameters_with_noise(
        model, {name: value for name, value in values.items() if name not in others}
    )
    more = parameters_with_noise(beside, others)
    return own, {name: value for name, value in more.items() if name not in both}


def parameters_with_noise(model: str, values: dict[str, Any]) -> dict[str, Any]:
    """The given parameters of a model, checked, and a little noise. Raises InputError."""
    declared = MODELS[model].parameters
    noise = declared.model_fields.get("eta")
    moved = {"eta": NOISE} if noise is not None and noise.default == 0.0 else {}
    shared, individuals = split_individuals(moved | values, "--set")
    parameters = checked(declared, shared, "--set").model_dump() | individuals
    MODELS[model].demand_individual(individuals)
    return {name: parameters[name] for name in shared}


def serve(laboratory: Any, stopping: StopSignals) -> None:
    """Tell the address and serve until Ctrl-C or SIGTERM."""
    try:
        announce(laboratory.host, laboratory.port, "Ctrl-C stops it", "press every button")
        ready = laboratory.simulation.ready.wait(0.8)
        if not ready or laboratory.simulation.state.compiling is not None:
            typer.echo(
                "compiling (first run only); you see a preview until it is ready ...", err=True
            )
        from app.viewer.lab.rule_files import RuleFiles

        rules = RuleFiles(FILES, laboratory.take_rule)
        while not stopping.asked:
            time.sleep(LOOK)
            rules.look()
            if laboratory.rest():
                typer.echo("paused: no browser has watched for ten minutes", err=True)
    finally:
        typer.echo("", err=True)
        laboratory.close()
        for line in laboratory.notices.unshown():
            typer.echo(f"flockscope: {line}", err=True)
