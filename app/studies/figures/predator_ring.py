"""A predator amid prey: the ring that they form about it at rest, and when it stays there.

The theory is that of Chen and Kolokolnikov 2014 for many prey; how it follows stands on their page,
docs/papers/chen2014.md.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field

from agents.kinds import ORDINARY
from agents.observables.neighbours import nearest_neighbour
from app.studies.charts.boxes import box, draw_key
from app.studies.charts.colour_table import COLOURS, RULER
from app.studies.experiment import Case, Experiment, flock_of
from app.studies.judge.verdict import Verdict, verdicts_on
from app.studies.measure import COUNT, Measure, Number, Settings
from worlds.input_error import InputError

if TYPE_CHECKING:
    from agents import Flock

PREDATOR = "predator"
"""The kind of the one that hunts."""
AT_ONCE = 500
"""Ticks between two looks at whether a run is still wanted."""


@dataclass(frozen=True)
class RingTheory:
    """The ring of many prey at rest with a predator in its middle, and how small shifts grow.

    dx_j/dt = 1/N sum_k [(x_j - x_k) / |x_j - x_k|^2 - a (x_j - x_k)] + b (x_j - z) / |x_j - z|^2
    and dz/dt = c/N sum_k (x_k - z) / |x_k - z|^p. The offset d of the predator from the centre of
    the prey obeys d'' = trace d' - determinant d while it is small.
    """

    n: int
    a: float
    b: float
    c: float
    p: float

    @property
    def inner(self) -> float:
        """R1, radius of the hole, length."""
        return math.sqrt(self.b / self.a)

    @property
    def outer(self) -> float:
        """R2, radius of the swarm, length."""
        return math.sqrt((1.0 + self.b) / self.a)

    @property
    def spacing(self) -> float:
        """The side of a square with as much room as each of the prey has, length."""
        return math.sqrt(math.pi / (self.a * self.n))

    @property
    def mean_square(self) -> float:
        """Of the distances of n prey to their centre: exact wherever nobody moves, length^2."""
        return (1.0 - 1.0 / self.n + 2.0 * self.b) / (2.0 * self.a)

    @property
    def mean_fourth(self) -> float:
        """Mean fourth power of the distances, of an evenly filled ring, length^4."""
        return (self.inner**4 + self.inner**2 * self.outer**2 + self.outer**4) / 3.0

    @property
    def low(self) -> float:
        """c below which the predator does not stay in the middle: the determinant is 0."""
        return self.b * self.outer ** (self.p - 2.0)

    @property
    def high(self) -> float:
        """c above which it does not: the trace is 0."""
        return 1.0 / (self.inner ** (2.0 - self.p) - self.outer ** (2.0 - self.p))

    @property
    def trace(self) -> float:
        """Sum of the rates of growth, 1/s."""
        return self.a * (self.c / self.high - 1.0)

    @property
    def determinant(self) -> float:
        """Product of the rates of growth, 1/s^2."""
        return self.a**2 * self.b * (self.c / self.low - 1.0) / (1.0 + self.b)

    @property
    def growth(self) -> float:
        """Rate at which a small offset grows, 1/s; below 0 the predator comes back."""
        return growth_of(self.trace, self.determinant)


def growth_of(trace: float, determinant: float) -> float:
    """The largest real part of the roots of x^2 - trace x + determinant.

    >>> growth_of(-1.0, 0.0), growth_of(0.2, 5.0)
    (0.0, 0.1)
    """
    inside = 0.25 * trace**2 - determinant
    return 0.5 * trace + math.sqrt(max(inside, 0.0))


def ring_theory(flock: Flock) -> RingTheory:
    """The theory of a flock of prey and one predator. Raises InputError where it has none."""
    if PREDATOR not in flock.kinds.names or len(flock.rows_of(PREDATOR)) != 1:
        raise InputError(f"the run has not one agent of a kind that is called {PREDATOR}")
    chases = flock.kinds.of(PREDATOR, ORDINARY)
    flees = flock.kinds.of(ORDINARY, PREDATOR)
    if chases.deed != "chase" or chases.power is None:
        raise InputError(f"{PREDATOR} does not chase {ORDINARY} by a power of the distance")
    if flees.deed != "flee" or flees.power != 1.0:
        raise InputError(f"{ORDINARY} does not flee {PREDATOR} by the power 1 of the distance")
    n = len(flock.rows_of(ORDINARY))
    a = flock.parameters.a  # type: ignore[attr-defined]
    return RingTheory(n, a, flees.weight, n * chases.weight, 1.0 + chases.power)


def set_strength(flock: Flock, c: float) -> None:
    """Let the predator be as strong as c."""
    chases = flock.kinds.of(PREDATOR, ORDINARY)
    weight = c / len(flock.rows_of(ORDINARY))
    flock.relate(PREDATOR, ORDINARY, replace(chases, weight=weight))


def offset_of(flock: Flock) -> np.ndarray:
    """The place of the predator from the centre of the prey, (2,), length."""
    prey = flock.position[flock.rows_of(ORDINARY)]
    offset: np.ndarray = flock.position[flock.rows_of(PREDATOR)[0]] - prey.mean(axis=0)
    return offset


def advance(flock: Flock, ticks: int, between: Callable[[], None]) -> None:
    """Run ticks, with looks at whether the run is still wanted."""
    while ticks > 0:
        between()
        flock.run(min(ticks, AT_ONCE))
        ticks -= AT_ONCE


class HuntSettings(Settings):
    """How long prey come to rest about the predator, and how its offset is then followed."""

    settle: float = Field(gt=0.0)
    """Time for which prey come to rest, s."""
    push: float = Field(gt=0.0)
    """By how much the predator is then shifted, length."""
    most: float = Field(gt=0.0)
    """The offset up to which it counts as small, length."""
    follow: float = Field(gt=0.0)
    """Time for which a small offset is followed, s."""
    every: int = Field(2, ge=1)
    """Ticks between two looks at it."""

    def shift_predator(self, flock: Flock) -> np.ndarray:
        """Shift the predator; the offset at which it was, (2,)."""
        rest = offset_of(flock)
        flock.position[flock.rows_of(PREDATOR)[0], 0] += self.push
        return rest

    def follow_offset(
        self, flock: Flock, rest: np.ndarray, between: Callable[[], None]
    ) -> np.ndarray:
        """Offsets from that at rest while they are small, at equal times, (T, 2), length."""
        offsets = [offset_of(flock) - rest]
        for _ in range(round(self.follow / (self.every * flock.dt))):
            between()
            flock.run(self.every)
            offsets.append(offset_of(flock) - rest)
            if np.hypot(*offsets[-1]) > self.most:
                break
        return np.array(offsets)

    def rates(
        self, flock: Flock, rest: np.ndarray, between: Callable[[], None]
    ) -> tuple[float, float]:
        """Trace and determinant of a small offset, 1/s and 1/s^2: those that fit best."""
        offsets = self.follow_offset(flock, rest, between)
        step = self.every * flock.dt
        speed = (offsets[2:] - offsets[:-2]) / (2.0 * step)
        change = (offsets[2:] - 2.0 * offsets[1:-1] + offsets[:-2]) / step**2
        terms = np.column_stack([speed.ravel(), -offsets[1:-1].ravel()])
        trace, determinant = np.linalg.lstsq(terms, change.ravel(), rcond=None)[0]
        return float(trace), float(determinant)


# Runs in which prey come to rest about a predator, and the bounds between which it stays.


class RingSettings(HuntSettings):
    """How far from each bound of the theory it is tried on either side."""

    kind: ClassVar[str] = "predator-ring"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("off", "off", "Mean square distance to the centre over the exact one, less 1",
                "ppm"),
        Measure("inner", "inner", "Innermost from R1 outwards, in spacings of prey", "1"),
        Measure("outer", "outer", "Outermost from R2 inwards, in spacings of prey", "1"),
        Measure("fourth", "r^4", "Mean fourth power of the distance over that of an even ring",
                "1"),
        Measure("even", "even", "Least distance to the nearest over its mean", "1", bounds=COUNT),
        Measure("low", "c_1/law", "c below which the predator leaves, over that of the law", "1"),
        Measure("high", "c_2/law", "c above which it does, over that of the law", "1"),
    )  # fmt: skip

    beside: float = Field(0.1, gt=0.0, lt=1.0)
    """Share of each bound by which it is tried below and above it."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Let prey come to rest, then look for the bounds."""
        advance(flock, round(self.settle / flock.dt), between)
        theory = ring_theory(flock)
        return self.shape(flock, theory) | {
            "low": self.crossing(flock, theory.low, 1, between) / theory.low,
            "high": self.crossing(flock, theory.high, 0, between) / theory.high,
        }

    def shape(self, flock: Flock, theory: RingTheory) -> dict[str, Number | None]:
        """The measures of a ring at rest."""
        prey = flock.position[flock.rows_of(ORDINARY)]
        centre = prey.mean(axis=0)
        square = ((prey - centre) ** 2).sum(axis=1)
        away = np.sqrt(square)
        near = nearest_neighbour(prey, flock.world.size, flock.world.images)
        return {
            "off": 1e6 * (float(square.mean()) / theory.mean_square - 1.0),
            "inner": (float(away.min()) - theory.inner) / theory.spacing,
            "outer": (theory.outer - float(away.max())) / theory.spacing,
            "fourth": float((square**2).mean()) / theory.mean_fourth,
            "even": float(near.min() / near.mean()),
        }

    def crossing(
        self, flock: Flock, bound: float, which: int, between: Callable[[], None]
    ) -> float:
        """c at which the trace (0) or the determinant (1) passes 0: both go straight with c.

        They are measured a little below and above the bound, from the same prey at rest.
        """
        saved = flock.position.copy(), flock.heading.copy(), flock.speed.copy(), flock.tick
        strengths = bound * (1.0 - self.beside), bound * (1.0 + self.beside)
        measured = []
        for c in strengths:
            set_strength(flock, c)
            measured.append(self.rates(flock, self.shift_predator(flock), between)[which])
            flock.position[:], flock.heading[:], flock.speed[:], flock.tick = saved
        below, above = measured
        return strengths[0] - below * (strengths[1] - strengths[0]) / (above - below)

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All of them."""
        return (self.settle + 4.0 * self.follow) / dt


# Runs in which prey at rest meet a weaker or a stronger predator.


class ChaseSettings(HuntSettings):
    """With which strength prey come to rest, and for how long the predator's is then another."""

    kind: ClassVar[str] = "predator-chase"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("growth", "growth", "Rate at which a small offset of the predator grows", "1/s"),
        Measure("miss", "miss", "That rate less the one of the law", "1/s"),
        Measure("away", "away", "Distance of the predator from the centre of the prey at the end, "
                "over R2", "1", bounds=COUNT),
        Measure("drift", "drift", "Speed of the centre of the prey", "length/s", bounds=COUNT),
        Measure("circling", "circling", "Rate at which the predator goes round that centre, either "
                "way", "rad/s", "it is in the middle", bounds=COUNT),
    )  # fmt: skip

    rest: float = Field(gt=0.0)
    """c with which prey come to rest."""
    lasts: float = Field(gt=0.0)
    """Time for which they meet the predator of the row, s."""
    last: float = Field(gt=0.0)
    """Time at the end over which drift and circling are measured, s."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Let prey come to rest, then give the predator the strength of the row."""
        theory = ring_theory(flock)
        at_rest = self.begin(flock, theory, between)
        trace, determinant = self.rates(flock, at_rest, between)
        growth = growth_of(trace, determinant)
        until = round((self.settle + self.lasts - self.last) / flock.dt)
        advance(flock, until - flock.tick, between)
        centre, offsets = centre_of(flock), [offset_of(flock)]
        for _ in range(round(self.last / (AROUND * flock.dt))):
            advance(flock, AROUND, between)
            offsets.append(offset_of(flock))
        away = np.array(offsets)
        angle = np.unwrap(np.arctan2(away[:, 1], away[:, 0]))
        circling = abs(float(angle[-1] - angle[0])) / self.last
        is_in_middle = float(np.hypot(*away[-1])) < self.most
        return {
            "growth": growth,
            "miss": growth - theory.growth,
            "away": float(np.hypot(*away[-1])) / theory.outer,
            "drift": float(np.hypot(*(centre_of(flock) - centre))) / self.last,
            "circling": None if is_in_middle else circling,
        }

    def begin(self, flock: Flock, theory: RingTheory, between: Callable[[], None]) -> np.ndarray:
        """Let prey come to rest and shift the predator, now of the row's strength; the offset at
        which it was, (2,)."""
        set_strength(flock, self.rest)
        advance(flock, round(self.settle / flock.dt), between)
        at_rest = self.shift_predator(flock)
        set_strength(flock, theory.c)
        return at_rest

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All of them."""
        return (self.settle + self.lasts) / dt


AROUND = 20
"""Ticks between two looks at the way that the predator takes round the prey."""


def centre_of(flock: Flock) -> np.ndarray:
    """The centre of the prey, (2,), length."""
    centre: np.ndarray = flock.position[flock.rows_of(ORDINARY)].mean(axis=0)
    return centre


# Pictures.

TRAIL = 20
"""Ticks between two places of a trail."""
HUNTER = COLOURS[1]


def draw_ring(figure: Any, experiment: Experiment, seed: int) -> None:
    """A ring at rest for each row, between its circles, and how evenly it is filled."""
    settings = experiment.settings
    assert isinstance(settings, RingSettings)
    cases = experiment.cases
    figure.set_size_inches(3.1 * len(cases), 6.4)
    rings, shares = figure.subplots(2, len(cases), squeeze=False, height_ratios=[1.35, 1.0])
    for k, case in enumerate(cases):
        flock = flock_of(case, seed)
        advance(flock, round(settings.settle / flock.dt), lambda: None)
        theory, centre = ring_theory(flock), centre_of(flock)
        draw_prey(rings[k], flock, centre, 1.15 * theory.outer)
        for radius in (theory.inner, theory.outer):
            draw_circle(rings[k], radius)
        rings[k].set_title(f"{case.label}\nN = {case.agents}", loc="left", fontsize=9)
        square = np.sort(((flock.position[flock.rows_of(ORDINARY)] - centre) ** 2).sum(axis=1))
        shares[k].step(
            square, np.arange(1, theory.n + 1) / theory.n, where="post", color=COLOURS[0]
        )
        shares[k].plot([theory.inner**2, theory.outer**2], [0.0, 1.0], "--", color=RULER)
        shares[k].set(xlabel="distance² to the centre", ylim=(0.0, 1.0))
    shares[0].set_ylabel("share of the prey nearer than that")
    draw_key(
        figure, [],
        f"seed {seed}; circles: R1 and R2; dashed: a ring that is filled evenly; red: the predator",
    )  # fmt: skip


def draw_prey(axes: Any, flock: Flock, centre: np.ndarray, half: float) -> None:
    """Draw prey and predator about a place, as far as `half` from it."""
    prey = flock.position[flock.rows_of(ORDINARY)] - centre
    predator = flock.position[flock.rows_of(PREDATOR)] - centre
    axes.plot(*prey.T, "o", color=COLOURS[0], markersize=2.6)
    axes.plot(*predator.T, "o", color=HUNTER, markersize=6.0, zorder=4)
    axes.set(xlim=(-half, half), ylim=(-half, half), aspect="equal", xticks=[], yticks=[])
    axes.grid(visible=False)


def draw_circle(axes: Any, radius: float) -> None:
    """Draw a circle of the theory."""
    angle = np.linspace(0.0, 2.0 * np.pi, 181)
    axes.plot(radius * np.cos(angle), radius * np.sin(angle), color=RULER, linewidth=1.0)


def draw_chase(figure: Any, experiment: Experiment, verdicts: list[Verdict], seed: int) -> None:
    """The growth of a small offset over c beside the theory; below it what becomes of some rows."""
    settings = experiment.settings
    assert isinstance(settings, ChaseSettings)
    laws = [ring_theory(flock_of(case, seed)) for case in experiment.cases]
    order = np.argsort([theory.c for theory in laws])
    panels = list(dict.fromkeys(order[np.linspace(0, len(order) - 1, 5).round().astype(int)]))
    figure.set_size_inches(11.5, 7.4)
    grid = figure.add_gridspec(2, len(panels), height_ratios=[1.25, 1.0])
    curve = figure.add_subplot(grid[0, :])
    c = np.linspace(0.0, 1.05 * max(theory.c for theory in laws), 400)
    curve.plot(c, [replace(laws[0], c=one).growth for one in c], color=RULER, label="theory")
    for bound in (laws[0].low, laws[0].high):
        curve.axvline(bound, color=RULER, linewidth=0.9, linestyle=":")
    curve.axhline(0.0, color=RULER, linewidth=0.8)
    for verdict in verdicts_on(verdicts, "growth"):
        theory = laws[experiment.cases.index(verdict.case)]
        box(curve, theory.c, verdict.values, COLOURS[0], 0.02)
    curve.set(xlabel="c, strength of the predator", ylabel="growth of a small offset / (1/s)")
    curve.legend(loc="upper left")
    for place, k in enumerate(panels):
        axes = figure.add_subplot(grid[1, place])
        draw_end(axes, settings, experiment.cases[k], laws[k], seed)
    draw_key(
        figure, [],
        f"dotted: the bounds of the law; below, seed {seed} after {settings.lasts:g} s: prey blue, "
        f"the predator red with its way in the last {settings.last:g} s",
    )  # fmt: skip


def draw_end(axes: Any, settings: ChaseSettings, case: Case, theory: RingTheory, seed: int) -> None:
    """Draw prey and predator at the end of a row's run, with the way of the predator among them."""
    flock = flock_of(case, seed)
    settings.begin(flock, theory, lambda: None)
    advance(flock, round((settings.lasts - settings.last) / flock.dt), lambda: None)
    way = []
    for _ in range(round(settings.last / (TRAIL * flock.dt))):
        advance(flock, TRAIL, lambda: None)
        way.append(offset_of(flock))
    half = max(1.25 * theory.outer, 1.1 * float(np.abs(way[-1]).max()))
    axes.plot(*np.array(way).T, color=HUNTER, linewidth=0.8, alpha=0.6)
    draw_prey(axes, flock, centre_of(flock), half)
    axes.set_title(case.label, loc="left", fontsize=9)


PICTURES = {"predator-ring": draw_ring, "predator-chase": draw_chase}
