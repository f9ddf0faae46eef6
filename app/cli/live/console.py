"""The terminal beside a laboratory's page: keys in, events out."""

from __future__ import annotations

import time

import typer

from app.cli.live.operate import actions_of, event_line, handle_keys_until_over
from app.cli.progress import StopSignals
from app.live.control.loop_status import Event
from app.viewer.live.session import Session

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
        handle_keys_until_over(
            self.handle_key, self.print_news, lambda: self.stopping.asked, self.verbose
        )

    def handle_key(self, pressed: str) -> None:
        """Ask the session for what was typed."""
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
        self.began = min(self.began, event.time)
        typer.echo(event_line(event, event.time - self.began))
