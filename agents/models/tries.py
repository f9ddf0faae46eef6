"""Declare what to try with a model: what to change, what one then sees, and what a check measures.

Pages of models, the guide of the laboratory and `flockscope list MODEL` show tries;
`agents.conformance` makes each and looks whether what it says comes true.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

RELATIONS = ("below", "above", "falls", "rises")


@dataclass(frozen=True)
class LessonCheck:
    """What a program finds of a try: an observable, its mean over the last fifth of some ticks.

    Raises TypeError for a relation that there is not.
    """

    observable: str
    relation: Literal["below", "above", "falls", "rises"]
    """`below` and `above` the number; or it `falls` or `rises` by that at least, beside as many
    ticks without the change."""
    number: float
    ticks: int

    def __post_init__(self) -> None:
        if self.relation not in RELATIONS:
            raise TypeError(f"{self.relation!r} is no relation: {', '.join(RELATIONS)}")

    def holds(self, before: float, after: float) -> bool:
        """Whether it does, from the observable without the change and with it.

        >>> LessonCheck("polarisation", "falls", 0.5, 100).holds(before=1.0, after=0.2)
        True
        """
        return {
            "below": after < self.number,
            "above": after > self.number,
            "falls": before - after >= self.number,
            "rises": after - before >= self.number,
        }[self.relation]

    @property
    def in_words(self) -> str:
        """What is found, for people.

        >>> LessonCheck("polarisation", "falls", 0.5, 100).in_words
        'polarisation: down by 0.5 or more in 100 ticks'
        """
        name = self.observable.replace("-", " ")
        if self.relation in ("below", "above"):
            return f"{name}: {self.relation} {self.number:g} after {self.ticks} ticks"
        direction = "down" if self.relation == "falls" else "up"
        return f"{name}: {direction} by {self.number:g} or more in {self.ticks} ticks"


@dataclass(frozen=True)
class LessonStep:
    """Something to try with a model, in its own world: three of them make its first lesson."""

    words: str
    """What to do, a sentence."""
    see: str
    """What one then sees, a sentence or two."""
    set: Mapping[str, Any]
    """The changes: parameters of the rule or the body, or options of a run, name -> value."""
    proof: LessonCheck
    anew: bool = False
    """Whether the run begins again with it, as options of a run need it."""

    @property
    def changes(self) -> str:
        """The changes in short.

        >>> proof = LessonCheck("polarisation", "below", 0.3, 100)
        >>> LessonStep("Add noise", "Disorder", {"eta": 5.0, "informed": 3}, proof).changes
        'eta = 5, informed = 3'
        """
        return ", ".join(f"{name} = {format_short(value)}" for name, value in self.set.items())


def format_short(value: Any) -> str:
    """A value as a person would write it."""
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:g}" if isinstance(value, int | float) else str(value)
