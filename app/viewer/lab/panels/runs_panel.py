"""The tab Runs: every run so far is a row, to be named, laid under the plots, opened again and
taken along; sweeps are rows, too.
"""

from __future__ import annotations

import html
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from urllib.parse import parse_qs

import numpy as np
import viser
from aiohttp import web

from agents.models.model import Model
from agents.observables.catalogue import default_charts
from app.front.controls import set_value
from app.front.http_server import Request, text_response
from app.studies.sweeps.sweep_table import as_csv, write_table
from app.viewer.gallery.saved_scene import TEXTS, SavedScene
from app.viewer.lab.panels.laboratory_plots import DOTS, LaboratoryPlots
from app.viewer.lab.panels.sweep_panel import set_html
from app.viewer.lab.runs_file import runs_as_bytes, spec_of
from app.viewer.lab.scene_requests import MARK, WORD, SceneRequests
from app.viewer.lab.sweeps.laboratory_sweeps import Sweeps, whole_number
from app.viewer.lab.sweeps.stored_sweeps import ListedSweep
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.measuring.kept_runs import (
    MOST_RUNS,
    KeptRun,
    differing_names,
    runs_table,
)
from app.viewer.measuring.observable_curves import ObservableHistory, Points, thin_ticks
from app.viewer.measuring.observable_format import format_observable, observable_words, scale
from app.viewer.measuring.run_conditions import BY_HAND, ConditionHistory
from app.viewer.panels.sending import Sender
from app.viewer.panels.shell import Sheets, block
from worlds.input_error import InputError
from worlds.number_text import counted

PATH = "/runs/"
"""Begins the addresses by which the page asks."""
PERIOD = 0.5
"""Time between two looks at the run that goes on, s."""
WIDTH, HEIGHT = 72, 26
"""Of the small curve, pixels."""
LISTED = 60
"""The latest runs, which are rows; those that are ticked are rows too."""
POINTS = 48
"""Of the small curve, about."""
TABLE, FILE = "Table", "JSONL"
TABLES, PICTURES = ("CSV", "Parquet"), ("PNG", "SVG")
KINDS = (TABLE, *TABLES, *PICTURES, FILE)


