"""Who has crashed: how many, when, against what, and the latest of them one by one."""

from __future__ import annotations

import html
from collections.abc import Callable

import numpy as np
import viser

from agents.state.agent_rows import CAUSES, Crashes
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.panels.style import block

LATEST = 5
"""Crashes in the list."""
EARLY = 100
"""The tick up to which the thesis counts what comes of the start."""

Show = Callable[[viser.ClientHandle, int, bool], None]
"""Shows a row of the flock, or of the one beside, in one browser."""


class CrashLists:
    """The latest crashes of the flock, and of the one beside it."""

    def __init__(self, gui: viser.GuiApi, show: Show):
        self.first, self.second = (CrashList(gui, show, beside) for beside in (False, True))

    def refresh(self, readings: FlockReadings, beside: FlockReadings | None) -> None:
        """Show the latest crashes, with the names of the models if there are two."""
        if beside is None:
            self.first.refresh(readings.crashes)
            self.second.refresh(None)
            return
        for one, read in ((self.first, readings), (self.second, beside)):
            one.refresh(read.crashes, read.flock.model.name)


class CrashList:
    """The latest crashes of one flock, each with a button that points the camera at it."""

    def __init__(self, gui: viser.GuiApi, show: Show, beside: bool):
        self.show = show
        self.beside = beside
        self.rows: dict[str, int] = {}
        """What the buttons show: identity -> row."""
        self.list = gui.add_html("", visible=False)
        self.buttons = gui.add_button_group(
            "Show",
            ("1",),
            hint="Point this browser's camera at an agent that has crashed",
            visible=False,
        )
        self.buttons.on_click(self.clicked)

    async def clicked(self, event: viser.GuiEvent) -> None:
        row = self.rows.get(event.target.value)
        if event.client is not None and row is not None:
            self.show(event.client, row, self.beside)

    def refresh(self, crashes: Crashes | None, model: str = "") -> None:
        """Show the latest crashes of a flock; nothing if there are none.

        `model` says which of two flocks it is.
        """
        some = crashes is not None and len(crashes) > 0
        if self.list.visible != some:
            self.list.visible = self.buttons.visible = some
        if crashes is None or not some:
            return
        self.list.content = block(listed(crashes, model))
        rows = {str(crashes.id[at]): int(crashes.row[at]) for at in latest(crashes)}
        if rows != self.rows:
            self.rows = rows
            self.buttons.options = tuple(rows)


def latest(crashes: Crashes) -> range:
    """Where the latest crashes are, newest first."""
    last = len(crashes) - 1
    return range(last, max(-1, last - LATEST), -1)


def listed(crashes: Crashes, model: str = "") -> str:
    """The latest crashes as a table, newest first; `model` says which of two flocks it is."""
    rows = "".join(
        f"<tr><td>{crashes.tick[at]}</td><td>{crashes.id[at]}</td>"
        f"<td>{CAUSES[int(crashes.cause[at])]}</td><td>{place(crashes.place[at])}</td></tr>"
        for at in latest(crashes)
    )
    return (
        f'<div class="fs-head">Latest crashes<span class="fs-quiet">{html.escape(model)}</span>'
        '</div><table class="fs-list"><tr><th>tick</th><th>agent</th><th>touched</th><th>at</th>'
        f"</tr>{rows}</table>"
    )


def counted(ticks: np.ndarray, agents: int) -> str:
    """How many have crashed, and when.

    >>> counted(np.array([0, 0, 7, 230]), 50)
    'Crashed <b>4</b> of 50 (2 at the start, 1 up to tick 100, 1 after tick 100)'
    """
    if not len(ticks):
        return f"Crashed <b>0</b> of {agents}"
    early = int(np.count_nonzero(ticks == 0))
    late = int(np.count_nonzero(ticks > EARLY))
    parts = {
        "at the start": early,
        f"up to tick {EARLY}": len(ticks) - early - late,
        f"after tick {EARLY}": late,
    }
    reported = ", ".join(f"{count} {words}" for words, count in parts.items() if count)
    return f"Crashed <b>{len(ticks)}</b> of {agents} ({reported})"


def place(where: np.ndarray) -> str:
    """A place in few figures.

    >>> place(np.array([1.234, 0.0, 23.9]))
    '1.2, 0.0, 23.9'
    """
    return ", ".join(f"{value:.1f}" for value in where)
