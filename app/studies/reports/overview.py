"""All experiments in one table: how many verdicts of each word."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from app.studies.claims.claims import Claim, differs_from_expected
from app.studies.experiment import Experiment
from app.studies.judge.claim_verdict import ClaimVerdict
from app.studies.judge.comparison import MeanComparison
from app.studies.judge.judge import CONFIDENCE, survives_holm
from app.studies.judge.verdict import Verdict
from app.studies.reports.tables import empty_table

Judged = tuple[Experiment, list[Verdict], list[Claim]]
"""An experiment with the verdicts on its rows and the answers to its claims."""
WORDS = ("agrees", "differs", "undecided", "by construction")
ANSWERS = ("holds", "does not hold", "undecided", "by construction")


def overview(outcomes: Sequence[Judged]) -> Any:
    """A line for each experiment: its rows beside published ones, its claims, what has changed."""
    heads = ("agree", "differ", "open", "built", "hold", "not", "open", "built", "news")
    table = empty_table("paper", "runs", *heads)
    answers = [
        answer for _, verdicts, claims in outcomes for answer in answers_of(verdicts, claims)
    ]
    table.title = (
        "verdicts on rows beside published ones, then on claims\n"
        "open: undecided; built: by construction; news: not as expected"
    )
    table.caption = describe_false_answers(answers)
    table.caption_justify = "left"
    table.title_justify = "left"
    totals: Counter[tuple[str, str]] = Counter()
    for experiment, verdicts, claims in outcomes:
        tally = Counter(("row", verdict.word) for verdict in verdicts if verdict.word)
        tally += Counter(("claim", claim.word) for claim in claims)
        totals += tally
        runs = max((len(verdict.values) for verdict in verdicts), default=0)
        table.add_row(
            experiment.name, str(runs), *counts(tally), str(changes(verdicts, claims) or "")
        )
    table.add_section()
    table.add_row("all", "", *counts(totals), "")
    return table


def answers_of(
    verdicts: Sequence[Verdict], claims: Sequence[Claim]
) -> list[MeanComparison | ClaimVerdict]:
    """All that runs were asked and can be wrong about."""
    compared = [verdict.comparison for verdict in verdicts if verdict.comparison]
    answers: list[MeanComparison | ClaimVerdict] = [*compared, *(claim.answer for claim in claims)]
    return [answer for answer in answers if answer.word != "by construction"]


def describe_false_answers(answers: Sequence[MeanComparison | ClaimVerdict]) -> str:
    """How many answers of a table may be false, and how many stand together (Holm at 1 %)."""
    decided = [answer for answer in answers if answer.word != "undecided"]
    sure = int(survives_holm(np.array([answer.p for answer in answers])).sum()) if answers else 0
    return (
        f"{len(answers)} answers at 99 % each, {len(decided)} decided: about "
        f"{(1.0 - CONFIDENCE) * len(answers):.2g} may be false; {sure} stand at 99 % all together "
        "(Holm)"
    )


def counts(tally: Counter[tuple[str, str]]) -> list[str]:
    """How often each word was given; nothing for never."""
    keys = [("row", word) for word in WORDS] + [("claim", word) for word in ANSWERS]
    return [str(tally[key] or "") for key in keys]


def changes(verdicts: Sequence[Verdict], claims: Sequence[Claim]) -> int:
    """How many verdicts are other than what was found before."""
    rows = [verdict for verdict in verdicts if verdict.word] + [*claims]
    return sum(differs_from_expected(row.word, row.expected) for row in rows)