class RunsPanel:
    """Shows the runs; `tell` tells all browsers of something."""

    def __init__(
        self,
        server: viser.ViserServer,
        plots: LaboratoryPlots,
        sweeps: Sweeps | None,
        tell: Callable[[str], object],
        where: str,
    ):
        """`where` says in a few words where the runs are kept."""
        self.runs, self.plots, self.sweeps, self.tell = plots.runs, plots, sweeps, tell
        self.due = 0.0
        self.seen: tuple[object, ...] = ()
        self.differ: dict[Model, list[str]] = {}
        """By model, what differs among its runs."""
        gui = server.gui
        self.going = gui.add_html("")
        self.list = gui.add_html("")
        self.last = gui.add_checkbox(
            "Tick the last run automatically",
            True,
            hint=f"Ticked runs of the model that runs lie under the plots, {len(DOTS)} at most, "
            "the latest first",
        )
        self.last.on_update(self.choose_last)
        self.buttons = gui.add_button_group(
            "All runs",
            KINDS,
            hint="Table: over the page. CSV, Parquet: a row for each run. PNG, SVG: the curves of "
            "the first plot, of the run that goes on and of all that are ticked. JSONL: a file "
            "that Save, Open a file ... opens again",
        )
        self.buttons.on_click(self.send_download)
        gui.add_html(block(f'<div class="fs-quiet">{html.escape(where)}</div>'))
        self.sheets = Sheets(server, self.large)
        self.sender: Sender = plots.sender

    # What browsers ask for.

    def listen(self, scenes: SceneRequests) -> None:
        """Answer the page: see static/runs.js."""
        scenes.opens(f"{PATH}open", self.scene)
        for name, act in (("show", self.show), ("name", self.rename), ("delete", self.delete)):
            scenes.front.route(f"{PATH}{name}", self.answering(act))

    def answering(self, act: Callable[[int, str], None]) -> Callable[[Request], web.Response]:
        """What answers a request to change a run."""

        def answer(request: Request) -> web.Response:
            if request.headers.getall(MARK, []) != [WORD]:
                return text_response(403, f"runs are changed with the header {MARK}: {WORD}")
            asked = parse_qs(request.raw_path.partition("?")[2], keep_blank_values=True)
            try:
                act(whole_number("run", asked.get("run", [""])[0]), asked.get("to", [""])[0])
            except InputError as refusal:
                return text_response(400, str(refusal))
            return text_response(200, "done")

        return answer

    def scene(self, asked: dict[str, list[str]]) -> SavedScene:
        """A run as a scene that begins as it began. Raises InputError."""
        run = self.runs.find(whole_number("run", asked.get("run", [""])[0]))
        first = run.course.conditions
        changes = run.course.history.changes()
        watch = f"The run from its start, without what was changed: {', '.join(changes)}."
        return SavedScene(
            title=run.label.capitalize()[: TEXTS["title"]],
            spec=spec_of(first),
            watch=watch[: TEXTS["watch"]] if changes else "",
            plots=self.plots.chosen if run.model is self.plots.model else (),
        )

    def show(self, number: int, to: str) -> None:
        """Lay a run under the plots, or do so no more. Raises InputError."""
        self.runs.show(number, to == "on")

    def rename(self, number: int, to: str) -> None:
        """Give a run a name. Raises InputError."""
        self.runs.rename(number, to)

    def delete(self, number: int, _to: str) -> None:
        """Keep a run no more. Raises InputError."""
        self.runs.delete(number)

    async def choose_last(self, _event: viser.GuiEvent) -> None:
        """Whether the last run is laid under the plots by itself."""
        self.runs.lays_last = self.last.value

    async def send_download(self, event: viser.GuiEvent) -> None:
        """Send all runs to the browser that asked."""
        client, kind = event.client, event.target.value
        if client is None:
            return
        rows = self.runs.rows
        if kind == TABLE:
            self.sheets.show(client, "All runs")
        elif kind in PICTURES:
            plotted = self.plots.charts[0].plot_contents()
            if plotted is None:
                self.tell("The first plot shows nothing: choose what it shows under Monitors.")
                return
            name = f"runs.{kind.lower()}"
            await self.sender.send(client, name, lambda: plotted.content(kind))
        elif not rows:
            self.tell("There is no run yet: the first is a row here once it is over.")
        elif kind == FILE:
            await self.sender.send(client, "runs.jsonl", lambda: runs_as_bytes(rows))
        elif kind in TABLES:
            name = f"runs.{kind.lower()}"
            await self.sender.send(client, name, lambda: table_bytes(rows, kind))

    def large(self, gui: viser.GuiApi) -> viser.GuiHtmlHandle:
        """What is in a window that shows all runs as a table."""
        place = gui.add_html("")
        place.content = block(table_html(self.runs.rows))
        return place

    # What the page shows.

    def refresh(self, runs: Sequence[FlockReadings]) -> None:
        """Show the runs that go on, and those that are over if anything of them is another."""
        now = time.monotonic()
        sweeps = () if self.sweeps is None else self.sweeps.seen.sweeps
        seen = (self.runs.rows, sweeps, self.runs.dropped)
        changed = seen != self.seen
        if changed:
            self.seen = seen
            set_value(self.last, self.runs.lays_last)
            rows = self.runs.rows
            models = dict.fromkeys(run.model for run in rows)
            self.differ = {model: differing_names(self.runs.runs_of(model)) for model in models}
            listed = [run for place, run in enumerate(rows) if place < LISTED or run.is_shown]
            text = "".join(self.row(run) for run in listed)
            if len(listed) < len(rows) or self.runs.dropped:
                text += f'<div class="fs-quiet">{self.left_out(len(rows) - len(listed))}</div>'
            set_html(self.list, block(text + "".join(map(sweep_row, sweeps))))
            self.sheets.update_each(self.fill)
        if changed or now >= self.due:
            self.due = now + PERIOD
            set_html(self.going, block("".join(self.going_row(run) for run in runs)))

    def left_out(self, unlisted: int) -> str:
        """What is not among the rows."""
        gone, said = self.runs.dropped, []
        if unlisted:
            said.append(f"{counted(unlisted, 'older run')}: Table and the files have them")
        if gone:
            said.append(f"{counted(gone, 'run')} before those left: {MOST_RUNS} are kept")
        return ". ".join(said)

    def fill(self, place: viser.GuiHtmlHandle) -> None:
        """Show the newest table."""
        place.content = block(table_html(self.runs.rows))

    def going_row(self, readings: FlockReadings) -> str:
        """The row of a run that goes on."""
        names = shown_names(readings.flock.model, readings.offered)
        course = ObservableHistory.of(readings, names)
        about = self.about(course, readings.conditions, names)
        return (
            f'<div class="fs-kept fs-kept-now"><i></i><div><b>now</b> {about}</div>'
            f"{small_curve(course, names)}</div>"
        )

    def row(self, run: KeptRun) -> str:
        """The row of a run that is over."""
        names = shown_names(run.model, tuple(run.measures))
        laid = self.runs.shown_of(run.model)
        age = laid.index(run) if run in laid else -1
        ticked = "true" if run.is_shown else "false"
        called = html.escape(run.label)
        line = f'<i class="fs-line fs-before-{age}"></i>' if age >= 0 else ""
        name = f" {html.escape(run.name)}" if run.name else ""
        buttons = "".join(
            f'<button type="button" data-run="{run.number}" data-act="{act}" '
            f'aria-label="{word} {called}" data-name="{html.escape(run.name)}">{word}</button>'
            for act, word in (("open", "Open"), ("name", "Name"), ("delete", "Delete"))
        )
        return (
            f'<div class="fs-kept"><button type="button" role="checkbox" aria-checked="{ticked}" '
            f'data-run="{run.number}" data-act="show" '
            f'aria-label="Lay {called} under the plots"></button>'
            f"<div><b>{run.number}{name}</b> {line} "
            f"{self.about(run.course, run.course.history, names)}"
            f'<div class="fs-kept-acts">{buttons}</div></div>'
            f"{small_curve(run.course, names)}</div>"
        )

    def about(
        self, course: ObservableHistory, history: ConditionHistory, names: tuple[str, ...]
    ) -> str:
        """What a run is, what differs, and what it came to."""
        first = history.first
        ticks = course.tick - history.stretches[0].begin
        differ = self.differ.get(first.model, ())
        told = [
            history.describe(name, steps)
            for name, steps in history.steps.items()
            if name not in ("seed", BY_HAND) and (name in differ or len(steps) > 1)
        ]
        told += [change for change in history.changes() if BY_HAND in change]
        parts = [
            f'<div class="fs-quiet">{html.escape(first.model.name)} · seed {first.seed} · '
            f"{ticks:,} ticks</div>".replace(",", " "),
        ]
        if told:
            parts.append(f"<div>{html.escape(', '.join(told))}</div>")
        came = ", ".join(
            f"{observable_words(name)} {format_observable(name, float(values[-1]))}"
            for name in names
            if len(values := course.points(name)[1])
        )
        if came:
            parts.append(f'<div class="fs-quiet">{html.escape(came)}</div>')
        return "".join(parts)


