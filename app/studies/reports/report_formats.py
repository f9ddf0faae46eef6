"""The outcome of an experiment: for people, as JSON, as a CSV file of the summary."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.studies.claims.claims import Claim, word_and_expected
from app.studies.experiment import Experiment
from app.studies.judge.claim_verdict import ANSWERS_NOTE
from app.studies.judge.comparison import NOTE, SPREAD_NOTE, WELCH_NOTE
from app.studies.judge.judge import RunRanges, share_interval
from app.studies.judge.verdict import Verdict, verdicts_on
from app.studies.reports.overview import answers_of, describe_false_answers
from app.studies.reports.tables import STYLES, style_answer, table_of
from worlds.file_writer import csv_text, write_text
from worlds.number_text import counted

if TYPE_CHECKING:
    from rich.console import Console


def as_value(
    experiment: Experiment, verdicts: list[Verdict], claims: list[Claim]
) -> dict[str, Any]:
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
        "rows": [verdict.as_row() for verdict in verdicts],
        "claims": [as_row(claim) for claim in claims],
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


def write_summary(path: Path, verdicts: list[Verdict]) -> None:
    """Write the summary as CSV, one line per row and measure. Raises InputError."""
    rows = [verdict.as_row() for verdict in verdicts]
    columns = dict.fromkeys(key for row in rows for key in row)
    cells = ([row.get(key, "") for key in columns] for row in rows)
    write_text("summary", path, csv_text(columns, cells))


def show(
    console: Console, experiment: Experiment, verdicts: list[Verdict], claims: list[Claim]
) -> None:
    """Print the outcome for people."""

    def tell(text: str) -> None:
        console.print(text, highlight=False)

    tell(f"[bold]{experiment.title}[/] ({experiment.source})")
    console.print(table_of(verdicts))
    runs = len(verdicts[0].values)
    tell(f"{runs} runs in each row" if runs > 1 else "one run")
    for line in describe_absences(experiment, verdicts):
        tell(line)
    if answers := answers_of(verdicts, claims):
        tell(f"[dim]{describe_false_answers(answers)}[/]")
    for line in reasons_of_rows(verdicts):
        tell(line)
    for claim in claims:
        why = f": {claim.by_construction}" if claim.word == "by construction" else ""
        tell(f"  {style_answer(claim.answer)}  {claim.text}{why}")
        word_text = word_and_expected(claim.word, claim.expected)
        if word_text:
            tell(f"    [dim]{word_text}[/]")
    for line in describe_known(experiment, verdicts):
        tell(line)
    for note in notes(experiment, verdicts, claims):
        tell(f"[dim]note: {note}[/]")


def describe_known(experiment: Experiment, verdicts: list[Verdict]) -> list[str]:
    """What was found before of rows, what is not compared and why, and other remarks on rows."""
    lines = [
        f"{experiment.settings.measure(measure).symbol} is not compared: {why}"
        for measure, why in experiment.not_compared.items()
    ]
    for verdict in verdicts:
        case = verdict.case
        row = f"{case.label}, N = {case.agents}"
        if verdict.comparison and verdict.expected:
            lines.append(
                f"{row}, {verdict.measure.symbol} {verdict.word}; "
                f"[dim]{word_and_expected(verdict.word, verdict.expected)}[/]"
            )
        if case.row and case.last and case.row.remark and verdict.measure == experiment.measures[0]:
            lines.append(f"{row}: {case.row.remark}")
    return lines


def describe_absences(experiment: Experiment, verdicts: list[Verdict]) -> list[str]:
    """Lines on each measure that some runs, but not all of a row, do not have.

    Of runs that were given up two things can be said that name their limit: the mean of what came
    first, the value or the limit, and the share of runs that end within it.
    """
    lines = []
    for measure in experiment.measures:
        rows = [
            verdict for verdict in verdicts_on(verdicts, measure.name) if verdict.summary.absent
        ]
        lines += [
            describe_given_up(row, row.summary.limit)
            for row in rows
            if row.summary.limit is not None
        ]
        rows = [row for row in rows if row.summary.limit is None]
        rows = [row for row in rows if row.summary.runs or row.published]
        if rows:
            cases = ", ".join(
                f"{row.case.label} N = {row.case.agents}{tick_text(row)} ({row.summary.absent})"
                for row in rows
            )
            lines.append(
                f"[bold red]{measure.absent}[/]  {measure.symbol}: {cases} of "
                f"{counted(len(rows[0].values), 'run')} each; left out above"
            )
    return lines


def reasons_of_rows(verdicts: list[Verdict]) -> list[str]:
    """What keeps rows undecided, or by construction, a line for each reason and measure."""
    reasons: dict[tuple[str, str, str], list[str]] = {}
    for verdict in verdicts:
        if verdict.comparison and verdict.comparison.why:
            key = verdict.word, verdict.measure.symbol, verdict.comparison.why
            reasons.setdefault(key, []).append(
                f"{verdict.case.label} N = {verdict.case.agents}{tick_text(verdict)}"
            )
    return [
        f"[{STYLES[word]}]{word}[/]  {symbol}: {why}: {', '.join(rows)}"
        for (word, symbol, why), rows in reasons.items()
    ]


def describe_given_up(verdict: Verdict, limit: float) -> str:
    """What can be said of a row of which runs were given up at a limit."""
    runs = verdict.ranges.runs
    low, high = RunRanges(
        verdict.ranges.least, verdict.ranges.least, (verdict.ranges.bounds[0], limit)
    ).interval()
    share = share_interval(verdict.summary.runs, runs)
    unit = "" if verdict.unit == "1" else f" {verdict.unit}"
    return (
        f"[bold red]{verdict.measure.absent}[/]  {verdict.case.label} "
        f"N = {verdict.case.agents}{tick_text(verdict)}: "
        f"{verdict.summary.absent} of {counted(runs, 'run')} given up at {limit:g}{unit}; mean of "
        f"min({verdict.measure.symbol}, {limit:g}) {verdict.summary.mean:.4g}{unit} "
        f"(99 %: {low:.4g} to "
        f"{high:.4g}); {verdict.summary.runs / runs:.1%} end within {limit:g}{unit} (99 %: "
        f"{float(share.low):.1%} to {float(share.high):.1%})"
    )


def tick_text(verdict: Verdict) -> str:
    """The tick of a run that is measured several times."""
    return "" if verdict.case.tick is None else f" at tick {verdict.case.tick}"


def notes(experiment: Experiment, verdicts: list[Verdict], claims: list[Claim]) -> list[str]:
    """What has to be known to read the numbers."""
    lines = list(experiment.notes.values())
    compared = [
        verdict.published for verdict in verdicts if verdict.published and verdict.comparison
    ]
    if compared:
        lines.append(NOTE)
    if any(not measure.values for measure in compared):
        lines.append(SPREAD_NOTE)
    if any(measure.values for measure in compared):
        lines.append(WELCH_NOTE)
    if claims:
        lines.append(ANSWERS_NOTE)
    return lines
