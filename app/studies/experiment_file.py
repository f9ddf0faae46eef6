"""An experiment's TOML file: rows and sweeps, what was published, what the paper claims."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, PlainValidator, model_validator

from agents.individuals import as_distribution
from agents.kinds import Kind, Relation, as_kinds
from agents.spec import OPTIONS, Options, relations
from app.strict_table import Line, ParameterValue, StrictTable, Value
from app.studies.measure import Settings
from worlds.input_error import InputError
from worlds.mission import Goal
from worlds.world import World


class Ranks(StrictTable):
    """Places on a plane for the first agents, with normal noise that follows from the seed."""

    places: tuple[tuple[float, float], ...] = Field(min_length=1)
    """Where they stand, the first agents at the first places; length."""
    off: float = Field(0.0, ge=0.0)
    """Standard deviation of their places along each axis, length."""
    heading: float
    """Which way they look, deg, anticlockwise from the x axis."""
    turned: float = Field(0.0, ge=0.0)
    """Standard deviation of their headings, deg."""
    speed: float = Field(0.0, ge=0.0)
    """Length per unit of time."""

    def start(self, agents: int, seed: int) -> dict[str, np.ndarray]:
        """Positions, headings and speeds of so many agents. Raises InputError if places lack."""
        if agents > len(self.places):
            raise InputError(
                f"agents = {agents}, but only {len(self.places)} have a place to start"
            )
        rng = np.random.default_rng(seed)
        off = self.off * rng.normal(size=(agents, 2))
        angle = np.radians(self.heading + self.turned * rng.normal(size=agents))
        return {
            "position": np.array(self.places[:agents], float) + off,
            "heading": np.column_stack([np.cos(angle), np.sin(angle)]),
            "speed": np.full(agents, self.speed),
        }


class Overrides(StrictTable):
    """What a row overrides of the world's mission."""

    ranks: Ranks | None = None
    """Where agents start; None: at random in the world's own region."""
    rests: tuple[float, float] | None = None
    """Where the goal rests, length; None: on its route."""
    speed: float | None = Field(default=None, gt=0.0)
    """Speed of the goal along its route; None: the world's own."""
    scene: str | None = None
    """Another world than the experiment's; None: that one."""
    turned: bool = False
    """Every run has one start, that of seed 1; from run to run the scene is turned by another
    angle, with the start in it, and its outlines begin elsewhere: the seed draws both."""

    @model_validator(mode="after")
    def _rests_or_moves(self) -> Overrides:
        if self.rests is not None and self.speed is not None:
            raise ValueError("a goal that rests has no speed")
        return self


START = 1
"""The seed of the start that turned runs have."""
PLAIN = Overrides()
"""Nothing is overridden."""


def with_goal(world: World, overrides: Overrides) -> World:
    """The world with the goal as the overrides have it. Raises InputError if it has no goal."""
    if overrides.speed is None and overrides.rests is None:
        return world
    if world.mission is None or world.mission.goal is None:
        text = "rests" if overrides.speed is None else f"speed = {overrides.speed:g}"
        raise InputError(f"{text}: the world {world.name!r} has no goal")
    if overrides.rests is not None:
        goal = Goal(route=(overrides.rests,))
    else:
        goal = world.mission.goal.model_copy(update={"speed": overrides.speed})
    return replace(world, mission=world.mission.model_copy(update={"goal": goal}))


class ExpectedVerdict(StrictTable):
    """What was found before, and why; the runs are judged without it."""

    verdict: Literal["holds", "does not hold", "agrees", "differs", "undecided"]
    why: str


class PublishedMeasure(StrictTable):
    """What a paper prints of a measure."""

    mean: float | None = None
    quartiles: tuple[float, float, float] | None = None
    values: list[float] = Field(default_factory=list)
    """The runs themselves, where the paper prints them."""
    expected: ExpectedVerdict | None = None
    by_construction: str = ""
    """Why runs cannot but agree; empty where they can differ."""

    @model_validator(mode="after")
    def _has_one_mean(self) -> PublishedMeasure:
        if self.values and self.mean is not None:
            raise ValueError("values already give the mean")
        return self

    @property
    def average(self) -> float | None:
        """The mean, printed or of the printed runs."""
        return sum(self.values) / len(self.values) if self.values else self.mean


