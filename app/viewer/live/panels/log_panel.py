"""What happened: the last events, newest on top, and all that are kept as a file."""

from __future__ import annotations

import html
import time
from collections.abc import Sequence
from dataclasses import asdict
from datetime import datetime

import viser

from app.live.control.loop_status import Event
from app.viewer.live.session import Session
from app.viewer.panels.shell import BLUE, GREEN, GREY, ORANGE, RED, block
from worlds.file_writer import csv_text

LATEST = 60
"""Events in the list."""
COLOURS = {
    "emergency": RED,
    "arm": GREEN,
    "run": GREEN,
    "cleared": GREEN,
    "stop": GREY,
    "disarm": GREY,
    "reset": GREY,
    "room": GREY,
    "compile": GREY,
    "part": GREY,
    "end": GREY,
    "tune": BLUE,
    "accompany": BLUE,
}
"""Of what was asked or is well; every other kind is a reason to stop, or refused."""
COLUMNS = ("at", "tick", "kind", "car", "words", "cause", "asked", "note")


class LogPanel:
    """The log of a session, of all its openings."""

    def __init__(self, gui: viser.GuiApi, session: Session):
        self.session = session
        self.shown = -1
        save = gui.add_button("Download all (CSV)", icon=viser.Icon.DOWNLOAD, color="gray")
        self.list = gui.add_html(block(event_list([])))
        save.on_click(self.send)

    async def send(self, event: viser.GuiEvent) -> None:
        if event.client is not None:
            name = f"flockscope-events-{datetime.now():%Y-%m-%d-%H%M%S}.csv"
            content = as_csv(list(self.session.events)).encode()
            event.client.send_file_download(name, content, save_immediately=True)

    def refresh(self) -> None:
        """Show what is new."""
        events = self.session.events
        if len(events) != self.shown:
            self.shown = len(events)
            self.list.content = block(
                event_list(events[-LATEST:]) + describe_dropped(events.dropped)
            )


def event_list(events: Sequence[Event]) -> str:
    """Events as HTML, the newest on top."""
    if not events:
        return '<div class="fs-quiet">Nothing has happened yet.</div>'
    return f'<div class="fs-log">{"".join(map(entry, reversed(events)))}</div>'


def describe_dropped(dropped: int) -> str:
    """Says that the oldest events are no longer kept, as HTML; empty if all are."""
    if not dropped:
        return ""
    return f'<div class="fs-quiet">The first {dropped} events are only in the recording.</div>'


def entry(event: Event) -> str:
    """One event."""
    colour = COLOURS.get(event.kind, ORANGE)
    cause = f" <i>{html.escape(event.cause)}</i>" if event.cause else ""
    return (
        f'<div style="border-color:{colour}"><i>{clock(event.time):%H:%M:%S.%f}'[:-4]
        + f"</i><b>{html.escape(event.kind)}</b> {html.escape(event.words)}{cause}</div>"
    )


def clock(monotonic: float) -> datetime:
    """The time of day of a moment on this machine's monotonic clock (s)."""
    return datetime.fromtimestamp(time.time() - time.monotonic() + monotonic)


def as_csv(events: Sequence[Event]) -> str:
    """All events as a table, the oldest first; `at` is this machine's time of day."""
    rows = (
        asdict(event) | {"at": clock(event.time).isoformat(timespec="milliseconds")}
        for event in events
    )
    return csv_text(COLUMNS, ([row[name] for name in COLUMNS] for row in rows))
