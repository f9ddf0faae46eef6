"""Where searches have ended, and what that is worth: places scatter on a plateau, values agree."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field, model_validator

from app.studies.judge.verdict import Verdict, verdicts_on
from app.studies.measure import Measure, Number, Settings
from app.studies.search import PENALTY, Algorithm, PointScores, search

if TYPE_CHECKING:
    from agents import Flock

# Searches for the best weights: what the outlook of Liu et al. 2021 asks for.
#
# One run is a whole search with seeds of its own, so that what is said of searches is said of many.

UNKNOWN_TICKS = 12.0
"""Ticks to consistency where nothing is known."""
APART = 100_000
"""Seeds between two searches."""
FRESH = 1000
"""By how much the fresh seeds of a search follow its first."""
Point = tuple[float, ...]


class SearchSettings(Settings):
    """A box of parameters, what a search may spend, and when a flock counts as consistent."""

    desired: float = Field(gt=0.0, lt=1.0)
    hold: int = Field(ge=1)
    limit: int = Field(ge=1)
    box: dict[str, tuple[float, float]] = Field(min_length=2)
    """The parameters that are searched, each with its least and its largest value."""
    log: list[str] = Field(default_factory=list)
    """Those of them that are searched on a logarithmic scale."""
    evaluations: int = Field(ge=1)
    population: int = Field(ge=2)
    seeds: int = Field(ge=1)
    """Runs of each point, with seeds that all points of a search have in common."""
    fresh: int = Field(ge=1)
    """Runs of what is found, with seeds that the search has not seen."""

    @model_validator(mode="after")
    def _rises(self) -> SearchSettings:
        if any(low >= high for low, high in self.box.values()):
            raise ValueError("box: a largest value above the least is needed")
        if any(name not in self.box or self.box[name][0] <= 0.0 for name in self.log):
            raise ValueError("log: names of the box with values above 0 are needed")
        return self

    def search_seeds(self, flock: Flock) -> range:
        """The seeds of the search that a flock stands for."""
        return range(APART * flock.seed, APART * flock.seed + self.seeds)

    def fresh_seeds(self, flock: Flock) -> range:
        """Its fresh seeds."""
        first = APART * flock.seed + FRESH
        return range(first, first + self.fresh)

    def points(self, unit: np.ndarray) -> list[Point]:
        """Points of the unit cube (K, D) as values of the parameters."""
        columns = [
            low * (high / low) ** shares if name in self.log else low + shares * (high - low)
            for (name, (low, high)), shares in zip(self.box.items(), unit.T, strict=True)
        ]
        return [tuple(row) for row in np.column_stack(columns).tolist()]

    def default(self, flock: Flock) -> Point:
        """The values that the flock has by itself."""
        return tuple(float(getattr(flock.parameters, name)) for name in self.box)

    def make_flock(self, flock: Flock, point: Point, seed: int, **more: float) -> Flock:
        """A flock like this one with other parameters and another seed."""
        from agents import Flock as Made

        changed = {**flock.options.parameters, **dict(zip(self.box, point, strict=True)), **more}
        return Made(flock.options.but(seed=seed, parameters=changed))

    def times(self, flock: Flock, point: Point, seeds: range) -> np.ndarray:
        """k_con of a point by seed; a run that is given up has taken all ticks."""
        results = [
            self.make_flock(flock, point, seed).run_until_consistent(
                self.limit, self.desired, self.hold
            )
            for seed in seeds
        ]
        return np.array([self.limit if k is None else k for k in results], float)

    def search(
        self,
        algorithm: Algorithm,
        flock: Flock,
        worth: Callable[[Point], Sequence[float]],
        between: Callable[[], None],
    ) -> dict[Point, Sequence[float]]:
        """All points that a search has tried, with what each is worth, the less the better."""
        evaluated: dict[Point, Sequence[float]] = {}

        def judge(units: np.ndarray) -> PointScores:
            between()
            points = self.points(units)
            for point in points:
                evaluated.setdefault(point, worth(point))
            values = np.array([evaluated[point] for point in points])
            return PointScores(np.minimum(values, PENALTY), np.zeros((len(points), 1)))

        search(
            algorithm, len(self.box), 2 if algorithm == "nsga2" else 1, 1, judge,
            evaluations=self.evaluations, population=self.population, seed=flock.seed,
        )  # fmt: skip
        return evaluated

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """Those of all points."""
        runs = self.evaluations * self.seeds + 10 * self.fresh
        return 2.0 * runs * (UNKNOWN_TICKS + self.hold)


class OptimaSettings(SearchSettings):
    """A genetic algorithm and a particle swarm look for the least k_con."""

    kind: ClassVar[str] = "optima"
    measured_by: ClassVar[tuple[Callable, ...]] = (search,)
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("default", "k_con", "Time to consistency at the paper's weights", "ticks"),
        Measure("ga", "k_con GA", "Time at the best weights of a genetic algorithm", "ticks"),
        Measure("pso", "k_con PSO", "Time at the best weights of a particle swarm", "ticks"),
        Measure("plateau", "k_con flat", "Time at the four corners of the plateau", "ticks"),
        Measure("flat", "flat", "Between the best and the worst of those corners", "ticks"),
        Measure("ga_gain", "gain GA", "What the genetic algorithm saves", "ticks"),
        Measure("pso_gain", "gain PSO", "What the particle swarm saves", "ticks"),
        Measure("apart", "apart", "Between what the two have found", "ticks"),
        Measure("ga_p1", "p1 GA", "First weight that the genetic algorithm found", "1"),
        Measure("ga_p2", "p2 GA", "Second weight that the genetic algorithm found", "1"),
        Measure("pso_p1", "p1 PSO", "First weight that the particle swarm found", "1"),
        Measure("pso_p2", "p2 PSO", "Second weight that the particle swarm found", "1"),
    )

    plateau_from: float
    """The value of the second parameter from which on nothing changes, it is said."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Search twice, and run what is found, and the plateau, with fresh seeds."""
        fresh, tried = self.fresh_seeds(flock), self.search_seeds(flock)
        times = {"default": self.times(flock, self.default(flock), fresh)}
        values: dict[str, Number | None] = {}
        for algorithm in ("ga", "pso"):
            evaluated = self.search(
                algorithm,
                flock,
                lambda point: [float(self.times(flock, point, tried).mean())],
                between,
            )
            best = min(evaluated, key=lambda point: evaluated[point][0])
            times[algorithm] = self.times(flock, best, fresh)
            values |= {f"{algorithm}_p1": best[0], f"{algorithm}_p2": best[1]}
        (low, high), (_, last) = list(self.box.values())[:2]
        corners = [(p1, p2) for p1 in (low, high) for p2 in (self.plateau_from, last)]
        means = [float(self.times(flock, corner, fresh).mean()) for corner in corners]
        of = {name: float(values.mean()) for name, values in times.items()}
        return (
            values
            | of
            | {
                "plateau": sum(means) / len(means),
                "flat": max(means) - min(means),
                "ga_gain": of["default"] - of["ga"],
                "pso_gain": of["default"] - of["pso"],
                "apart": abs(of["ga"] - of["pso"]),
            }
        )