def shown_names(model: Model, offered: Sequence[str]) -> tuple[str, ...]:
    """What a row tells of a run: what the model's first plot shows."""
    charts = default_charts(model, tuple(offered))
    return next((chart for chart in charts if chart), ())


def small_curve(course: ObservableHistory, names: Sequence[str]) -> str:
    """SVG of how the first of some observables went, with a dot where something was changed."""
    at, values = course.points(names[0]) if names else (np.empty(0), np.empty(0))
    if len(at) < 2:
        return "<i></i>"
    kept = thin_ticks(at, POINTS)
    x, y = places(at, values, at[kept], values[kept], names[0])
    line = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(x, y, strict=True))
    marks = course.history.marks
    marks = marks[(marks >= at[0]) & (marks <= at[-1])]
    marks = marks[thin_ticks(marks, 10)] if len(marks) else marks
    dots = "".join(
        f'<circle cx="{a:.1f}" cy="{b:.1f}" r="2"/>'
        for a, b in zip(*places(at, values, marks, np.interp(marks, at, values), names[0]),
                        strict=True)
    )  # fmt: skip
    title = html.escape(f"{observable_words(names[0])} over the run")
    return (
        f'<svg class="fs-kept-curve" role="img" aria-label="{title}" width="{WIDTH}" '
        f'height="{HEIGHT}" viewBox="0 0 {WIDTH} {HEIGHT}"><polyline points="{line}"/>{dots}</svg>'
    )


