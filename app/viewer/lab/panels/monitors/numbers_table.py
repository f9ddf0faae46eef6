"""All numbers of the monitors as one table: to be looked at, and to be taken along as CSV."""

from __future__ import annotations

import html
import math
from collections.abc import Sequence

import viser

from app.viewer.lab.panels.monitors.more_numbers import MoreNumbers
from app.viewer.measuring.flock_numbers import numbers, rows
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.panels.large_window import Sheets
from app.viewer.panels.plotted import file_stem, plot_csv
from app.viewer.panels.sending import Sender
from app.viewer.panels.style import block

TABLE, CSV = "Table", "CSV"


class NumbersTable:
    """Two buttons: the table over the page, kept up to date, and the same as a file."""

    def __init__(self, server: viser.ViserServer, more: MoreNumbers, sender: Sender):
        self.more, self.sender = more, sender
        self.runs: tuple[FlockReadings, ...] = ()
        self.last = math.inf
        self.buttons = server.gui.add_button_group(
            "All numbers",
            (TABLE, CSV),
            hint="Everything in the monitors, in full, with its unit; of two flocks a column each",
        )
        self.buttons.on_click(self.pressed)
        self.sheets = Sheets(server, self.large)

    def refresh(self, runs: tuple[FlockReadings, ...], last: float) -> None:
        """These are the flocks now; what is measured over a run is of its `last` ticks."""
        self.runs, self.last = runs, last
        self.sheets.each(self.fill)

    def large(self, gui: viser.GuiApi) -> viser.GuiHtmlHandle:
        """What is in a window that shows it."""
        place = gui.add_html("")
        self.fill(place)
        return place

    def fill(self, place: viser.GuiHtmlHandle) -> None:
        """Show the newest table."""
        place.content = block(tabled(self.header, self.rows))

    async def pressed(self, event: viser.GuiEvent) -> None:
        client, wanted = event.client, event.target.value
        if client is None or not self.runs:
            return
        if wanted == TABLE:
            self.sheets.show(client, "All numbers")
        elif wanted == CSV:
            first = self.runs[0]
            models = "-beside-".join(self.models)
            name = file_stem(f"{models}-seed{first.flock.seed}-tick{first.tick}-numbers")
            await self.sender.send(client, f"{name}.csv", self.csv)

    @property
    def models(self) -> list[str]:
        """The names of the models."""
        return [run.flock.model.name for run in self.runs]

    @property
    def header(self) -> list[str]:
        """Of the table."""
        values = self.models if len(self.runs) > 1 else ["value"]
        return ["name", *values, "unit"]

    @property
    def rows(self) -> list[list[object]]:
        """Of the table as it is now."""
        more = self.more
        return rows([numbers(run, more.values(run, self.last)) for run in self.runs])

    def csv(self) -> bytes:
        """The table as a file."""
        return plot_csv(self.header, self.rows).encode()


def tabled(header: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """A table as HTML, numbers in full."""
    head = "".join(f"<th>{html.escape(cell)}</th>" for cell in header)
    body = "".join(
        "<tr>" + "".join(f"<td>{html.escape(full(cell))}</td>" for cell in row) + "</tr>"
        for row in rows
    )
    return f'<table class="fs-numbers"><tr>{head}</tr>{body}</table>'


def full(cell: object) -> str:
    """A cell in all its figures.

    >>> full(1 / 3), full(3.0), full(float("nan")), full("m")
    ('0.3333333333333333', '3', '–', 'm')
    """
    if not isinstance(cell, int | float):
        return str(cell)
    if math.isnan(cell):
        return "–"
    return repr(int(cell)) if math.isfinite(cell) and cell == int(cell) else repr(float(cell))
