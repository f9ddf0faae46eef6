"""Measure tracks, and write what comes out as a folder: a page, a PDF, tables."""

from __future__ import annotations

import hashlib
import html
import io
import json
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from app.figure import NAMED, UNDATED, new_figure, save_figure
from app.results_folder import demand_folder, make_folder
from app.tracks.measures.measure_catalogue import choose_measures
from app.tracks.measures.track_measure import (
    MeasureChart,
    MeasureInput,
    MeasureOptions,
    MeasureResult,
    TrackMeasure,
)
from app.tracks.motion import SmoothedMotion, smoothed_motion
from app.tracks.tracks import Tracks
from worlds.file_writer import csv_text, write_bytes, write_text, writing
from worlds.input_error import InputError
from worlds.number_text import counted

PAGE, BOOK, NUMBERS, SERIES = "report.html", "report.pdf", "numbers.json", "series.parquet"
WIDE, HIGH = 7.2, 3.1
"""Inches of a chart over time."""
SQUARE = 4.6
"""Inches of a map."""
SECONDS = 0.5
"""About how long the charts of a measure take to draw."""


class SkippedMeasure(NamedTuple):
    """A measure that these tracks do not have."""

    name: str
    reason: str


@dataclass(frozen=True, eq=False)
class TrackReport:
    """What was measured of tracks."""

    tracks: Tracks
    motion: SmoothedMotion
    options: MeasureOptions
    results: Mapping[str, MeasureResult]
    """By the names of measures."""
    measures: Mapping[str, TrackMeasure]
    skipped: tuple[SkippedMeasure, ...]

    @property
    def how(self) -> str:
        """How headings and velocities were made, which stands beside every result."""
        return self.motion.describe()

    def value(self) -> dict[str, Any]:
        """All numbers as one value for JSON."""
        tracks = self.tracks
        return {
            "tracks": tracks.name,
            "format": tracks.format,
            "individuals": len(tracks.ids),
            "frames": len(tracks.frame),
            "seconds": float(tracks.time[-1] - tracks.time[0]),
            "unit": tracks.unit,
            "seen": float(tracks.seen.mean()),
            "window_frames": self.motion.frames,
            "window_seconds": self.motion.window,
            "noise": self.motion.noise,
            "velocity_noise": self.motion.velocity_noise,
            "least_speed": self.motion.least_speed,
            "least": self.options.least,
            "dropped": [{"rows": one.rows, "reason": one.reason} for one in tracks.dropped],
            "measures": {
                name: {"numbers": dict(result.numbers), "notes": list(result.notes)}
                for name, result in self.results.items()
            },
            "skipped": {one.name: one.reason for one in self.skipped},
        }


def estimate_seconds(given: MeasureInput, measures: Sequence[TrackMeasure]) -> list[float]:
    """About how long each measure takes, s."""
    frames = len(given.tracks.frame)
    seen = math.ceil(float(given.tracks.seen.sum(axis=1).mean()))
    return [measure.cost(frames, seen) for measure in measures]


def measure_tracks(
    tracks: Tracks,
    only: list[str] | None = None,
    options: MeasureOptions | None = None,
    *,
    window: float | None = None,
    least_speed: float = 0.0,
    use_file_headings: bool = False,
    tell: Callable[[float, float, str], None] = lambda *_: None,
) -> TrackReport:
    """Measure tracks.

    Parameters
    ----------
    only: names of measures; None for all that these tracks have: what they lack is said.
    options: what all measures share.
    window, least_speed, use_file_headings: as `smoothed_motion` takes them.
    tell: is told the share that is done, about how many seconds are left, and what is measured.

    Raises InputError, for a measure that was asked for and cannot be made too.

    >>> place = np.cumsum(np.ones((9, 6, 2)), axis=0) + np.arange(6.0)[:, None]
    >>> frame = np.arange(9)
    >>> marching = Tracks(place, frame, frame / 10.0, tuple("abcdef"), "m")
    >>> measure_tracks(marching, ["polarisation"]).results["polarisation"].numbers["mean"]
    1.0
    """
    options = options or MeasureOptions()
    if options.least < 1:
        raise InputError(f"least = {options.least} is not allowed: 1 or more individuals")
    motion = smoothed_motion(tracks, window, least_speed, use_file_headings=use_file_headings)
    given = MeasureInput(tracks, motion, options)
    measures, skipped = [], []
    for measure in choose_measures(only):
        reason = measure.lacks(given)
        if reason and only:
            raise InputError(f"{measure.name} of {tracks.name}: {reason}")
        if reason:
            skipped.append(SkippedMeasure(measure.name, reason))
        else:
            measures.append(measure)
    costs = estimate_seconds(given, measures)
    total, done = sum(costs) or 1.0, 0.0
    results = {}
    for measure, cost in zip(measures, costs, strict=True):
        tell(done / total, total - done, measure.name)

        def progress(share: float, before=done, cost=cost, name=measure.name) -> None:
            tell((before + share * cost) / total, total - before - share * cost, name)

        results[measure.name] = measure.compute(given, progress)
        done += cost
    by_name = {measure.name: measure for measure in measures}
    return TrackReport(tracks, motion, options, results, by_name, tuple(skipped))


