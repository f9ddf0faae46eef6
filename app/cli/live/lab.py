"""`flockscope live lab`: a laboratory of real or emulated cars in the browser."""

from __future__ import annotations

import time
import webbrowser
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.cli.live.run import actions_of, event_line, watch
from app.cli.progress import StopSignals
from app.cli.serving_options import AllowHost, Host, OpenBrowser, Port, announce
from app.cli.usage import Rules
from app.live.control.loop_status import Event
from app.viewer.live.session import Session
from worlds.plug_ins import demand_parquet

if TYPE_CHECKING:
    from app.viewer.live.page import LivePage

# The terminal beside a laboratory's page: keys in, events out.

TERMINAL = "terminal"


class SessionConsole:
    """Passes the keys of the terminal to a session; `verbose`: events are shown."""

    def __init__(self, session: Session, stopping: StopSignals, verbose: bool):
        self.session = session
        self.stopping = stopping
        self.verbose = verbose
        self.shown = 0
        self.trouble = ""
        self.began = time.monotonic()

    def operate(self) -> None:
        """Until q, Ctrl-C or SIGTERM."""
        watch(self.obey, self.see, lambda: self.stopping.asked, self.verbose)

    def obey(self, pressed: str) -> None:
        """Ask the session for what was typed."""
        for action in actions_of(pressed):
            if action == "emergency":
                self.session.emergency(TERMINAL)
            else:
                self.session.ask(action, TERMINAL)

    def see(self) -> None:
        """Show what is new: events, and why no loop is open."""
        state = self.session.state
        trouble = state.trouble if state.phase == "failed" else ""
        if trouble and trouble != self.trouble:
            typer.echo(trouble, err=True)
        self.trouble = trouble
        shown = len(self.session.events)
        for event in self.session.events[self.shown : shown] if self.verbose else ():
            self.show(event)
        self.shown = shown

    def show(self, event: Event) -> None:
        """Print an event."""
        self.began = min(self.began, event.time)
        typer.echo(event_line(event, event.time - self.began))


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
    from app.live.device_kinds import EMULATED
    from app.live.operating.lab_choices import laboratory
    from app.viewer.web.origin import allowed

    if record is not None:
        demand_parquet("--record")
    names = tuple(allowed(name) for name in allow_host or ())
    choices = laboratory(file, EMULATED if file is None and source is None else source)

    def opening() -> LivePage:
        from app.viewer.live.page import LivePage

        shelf = recordings or record or RECORDINGS
        return LivePage(choices, host, port, record, shelf, allow=names)

    serve(opening, open_browser, quiet)


def serve(opening: Callable[[], LivePage], open_browser: bool, quiet: bool) -> None:
    """Serve the page until q, Ctrl-C or SIGTERM; then stop the cars. Raises InputError."""
    pass
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