class KindsOfRun(StrictTable):
    """Kinds of agents beside the ordinary ones, and what these do about them, as in a spec."""

    kinds: Annotated[tuple[Kind, ...], PlainValidator(as_kinds)] = ()
    to: Annotated[dict[str, Relation], PlainValidator(relations)] = Field(default_factory=dict)

    @property
    def of_kinds(self) -> dict[str, Any]:
        """What there is of both, by the names that a spec has for them."""
        return {key: value for key in ("kinds", "to") if (value := getattr(self, key))}


class PaperRow(KindsOfRun, Options):
    """One row of a table, and its options, with the published numbers by measure."""

    model: str
    agents: int = Field(ge=1)
    label: str = ""
    """Its name in the table; the model's where it has none of its own."""
    parameters: dict[str, ParameterValue] = Field(default_factory=dict)
    obstacles: bool = True
    """Whether the world keeps its obstacles."""
    size: float | None = Field(None, gt=0.0)
    """Side of its box; None: that of its number of agents in `sizes`, or the world's own."""
    mission: Overrides = PLAIN
    """What is other in it than in the world's mission."""
    published: dict[str, PublishedMeasure] = Field(default_factory=dict)
    remark: str = ""
    """What else is known of it."""

    @model_validator(mode="after")
    def _has_a_mission(self) -> PaperRow:
        if self.size is not None and self.mission != PLAIN:
            raise ValueError("a row with a size has no mission: it is laid out in another box")
        return self


class PaperSweep(KindsOfRun, Options):
    """One parameter over several values, for several sizes of flock, and its options.

    An option that is a number, as `delay`, stands where a parameter may.
    """

    model: str
    label: str = ""
    """Its name in the table; the model's where it has none of its own."""
    agents: list[int] = Field(min_length=1)
    parameter: str
    values: list[Value] = Field(min_length=1)
    against: str = ""
    """A second parameter, of which each value is combined with each of the first."""
    against_values: list[Value] = Field(default_factory=list)
    there_and_back: bool = False
    """Whether a single run goes through the values, from the first to the last and back."""
    fixed: dict[str, ParameterValue] = Field(default_factory=dict)
    trend: Literal["rises", "falls"] | None = None
    """What the paper says the time does along the values."""
    flat_from: float | None = None
    """The value from which on, the paper says, it hardly changes."""

    @model_validator(mode="after")
    def _has_both(self) -> PaperSweep:
        if bool(self.against) != bool(self.against_values):
            raise ValueError("against and against_values need each other")
        if self.there_and_back and self.parameter in OPTIONS:
            raise ValueError(f"{self.parameter} is an option, which a run has from its start")
        for value in (*self.values, *self.against_values):
            if as_distribution(value) is not None:
                name = self.parameter if value in self.values else self.against
                raise ValueError(
                    f"{value} has no place along an axis: vary {name}.mean and {name}.spread"
                )
        return self


class StatedClaim(StrictTable):
    """What all claims have."""

    measure: str
    expected: ExpectedVerdict | None = None
    by_construction: str = ""
    """Why it cannot fail; empty where it can."""


class OrderClaim(StatedClaim):
    """The mean of a measure rises from row to row."""

    says: Literal["order"]
    labels: list[str] = Field(min_length=2)
    agents: list[int] = Field(default_factory=list)
    """The sizes at which it is said; empty: the rows may differ in size."""


class EveryRunClaim(StatedClaim):
    """A measure is within bounds in every run."""

    says: Literal["every"]
    labels: list[str] = Field(default_factory=list)
    """The rows that it is said of; empty: all."""
    agents: list[int] = Field(default_factory=list)
    """The sizes that it is said of; empty: all."""
    tick: int | None = None
    """The tick at which it is said, where runs are measured several times."""
    share: float = Field(1.0, gt=0.0, le=1.0)
    """The share of the runs in which it is to be so; 1: in every run."""
    above: float | None = None
    below: float | None = None
    at_least: float | None = None
    at_most: float | None = None


