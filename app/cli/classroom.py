"""`flockscope class`: a class behind one address, each student with a flock of their own."""

from __future__ import annotations

import asyncio
import time
import webbrowser
from datetime import datetime
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.cli.options.run_arguments import is_file
from app.cli.options.serving_options import AllowHost, Host, OpenBrowser, Port
from app.cli.terminal.progress import StopSignals, exit_process
from app.front.origin import LOOPBACK, parse_allowed_host
from app.results_folder import RESULTS
from app.studies.workers.process_executor import cores
from worlds.file_writer import demand_writable
from worlds.input_error import InputError, unknown

if TYPE_CHECKING:
    from app.classroom.class_keeper import ClassKeeper
    from app.classroom.classroom import Classroom
    from app.classroom.front.serving import ClassFront
    from app.viewer.gallery.saved_scene import SavedScene

LOOK = 0.1
"""Seconds between two looks whether somebody asked it to stop."""
FAREWELL = 1.0
"""Seconds that pages have to hear that a class is over."""
MOST_STUDENTS, MOST_ON_SERVER = 500, 200
"""Where flocks run in browsers, and where they run on the server."""
FILE = ".zip"
"""The ending of a class's file."""


class FlockPlace(StrEnum):
    """Where students' flocks run."""

    IN_BROWSER = "in-browser"
    ON_SERVER = "on-server"


def classroom(
    scene: Annotated[
        str | None,
        typer.Argument(
            help="A lesson or a scene by its NAME, FILE.toml of a scene, or FILE.zip of a class "
            "that is opened again.",
            show_default="order-against-noise",
        ),
    ] = None,
    lesson: Annotated[
        str | None, typer.Option(help="A lesson: NAME, as `flockscope list lessons` has it.")
    ] = None,
    students: Annotated[
        int,
        typer.Option(
            min=1,
            max=MOST_STUDENTS,
            help=f"Students at most; {MOST_ON_SERVER} where flocks run on the server.",
        ),
    ] = 40,
    flocks: Annotated[
        FlockPlace | None,
        typer.Option(
            help="Where students' flocks run.", show_default="in-browser where the scene can"
        ),
    ] = None,
    host: Host = "127.0.0.1",
    port: Port = 8080,
    allow_host: AllowHost = None,
    certificate: Annotated[
        Path | None, typer.Option(help="A certificate (PEM): the class is served by https.")
    ] = None,
    key: Annotated[Path | None, typer.Option(help="Its private key (PEM).")] = None,
    out: Annotated[
        Path | None,
        typer.Option(help="File.zip in which the class is kept; by default in results/classes."),
    ] = None,
    workers: Annotated[
        int | None,
        typer.Option(
            min=1,
            max=64,
            help="Processes for students' flocks on the server.",
            show_default="two a core",
        ),
    ] = None,
    open_browser: OpenBrowser = True,
) -> None:
    """Open a class: students enter by a code on the wall, and have flocks of their own."""
    if (certificate is None) != (key is None):
        option = "--certificate" if key is None else "--key"
        raise InputError(
            f"{option} is given alone: a certificate needs its key (PEM), and the reverse"
        )
    if lesson is not None:
        scene = lesson_name(lesson, scene)
    path = out or (Path(scene) if scene and scene.endswith(FILE) else default_file())
    if path.suffix != FILE:
        raise InputError(f"--out {str(path)!r} is no name of a class's file: it ends in {FILE}")
    if out is not None and str(out) != scene:
        demand_writable("class", path, False)
    pair = None if certificate is None or key is None else (certificate, key)
    names = tuple(parse_allowed_host(name) for name in allow_host or ())
    from app.classroom.class_keeper import ClassKeeper
    from app.classroom.front.serving import ClassFront

    classroom = open_class(scene, students, workers or 2 * cores(), flocks)
    keeping = ClassKeeper(classroom, path)
    front = ClassFront(classroom, host, port, names, pair)
    with StopSignals() as stopping:
        asyncio.run(serve(front, keeping, host, stopping, open_browser))
    exit_process()


def lesson_name(lesson: str, scene: str | None) -> str:
    """The lesson that a class opens on. Raises InputError."""
    from app.viewer.gallery.lessons.lessons import lesson_names

    if scene is not None:
        raise InputError(f"--lesson {lesson} has a scene of its own: leave {scene} out")
    if lesson not in lesson_names():
        raise unknown("lesson", lesson, lesson_names())
    return lesson


