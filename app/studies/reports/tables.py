"""The outcome of an experiment as a table for people, within 80 columns."""

from __future__ import annotations

import math
from typing import Any

from app.studies.figures.phases import PhasePoint, map_points, way_points
from app.studies.judge.claim_verdict import ClaimVerdict
from app.studies.judge.comparison import MeanComparison
from app.studies.judge.statistics import MeasureSummary
from app.studies.judge.verdict import Verdict, group_by_sweep, main_verdicts, name, verdicts_on

# Verdicts and answers in words and colours.

STYLES = {
    "agrees": "green",
    "holds": "green",
    "differs": "bold red",
    "does not hold": "bold red",
    "undecided": "yellow",
    "by construction": "dim",
}


def style_answer(answer: MeanComparison | ClaimVerdict | None) -> str:
    """A verdict in its colour; nothing where nothing is compared."""
    return f"[{STYLES[answer.word]}]{answer}[/]" if answer else ""


# The table of runs that are looked at several times: a line for each row and look.


def gathering_table(verdicts: list[Verdict]) -> Any:
    """The means of all measures at each look; below a row's last look what was published."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    symbols = list(dict.fromkeys(verdict.measure.symbol for verdict in verdicts))
    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    for column in ("N", "model", "tick", *symbols):
        left = "left" if column == "model" else "right"
        table.add_column(column, justify=left, no_wrap=True)  # type: ignore[arg-type]
    before = None
    for look in group_by_look(verdicts):
        case = look[0].case
        head = ("", "") if case.row is before else (str(case.agents), case.label)
        before = case.row
        means = (
            format_mean(verdict.summary.mean) if verdict.summary.runs else "-" for verdict in look
        )
        table.add_row(*head, str(case.tick), *means, end_section=case.last and not paper(look))
        if case.last and paper(look):
            table.add_row("", "published", "", *(format_published(verdict) for verdict in look))
            table.add_row(
                "",
                "",
                "",
                *(style_answer(verdict.comparison) for verdict in look),
                end_section=True,
            )
    return table


def group_by_look(verdicts: list[Verdict]) -> list[list[Verdict]]:
    """The verdicts of each look."""
    by_look: dict[int, list[Verdict]] = {}
    for verdict in verdicts:
        by_look.setdefault(id(verdict.case), []).append(verdict)
    return list(by_look.values())


def paper(look: list[Verdict]) -> bool:
    """Whether anything was published of it."""
    return any(verdict.published for verdict in look)


def format_published(verdict: Verdict) -> str:
    """A published mean."""
    if verdict.published is None or verdict.published.average is None:
        return ""
    return format_mean(verdict.published.average)


def format_mean(value: float) -> str:
    """A mean with as many digits as are of use."""
    return f"{value:.2f}" if abs(value) < 10.0 else f"{value:.1f}"


# The tables of a map of phases and of the ways there and back, within 80 columns.

SHORT = {
    "fragments": "frag",
    "swarm": "swarm",
    "torus": "torus",
    "dynamic parallel": "dyn",
    "highly parallel": "high",
    "disperses": "apart",
    "flock": "flock",
    "ring": "ring",
    "mill": "mill",
    "double mill": "2mill",
    "disordered": "dis",
}
PHASE_STYLES = {
    "fragments": "dim",
    "swarm": "yellow",
    "torus": "magenta",
    "dynamic parallel": "cyan",
    "highly parallel": "blue",
    "disperses": "dim",
    "flock": "blue",
    "ring": "green",
    "mill": "magenta",
    "double mill": "cyan",
    "disordered": "yellow",
}


def phase_tables(verdicts: list[Verdict]) -> Any:
    """Both tables, as far as there are places of their kind."""
    from rich.console import Group

    tables = [map_table(map_points(verdicts)), ways_table(way_points(verdicts))]
    return Group(*(table for table in tables if table is not None))


def map_table(points: list[PhasePoint]) -> Any | None:
    """Three lines for each value of the second parameter: p, m and the commonest phase."""
    if not points:
        return None
    sweep = points[0].case.own_sweep
    xs = sorted({spot.x for spot in points})
    table = empty_text_table("", *(f"{x:g}" for x in xs))
    table.title = f"columns: {sweep.parameter}, rows: {sweep.against}"
    for y in sorted({spot.y for spot in points}, reverse=True):
        row = {spot.x: spot for spot in points if spot.y == y}
        line = [row.get(x) for x in xs]
        table.add_row(f"{y:g} p", *(mean(spot.p if spot else None) for spot in line))
        table.add_row("m", *(mean(spot.m if spot else None) for spot in line))
        table.add_row("", *(format_phase(spot) for spot in line), end_section=True)
    return table


def ways_table(pairs: list[tuple[PhasePoint, PhasePoint]]) -> Any | None:
    """A line for each value: p, m and the commonest phase on the way there and back."""
    if not pairs:
        return None
    sweep = pairs[0][0].case.own_sweep
    heads = ("p", "m", "there", "p", "m", "back")
    table = empty_text_table(sweep.parameter, *heads)
    for up, down in pairs:
        cells = [
            text for spot in (up, down) for text in (mean(spot.p), mean(spot.m), format_phase(spot))
        ]
        table.add_row(f"{up.x:g}", *cells)
    return table


def empty_text_table(*columns: str) -> Any:
    """An empty table."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(box=SIMPLE_HEAD, padding=0, pad_edge=False, title_justify="left")
    for column in columns:
        table.add_column(column, justify="right", no_wrap=True)
    return table


