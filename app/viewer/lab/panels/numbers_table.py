"""All numbers of the monitors as one table: to be looked at, and to be taken along as CSV."""

from __future__ import annotations

import html
import math
from collections.abc import Iterable, Sequence

import viser

from agents.observables.catalogue import OBSERVABLES
from app.viewer.measuring.flock_numbers import (
    SAVES,
    EnergySavings,
    Number,
    number_of,
    numbers,
    rows,
)
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.measuring.observable_format import (
    format_observable,
    observable_words,
    run_observables,
)
from app.viewer.panels.chart import file_stem, plot_csv
from app.viewer.panels.sending import Sender
from app.viewer.panels.shell import Sheets, block

# More numbers of a flock, for whoever wants them.

JOULES = "joules-per-metre"
"""None of the observables: it takes an aircraft as well."""
SIZES = "group sizes"
"""Drawn as bars, not told as a number."""


class MoreNumbers:
    """A folder of switches, one for each observable; off, it costs nothing."""

    def __init__(self, gui: viser.GuiApi):
        self.joules = EnergySavings()
        self.switches = {}
        with gui.add_folder("More numbers", expand_by_default=False):
            for name, observable in OBSERVABLES.items():
                everyone = observable.card is not None and observable.card.of is None
                if not (everyone or observable.events or observable.is_table):
                    self.switches[name] = gui.add_checkbox(
                        observable_words(name), False, hint=observable.title
                    )
            self.switches[SIZES] = gui.add_checkbox(SIZES, False, hint="Groups of each size")
            self.switches[JOULES] = gui.add_checkbox(
                "saved J/m",
                False,
                hint="What the flock saves of the energy per metre that the aircraft of the thesis "
                "needs alone at v0, in trim, if a unit of length is a metre; found in some seconds",
            )

    def offer(self, offered: Iterable[str]) -> None:
        """Show the switches of what these flocks have."""
        names = {*offered, *run_observables(), SIZES}
        if names.intersection(SAVES):
            names.add(JOULES)
        for name, switch in self.switches.items():
            if switch.visible != (name in names):
                switch.visible = name in names

    @property
    def chosen(self) -> tuple[str, ...]:
        """What is switched on and to be had."""
        return tuple(
            name for name, switch in self.switches.items() if switch.value and switch.visible
        )

    @property
    def names(self) -> frozenset[str]:
        """The observables that must be measured for it."""
        measured = (name for name in self.chosen if name not in (SIZES, JOULES))
        return frozenset(name for name in measured if OBSERVABLES[name].over is None)

    def numbers(self, readings: FlockReadings, last: float) -> dict[str, str]:
        """The numbers of a flock, name -> text; those over a run are of its `last` ticks."""
        rows = {}
        for name in self.chosen:
            if name == JOULES:
                rows["saved J/m"] = self.joules.describe(readings)
            elif OBSERVABLES[name].over is not None:
                rows[observable_words(name)] = format_observable(name, readings.over(name, last))
            elif name != SIZES:
                rows[observable_words(name)] = format_observable(name, readings.values.get(name))
        return rows

    def values(self, readings: FlockReadings, last: float) -> dict[str, Number]:
        """The same numbers in full, but for those of one tick, which the readings have."""
        rows = {
            observable_words(name): number_of(name, readings.over(name, last), readings.flock.model)
            for name in self.chosen
            if name in OBSERVABLES and OBSERVABLES[name].over is not None
        }
        saved = self.joules.savings(readings) if JOULES in self.chosen else None
        if saved is not None:
            rows["energy saved by formation"] = Number(saved[0], "J/m")
            rows["energy needed alone"] = Number(saved[1], "J/m")
        return rows


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
        self.buttons.on_click(self.send_download)
        self.sheets = Sheets(server, self.large)

    def refresh(self, runs: tuple[FlockReadings, ...], last: float) -> None:
        """These are the flocks now; what is measured over a run is of its `last` ticks."""
        self.runs, self.last = runs, last
        self.sheets.update_each(self.fill)

    def large(self, gui: viser.GuiApi) -> viser.GuiHtmlHandle:
        """What is in a window that shows it."""
        place = gui.add_html("")
        self.fill(place)
        return place

    def fill(self, place: viser.GuiHtmlHandle) -> None:
        """Show the newest table."""
        place.content = block(numbers_html(self.header, self.rows))

    async def send_download(self, event: viser.GuiEvent) -> None:
        client, file_kind = event.client, event.target.value
        if client is None or not self.runs:
            return
        if file_kind == TABLE:
            self.sheets.show(client, "All numbers")
        elif file_kind == CSV:
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


def numbers_html(header: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """A table as HTML, numbers in full."""
    head = "".join(f"<th>{html.escape(cell)}</th>" for cell in header)
    body = "".join(
        "<tr>" + "".join(f"<td>{html.escape(format_in_full(cell))}</td>" for cell in row) + "</tr>"
        for row in rows
    )
    return f'<table class="fs-numbers"><tr>{head}</tr>{body}</table>'


def format_in_full(cell: object) -> str:
    """A cell in all its figures.

    >>> tuple(map(format_in_full, (1 / 3, 3.0, float("nan"), "m")))
    ('0.3333333333333333', '3', '–', 'm')
    """
    if not isinstance(cell, int | float):
        return str(cell)
    if math.isnan(cell):
        return "–"
    return repr(int(cell)) if math.isfinite(cell) and cell == int(cell) else repr(float(cell))
