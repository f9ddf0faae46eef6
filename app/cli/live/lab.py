"""`flockscope live lab`: a laboratory of real or emulated cars in the browser."""

from __future__ import annotations

import webbrowser
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.cli.serving_options import AllowHost, Host, OpenBrowser, Port, announce
from app.cli.usage import Rules
from worlds.plug_ins import demand_parquet

if TYPE_CHECKING:
    from app.viewer.live.page import LivePage


RECORDINGS = Path("recordings")


def lab(
    file: Annotated[
        Path | None,
        typer.Argument(help="The laboratory's file; without one, an example with emulated cars."),
    ] = None,
    source: Annotated[
        str | None,
        typer.Option(help="Another source: one that the file names, or `emulated cars`."),
    ] = None,
    record: Annotated[
        Path | None,
        typer.Option(help="Record each opening of the room in a new folder in this one."),
    ] = None,
    recordings: Annotated[
        Path | None,
        typer.Option(
            help="Folder in which the page's Record button records, and whose recordings it plays. "
            "\\[default: recordings, or that of --record]"
        ),
    ] = None,
    port: Port = 8080,
    host: Host = "127.0.0.1",
    allow_host: AllowHost = None,
    open_browser: OpenBrowser = True,
    rule: Rules = None,  # noqa: ARG001 - taken into the catalogue before this is called
    quiet: Annotated[bool, typer.Option("--quiet", help="Print no events.")] = False,
) -> None:
    """Open a laboratory of cars in the browser. Nothing moves before it is armed.

    Space or Esc in any browser is the emergency stop. Keys in the terminal: a arms, space or any
    other key is the emergency stop, r resets it, d disarms, q leaves.
    """
    from app.front.origin import parse_allowed_host
    from app.live.device_kinds import EMULATED
    from app.live.operating.lab_choices import laboratory

    if record is not None:
        demand_parquet("--record")
    names = tuple(parse_allowed_host(name) for name in allow_host or ())
    choices = laboratory(file, EMULATED if file is None and source is None else source)

    def opening() -> LivePage:
        from app.viewer.live.page import LivePage

        shelf = recordings or record or RECORDINGS
        return LivePage(choices, host, port, record, shelf, allow=names)

    serve(opening, open_browser, quiet)


def serve(opening: Callable[[], LivePage], open_browser: bool, quiet: bool) -> None:
    """Serve the page until q, Ctrl-C or SIGTERM; then stop the cars. Raises InputError."""
    from app.cli.live.console import SessionConsole
    from app.cli.progress import StopSignals

    with StopSignals() as stopping:
        page = opening()
        try:
            leaving = "q or Ctrl-C stops the cars and leaves"
            announce(page.host, page.port, leaving, "see and stop the cars, and change the rule")
            typer.echo(f"a browser arms with the code {page.session.code.digits}", err=True)
            if open_browser:
                webbrowser.open(page.address)
            SessionConsole(page.session, stopping, not quiet).operate()
        finally:
            page.close()
