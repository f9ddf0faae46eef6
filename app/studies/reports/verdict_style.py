"""Verdicts and answers in words and colours."""

from __future__ import annotations

from app.studies.verdicts.claim_verdict import ClaimVerdict
from app.studies.verdicts.comparison import MeanComparison

STYLES = {
    "agrees": "green",
    "holds": "green",
    "differs": "bold red",
    "does not hold": "bold red",
    "undecided": "yellow",
    "by construction": "dim",
}


def styled(found: MeanComparison | ClaimVerdict | None) -> str:
    """A verdict in its colour; nothing where nothing is compared."""
    return f"[{STYLES[found.word]}]{found}[/]" if found else ""
