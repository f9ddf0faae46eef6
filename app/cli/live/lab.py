"""`flockscope live lab`: a laboratory of cars in the browser, and the terminal beside it."""

from __future__ import annotations

import time
import webbrowser
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from app.cli.options.serving_options import AllowHost, Host, OpenBrowser, Port, announce
from app.cli.terminal.progress import StopSignals
from app.cli.terminal.usage import Rules
from worlds.plug_ins import demand_parquet

if TYPE_CHECKING:
    from app.live.control.loop_status import Event
    from app.viewer.live.page import LivePage
    from app.viewer.live.session import Session

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
        """Handle keys until q, Ctrl-C or SIGTERM."""
        from app.cli.live.operate import handle_keys_until_over

        handle_keys_until_over(
            self.handle_key, self.print_news, lambda: self.stopping.asked, self.verbose
        )

    def handle_key(self, pressed: str) -> None:
        """Ask the session for what was typed."""
        from app.cli.live.operate import actions_of

        for action in actions_of(pressed):
            if action == "emergency":
                self.session.emergency(TERMINAL)
            else:
                self.session.ask(action, TERMINAL)

    def print_news(self) -> None:
        """Show what is new: events, and why no loop is open."""
        state = self.session.state
        trouble = state.trouble if state.phase == "failed" else ""
        if trouble and trouble != self.trouble:
            typer.echo(trouble, err=True)
        self.trouble = trouble
        event_count = len(self.session.events)
        for event in self.session.events[self.shown : event_count] if self.verbose else ():
            self.show(event)
        self.shown = event_count

    def show(self, event: Event) -> None:
        """Print an event."""
        from app.cli.live.operate import event_line

        self.began = min(self.began, event.time)
        typer.echo(event_line(event, event.time - self.began))
