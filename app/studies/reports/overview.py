"""All experiments in one table: how many verdicts of each word."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from app.studies.claims.claims import Claim, is_news
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
    answers = [one for _, made, said in outcomes for one in answers_of(made, said)]
    table.title = (
        "verdicts on rows beside published ones, then on claims\n"
        "open: undecided; built: by construction; news: not as expected"
    )
    table.caption = false_words(answers)
    table.caption_justify = "left"
    table.title_justify = "left"
    totals: Counter[tuple[str, str]] = Counter()
    for experiment, made, said in outcomes:
        found = Counter(("row", one.word) for one in made if one.word)
        found += Counter(("claim", one.word) for one in said)
        totals += found
        runs = max((len(one.values) for one in made), default=0)
        table.add_row(experiment.name, str(runs), *counts(found), str(changes(made, said) or ""))
    table.add_section()
    table.add_row("all", "", *counts(totals), "")
    return table


def answers_of(
    made: Sequence[Verdict], said: Sequence[Claim]
) -> list[MeanComparison | ClaimVerdict]:
    """All that runs were asked and can be wrong about."""
    compared = [one.comparison for one in made if one.comparison]
    found: list[MeanComparison | ClaimVerdict] = [*compared, *(claim.answer for claim in said)]
    return [one for one in found if one.word != "by construction"]


def false_words(answers: Sequence[MeanComparison | ClaimVerdict]) -> str:
    """How many answers of a table may be false, and how many stand together (Holm at 1 %)."""
    decided = [one for one in answers if one.word != "undecided"]
    sure = int(survives_holm(np.array([one.p for one in answers])).sum()) if answers else 0
    return (
        f"{len(answers)} answers at 99 % each, {len(decided)} decided: about "
        f"{(1.0 - CONFIDENCE) * len(answers):.2g} may be false; {sure} stand at 99 % all together "
        "(Holm)"
    )


def counts(found: Counter[tuple[str, str]]) -> list[str]:
    """How often each word was given; nothing for never."""
    keys = [("row", word) for word in WORDS] + [("claim", word) for word in ANSWERS]
    return [str(found[key] or "") for key in keys]


def changes(made: Sequence[Verdict], said: Sequence[Claim]) -> int:
    """How many verdicts are other than what was found before."""
    found = [one for one in made if one.word] + [*said]
    return sum(is_news(one.word, one.expected) for one in found)