def places(at: np.ndarray, values: np.ndarray, x: np.ndarray, y: np.ndarray, name: str) -> Points:
    """Where points of a curve lie in its small picture, pixels: a share goes from 0 to 1."""
    low, high = (0.0, 1.0) if scale(name).is_share else (float(values.min()), float(values.max()))
    high = high if high > low else low + 1.0
    across = (x - at[0]) / (at[-1] - at[0])
    up = (np.clip(y, low, high) - low) / (high - low)
    return 2 + across * (WIDTH - 4), HEIGHT - 3 - up * (HEIGHT - 6)


def sweep_row(sweep: ListedSweep) -> str:
    """The row of a sweep: a click shows it."""
    name = html.escape(sweep.name)
    return (
        f'<div class="fs-kept"><i></i><div><b>{name}</b> <span class="fs-quiet">sweep · '
        f"{html.escape(sweep.state)}</span>"
        f'<div class="fs-kept-acts"><button type="button" data-sweep-name="{name}" '
        f'aria-label="Show the sweep {name}">Show</button></div></div><i></i></div>'
    )


def table_html(runs: Sequence[KeptRun]) -> str:
    """All runs as a table; parameters that are the same in all of them are left out."""
    if not runs:
        return "There is no run yet: the first is a row here once it is over."
    table = runs_table(runs)
    always = ("run", "name", "model", "seed", "agents", "ticks")
    columns = {
        name: values
        for name, values in table.items()
        if name in always or len({repr(value) for value in values}) > 1
    }
    head = "".join(f"<th>{html.escape(name)}</th>" for name in columns)
    rows = "".join(
        "<tr>" + "".join(f"<td>{html.escape(cell_text(cell))}</td>" for cell in row) + "</tr>"
        for row in zip(*columns.values(), strict=True)
    )
    return f'<div class="fs-runs"><table class="fs-numbers"><tr>{head}</tr>{rows}</table></div>'


def cell_text(cell: object) -> str:
    """A cell for people.

    >>> tuple(map(cell_text, (None, True, 0.123456789, 12, "x")))
    ('', 'on', '0.1235', '12', 'x')
    """
    if cell is None:
        return ""
    if isinstance(cell, bool):
        return "on" if cell else "off"
    return f"{cell:.4g}" if isinstance(cell, float) else str(cell)


def table_bytes(runs: Sequence[KeptRun], kind: str) -> bytes:
    """All runs as a file."""
    table = runs_table(runs)
    if kind == "CSV":
        return as_csv(table).encode()
    with tempfile.TemporaryDirectory() as place:
        path = Path(place) / "runs.parquet"
        write_table(table, path, False)
        return path.read_bytes()
