"""Verdicts and answers in words and colours."""

from __future__ import annotations

from app.experiments.verdicts.answer import Answer
from app.experiments.verdicts.comparison import Comparison

STYLES = {
    "agrees": "green",
    "holds": "green",
    "differs": "bold red",
    "does not hold": "bold red",
    "undecided": "yellow",
    "by construction": "dim",
}


def styled(found: Comparison | Answer | None) -> str:
    """A verdict in its colour; nothing where nothing is compared."""
    return f"[{STYLES[found.word]}]{found}[/]" if found else ""
