"""The outcome of an experiment: for people, as JSON, as a CSV file of the summary."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.experiments.experiment import Experiment
from app.experiments.reports.tables import STYLES, table_of
from app.experiments.verdicts.claim import Claim
from app.experiments.verdicts.statistics import INTERVAL_NOTE, NOTE, WELCH_NOTE
from app.experiments.verdicts.verdict import Verdict, of
from worlds.counting import counted
from worlds.writing import write_text

if TYPE_CHECKING:
    from rich.console import Console

CLAIM_STYLES = {"holds": "green", "does not hold": "bold red", "not reproduced": "yellow"}


def as_value(experiment: Experiment, made: list[Verdict], said: list[Claim]) -> dict[str, Any]:
    """The outcome as one value for JSON."""
    return {
        "name": experiment.name,
        "title": experiment.title,
        "source": experiment.source,
        "kind": experiment.settings.kind,
        "settings": experiment.settings.model_dump(),
        "notes": {**experiment.notes, "z": NOTE, "welch": WELCH_NOTE, "interval": INTERVAL_NOTE},
        "rows": [one.as_row() for one in made],
        "claims": [{"text": one.text, "holds": one.holds, "why": one.why} for one in said],
    }


def write_summary(path: Path, made: list[Verdict]) -> None:
    """Write the summary as CSV, one line per row and measure. Raises Refusal."""
    rows = [one.as_row() for one in made]
    text = io.StringIO()
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    write_text("summary", path, text.getvalue())


def show(console: Console, experiment: Experiment, made: list[Verdict], said: list[Claim]) -> None:
    """Print the outcome for people."""

    def tell(text: str) -> None:
        console.print(text, highlight=False)

    tell(f"[bold]{experiment.title}[/] ({experiment.source})")
    console.print(table_of(made))
    runs = len(made[0].values)
    tell(f"{runs} runs in each row" if runs > 1 else "one run")
    for line in absences(experiment, made):
        tell(line)
    for claim in said:
        why = f": {claim.why}" if claim.word == "not reproduced" else ""
        tell(f"  [{CLAIM_STYLES[claim.word]}]{claim.word}[/]  {claim.text}{why}")
    for kind, known in (
        ("not reproduced", experiment.not_reproduced),
        ("not compared", experiment.not_compared),
    ):
        for measure, why in known.items():
            tell(f"[yellow]{kind}[/]  {experiment.settings.measure(measure).symbol}: {why}")
    for one in made:
        case = one.case
        if one.published and one.published.not_reproduced:
            style = STYLES["not reproduced"]
            why = one.published.not_reproduced
            tell(f"[{style}]not reproduced[/]  {case.label}, N = {case.agents}: {why}")
        if case.row and case.last and case.row.remark and one.measure == experiment.measures[0]:
            tell(f"{case.label}, N = {case.agents}: {case.row.remark}")
    for note in notes(experiment, made):
        tell(f"[dim]note: {note}[/]")


def absences(experiment: Experiment, made: list[Verdict]) -> list[str]:
    """A line for each measure that some runs, but not all of a row, do not have."""
    lines = []
    for measure in experiment.measures:
        rows = [one for one in of(made, measure.name) if one.summary.absent]
        rows = [one for one in rows if one.summary.runs or one.published]
        if rows:
            cases = ", ".join(
                f"{one.case.label} N = {one.case.agents}{at(one)} ({one.summary.absent})"
                for one in rows
            )
            lines.append(
                f"[bold red]{measure.absent}[/]  {measure.symbol}: {cases} of "
                f"{counted(len(rows[0].values), 'run')} each; left out above"
            )
    return lines


def at(one: Verdict) -> str:
    """The tick of a run that is measured several times."""
    return "" if one.case.tick is None else f" at tick {one.case.tick}"


def notes(experiment: Experiment, made: list[Verdict]) -> list[str]:
    """What has to be known to read the numbers."""
    found = list(experiment.notes.values())
    compared = [one.published for one in made if one.published and one.z is not None]
    if any(not one.values for one in compared):
        found.append(NOTE)
    if any(one.values for one in compared):
        found.append(WELCH_NOTE)
    shown = any(one.published for one in made) and not experiment.settings.stops
    if shown and len(experiment.measures) > 1:
        found.append(INTERVAL_NOTE)
    return found
