"""A sweep's TOML file: the run, when it stops, the designs, the replicates, what is observed."""

from __future__ import annotations

import re
from typing import Annotated, Any, Literal

from pydantic import AliasChoices, ConfigDict, Field, field_validator, model_validator

from agents.spec import LARGEST_SEED, Options
from app.strict_table import Line, StrictTable, Value
from app.studies.cluster.cluster_options import Cluster

MOST_CELLS = 1_000_000
MOST_TICKS = 10**9
EVERY = re.compile(r"every ([1-9][0-9]{0,8})")


class RunOptions(StrictTable, Options):
    """What all runs share; axes set what differs."""

    model: str
    """A model, or a file of a rule."""
    agents: int | None = Field(default=None, ge=1)
    size: float | tuple[float, ...] | None = None
    dim: Literal[2, 3] | None = None
    world: str | None = None
    ticks: int = Field(ge=1, le=MOST_TICKS)
    """Ticks of a run; with [stop] the most."""
    timeout: float | None = Field(
        default=None, gt=0.0, validation_alias=AliasChoices("timeout", "seconds")
    )
    """Seconds of the clock after which a run is killed; None: as long as it takes. Files of earlier
    versions say `seconds`."""
    parameters: dict[str, Value] = Field(default_factory=dict)


class Stop(StrictTable):
    """When a run is over before its last tick."""

    when: str
    hold: int = Field(default=1, ge=1)
    """Ticks for which it has to hold; `k` is the tick from which it did."""
    every: int = Field(default=1, ge=1)
    """Ticks between two looks."""


class Span(StrictTable):
    """Values of an axis between two bounds; a grid says how many, or how far apart."""

    model_config = ConfigDict(populate_by_name=True)

    from_: float = Field(alias="from")
    to: float
    count: int | None = Field(default=None, ge=2, le=MOST_CELLS)
    step: float | None = Field(default=None, gt=0.0)
    scale: Literal["linear", "log"] = "linear"

    @model_validator(mode="after")
    def _fits(self) -> Span:
        if self.scale == "log" and min(self.from_, self.to) <= 0.0:
            raise ValueError("a scale of log needs from and to above 0")
        if self.scale == "log" and self.step is not None:
            raise ValueError("a scale of log has no step: give count")
        if self.count is not None and self.step is not None:
            raise ValueError("count and step are two ways to say the same: give one")
        if self.from_ == self.to:
            raise ValueError("from and to are the same")
        return self


type Axis = Annotated[list[Value], Field(min_length=1, max_length=MOST_CELLS)] | Span


class Design(StrictTable):
    """What all designs have."""

    where: str = ""
    """A condition between axes: only cells for which it holds are run."""


class GridDesign(Design):
    """Every value of an axis with every value of the others."""

    kind: Literal["grid"] = "grid"
    axes: dict[str, Axis] = Field(min_length=1)


class ListDesign(Design):
    """Cells one by one: rows of the file, or of a CSV beside it."""

    kind: Literal["list", "csv"]
    rows: list[dict[str, Value]] = Field(default_factory=list)
    file: str = ""
    """A CSV whose first line names the axes."""

    @model_validator(mode="after")
    def _has_one(self) -> ListDesign:
        if bool(self.rows) == bool(self.file):
            raise ValueError("either rows or file is needed")
        return self


class SampleDesign(Design):
    """What samples have: bounds of axes, and a seed of their own."""

    axes: dict[str, Axis] = Field(min_length=1)
    seed: int = Field(default=1, ge=0, le=2**32 - 1)

    @field_validator("axes")
    @classmethod
    def _are_bounds(cls, axes: dict[str, Any]) -> dict[str, Any]:
        for name, axis in axes.items():
            if isinstance(axis, Span) and (axis.count is not None or axis.step is not None):
                raise ValueError(f"{name}: a sample draws its own values: leave count and step out")
        return axes


class Latin(SampleDesign):
    """A Latin hypercube."""

    kind: Literal["latin-hypercube"]
    points: int = Field(ge=1, le=MOST_CELLS)


def power_of_two(value: int) -> int:
    """A power of two. Raises ValueError for any other number."""
    if value & (value - 1):
        raise ValueError(f"{value} is not a power of two")
    return value


