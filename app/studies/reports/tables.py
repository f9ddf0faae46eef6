"""The outcome of an experiment as a table for people, within 80 columns."""

from __future__ import annotations

import math
from typing import Any

from app.studies.reports.gathering_table import gathering_table
from app.studies.reports.phase_tables import phase_tables
from app.studies.reports.verdict_style import styled
from app.studies.verdicts.statistics import MeasureSummary
from app.studies.verdicts.verdict import Verdict, main_ones, name, of, sweeps_of


def table_of(made: list[Verdict]) -> Any:
    """The table that fits: by what was published, and by how many measures there are."""
    if any(one.measure.words for one in made) and any(one.case.sweep for one in made):
        return phase_tables(made)
    if any(one.case.tick is not None for one in made):
        return gathering_table(made)
    if any(one.published for one in made):
        return published_tables(made)
    if any(one.case.sweep for one in made):
        return sweep_table(made) if made == main_ones(made) else sweep_tables(made)
    return measure_table(made)


def published_tables(made: list[Verdict]) -> Any:
    """A table for each measure of which something was published, and one of the others."""
    from rich.console import Group

    measures = list(dict.fromkeys(one.measure.name for one in made))
    compared = [name for name in measures if any(one.published for one in of(made, name))]
    tables = [published_table(of(made, name)) for name in compared]
    others = [one for one in made if one.measure.name not in compared]
    return Group(*tables, *([measure_table(others)] if others else []))


def published_table(made: list[Verdict]) -> Any:
    """One measure, two lines per row: measured, and below it published and the difference."""
    table = empty_table("N", "model", "mean", "s", "25 %", "50 %", "75 %", "z, d", "")
    measure = made[0].measure
    unit = "" if made[0].unit == "1" else f", {made[0].unit}"
    table.title = f"{measure.symbol}: {measure.title[0].lower()}{measure.title[1:]}{unit}"
    table.title_justify = "left"
    for k, one in enumerate(made):
        s, row, found = one.summary, one.published, one.comparison
        table.add_row(
            str(one.case.agents),
            one.case.label,
            mean_of(s),
            number(s.sd),
            *quartiles_of(s),
            signed(found.z if found else None),
            styled(found),
        )
        if row:
            quartiles = row.quartiles or (None, None, None)
            effect, interval = signed(found.effect if found else None), ""
            if found and not math.isnan(found.interval[0]):
                interval = " to ".join(map(rounded, found.interval))
            table.add_row(
                "", "paper", number(row.average), "", *(number(q) for q in quartiles),
                effect, interval, style="dim",
            )  # fmt: skip
        close_size(table, made, k)
    return table


def sweep_table(made: list[Verdict]) -> Any:
    """What was measured for each value of the swept parameters."""
    table = empty_table("N", "model", "parameter", "mean", "s", "25 %", "50 %", "75 %")
    for k, one in enumerate(made):
        case, s = one.case, one.summary
        table.add_row(
            str(case.agents),
            case.label,
            f"{case.sweep.parameter} = {name(case.value)}" if case.sweep else "",
            mean_of(s),
            number(s.sd),
            *quartiles_of(s),
        )
        close_size(table, made, k)
    return table


def sweep_tables(made: list[Verdict]) -> Any:
    """Of several measures: a table for each sweep, means and standard deviations by value."""
    from rich.console import Group

    tables = []
    for sweep, agents, points in sweeps_of(made):
        rows = by_row(points)
        symbols = [one.measure.symbol for one in rows[0]]
        units = ["" if one.unit == "1" else f" / {one.unit}" for one in rows[0]]
        table = empty_table(sweep.parameter, *map("".join, zip(symbols, units, strict=True)))
        table.title = f"{rows[0][0].case.label}, N = {agents}: mean, standard deviation"
        table.title_justify = "left"
        for row in rows:
            cells = [f"{mean_of(one.summary)} {number(one.summary.sd):>6}" for one in row]
            table.add_row(name(row[0].case.value), *cells)
        tables.append(table)
    return Group(*tables)


def measure_table(made: list[Verdict]) -> Any:
    """A line for each measure of each row; of a single run the values alone."""
    single = all(len(one.values) == 1 for one in made)
    columns = ("value",) if single else ("mean", "least", "most", "runs")
    table = empty_table("N", "model", "measure", *columns, "unit")
    for row in by_row(made):
        for k, one in enumerate(row):
            s = one.summary
            head = ("", "") if k else (str(one.case.agents), one.case.label)
            numbers = [mean_of(s)]
            if not single:
                numbers += [number(s.least), at_least(s.most, s), str(s.runs)]
            if s.runs == 0:
                numbers[0] = one.measure.absent
            table.add_row(*head, one.measure.symbol, *numbers, one.unit)
        table.add_section()
    return table


def by_row(made: list[Verdict]) -> list[list[Verdict]]:
    """The verdicts on all measures of each row."""
    step = len({one.measure for one in made}) or 1
    return [made[k : k + step] for k in range(0, len(made), step)]


def empty_table(*columns: str) -> Any:
    """A table with numbers to the right."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    words = ("paper", "model", "parameter", "measure", "unit", "")
    for column in columns:
        table.add_column(column, justify="left" if column in words else "right", no_wrap=True)
    return table


def close_size(table: Any, made: list[Verdict], k: int) -> None:
    """Leave a gap where the size of the flock changes."""
    if k + 1 < len(made) and made[k + 1].case.agents != made[k].case.agents:
        table.add_section()


def mean_of(s: MeasureSummary) -> str:
    """A mean; where runs were given up the true one is at least this."""
    return number(s.mean) if s.limit is None else f"≥{number(s.mean)}"


def quartiles_of(s: MeasureSummary) -> list[str]:
    """The quartiles; those in which a run was given up are at least this."""
    return [at_least(q, s) for q in s.quartiles]


def at_least(value: float, s: MeasureSummary) -> str:
    """A value of the runs, which is at least their limit where it reaches it."""
    return f"≥{number(value)}" if s.limit is not None and value >= s.limit else number(value)


def signed(value: float | None) -> str:
    """A number of standard errors or deviations with its sign."""
    return "" if value is None or math.isnan(value) else f"{value:+.2f}"


def rounded(value: float) -> str:
    """A number with its sign and about three digits.

    >>> rounded(-1164.2), rounded(0.01234)
    ('-1164', '+0.0123')
    """
    return f"{value:+.0f}" if abs(value) >= 100 else f"{value:+.3g}"


def number(value: float | None, digits: int = 2) -> str:
    """A number with as many digits as are of use."""
    if value is None or math.isnan(value):
        return ""
    return f"{value:.{digits}f}" if abs(value) < 100 else f"{value:.1f}"
