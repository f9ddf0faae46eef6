"""The TOML file of an optimisation: a sweep's, with a search in place of designs."""

from __future__ import annotations

from typing import Literal

from pydantic import Field, field_validator, model_validator

from agents.spec import LARGEST_SEED
from app.strict_table import Line, StrictTable, Value
from app.studies.cluster.cluster_options import Cluster
from app.studies.search import Algorithm
from app.studies.sweeps.given.sweep_file import (
    MOST_TICKS,
    Axis,
    Observe,
    RunOptions,
    Span,
    Stop,
)

MOST_EVALUATIONS = 1_000_000
FRESH_FROM = 1000
"""How much later fresh seeds begin, so that they are easily told from the others."""


class Search(StrictTable):
    """What is searched, and how."""

    algorithm: Algorithm
    axes: dict[str, Axis] = Field(min_length=1)
    where: str = ""
    """A condition between axes: points for which it does not hold are not run."""
    evaluations: int = Field(ge=1, le=MOST_EVALUATIONS)
    """Points that are proposed, at most."""
    population: int | None = Field(default=None, ge=2, le=10_000)
    """Points of a generation."""
    seed: int = Field(default=1, ge=0, le=2**32 - 1)
    """Of the search, not of its runs."""

    @field_validator("axes")
    @classmethod
    def _are_bounds(cls, axes: dict[str, Axis]) -> dict[str, Axis]:
        for name, axis in axes.items():
            if isinstance(axis, Span) and (axis.count is not None or axis.step is not None):
                raise ValueError(f"{name}: a search finds its own values: leave count and step out")
            if not isinstance(axis, Span) and len(axis) < 2:
                raise ValueError(f"{name}: there is nothing to choose between")
        return axes

    @model_validator(mode="after")
    def _fits(self) -> Search:
        if self.algorithm == "cma" and len(self.axes) < 2:
            raise ValueError("algorithm: cma needs two axes or more: take ga or pso")
        return self

    @property
    def generation(self) -> int:
        """Points of a generation: an eighth of all, from 4 to 50, where nothing is said."""
        return self.population or max(4, min(50, self.evaluations // 8))


class Seeds(StrictTable):
    """How often each point is run, with seeds that all points have in common."""

    count: int = Field(default=10, ge=1, le=1_000_000)
    first: int = Field(default=1, ge=0, le=LARGEST_SEED // 2)
    fresh: int = Field(default=100, ge=2, le=1_000_000)
    """Seeds that the search has not seen, on which the best is told."""

    @property
    def common(self) -> range:
        """Those of the search."""
        return range(self.first, self.first + self.count)

    @property
    def unseen(self) -> range:
        """Those of the answer."""
        first = self.first + max(FRESH_FROM, self.count)
        return range(first, first + self.fresh)


class PointMeasurement(StrictTable):
    """What is measured of a point, in runs that may differ from the others."""

    at: dict[str, Value] = Field(default_factory=dict)
    """Parameters and options of these runs."""
    ticks: int | None = Field(default=None, ge=1, le=MOST_TICKS)
    """Ticks of these runs; None: as [run] has it."""
    stop: bool = True
    """Whether [stop] is for these runs, too."""


class Objective(PointMeasurement):
    """What is to be the least or the most: the mean of an observable over the seeds."""

    observable: str
    """A column of what is observed; k of [stop]."""
    aim: Literal["least", "most"]


class Constraint(PointMeasurement):
    """What the mean of an observable has to keep to."""

    says: str
    """A comparison with >= or <=, such as `polarisation >= 0.9`."""


class OptimisationFile(StrictTable):
    """A whole file."""

    title: Line = Field(default="", max_length=200)
    run: RunOptions
    stop: Stop | None = None
    search: Search
    replicates: Seeds = Seeds()
    observe: list[Observe] = Field(default_factory=list)
    objective: list[Objective] = Field(min_length=1)
    constraint: list[Constraint] = Field(default_factory=list)
    cluster: Cluster = Cluster()

    @model_validator(mode="after")
    def _fits(self) -> OptimisationFile:
        several = len(self.objective) > 1
        if several != (self.search.algorithm == "nsga2"):
            raise ValueError(
                "algorithm: several objectives need nsga2, one needs ga, pso or cma: there are "
                f"{len(self.objective)} with {self.search.algorithm}"
            )
        return self