def table_files(name: str, result: MeasureResult) -> dict[str, Mapping[str, np.ndarray]]:
    """The tables of a measure by the names of their files."""
    return {
        f"{name}-{table}.csv" if table else f"{name}.csv": columns
        for table, columns in result.tables.items()
    }


def demand_report_folder(folder: Path, names: Sequence[str], overwrite: bool) -> None:
    """Refuse a folder that holds a report already, or cannot be written. Raises InputError."""
    files = [PAGE, BOOK, NUMBERS, SERIES, *(f"{name}.csv" for name in names)]
    demand_folder("--out", folder, files, overwrite)


def write_report(
    report: TrackReport,
    folder: Path,
    overwrite: bool = False,
    tell: Callable[[float, float, str], None] = lambda *_: None,
) -> list[Path]:
    """Write page, PDF and tables, each whole or not at all; returns the files.

    `series.parquet` has all that is measured by frame, if pyarrow is installed. `tell` as
    `measure_tracks` has it. Raises InputError.
    """
    tables = {
        file: columns
        for name, result in report.results.items()
        for file, columns in table_files(name, result).items()
    }
    demand_folder("--out", folder, [PAGE, BOOK, NUMBERS, SERIES, *tables], overwrite)
    charts, book = draw_charts(report, tell)
    make_folder(folder)
    for file, columns in tables.items():
        rows = zip(*(plain_cells(column) for column in columns.values()), strict=True)
        write_text("table", folder / file, csv_text(columns, rows))
    files = [*tables]
    if write_series(report, folder / SERIES):
        files.append(SERIES)
    write_bytes("PDF", folder / BOOK, book)
    numbers = json.dumps(json_value(report.value()), indent=2, ensure_ascii=False)
    write_text("numbers", folder / NUMBERS, numbers + "\n")
    write_text("page", folder / PAGE, page_of(report, charts))
    return [folder / name for name in (PAGE, BOOK, NUMBERS, *files)]


def plain_cells(column: np.ndarray) -> list[Any]:
    """A column for CSV: what is no number is empty, True and False are 1 and 0."""
    if column.dtype.kind == "f":
        return [value if math.isfinite(value) else "" for value in column.tolist()]
    return column.astype(int).tolist() if column.dtype == bool else column.tolist()


