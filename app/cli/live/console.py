"""The terminal beside the page of a room: keys in, events out."""

from __future__ import annotations

import time

import typer

from app.cli.live.keys import Keys
from app.cli.live.operate import HELP, KEYS, LEAVES
from app.cli.stopping import Stopping
from app.live.control.events import Event
from app.viewer.live.room import Room

EVERY = 0.05
"""Seconds between two looks."""
TERMINAL = "terminal"


class Console:
    """Serves the keys of the terminal until the operator leaves; `said`: events are shown."""

    def __init__(self, room: Room, stopping: Stopping, said: bool):
        self.room = room
        self.stopping = stopping
        self.said = said
        self.shown = 0
        self.trouble = ""
        self.began = time.monotonic()

    def operate(self) -> None:
        """Until q, Ctrl-C or SIGTERM."""
        with Keys() as keys:
            if self.said and keys.there:
                typer.echo(HELP, err=True)
            while not self.stopping.asked:
                pressed = keys.pressed(EVERY)
                if LEAVES in pressed:
                    break
                self.obey(pressed)
                self.see()

    def obey(self, pressed: str) -> None:
        """Do what was typed; among several keys an emergency stop goes first."""
        wishes = [KEYS.get(key) for key in pressed]
        if None in wishes:
            self.room.emergency(TERMINAL)
            return
        for wish in wishes:
            if wish is not None:
                self.room.ask(wish, TERMINAL)

    def see(self) -> None:
        """Show what is new: events, and why a room is not open."""
        state = self.room.state
        trouble = state.trouble if state.status == "failed" else ""
        if trouble and trouble != self.trouble:
            typer.echo(trouble, err=True)
        self.trouble = trouble
        shown = len(self.room.events)
        for event in self.room.events[self.shown : shown] if self.said else ():
            self.tell(event)
        self.shown = shown

    def tell(self, event: Event) -> None:
        """Print an event."""
        self.began = min(self.began, event.time)
        cause = f" ({event.cause})" if event.cause else ""
        at = event.time - self.began
        typer.echo(f"{at:8.2f} s  {event.kind:<9} {event.words}{cause}")