class TradeoffSettings(SearchSettings):
    """NSGA-II weighs k_con without noise against the consistency with noise."""

    kind: ClassVar[str] = "tradeoff"
    measured_by: ClassVar[tuple[Callable, ...]] = (search,)
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("quick", "k_con quick", "Time to consistency at the quick end", "ticks"),
        Measure("quick_deg", "Deg quick", "Consistency with noise at the quick end", "1"),
        Measure("calm", "k_con calm", "Time to consistency at the calm end", "ticks"),
        Measure("calm_deg", "Deg calm", "Consistency with noise at the calm end", "1"),
        Measure("default", "k_con", "Time to consistency at the paper's weights", "ticks"),
        Measure("default_deg", "Deg", "Consistency with noise at the paper's weights", "1"),
        Measure("slower", "slower", "How much longer the calm end takes", "ticks"),
        Measure("calmer", "calmer", "How much more consistent the calm end is", "1"),
        Measure("quick_p2", "p2 quick", "Second weight at the quick end", "1"),
        Measure("calm_p2", "p2 calm", "Second weight at the calm end", "1"),
        Measure("within_10", "Deg k <= 10", "Most consistency with k_con of 10 or less", "1"),
        Measure("within_12", "Deg k <= 12", "Most consistency with k_con of 12 or less", "1"),
        Measure("within_15", "Deg k <= 15", "Most consistency with k_con of 15 or less", "1"),
        Measure("within_20", "Deg k <= 20", "Most consistency with k_con of 20 or less", "1"),
    )

    noise: float = Field(gt=0.0)
    """The eta of the second objective, rad."""
    lasts: int = Field(ge=1)
    """Ticks of its runs."""
    over: int = Field(ge=1)
    """Ticks at their end over which the mean is taken."""

    @model_validator(mode="after")
    def _looks(self) -> TradeoffSettings:
        if self.over > self.lasts:
            raise ValueError("over cannot be more than lasts")
        return self

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Search once, and run the front with fresh seeds."""
        tried, fresh = self.search_seeds(flock), self.fresh_seeds(flock)

        def worth(point: Point, seeds: range = tried) -> tuple[float, float]:
            time = float(self.times(flock, point, seeds).mean())
            return time, -self.consistency(flock, point, seeds)

        evaluated = self.search("nsga2", flock, worth, between)
        front = [
            point for point, value in evaluated.items()
            if not any(all(o <= v for o, v in zip(other, value, strict=True)) and other != value
                       for other in evaluated.values())
        ]  # fmt: skip
        values = {point: worth(point, fresh) for point in front}
        quick = min(front, key=lambda point: values[point][0])
        calm = min(front, key=lambda point: values[point][1])
        default = worth(self.default(flock), fresh)
        summary: dict[str, Number | None] = {
            "quick": values[quick][0],
            "quick_deg": -values[quick][1],
            "calm": values[calm][0],
            "calm_deg": -values[calm][1],
            "default": default[0],
            "default_deg": -default[1],
            "slower": values[calm][0] - values[quick][0],
            "calmer": values[quick][1] - values[calm][1],
            "quick_p2": quick[1],
            "calm_p2": calm[1],
        }
        for most in (10, 12, 15, 20):
            reachable = [-deg for time, deg in values.values() if time <= most]
            summary[f"within_{most}"] = max(reachable, default=None)
        return summary

    def consistency(self, flock: Flock, point: Point, seeds: range) -> float:
        """The mean consistency of a point with noise over the last ticks."""
        consistencies: list[float] = []
        for seed in seeds:
            other_flock = self.make_flock(flock, point, seed, eta=self.noise)
            other_flock.run(self.lasts - self.over)
            for _ in range(self.over):
                other_flock.run(1)
                consistencies.append(float(other_flock.observe("consistency")))
        return float(np.mean(consistencies))


FOUND = {"ga": ("genetic algorithm", "#2166ac", "o"), "pso": ("particle swarm", "#b07d12", "^")}
TOLD = {"default": "paper's weights", "ga": "GA", "pso": "PSO", "plateau": "plateau"}
CALM = {10: "within_10", 12: "within_12", 15: "within_15", 20: "within_20"}


def values(verdicts: list[Verdict], name: str) -> np.ndarray:
    """What was measured in each search; nan where one has none."""
    (row,) = verdicts_on(verdicts, name)[:1]
    return np.array([np.nan if value is None else value for value in row.values], float)


def draw_optima(figure: Any, verdicts: list[Verdict]) -> None:
    """The weights that were found, and k_con there beside the paper's and the plateau's."""
    figure.set_size_inches(9.6, 4.4)
    left, right = figure.subplots(1, 2)
    for name, (label, colour, marker) in FOUND.items():
        places = values(verdicts, f"{name}_p2"), values(verdicts, f"{name}_p1")
        left.plot(*places, marker, color=colour, label=label, alpha=0.8)
    left.set_xlabel("$p_2$")
    left.set_ylabel("$p_1$")
    left.set_title("the best weights of each search", loc="left")
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower left", ncols=2)
    off = np.random.default_rng(0)
    for k, name in enumerate(TOLD):
        present = values(verdicts, name)
        colour = FOUND.get(name, ("", "#555555", ""))[1]
        right.plot(
            k + off.uniform(-0.15, 0.15, present.size), present, ".", color=colour, alpha=0.7
        )
        right.hlines(present.mean(), k - 0.3, k + 0.3, color=colour)
    right.set_xticks(range(len(TOLD)), list(TOLD.values()))
    right.set_ylabel("$k_{con}$ / ticks")
    right.set_ylim(bottom=0.0)
    right.set_title("what they are worth, on fresh seeds", loc="left")


def draw_tradeoff(figure: Any, verdicts: list[Verdict]) -> None:
    """The ends of each front, and the most consistency that a time allows."""
    figure.set_size_inches(7.2, 4.6)
    axes = figure.subplots()
    for name, colour, label in (
        ("quick", "#2166ac", "the quick end of a front"),
        ("calm", "#1b7837", "the calm end of a front"),
        ("default", "#b2182b", "the paper's weights"),
    ):
        places = values(verdicts, name), values(verdicts, f"{name}_deg")
        axes.plot(*places, "o", color=colour, label=label, alpha=0.7, markersize=5)
    means = [np.nanmean(values(verdicts, name)) for name in CALM.values()]
    axes.plot(list(CALM), means, "-", color="#555555", label="most of a front in such a time")
    axes.set_xscale("log")
    ticks = (8, 10, 15, 20, 30, 50)
    axes.set_xticks(ticks, list(map(str, ticks)))
    axes.minorticks_off()
    axes.set_xlabel("$k_{con}$ / ticks, without noise")
    axes.set_ylabel("consistency with noise")
    axes.legend()


PICTURES = {"optima": draw_optima, "tradeoff": draw_tradeoff}