def json_value(value: Any) -> Any:
    """A value as JSON has it: None for what is no number."""
    if isinstance(value, Mapping):
        return {key: json_value(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [json_value(one) for one in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


def series_columns(report: TrackReport) -> dict[str, np.ndarray]:
    """All that is measured by frame: frame, time, and of each measure its values and numbers."""
    columns = {"frame": report.tracks.frame, "time": report.tracks.time}
    for name, result in report.results.items():
        if report.measures[name].by_frame:
            for column, values in result.tables[""].items():
                if column not in ("frame", "time"):
                    key = name.replace("-", "_")
                    columns[f"{key}_n" if column == "n" else column] = values
    return columns


def write_series(report: TrackReport, path: Path) -> bool:
    """Write what is measured by frame as Parquet; False if there is nothing, or no pyarrow."""
    from importlib.util import find_spec

    columns = series_columns(report)
    if len(columns) == 2 or find_spec("pyarrow") is None:
        return False
    import pyarrow as pa
    import pyarrow.parquet as pq

    notes = {b"flockscope_measures": json.dumps(json_value(report.value()), ensure_ascii=False).encode()}
    with writing("table", path) as file:
        pq.write_table(pa.table(columns).replace_schema_metadata(notes), file)
    return True


# The page and the PDF.

STYLE = """
:root { color-scheme: light; }
body { font: 16px/1.5 system-ui, sans-serif; color: #1f2328; max-width: 56rem; margin: 2rem auto;
  padding: 0 1rem; }
h1 { font-size: 1.6rem; } h2 { font-size: 1.2rem; margin-top: 2.5rem; }
table { border-collapse: collapse; margin: 0.6rem 0; }
td, th { border-bottom: 1px solid #d8dee4; padding: 0.15rem 0.9rem 0.15rem 0; text-align: left; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
figure { margin: 0.8rem 0; } figure svg { max-width: 100%; height: auto; }
.quiet { color: #59636e; } .warning { font-weight: 600; }
"""


def draw_chart(figure: Any, chart: MeasureChart) -> None:
    """Draw a chart on an empty figure."""
    figure.set_size_inches(*((SQUARE + 1.0, SQUARE) if chart.is_square else (WIDE, HIGH)))
    axes = figure.add_subplot()
    chart.draw(axes)
    axes.set_xlabel(chart.x)
    axes.set_ylabel(chart.y)
    if chart.title:
        axes.set_title(chart.title)


def draw_charts(
    report: TrackReport, tell: Callable[[float, float, str], None] = lambda *_: None
) -> tuple[dict[str, list[str]], bytes]:
    """All charts, drawn once: by measure as elements of SVG that need nothing else, and the PDF.

    The PDF begins with a page of words; each measure has its charts there, and its numbers.
    """
    from matplotlib.backends.backend_pdf import PdfPages

    charts: dict[str, list[str]] = {}
    file = io.BytesIO()
    with PdfPages(file, metadata=UNDATED["pdf"]) as book:
        with new_figure(NAMED) as figure:
            write_words(figure, f"Measures of {report.tracks.name}", describe_tracks(report))
            book.savefig(figure)
        for k, (name, result) in enumerate(report.results.items()):
            tell(k / len(report.results), SECONDS * (len(report.results) - k), "charts")
            measure = report.measures[name]
            charts[name] = []
            for chart in result.charts:
                with new_figure(NAMED) as figure:
                    draw_chart(figure, chart)
                    picture = io.BytesIO()
                    save_figure(figure, picture, ".svg")
                    charts[name].append(svg_element(picture.getvalue().decode()))
                    figure.set_layout_engine("none")  # it is laid out, which takes half the time
                    book.savefig(figure)
            notes = [f"{upper_first(note)}." for note in result.notes]
            numbers = [f"{key}: {format_number(value)}" for key, value in result.numbers.items()]
            with new_figure(NAMED) as figure:
                write_words(
                    figure, measure.title, [*notes, *numbers, upper_first(report.how) + "."]
                )
                book.savefig(figure)
    return charts, file.getvalue()


def svg_element(text: str) -> str:
    """The element of a file of SVG, as a page of HTML takes it; its ids stay apart from others'."""
    element = text[text.index("<svg") :]
    prefix = f"c{hashlib.sha256(element.encode()).hexdigest()[:8]}-"
    element = re.sub(r' id="', f' id="{prefix}', element)
    return re.sub(r'(href="#|url\(#)', rf"\1{prefix}", element)


def format_number(value: float) -> str:
    """A number for people, four digits.

    >>> [format_number(value) for value in (0.123456, 1234567, float("nan"), 3.0)]
    ['0.1235', '1\\u202f234\\u202f567', '-', '3']
    """
    if isinstance(value, float) and not math.isfinite(value):
        return "-"
    if float(value).is_integer() and abs(value) < 1e15:
        return f"{int(value):,}".replace(",", "\u202f")
    return f"{value:.4g}"


def describe_tracks(report: TrackReport) -> list[str]:
    """What was measured, in sentences: the data, the window, what is not in it."""
    tracks = report.tracks
    seconds = float(tracks.time[-1] - tracks.time[0])
    lines = [
        f"{counted(len(tracks.ids), 'individual')}, {counted(len(tracks.frame), 'frame')}, "
        f"{seconds:.4g} s at {tracks.rate:.4g} frames/s, in {tracks.unit}; "
        f"{float(tracks.seen.mean()):.1%} of all places are seen.",
        f"Velocities and headings: {report.how}.",
        f"A frame has a value if {report.options.least} individuals or more are seen.",
    ]
    if tracks.filled is not None and tracks.filled.any():
        lines.append(f"{int(tracks.filled.sum())} places are interpolated.")
    return [*lines, *(f"{one}." for one in tracks.dropped), *tracks.notes]


def page_of(report: TrackReport, charts: Mapping[str, Sequence[str]]) -> str:
    """The report as one page of HTML that needs no other file; `charts` are of `draw_charts`."""
    title = f"Measures of {report.tracks.name}"
    parts = [
        "<!doctype html>", '<html lang="en">', '<head><meta charset="utf-8">',
        '<meta name="viewport" content="width=device-width, initial-scale=1">',
        f"<title>{html.escape(title)}</title><style>{STYLE}</style></head><body>",
        f"<h1>{html.escape(title)}</h1>",
        *(f"<p>{html.escape(line)}</p>" for line in describe_tracks(report)),
    ]  # fmt: skip
    for name, result in report.results.items():
        measure = report.measures[name]
        source = f' <span class="quiet">({html.escape(measure.source)})</span>'
        parts.append(
            f'<h2 id="{name}">{html.escape(measure.title)}{source if measure.source else ""}</h2>'
        )
        for note in result.notes:
            kind = "warning" if note.startswith("not resolved") else "quiet"
            parts.append(f'<p class="{kind}">{html.escape(upper_first(note))}.</p>')
        parts += [
            f'<figure role="img" aria-label="{html.escape(f"{measure.title}: {chart.y}")}">'
            f"{picture}</figure>"
            for chart, picture in zip(result.charts, charts[name], strict=True)
        ]
        rows = "".join(
            f'<tr><td>{html.escape(key)}</td><td class="number">{format_number(value)}</td></tr>'
            for key, value in result.numbers.items()
        )
        unit = measure.by_frame.format(u=report.tracks.unit)
        caption = f" Unit: {unit}." if unit not in ("", "1") else ""
        parts.append(f"<table>{rows}</table>")
        parts.append(f'<p class="quiet">{html.escape(upper_first(report.how) + "." + caption)}</p>')
    if report.skipped:
        items = "".join(
            f"<li>{html.escape(one.name)}: {html.escape(one.reason)}</li>" for one in report.skipped
        )
        parts.append(f"<h2>Not measured</h2><ul>{items}</ul>")
    return "\n".join([*parts, "</body></html>", ""])


def write_words(figure: Any, title: str, lines: Sequence[str]) -> None:
    """Write lines on an empty figure, broken where they are long."""
    from textwrap import wrap

    broken = [part for line in lines for part in (wrap(line, 92) or [""])]
    figure.set_size_inches(WIDE, max(HIGH, 0.8 + 0.19 * len(broken)))
    high = figure.get_size_inches()[1]
    figure.text(0.05, 1.0 - 0.35 / high, title, fontsize=12, weight="bold")
    for k, line in enumerate(broken):
        figure.text(0.05, 1.0 - (0.65 + 0.19 * k) / high, line, fontsize=9)


def upper_first(text: str) -> str:
    """A sentence with a capital.

    >>> upper_first("window 5 frames")
    'Window 5 frames'
    """
    return text[:1].upper() + text[1:]


def describe_report(report: TrackReport) -> list[str]:
    """The report in lines for a terminal."""
    lines = [*describe_tracks(report)]
    for name, result in report.results.items():
        shown = [
            f"{key} {format_number(value)}"
            for key, value in result.numbers.items()
            if not key.startswith("of all individuals")
        ]
        unit = report.measures[name].by_frame.format(u=report.tracks.unit)
        lines.append(f"{name}{f' ({unit})' if unit not in ('', '1') else ''}: {', '.join(shown)}")
        lines += [f"  {note}" for note in result.notes]
    return lines + [f"not measured: {one.name}: {one.reason}" for one in report.skipped]