class Sobol(SampleDesign):
    """Points of a scrambled Sobol sequence."""

    kind: Literal["sobol"]
    points: int = Field(ge=1, le=MOST_CELLS)
    _balanced = field_validator("points")(power_of_two)


class Saltelli(SampleDesign):
    """Saltelli's points for Sobol indices: points (D + 2) cells, or points (2 D + 2)."""

    kind: Literal["saltelli"]
    points: int = Field(ge=2, le=MOST_CELLS)
    second_order: bool = False
    _balanced = field_validator("points")(power_of_two)


class Morris(SampleDesign):
    """Morris' trajectories of elementary effects: trajectories (D + 1) cells."""

    kind: Literal["morris"]
    trajectories: int = Field(ge=2, le=MOST_CELLS)
    levels: int = Field(default=4, ge=2, le=1000)

    @field_validator("levels")
    @classmethod
    def _even(cls, value: int) -> int:
        if value % 2:
            raise ValueError(f"{value} levels are not even")
        return value


type AnyDesign = Annotated[
    GridDesign | ListDesign | Latin | Sobol | Saltelli | Morris, Field(discriminator="kind")
]


class Precision(StrictTable):
    """More replicates where the interval of a mean is wide, until it is narrow enough."""

    observable: str
    within: float = Field(gt=0.0)
    """Half of the interval of the mean, at most."""
    relative: bool = False
    """Whether `within` is a share of the mean."""
    confidence: float = Field(default=0.95, gt=0.5, lt=1.0)
    most: int = Field(ge=2, le=1_000_000)
    """Replicates of a cell, at most."""
    step: int = Field(5, ge=1)
    """Replicates that are added at a time."""
    budget: int | None = Field(default=None, ge=1)
    """Runs of the whole sweep, at most."""


class Replicates(StrictTable):
    """How often each cell is run, and from which seeds."""

    count: int = Field(default=10, ge=1, le=1_000_000)
    seeds: Literal["common", "distinct"] = "common"
    """`common`: first, first + 1, ... in every cell. `distinct`: no seed twice."""
    first: int = Field(default=1, ge=0, le=LARGEST_SEED // 2)
    precision: Precision | None = None

    @model_validator(mode="after")
    def _fits(self) -> Replicates:
        more = self.precision
        if more is not None and (self.count < 2 or more.most < self.count):
            raise ValueError("a precision needs count of 2 or more, and most no less than count")
        return self


class Observe(StrictTable):
    """What is measured of a run: an observable by name, or a function of one's own."""

    name: str = ""
    measure: str = ""
    """FILE.py:FUNCTION, which takes a snapshot and returns a number."""
    when: str = "final"
    """`final`, or `every K` ticks along the run, or `each` tick."""
    over: int | None = Field(default=None, ge=1)
    """Ticks at the end of the run over which the mean is taken."""
    column: str = Field(default="", max_length=60)
    """Its name in tables; by default its own."""

    @model_validator(mode="after")
    def _is_one(self) -> Observe:
        if bool(self.name) == bool(self.measure):
            raise ValueError("either name or measure is needed")
        if self.when not in ("final", "each") and not EVERY.fullmatch(self.when):
            raise ValueError("when is 'final', 'each' or 'every K'")
        if self.over is not None and self.when != "final":
            raise ValueError("a mean over the last ticks is of the end: leave when out")
        return self

    @property
    def every(self) -> int | None:
        """Ticks between two looks along the run; None where there is one at the end only."""
        found = EVERY.fullmatch(self.when)
        return int(found[1]) if found else {"final": None, "each": 1}[self.when]


class Record(StrictTable):
    """Which runs are kept as recordings."""

    where: str = ""
    """A condition between axes; empty: every cell."""
    replicates: int = Field(default=1, ge=1)
    """The first so many of each."""
    every: int = Field(default=1, ge=1)
    """Ticks between two frames."""


class SweepFile(StrictTable):
    """A whole file."""

    title: Line = Field(default="", max_length=200)
    run: RunOptions
    stop: Stop | None = None
    design: list[AnyDesign] = Field(default_factory=list)
    replicates: Replicates = Replicates()
    observe: list[Observe] = Field(default_factory=list)
    record: list[Record] = Field(default_factory=list)
    cluster: Cluster = Cluster()