def mean(summary: MeasureSummary | None) -> str:
    """A mean to two digits."""
    return "" if summary is None else f"{summary.mean:.2f}"


def format_phase(spot: PhasePoint | None) -> str:
    """The commonest phase in its colour."""
    return "" if spot is None else f"[{PHASE_STYLES[spot.phase]}]{SHORT[spot.phase]}[/]"


def table_of(verdicts: list[Verdict]) -> Any:
    """The table that fits: by what was published, and by how many measures there are."""
    if any(verdict.measure.words for verdict in verdicts) and any(
        verdict.case.sweep for verdict in verdicts
    ):
        return phase_tables(verdicts)
    if any(verdict.case.tick is not None for verdict in verdicts):
        return gathering_table(verdicts)
    if any(verdict.published for verdict in verdicts):
        return published_tables(verdicts)
    if any(verdict.case.sweep for verdict in verdicts):
        return (
            sweep_table(verdicts) if verdicts == main_verdicts(verdicts) else sweep_tables(verdicts)
        )
    return measure_table(verdicts)


def published_tables(verdicts: list[Verdict]) -> Any:
    """A table for each measure of which something was published, and one of the others."""
    from rich.console import Group

    measures = list(dict.fromkeys(verdict.measure.name for verdict in verdicts))
    compared = [
        name
        for name in measures
        if any(verdict.published for verdict in verdicts_on(verdicts, name))
    ]
    tables = [published_table(verdicts_on(verdicts, name)) for name in compared]
    others = [verdict for verdict in verdicts if verdict.measure.name not in compared]
    return Group(*tables, *([measure_table(others)] if others else []))


def published_table(verdicts: list[Verdict]) -> Any:
    """One measure, two lines per row: measured, and below it published and the difference."""
    table = empty_table("N", "model", "mean", "s", "25 %", "50 %", "75 %", "z, d", "")
    measure = verdicts[0].measure
    unit = "" if verdicts[0].unit == "1" else f", {verdicts[0].unit}"
    table.title = f"{measure.symbol}: {measure.title[0].lower()}{measure.title[1:]}{unit}"
    table.title_justify = "left"
    for k, verdict in enumerate(verdicts):
        s, row, comparison = verdict.summary, verdict.published, verdict.comparison
        table.add_row(
            str(verdict.case.agents),
            verdict.case.label,
            mean_of(s),
            number(s.sd),
            *quartiles_of(s),
            format_signed(comparison.z if comparison else None),
            style_answer(comparison),
        )
        if row:
            quartiles = row.quartiles or (None, None, None)
            effect, interval = format_signed(comparison.effect if comparison else None), ""
            if comparison and not math.isnan(comparison.interval[0]):
                interval = " to ".join(map(format_rounded, comparison.interval))
            table.add_row(
                "", "paper", number(row.average), "", *(number(q) for q in quartiles),
                effect, interval, style="dim",
            )  # fmt: skip
        add_size_gap(table, verdicts, k)
    return table


