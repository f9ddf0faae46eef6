"""The outcome of an experiment: a table for people, JSON, a CSV file of the summary."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.experiments.experiment import Experiment
from app.experiments.statistics import NOTE
from app.experiments.verdict import Claim, Verdict, name
from worlds.refusal import Refusal

if TYPE_CHECKING:
    from rich.console import Console

STYLES = {"agrees": "green", "differs": "bold red", "not reproduced": "yellow"}


def as_value(experiment: Experiment, made: list[Verdict], said: list[Claim]) -> dict[str, Any]:
    """The outcome as one value for JSON."""
    return {
        "name": experiment.name,
        "title": experiment.title,
        "source": experiment.source,
        "settings": experiment.settings.model_dump(),
        "notes": {**experiment.notes, "z": NOTE},
        "rows": [one.as_row() for one in made],
        "claims": [{"text": one.text, "holds": one.holds} for one in said],
    }


def write_summary(path: Path, made: list[Verdict]) -> None:
    """Write the summary as CSV, one line per row. Raises Refusal."""
    rows = [one.as_row() for one in made]
    try:
        with open(path, "w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, list(rows[0]), lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
    except OSError as error:
        raise Refusal(f"{str(path)!r} cannot be written: {error.strerror or error}") from None


def show(console: Console, experiment: Experiment, made: list[Verdict], said: list[Claim]) -> None:
    """Print the outcome for people."""
    console.print(f"[bold]{experiment.title}[/] ({experiment.source})")
    published = any(one.measured.cell.published for one in made)
    console.print(published_table(made) if published else sweep_table(made))
    console.print(f"{len(made[0].measured.times)} runs in each row", highlight=False)
    for one in made:
        if one.summary.given_up:
            cell = one.measured.cell
            limit = experiment.settings.limit
            text = f"{cell.model}, N = {cell.agents}: {count(one)} within {limit} ticks"
            console.print(f"[bold red]not consistent[/]  {text}; left out above", highlight=False)
    for claim in said:
        mark = "[green]holds[/]" if claim.holds else "[bold red]does not hold[/]"
        console.print(f"  {mark}  {claim.text}", highlight=False)
    for one in made:
        row = one.measured.cell.published
        if row and row.not_reproduced:
            text = f"{row.model}, N = {row.agents}: {row.not_reproduced}"
            console.print(f"[yellow]not reproduced[/]  {text}", highlight=False)
        if row and row.remark:
            console.print(f"{row.model}, N = {row.agents}: {row.remark}", highlight=False)
    notes = [*experiment.notes.values(), *([NOTE] if published else [])]
    for note in notes:
        console.print(f"[dim]note: {note}[/]", highlight=False)


def published_table(made: list[Verdict]) -> Any:
    """Two lines per row: measured, and below it published."""
    table = empty_table("N", "model", "mean", "s", "25 %", "50 %", "75 %", "z", "")
    for k, one in enumerate(made):
        cell, s, row = one.measured.cell, one.summary, one.measured.cell.published
        style = STYLES.get(one.word, "")
        table.add_row(
            str(cell.agents),
            cell.model,
            number(s.mean),
            number(s.sd),
            *(number(q) for q in s.quartiles),
            "" if one.z is None else f"{one.z:+.2f}",
            f"[{style}]{one.word}[/]" if style else one.word,
        )
        if row:
            quartiles = row.quartiles or (None, None, None)
            table.add_row(
                "", "", number(row.mean), "", *(number(q) for q in quartiles), "", "published",
                style="dim",
            )  # fmt: skip
        if k + 1 < len(made) and made[k + 1].measured.cell.agents != cell.agents:
            table.add_section()
    return table


def sweep_table(made: list[Verdict]) -> Any:
    """What was measured for each value of the swept parameters."""
    table = empty_table("N", "model", "parameter", "mean", "s", "25 %", "50 %", "75 %")
    for k, one in enumerate(made):
        cell, s = one.measured.cell, one.summary
        table.add_row(
            str(cell.agents),
            cell.model,
            f"{cell.sweep.parameter} = {name(cell.value)}" if cell.sweep else "",
            number(s.mean),
            number(s.sd),
            *(number(q) for q in s.quartiles),
        )
        if k + 1 < len(made) and made[k + 1].measured.cell.agents != cell.agents:
            table.add_section()
    return table


def empty_table(*columns: str) -> Any:
    """A table with numbers to the right."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(box=SIMPLE_HEAD, padding=(0, 1, 0, 0), pad_edge=False)
    words = ("model", "parameter", "")
    for column in columns:
        table.add_column(column, justify="left" if column in words else "right", no_wrap=True)
    return table


def count(one: Verdict) -> str:
    """How many runs were given up."""
    return f"{one.summary.given_up} of {len(one.measured.times)} runs"


def number(value: float | None) -> str:
    """A number with as many digits as are of use."""
    if value is None or math.isnan(value):
        return ""
    return f"{value:.2f}" if value < 100 else f"{value:.1f}"
