"""Before the runs: which claims and comparisons a number of runs can decide at all."""

from __future__ import annotations

from collections.abc import Iterator

from app.studies.claims.sweep_claims import HALF
from app.studies.experiment import Experiment
from app.studies.experiment_file import (
    DeclaredClaim,
    EnduranceClaim,
    EveryRunClaim,
    FasterClaim,
    PhaseClaim,
)
from app.studies.judge.claim_verdict import runs_for_share
from app.studies.judge.comparison import runs_to_agree
from app.studies.judge.judge import FEWEST_RUNS
from worlds.number_text import counted


def describe_prospects(experiment: Experiment, runs: int) -> str:
    """What so many runs can decide, in a sentence; empty where nothing is to be decided."""
    all_questions = list(questions(experiment))
    few = [(words, needed) for words, needed in all_questions if needed is None or needed > runs]
    if not all_questions:
        return ""
    decided = len(all_questions) - len(few)
    text = (
        f"{counted(runs, 'run')} can decide {decided} of {len(all_questions)} claims and "
        "comparisons"
    )
    if not few:
        return text
    listed = "; ".join(
        f"{words} ({'no number would' if needed is None else needed})"
        for words, needed in dict(few).items()
    )
    return f"{text}, as far as their spread allows; too few to bear out: {listed}"


def questions(experiment: Experiment) -> Iterator[tuple[str, int | None]]:
    """What is asked of the runs, in words, and the runs from which on it can be borne out."""
    for claim in experiment.said:
        if not claim.by_construction and (row_count := rows_of(experiment, claim)):
            words = experiment.settings.measure(claim.measure).symbol
            labels = getattr(claim, "labels", None)
            name = f"{words} of {', '.join(labels)}" if labels else words
            yield name, runs_needed(experiment, claim, row_count)
    for sweep in {id(case.sweep): case.sweep for case in experiment.cases if case.sweep}.values():
        if sweep.trend:
            yield f"{sweep.parameter} {sweep.trend}", FEWEST_RUNS
        if sweep.flat_from is not None:
            yield f"{sweep.parameter} flat", FEWEST_RUNS
    for case in experiment.cases:
        for measure in experiment.measures:
            published = case.published(measure.name)
            spared = measure.name in experiment.not_compared
            if published is None or published.by_construction:
                continue
            if published.average is not None and not spared:
                yield f"{measure.symbol} agrees", runs_to_agree(published)


def rows_of(experiment: Experiment, claim: DeclaredClaim) -> int:
    """How many cases a claim is about; none where those that it names are not run."""
    labels = set(getattr(claim, "labels", [])) or {getattr(claim, "label", "")} - {""}
    sizes, tick = getattr(claim, "agents", []), getattr(claim, "tick", None)
    return sum(
        (not labels or case.label in labels)
        and (not sizes or case.agents in sizes)
        and tick in (None, case.tick)
        for case in experiment.cases
    )


def runs_needed(experiment: Experiment, claim: DeclaredClaim, rows: int) -> int | None:
    """Runs with which a claim can be borne out if no run speaks against it."""
    if isinstance(claim, EveryRunClaim):
        if experiment.runs == 1:
            return 1
        return runs_for_share(1.0, claim.share, 1 if claim.share == 1.0 else rows)
    if isinstance(claim, FasterClaim | EnduranceClaim):
        return runs_for_share(1.0, 1.0)
    if isinstance(claim, PhaseClaim):
        return runs_for_share(1.0, HALF, rows)
    return FEWEST_RUNS
