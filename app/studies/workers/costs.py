"""How long runs take: a guess from the published times, put right by the runs that are done."""

from __future__ import annotations

PER_AGENT_TICK = 1e-7
"""Seconds per agent and tick to begin with."""
PER_SIGNAL = 3.0
"""How many times dearer a tick is for each signal of the rule."""


def guess(ticks: float, agents: int, signals: int) -> float:
    """Seconds that a run of so many ticks may take; `signals` of the rule."""
    return ticks * (agents + 1) * PER_AGENT_TICK * (1.0 + PER_SIGNAL * signals)


class Costs:
    """What is done and what is left, in seconds of one core."""

    def __init__(self, guesses: list[float], left: list[int]):
        self.guesses = guesses
        self.left = list(left)
        self.spent = [0.0] * len(guesses)
        self.done = [0] * len(guesses)

    def add(self, case: int, seconds: float) -> None:
        """Count a run of a case (by its number) that is done."""
        self.left[case] -= 1
        self.done[case] += 1
        self.spent[case] += seconds

    @property
    def slowness(self) -> float:
        """How many times longer the runs take than guessed."""
        guessed = sum(n * guess for n, guess in zip(self.done, self.guesses, strict=True))
        return sum(self.spent) / guessed if guessed else 1.0

    @property
    def ahead(self) -> float:
        """Seconds of one core for what is left."""
        slowness = self.slowness
        return sum(
            left * (spent / done if done else slowness * guess)
            for left, spent, done, guess in zip(
                self.left, self.spent, self.done, self.guesses, strict=True
            )
        )

    @property
    def share(self) -> float:
        """Share of the work that is done, in [0, 1]."""
        spent, ahead = sum(self.spent), self.ahead
        return spent / (spent + ahead) if spent + ahead else 1.0
