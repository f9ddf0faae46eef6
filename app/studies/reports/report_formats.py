"""The outcome of an experiment: for people, as JSON, as a CSV file of the summary."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.studies.claims.claims import Claim, beside
from app.studies.experiment import Experiment
from app.studies.judge.claim_verdict import ANSWERS_NOTE
from app.studies.judge.comparison import NOTE, SPREAD_NOTE, WELCH_NOTE
from app.studies.judge.judge import RunRanges, share_interval
from app.studies.judge.verdict import Verdict, of
from app.studies.reports.overview import answers_of, false_words
from app.studies.reports.tables import STYLES, styled, table_of
from worlds.file_writer import csv_text, write_text
from worlds.number_text import counted

if TYPE_CHECKING:
    from rich.console import Console


def as_value(experiment: Experiment, made: list[Verdict], said: list[Claim]) -> dict[str, Any]:
    """The outcome as one value for JSON."""
    return {
        "name": experiment.name,
        "title": experiment.title,
        "source": experiment.source,
        "kind": experiment.settings.kind,
        "settings": experiment.settings.model_dump(),
        "notes": {
            **experiment.notes,
            "verdicts": NOTE,
            "spread": SPREAD_NOTE,
            "welch": WELCH_NOTE,
            "claims": ANSWERS_NOTE,
        },
        "rows": [one.as_row() for one in made],
        "claims": [as_row(one) for one in said],
    }


def as_row(claim: Claim) -> dict[str, Any]:
    """A claim and its answer for JSON."""
    return {
        "text": claim.text,
        "verdict": claim.word,
        "needed": claim.answer.needed,
        "because": claim.answer.why,
        "p": claim.answer.p,
        "expected": claim.expected.verdict if claim.expected else "",
        "why": claim.by_construction or (claim.expected.why if claim.expected else ""),
    }


def write_summary(path: Path, made: list[Verdict]) -> None:
    """Write the summary as CSV, one line per row and measure. Raises InputError."""
    rows = [one.as_row() for one in made]
    columns = dict.fromkeys(key for row in rows for key in row)
    cells = ([row.get(key, "") for key in columns] for row in rows)
    write_text("summary", path, csv_text(columns, cells))


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
    if answers := answers_of(made, said):
        tell(f"[dim]{false_words(answers)}[/]")
    for line in reasons_of_rows(made):
        tell(line)
    for claim in said:
        why = f": {claim.by_construction}" if claim.word == "by construction" else ""
        tell(f"  {styled(claim.answer)}  {claim.text}{why}")
        known = beside(claim.word, claim.expected)
        if known:
            tell(f"    [dim]{known}[/]")
    for line in known_of(experiment, made):
        tell(line)
    for note in notes(experiment, made, said):
        tell(f"[dim]note: {note}[/]")


def known_of(experiment: Experiment, made: list[Verdict]) -> list[str]:
    """What was found before of rows, what is not compared and why, and other remarks on rows."""
    lines = [
        f"{experiment.settings.measure(measure).symbol} is not compared: {why}"
        for measure, why in experiment.not_compared.items()
    ]
    for one in made:
        case = one.case
        row = f"{case.label}, N = {case.agents}"
        if one.comparison and one.expected:
            lines.append(
                f"{row}, {one.measure.symbol} {one.word}; [dim]{beside(one.word, one.expected)}[/]"
            )
        if case.row and case.last and case.row.remark and one.measure == experiment.measures[0]:
            lines.append(f"{row}: {case.row.remark}")
    return lines


def absences(experiment: Experiment, made: list[Verdict]) -> list[str]:
    """Lines on each measure that some runs, but not all of a row, do not have.

    Of runs that were given up two things can be said that name their limit: the mean of what came
    first, the value or the limit, and the share of runs that end within it.
    """
    lines = []
    for measure in experiment.measures:
        rows = [one for one in of(made, measure.name) if one.summary.absent]
        lines += [given_up(one, one.summary.limit) for one in rows if one.summary.limit is not None]
        rows = [one for one in rows if one.summary.limit is None]
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


def reasons_of_rows(made: list[Verdict]) -> list[str]:
    """What keeps rows undecided, or by construction, a line for each reason and measure."""
    found: dict[tuple[str, str, str], list[str]] = {}
    for one in made:
        if one.comparison and one.comparison.why:
            key = one.word, one.measure.symbol, one.comparison.why
            found.setdefault(key, []).append(f"{one.case.label} N = {one.case.agents}{at(one)}")
    return [
        f"[{STYLES[word]}]{word}[/]  {symbol}: {why}: {', '.join(rows)}"
        for (word, symbol, why), rows in found.items()
    ]


def given_up(one: Verdict, limit: float) -> str:
    """What can be said of a row of which runs were given up at a limit."""
    runs = one.ranges.runs
    low, high = RunRanges(
        one.ranges.least, one.ranges.least, (one.ranges.bounds[0], limit)
    ).interval()
    share = share_interval(one.summary.runs, runs)
    unit = "" if one.unit == "1" else f" {one.unit}"
    return (
        f"[bold red]{one.measure.absent}[/]  {one.case.label} N = {one.case.agents}{at(one)}: "
        f"{one.summary.absent} of {counted(runs, 'run')} given up at {limit:g}{unit}; mean of "
        f"min({one.measure.symbol}, {limit:g}) {one.summary.mean:.4g}{unit} (99 %: {low:.4g} to "
        f"{high:.4g}); {one.summary.runs / runs:.1%} end within {limit:g}{unit} (99 %: "
        f"{float(share.low):.1%} to {float(share.high):.1%})"
    )


def at(one: Verdict) -> str:
    """The tick of a run that is measured several times."""
    return "" if one.case.tick is None else f" at tick {one.case.tick}"


def notes(experiment: Experiment, made: list[Verdict], said: list[Claim]) -> list[str]:
    """What has to be known to read the numbers."""
    found = list(experiment.notes.values())
    compared = [one.published for one in made if one.published and one.comparison]
    if compared:
        found.append(NOTE)
    if any(not one.values for one in compared):
        found.append(SPREAD_NOTE)
    if any(one.values for one in compared):
        found.append(WELCH_NOTE)
    if said:
        found.append(ANSWERS_NOTE)
    return found
