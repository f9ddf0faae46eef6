"""What kind of runs an experiment makes: how one is run, and what is measured of it."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Literal, NamedTuple

from pydantic import Field

from app.strict_table import ParameterValue, StrictTable

if TYPE_CHECKING:
    from agents import Flock

Number = int | float


class MeasureBounds(NamedTuple):
    """What no run of a measure can be outside of."""

    low: float = -math.inf
    high: float = math.inf
    binary: bool = False
    """Whether each run gives one of the two and nothing between: successes are counted."""
    rare: bool = False
    """Whether few runs may be far from all others, as those with a crash."""


UNBOUNDED = MeasureBounds()
COUNT, PERCENT, SHARE = (MeasureBounds(0.0, high) for high in (math.inf, 100.0, 1.0))
HALF_TURN = MeasureBounds(0.0, 180.0)
SUCCESS, EITHER = PERCENT._replace(binary=True), SHARE._replace(binary=True)
RARE, RARE_PERCENT = COUNT._replace(rare=True), PERCENT._replace(rare=True)


@dataclass(frozen=True)
class Measure:
    """A number that is measured of each run."""

    name: str
    """Its column in the store."""
    symbol: str
    """At the head of a table."""
    title: str
    unit: str
    absent: str = "not measured"
    """What it means for a run to have none."""
    without: float = math.nan
    """What a run without it counts as in claims: a distance never measured is inf."""
    whole: bool = False
    """Whether it is a whole number."""
    words: tuple[str, ...] = ()
    """What the whole numbers from 0 on stand for, where it is no quantity but a name."""
    bounds: MeasureBounds = UNBOUNDED
    limited: bool = False
    """Whether a run without it was given up at the settings' `limit`, in its unit, and so has at
    least that."""

    def counted(self, value: Number | None) -> float:
        """What a run with that value counts as in claims."""
        return self.without if value is None else value

    def read(self, text: str) -> Number | None:
        """A value from the store. Raises ValueError."""
        if not text:
            return None
        return int(text) if self.whole else float(text)


class Settings(StrictTable):
    """What all rows of an experiment share; each kind of experiment adds its own."""

    kind: ClassVar[str]
    measures: ClassVar[tuple[Measure, ...]]
    """In the order of the store's columns."""
    measured_by: ClassVar[tuple[Callable, ...]] = ()
    """Compiled functions that the numbers depend on beside the flock's own loop."""

    world: str
    dim: Literal[2, 3] | None = None
    """Dimensions; None for the world's own, or 2."""
    parameters: dict[str, ParameterValue] = Field(default_factory=dict)
    n_counts_informed: bool = False
    """Whether the paper counts the information agents, and those of all kinds, in N."""

    @property
    def stops(self) -> Sequence[int]:
        """The ticks at which each run is measured; none where a run is measured once."""
        return []

    @abstractmethod
    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Run a flock to the end; its measures by name, None where there is none.

        `between` is called now and then and may end the run by raising. The flock is at tick 0, or,
        in a run that goes through several values of a parameter or several looks, where it was left
        the time before.
        """

    @abstractmethod
    def ticks(self, published: float | None, dt: float) -> float:
        """Ticks that a run may take, from the published time if there is one."""

    def compile(self, flock: Flock) -> None:
        """Compile what `run` calls beside the flock's own loop; the flock may be used up."""

    def limits_of(
        self, measure: Measure, values: Mapping[str, Sequence[Number | None]]
    ) -> list[float | None]:
        """What each run was given up at that is without a value; None where that says nothing."""
        limit = float(self.limit) if measure.limited else None  # type: ignore[attr-defined]
        return [limit] * len(values[measure.name])

    @classmethod
    def measure(cls, name: str) -> Measure:
        """The measure of that name. Raises KeyError."""
        return {measure.name: measure for measure in cls.measures}[name]
