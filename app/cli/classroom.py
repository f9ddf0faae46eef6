"""`flockscope class`: a class behind one address, each student with a flock of their own."""

from __future__ import annotations

import asyncio
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.cli.lab import is_file
from app.cli.serving_options import AllowHost, Host, OpenBrowser, Port
from app.cli.stopping import Stopping, leave
from app.experiments.workers.processes import cores
from app.viewer.web.addresses import LOOPBACK
from app.viewer.web.origin import allowed
from worlds.refusal import Refusal

if TYPE_CHECKING:
    from app.classroom.front.serving import ClassFront
    from app.viewer.gallery.saved_scene import SavedScene

FIRST = "order"
"""The scene of a class that asks for none."""
LOOK = 0.1
"""Seconds between two looks whether somebody asked it to stop."""
MOST_STUDENTS = 200


def classroom(
    scene: Annotated[
        str, typer.Argument(help="A scene: NAME of a built-in one, or FILE.toml of a scene.")
    ] = FIRST,
    students: Annotated[int, typer.Option(min=1, max=MOST_STUDENTS, help="Students at most.")] = 40,
    host: Host = "127.0.0.1",
    port: Port = 8080,
    allow_host: AllowHost = None,
    certificate: Annotated[
        Path | None, typer.Option(help="A certificate (PEM): the class is served by https.")
    ] = None,
    key: Annotated[Path | None, typer.Option(help="Its private key (PEM).")] = None,
    workers: Annotated[
        int | None, typer.Option(min=1, max=64, help="Processes for students' flocks.")
    ] = None,
    open_browser: OpenBrowser = True,
) -> None:
    """Open a class: students enter by a code on the wall, and have flocks of their own."""
    from app.classroom.classroom import Classroom
    from app.classroom.front.serving import ClassFront

    if (certificate is None) != (key is None):
        given, missing = (
            ("--key", "--certificate") if certificate is None else ("--certificate", "--key")
        )
        raise Refusal(f"{given} needs {missing} beside it")
    pair = None if certificate is None or key is None else (certificate, key)
    names = tuple(allowed(name) for name in allow_host or ())
    opened = opened_scene(scene)
    classroom = Classroom(opened, students, workers or max(2, cores()))
    front = ClassFront(classroom, host, port, names, pair)
    with Stopping() as stopping:
        asyncio.run(serve(front, host, stopping, open_browser))
    leave()


def opened_scene(name: str) -> SavedScene:
    """The scene of a class. Raises Refusal."""
    from app.viewer.gallery.collection import find_scene
    from app.viewer.gallery.opened import opened_file
    from app.viewer.gallery.saved_scene import SavedScene

    if not is_file(name):
        return find_scene(name)
    opened = opened_file(name)
    if not isinstance(opened, SavedScene):
        raise Refusal(f"{name} is no scene: a class begins with a scene or a spec (TOML)")
    return opened


async def serve(front: ClassFront, host: str, stopping: Stopping, open_browser: bool) -> None:
    """Serve until Ctrl-C or SIGTERM, and say where."""
    classroom = front.classroom
    await classroom.open()
    try:
        await front.open()
        announce(front, host)
        if open_browser:
            webbrowser.open(front.teachers_link)
        while not stopping.asked and not classroom.is_over:
            await asyncio.sleep(LOOK)
    finally:
        typer.echo("", err=True)
        await classroom.close()
        await front.close()


def announce(front: ClassFront, host: str) -> None:
    """Say where the class is: to students aloud, to the teacher alone."""
    links = front.teacher.links()
    typer.echo(f"students enter at {links[0]}")
    for link in links[1:]:
        typer.echo(f"               or {link}")
    typer.echo(f"the teacher's page, for you alone: {front.teachers_link} (Ctrl-C ends the class)")
    if host in LOOPBACK:
        typer.echo(f"only this machine reaches {host}: --host 0.0.0.0 lets students in", err=True)
