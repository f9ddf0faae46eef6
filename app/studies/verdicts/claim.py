"""What a paper says in words, and what was measured."""

from __future__ import annotations

from dataclasses import dataclass

from app.studies.experiment_file import ExpectedVerdict
from app.studies.verdicts.claim_verdict import ClaimVerdict


@dataclass(frozen=True)
class Claim:
    """What a paper says with what was measured, and the answer of the runs."""

    text: str
    answer: ClaimVerdict
    expected: ExpectedVerdict | None = None
    """What was found before."""
    by_construction: str = ""
    """Why it cannot fail; empty where it can."""

    @property
    def word(self) -> str:
        """In a word."""
        return self.answer.word


def beside(word: str, expected: ExpectedVerdict | None) -> str:
    """What was found before beside the word that the runs give; nothing where nothing is known."""
    if expected is None:
        return ""
    now = f"; now: {word}" if is_news(word, expected) else ""
    return f"expected: {expected.verdict}{now}; {expected.why}"


def is_news(word: str, expected: ExpectedVerdict | None) -> bool:
    """Whether the runs say something else than what was found before."""
    return expected is not None and word not in ("undecided", expected.verdict)
