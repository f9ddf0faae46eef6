"""How differences in velocity fall in a flock that flies apart, beside what is known beforehand."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field

from app.studies.charts.boxes import draw_key
from app.studies.experiment import Case, Experiment, flock_of
from app.studies.measure import Measure, Number, Settings
from worlds.input_error import InputError

if TYPE_CHECKING:
    from agents import Flock

# Runs in which agents fly apart and listen to all others: do they come to one velocity?
#
# The bound is that of Ha and Liu 2009, "A simple proof of the Cucker-Smale flocking dynamics and
# mean-field limit", Communications in Mathematical Sciences 7, 297-325, for a sum that is not
# divided by N. X is the root of the sum of |x_i - <x>|^2, V of |v_i - <v>|^2. Since no two agents
# are further apart than sqrt(2) X, and X grows by no more than V,
#
#     dV/dt <= -N a(sqrt(2) X) V,    V + N int_{X_0}^{X} a(sqrt(2) s) ds never grows.
#
# So X never comes beyond X_M, where the integral from X_0 is V_0 / N; and there is such an X_M if
# V_0 is less than N times the integral to infinity, which is infinite up to beta = 1/2. Two agents
# that fly straight apart keep to both with equality: for them the critical speed is exact.

NO_BOUND = "no bound"
ROUNDING = 1e-9
"""Share of the differences at the start below which rounding is as large as they are."""


@dataclass(frozen=True)
class ConsensusBound:
    """What is known beforehand of a flock that begins with X_0 and V_0."""

    n: int
    K: float
    sigma: float
    beta: float
    x0: float
    v0: float

    def weight(self, s: float) -> float:
        """a(sqrt(2) s), 1/s: the least weight between two agents of a flock with X = s."""
        return self.K / (self.sigma**2 + 2.0 * s * s) ** self.beta

    def spread_lost(self, x: float) -> float:
        """Of V, at least, by the time that X comes to x (inf: ever), length/time."""
        from scipy.integrate import quad

        if math.isinf(x):
            return math.inf if self.beta <= 0.5 else self.n * quad(self.weight, self.x0, x)[0]

        def weight(u: float) -> float:  # on a logarithmic scale: x may be many powers of ten
            return self.weight(math.exp(u)) * math.exp(u)

        return self.n * quad(weight, math.log(self.x0), math.log(x))[0]

    @property
    def share(self) -> float:
        """V_0 over the critical one: below 1 the flock is certain to come to one velocity."""
        return self.v0 / self.spread_lost(math.inf)

    @property
    def furthest_distance(self) -> float:
        """X_M, length; inf where there is none."""
        from scipy.optimize import brentq

        if self.share >= 1.0:
            return math.inf
        high = 2.0 * self.x0
        while self.spread_lost(high) < self.v0:
            high *= 2.0
        low = math.log(self.x0 * (1.0 + 1e-9))
        return math.exp(
            brentq(lambda u: self.spread_lost(math.exp(u)) - self.v0, low, math.log(high))
        )

    def differences(self, time: np.ndarray) -> np.ndarray:
        """The most that V can be at times (T,), length/time."""
        return self.v0 * np.exp(-self.n * self.weight(self.furthest_distance) * time)


class ConsensusSettings(Settings):
    """How agents set off, for how long they are followed, and how often they are looked at.

    They fly straight apart from their centre, the further out the faster: `v_start` of the body is
    the root of the mean of their squared speeds here.
    """

    kind: ClassVar[str] = "consensus"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure(
            "speed", "v/v_c", "Speed at the start over the critical one; 0: there is none", "1"
        ),
        Measure("left", "left", "Differences in velocity at the end, of those at the start", "1"),
        Measure("kept", "kept", "V and what the bound takes off it, of V at the start, end", "1"),
        Measure("late", "V/bound", "Differences in velocity over their bound, most", "1", NO_BOUND),
        Measure("far", "X/bound", "Size of the flock over its bound, most", "1", NO_BOUND),
    )

    radius: float = Field(gt=0.0)
    """Gyration radius at the start, length; of two agents half their distance."""
    lasts: int = Field(ge=1)
    """Ticks."""
    looks: int = Field(100, ge=1)
    """How often it is looked at, evenly."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Follow a flock that flies apart, and hold it against what is known beforehand."""
        time, x, v = self.follow_flock(flock, between)
        bound = self.find_bound(flock, float(x[0]), float(v[0]))
        values: dict[str, Number | None] = {
            "speed": bound.share,
            "left": float(v[-1] / v[0]),
            "kept": (float(v[-1]) + bound.spread_lost(float(x[-1]))) / bound.v0,
        }
        if bound.share >= 1.0:
            return values | {"late": None, "far": None}
        most = bound.differences(time)[1:]
        sure = most > ROUNDING * v[0]
        values["late"] = float((v[1:][sure] / most[sure]).max())
        return values | {"far": float(x.max() / bound.furthest_distance)}

    def follow_flock(
        self, flock: Flock, between: Callable[[], None]
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Times, X and V at the start and at each look, (1 + looks,) each.

        Raises InputError if the flock became larger than the reach, which stands for no limit.
        """
        self.set_headings(flock)
        rows = [(0.0, *sizes(flock))]
        for look in range(self.looks):
            between()
            flock.run((look + 1) * self.lasts // self.looks - look * self.lasts // self.looks)
            rows.append((flock.tick * flock.dt, *sizes(flock)))
        time, x, v = np.array(rows).T
        if math.sqrt(2.0) * x.max() > flock.reach:
            raise InputError(
                f"r = {flock.reach:g} is less than the flock became wide, "
                f"{math.sqrt(2.0) * x.max():g}"
            )
        return time, x, v

    def set_headings(self, flock: Flock) -> None:
        """Let the agents fly straight apart from their centre."""
        apart = flock.position - flock.position.mean(axis=0)
        out = np.linalg.norm(apart, axis=1)
        wide = math.sqrt((out**2).mean())
        flock.position[:] = flock.position.mean(axis=0) + apart * (self.radius / wide)
        flock.heading[:] = apart / out[:, None]
        flock.speed[:] = out * (flock.parameters.v_start / wide)  # type: ignore[attr-defined]

    def find_bound(self, flock: Flock, x0: float, v0: float) -> ConsensusBound:
        """What is known of a flock that begins so."""
        p: Any = flock.parameters
        return ConsensusBound(len(flock.ids), p.K, p.sigma, p.beta, x0, v0)

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All of them."""
        return self.lasts


def sizes(flock: Flock) -> tuple[float, float]:
    """X and V: sqrt(N) times gyration radius and velocity spread."""
    root = math.sqrt(len(flock.ids))
    return root * flock.observe("gyration-radius"), root * flock.observe("velocity-spread")


COLOURS = ("#2166ac", "#c0392b", "#1b7837", "#e08214", "#762a83", "#35978f", "#8c510a", "#3c434b")
DASHES = (0, (4, 2))
LEAST = 1e-4
"""The smallest share of the differences that is shown."""


def draw_consensus(figure: Any, experiment: Experiment, seed: int) -> None:
    """Two agents on the left in the plane of V over X, flocks on the right over time."""
    settings = experiment.settings
    assert isinstance(settings, ConsensusSettings)
    figure.set_size_inches(12.4, 5.4)
    pairs, flocks = figure.subplots(1, 2)
    lines = []
    for case, colour in zip(experiment.cases, COLOURS * 2, strict=False):
        flock = flock_of(case, seed)
        time, x, v = settings.follow_flock(flock, lambda: None)
        bound = settings.find_bound(flock, float(x[0]), float(v[0]))
        if case.agents == 2:
            draw_pair(pairs, case, bound, x, v, colour)
        else:
            draw_flock(flocks, case, bound, time, v, colour)
        lines.append(case)
    pairs.set_xscale("log")
    pairs.set_xlabel("distance, of that at the start")
    pairs.set_ylabel("relative speed, of the critical one")
    pairs.set_ylim(0.0, None)
    pairs.set_title("two agents that fly apart", loc="left")
    flocks.set_xscale("log")
    flocks.set_yscale("log")
    flocks.set_ylim(LEAST, 2.0)
    flocks.set_xlabel("time / s")
    flocks.set_ylabel("differences in velocity, of those at the start")
    flocks.set_title("flocks that fly apart", loc="left")
    for axes in (pairs, flocks):
        if axes.has_data():
            axes.legend(loc="best", fontsize=8)
    draw_key(
        figure,
        [],
        "lines: runs; dashed on the left: the closed form of two agents, on the right: the bound "
        "that no flock with a start below the critical speed may exceed",
    )


def draw_pair(
    axes: Any, case: Case, bound: ConsensusBound, x: np.ndarray, v: np.ndarray, colour: str
) -> None:
    """Two agents, in units of the critical speed, or of their own where there is none."""
    critical = bound.v0 / bound.share if bound.share > 0.0 else bound.v0
    exact = np.array([bound.v0 - bound.spread_lost(value) for value in x])
    axes.plot(x / x[0], v / critical, color=colour, linewidth=2.0, label=f"$\\beta$ = {case.label}")
    axes.plot(x / x[0], exact / critical, color="black", linewidth=0.9, linestyle=DASHES)


def draw_flock(
    axes: Any, case: Case, bound: ConsensusBound, time: np.ndarray, v: np.ndarray, colour: str
) -> None:
    """A flock over time, with its bound if it has one."""
    axes.plot(
        time[1:],
        v[1:] / v[0],
        color=colour,
        linewidth=2.0,
        label=f"$\\beta$ = {case.label}, N = {case.agents}",
    )
    if bound.share < 1.0:
        most = bound.differences(time[1:]) / v[0]
        axes.plot(time[1:], most, color=colour, linewidth=1.0, linestyle=DASHES)


PICTURES = {"consensus": draw_consensus}