class NearClaim(StatedClaim):
    """The mean of a measure is no further than a bound from a value."""

    says: Literal["near"]
    labels: list[str] = Field(min_length=1)
    agents: list[int] = Field(default_factory=list)
    """The sizes that it is said of; empty: all."""
    value: float
    within: float = Field(gt=0.0)


class ScalingClaim(StatedClaim):
    """A measure goes with a power of the number of agents, over the sizes of a row's label."""

    says: Literal["scales"]
    label: str
    power: float
    within: float = Field(gt=0.0)


class FasterClaim(StatedClaim):
    """One row is faster than another by more than a share, in every pair of runs of one seed."""

    says: Literal["faster"]
    label: str
    than: str
    by: float = Field(gt=0.0, lt=1.0)


class EnduranceClaim(StatedClaim):
    """A measure is within bounds in every run, at all values of a sweep."""

    says: Literal["endures"]
    labels: list[str] = Field(min_length=1)
    """The sweeps that it is said of, each for itself."""
    above: float | None = None
    below: float | None = None
    at_least: float | None = None
    at_most: float | None = None


class PhaseClaim(StatedClaim):
    """A word of a measure that is a name is the commonest somewhere on a map."""

    says: Literal["found"]
    word: str


class LagClaim(StatedClaim):
    """A measure is larger on the way back than on the way there, somewhere by more than a step."""

    says: Literal["lags"]
    by: float = Field(gt=0.0)


class EqualityClaim(StatedClaim):
    """The means of a measure in two rows are less than a distance apart."""

    says: Literal["alike"]
    labels: tuple[str, str]
    within: float = Field(gt=0.0)


class SizeClaim(StatedClaim):
    """The mean of a measure rises or falls from size to size."""

    says: Literal["sizes"]
    label: str
    """Of rows, or of a sweep."""
    value: Value | None = None
    """The value of the sweep at which it is said; None: it is said of rows."""
    agents: list[int] = Field(min_length=2)
    trend: Literal["rises", "falls"]
    by: float = Field(0.0, ge=0.0)
    """Of the mean at each size, the share by which the next is more, or less, at least."""


class ReachClaim(StatedClaim):
    """The mean of a measure is beyond a bound at some value of a sweep, or at none."""

    says: Literal["reaches"]
    label: str
    agents: list[int] = Field(min_length=1)
    above: float | None = None
    below: float | None = None
    nowhere: bool = False
    """Whether it is said to be so at no value."""

    @model_validator(mode="after")
    def _has_one_bound(self) -> ReachClaim:
        if (self.above is None) == (self.below is None):
            raise ValueError("either above or below is needed")
        return self


DeclaredClaim = Annotated[
    OrderClaim
    | EveryRunClaim
    | NearClaim
    | ScalingClaim
    | FasterClaim
    | EnduranceClaim
    | PhaseClaim
    | LagClaim
    | EqualityClaim
    | SizeClaim
    | ReachClaim,
    Field(discriminator="says"),
]


class ExperimentFile[Kind: Settings](StrictTable):
    """A whole file."""

    kind: str = "convergence"
    title: Line
    source: Line
    picture: str
    runs: int = Field(ge=1)
    settings: Kind
    report: list[str] = Field(default_factory=list)
    """The measures to report, the main one first; empty: the first of the kind."""
    sizes: dict[str, float] = Field(default_factory=dict)
    """Side of the box by number of agents; empty: the world's own."""
    expected: dict[str, ExpectedVerdict] = Field(default_factory=dict)
    """What was found before of measures, in all rows."""
    not_compared: dict[str, str] = Field(default_factory=dict)
    """Measures whose published values are shown without a verdict, and why."""
    notes: dict[str, str] = Field(default_factory=dict)
    rows: list[PaperRow] = Field(default_factory=list)
    sweeps: list[PaperSweep] = Field(default_factory=list)
    claims: list[DeclaredClaim] = Field(default_factory=list)
