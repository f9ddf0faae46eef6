"""What a paper says in words, and what was measured."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Claim:
    """What a paper says, and what was measured."""

    text: str
    holds: bool
    why: str = ""
    """Why it does not hold, where that is known."""

    @property
    def word(self) -> str:
        """In a word."""
        if self.holds:
            return "holds"
        return "not reproduced" if self.why else "does not hold"