def sweep_table(verdicts: list[Verdict]) -> Any:
    """What was measured for each value of the swept parameters."""
    table = empty_table("N", "model", "parameter", "mean", "s", "25 %", "50 %", "75 %")
    for k, verdict in enumerate(verdicts):
        case, s = verdict.case, verdict.summary
        table.add_row(
            str(case.agents),
            case.label,
            f"{case.sweep.parameter} = {name(case.value)}" if case.sweep else "",
            mean_of(s),
            number(s.sd),
            *quartiles_of(s),
        )
        add_size_gap(table, verdicts, k)
    return table


def sweep_tables(verdicts: list[Verdict]) -> Any:
    """Of several measures: a table for each sweep, means and standard deviations by value."""
    from rich.console import Group

    tables = []
    for sweep, agents, points in group_by_sweep(verdicts):
        rows = group_by_row(points)
        symbols = [row.measure.symbol for row in rows[0]]
        units = ["" if row.unit == "1" else f" / {row.unit}" for row in rows[0]]
        table = empty_table(sweep.parameter, *map("".join, zip(symbols, units, strict=True)))
        table.title = f"{rows[0][0].case.label}, N = {agents}: mean, standard deviation"
        table.title_justify = "left"
        for row in rows:
            cells = [
                f"{mean_of(verdict.summary)} {number(verdict.summary.sd):>6}" for verdict in row
            ]
            table.add_row(name(row[0].case.value), *cells)
        tables.append(table)
    return Group(*tables)


def measure_table(verdicts: list[Verdict]) -> Any:
    """A line for each measure of each row; of a single run the values alone."""
    single = all(len(verdict.values) == 1 for verdict in verdicts)
    columns = ("value",) if single else ("mean", "least", "most", "runs")
    table = empty_table("N", "model", "measure", *columns, "unit")
    for row in group_by_row(verdicts):
        for k, verdict in enumerate(row):
            s = verdict.summary
            head = ("", "") if k else (str(verdict.case.agents), verdict.case.label)
            numbers = [mean_of(s)]
            if not single:
                numbers += [number(s.least), format_limited(s.most, s), str(s.runs)]
            if s.runs == 0:
                numbers[0] = verdict.measure.absent
            table.add_row(*head, verdict.measure.symbol, *numbers, verdict.unit)
        table.add_section()
    return table


def group_by_row(verdicts: list[Verdict]) -> list[list[Verdict]]:
    """The verdicts on all measures of each row."""
    step = len({verdict.measure for verdict in verdicts}) or 1
    return [verdicts[k : k + step] for k in range(0, len(verdicts), step)]


def empty_table(*columns: str) -> Any:
    """A table with numbers to the right."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    words = ("paper", "model", "parameter", "measure", "unit", "")
    for column in columns:
        table.add_column(column, justify="left" if column in words else "right", no_wrap=True)
    return table


def add_size_gap(table: Any, verdicts: list[Verdict], k: int) -> None:
    """Leave a gap where the size of the flock changes."""
    if k + 1 < len(verdicts) and verdicts[k + 1].case.agents != verdicts[k].case.agents:
        table.add_section()


def mean_of(s: MeasureSummary) -> str:
    """A mean; where runs were given up the true one is at least this."""
    return number(s.mean) if s.limit is None else f"≥{number(s.mean)}"


def quartiles_of(s: MeasureSummary) -> list[str]:
    """The quartiles; those in which a run was given up are at least this."""
    return [format_limited(q, s) for q in s.quartiles]


def format_limited(value: float, s: MeasureSummary) -> str:
    """A value of the runs, which is at least their limit where it reaches it."""
    return f"≥{number(value)}" if s.limit is not None and value >= s.limit else number(value)


def format_signed(value: float | None) -> str:
    """A number of standard errors or deviations with its sign."""
    return "" if value is None or math.isnan(value) else f"{value:+.2f}"


def format_rounded(value: float) -> str:
    """A number with its sign and about three digits.

    >>> format_rounded(-1164.2), format_rounded(0.01234)
    ('-1164', '+0.0123')
    """
    return f"{value:+.0f}" if abs(value) >= 100 else f"{value:+.3g}"


def number(value: float | None, digits: int = 2) -> str:
    """A number with as many digits as are of use."""
    if value is None or math.isnan(value):
        return ""
    return f"{value:.{digits}f}" if abs(value) < 100 else f"{value:.1f}"
