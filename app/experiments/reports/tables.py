"""The outcome of an experiment as a table for people, within 80 columns."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from app.experiments.file import Published
from app.experiments.reports.gathering_table import gathering_table
from app.experiments.reports.phase_tables import phase_tables
from app.experiments.verdicts.verdict import Verdict, main_ones, name

STYLES = {"agrees": "green", "differs": "bold red", "not reproduced": "yellow"}


def table_of(made: list[Verdict]) -> Any:
    """The table that fits: by what was published, and by how many measures there are."""
    if any(one.measure.words for one in made):
        return phase_tables(made)
    if any(one.case.tick is not None for one in made):
        return gathering_table(made)
    several = len({one.measure.name for one in made}) > 1
    if any(one.published for one in made):
        return comparison_table(made) if several else published_table(made)
    if any(one.case.sweep for one in made):
        return sweep_table(made)
    return measure_table(made)


def published_table(made: list[Verdict]) -> Any:
    """One measure, two lines per row: measured, and below it published."""
    table = empty_table("N", "model", "mean", "s", "25 %", "50 %", "75 %", "z", "")
    for k, one in enumerate(made):
        s, row = one.summary, one.published
        table.add_row(
            str(one.case.agents),
            one.case.label,
            number(s.mean),
            number(s.sd),
            *(number(q) for q in s.quartiles),
            z_of(one),
            styled(one.word),
        )
        if row:
            quartiles = row.quartiles or (None, None, None)
            table.add_row(
                "", "", number(row.mean), "", *(number(q) for q in quartiles), "", "published",
                style="dim",
            )  # fmt: skip
        close_size(table, made, k)
    return table


def comparison_table(made: list[Verdict]) -> Any:
    """Several measures, two lines per row: the first in full, the others with their means."""
    rows = by_row(made)
    first, *others = rows[0]
    symbols = (one.measure.symbol for one in others)
    table = empty_table("N", "model", first.measure.symbol, "95 %", "25/50/75 %", *symbols, "z", "")
    for k, (main, *more) in enumerate(rows):
        s, row = main.summary, main.published
        table.add_row(
            str(main.case.agents),
            main.case.label,
            number(s.mean),
            "-".join(f"{x:.1f}" for x in s.interval),
            three(s.quartiles),
            *(number(one.summary.mean, 3) for one in more),
            z_of(main),
            styled(main.word),
        )
        if row:
            means = (number((one.published or Published()).mean, 3) for one in more)
            table.add_row(
                "", "", number(row.mean), "", three(row.quartiles), *means, "", "paper", style="dim"
            )
        close_size(table, [row[0] for row in rows], k)
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
            number(s.mean),
            number(s.sd),
            *(number(q) for q in s.quartiles),
        )
        close_size(table, made, k)
    return table


def measure_table(made: list[Verdict]) -> Any:
    """A line for each measure of each row; of a single run the values alone."""
    single = all(len(one.values) == 1 for one in made)
    columns = ("value",) if single else ("mean", "least", "most", "runs")
    table = empty_table("N", "model", "measure", *columns, "unit")
    for row in by_row(made):
        for k, one in enumerate(row):
            s = one.summary
            head = ("", "") if k else (str(one.case.agents), one.case.label)
            numbers = [number(s.mean)]
            if not single:
                numbers += [number(s.least), number(s.most), str(s.runs)]
            if s.runs == 0:
                numbers[0] = one.measure.absent
            table.add_row(*head, one.measure.symbol, *numbers, one.measure.unit)
        table.add_section()
    return table


def by_row(made: list[Verdict]) -> list[list[Verdict]]:
    """The verdicts on all measures of each row."""
    step = len(made) // max(1, len(main_ones(made)))
    return [made[k : k + step] for k in range(0, len(made), step)]


def empty_table(*columns: str) -> Any:
    """A table with numbers to the right."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    words = ("model", "parameter", "measure", "unit", "")
    for column in columns:
        table.add_column(column, justify="left" if column in words else "right", no_wrap=True)
    return table


def close_size(table: Any, made: list[Verdict], k: int) -> None:
    """Leave a gap where the size of the flock changes."""
    if k + 1 < len(made) and made[k + 1].case.agents != made[k].case.agents:
        table.add_section()


def styled(word: str) -> str:
    """A verdict in its colour."""
    style = STYLES.get(word, "")
    return f"[{style}]{word}[/]" if style else word


def z_of(one: Verdict) -> str:
    """z with its sign."""
    return "" if one.z is None else f"{one.z:+.2f}"


def three(values: Sequence[float] | None) -> str:
    """Quartiles in a word."""
    return "" if values is None else "/".join(f"{value:.3g}" for value in values)


def number(value: float | None, digits: int = 2) -> str:
    """A number with as many digits as are of use."""
    if value is None or math.isnan(value):
        return ""
    return f"{value:.{digits}f}" if abs(value) < 100 else f"{value:.1f}"