def open_class(
    name: str | None, seats: int, workers: int, flocks: FlockPlace | None = None
) -> Classroom:
    """The class of a lesson, a scene or a file. Raises InputError."""
    from app.classroom.class_file import load
    from app.classroom.class_keeper import restore_class
    from app.classroom.classroom import Classroom
    from app.viewer.gallery.file_opener import opened_file
    from app.viewer.gallery.lessons.lessons import FIRST
    from app.viewer.gallery.saved_scene import SavedScene
    from app.viewer.gallery.scene_collection import find_lesson

    name = name or FIRST
    if name.endswith(FILE):
        state = load(Path(name))
        in_browser = runs_in_browser(state.scene, state.seats, flocks)
        return restore_class(state, Path(name), workers, RESULTS, in_browser)
    scene = opened_file(name) if is_file(name) else find_lesson(name)
    if not isinstance(scene, SavedScene):
        raise InputError(f"{name} is no scene: a class begins with a scene or a spec (TOML)")
    return Classroom(scene, seats, workers, RESULTS, runs_in_browser(scene, seats, flocks))


def runs_in_browser(scene: SavedScene, seats: int, flocks: FlockPlace | None) -> bool:
    """Whether students' flocks are to run in their browsers. Raises InputError."""
    from app.classroom.workers.page_worker import demand_in_browser

    is_chosen, reason = flocks is FlockPlace.IN_BROWSER, ""
    if flocks is not FlockPlace.ON_SERVER:
        try:
            demand_in_browser(scene)
            return True
        except InputError as refusal:
            if is_chosen:
                raise
            reason = str(refusal)
    if seats > MOST_ON_SERVER:
        raise InputError(
            f"{seats} students are too many for flocks on the server: at most {MOST_ON_SERVER}"
            + (f" ({reason})" if reason else "")
        )
    if reason:
        typer.echo(f"students' flocks run on the server: {reason}", err=True)
    return False


def default_file() -> Path:
    """A file that is not there yet, named for the time."""
    now = datetime.now().strftime("%Y-%m-%d-%H%M%S")
    return RESULTS / "classes" / f"{now}{FILE}"


async def serve(
    front: ClassFront, keeping: ClassKeeper, host: str, stopping: StopSignals, open_browser: bool
) -> None:
    """Serve until the class is over, or Ctrl-C or SIGTERM, and say where; keep it meanwhile."""
    from app.classroom.class_keeper import EVERY

    classroom = front.classroom
    await classroom.open()
    try:
        await front.open()
        announce(front, host)
        if open_browser:
            loop = asyncio.get_running_loop()  # a browser may not return before it has the page
            loop.run_in_executor(None, webbrowser.open, front.opening_link)
        due, noted = time.monotonic() + EVERY, ""
        while not stopping.asked and not classroom.is_over:
            await asyncio.sleep(LOOK)
            if classroom.flocks_note != noted:
                noted = classroom.flocks_note
                typer.echo(noted, err=True)
            if time.monotonic() >= due:
                await save_regularly(keeping)
                due = time.monotonic() + EVERY
    finally:
        typer.echo("", err=True)
        await save_regularly(keeping)
        if classroom.has_ended:
            keeping.forget_keys()
            await asyncio.sleep(FAREWELL)
        await classroom.close()
        await front.close()
    if keeping.kept is not None:
        ended = "is in" if classroom.has_ended else "goes on, with those who are in it, from"
        typer.echo(f"the class {ended} {str(keeping.path)!r}: flockscope class {keeping.path}")


async def save_regularly(keeping: ClassKeeper) -> None:
    """Keep the class; what cannot be written is said, here and on the teacher's page, and tried
    again later."""
    classroom, reason = keeping.classroom, ""
    try:
        await keeping.keep()
    except InputError as refusal:
        reason = str(refusal)
        typer.echo(f"flockscope: the class is not kept: {reason}", err=True)
    if classroom.not_kept != reason:
        classroom.not_kept = reason
        classroom.tell()


def announce(front: ClassFront, host: str) -> None:
    """Say where the class is: to students aloud, to the teacher alone."""
    links = front.teacher.links()
    typer.echo(f"students enter at {links[0]}")
    for link in links[1:]:
        typer.echo(f"               or {link}")
    typer.echo(f"the teacher's page, for you alone: {front.teachers_link} (Ctrl-C stops it)")
    if host in LOOPBACK:
        typer.echo(f"only this machine reaches {host}: --host 0.0.0.0 lets students in", err=True)
