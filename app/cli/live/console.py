"""The terminal beside a laboratory's page: keys in, events out."""

from __future__ import annotations

import time

import typer

from app.cli.live.keys import Keys
from app.cli.live.operate import HELP, KEYS, LEAVES
from app.cli.stopping import Stopping
from app.live.control.events import Event
from app.viewer.live.session import Session

EVERY = 0.05
"""Seconds between two looks at keys and events."""
TERMINAL = "terminal"


class SessionConsole:
    """Serves the keys of the terminal until the operator leaves; `said`: events are shown."""

    def __init__(self, session: Session, stopping: Stopping, verbose: bool):
        self.session = session
        self.stopping = stopping
        self.verbose = verbose
        self.shown = 0
        self.trouble = ""
        self.began = time.monotonic()

    def operate(self) -> None:
        """Until q, Ctrl-C or SIGTERM."""
        with Keys() as keys:
            if self.verbose and keys.there:
                typer.echo(HELP, err=True)
            while not self.stopping.asked:
                pressed = keys.pressed(EVERY)
                if LEAVES in pressed:
                    break
                self.obey(pressed)
                self.see()

    def obey(self, pressed: str) -> None:
        """Do what was typed; among several keys an emergency stop goes first."""
        actions = [KEYS.get(key) for key in pressed]
        if None in actions:
            self.session.emergency(TERMINAL)
            return
        for action in actions:
            if action is not None:
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
            self.tell(event)
        self.shown = shown

    def tell(self, event: Event) -> None:
        """Print an event."""
        self.began = min(self.began, event.time)
        cause = f" ({event.cause})" if event.cause else ""
        at = event.time - self.began
        typer.echo(f"{at:8.2f} s  {event.kind:<9} {event.words}{cause}")
