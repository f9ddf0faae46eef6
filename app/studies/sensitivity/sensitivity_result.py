"""What a sweep over a design of sensitivity says of each thing measured, in numbers and words."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from app.studies.runs.database import BROKEN
from app.studies.runs.store_reader import StoreReader
from app.studies.sweeps.checked_sweep import Sweep
from app.studies.sweeps.designs import problem, unit_sample
from app.studies.sweeps.sweep_file import Morris, Saltelli
from worlds.input_error import InputError, unknown
from worlds.number_text import counted
from worlds.plug_ins import demand

# Sobol's and Morris' indices of what a design has given, by SALib; refused where it prints zeros.
#
# One value that is missing, or values that are all the same, give SALib indices of exactly 0 with
# intervals of 0. So nothing reaches it but a number for each cell, not all of them the same.

RESAMPLES = 1000
"""Draws with which intervals are found."""
SAME = 1e-12
"""Deviation of the cells, as a share of what is measured, that is rounding."""


@dataclass(frozen=True)
class Index:
    """A number with half of its 95 % interval; nan where that is not known."""

    value: float
    half: float = math.nan

    @property
    def interval(self) -> tuple[float, float]:
        """Its 95 % interval, which SALib gives by its half."""
        return self.value - self.half, self.value + self.half


@dataclass(frozen=True)
class Influence:
    """How much an axis has to do with what is measured.

    `total` is S_T of Sobol, the share of the variance that is gone if the axis is held, or mu* of
    Morris, the mean size of the effect that its whole range has. `alone` is S_1, what it explains
    without the others, or mu, the mean of the effects with their sign. `spread` is Morris' sigma.
    """

    axis: str
    total: Index
    alone: Index
    spread: float | None = None


@dataclass(frozen=True)
class PairIndex:
    """S_2 of two axes: what they explain together beyond what each does alone."""

    axes: tuple[str, str]
    index: Index


def sobol(design: Saltelli, y: np.ndarray) -> tuple[list[Influence], list[PairIndex]]:
    """The indices of values (K,) of the cells of a design, in its order. Raises InputError."""
    demand("SALib", "an analysis of sensitivity", "experiments")
    from SALib.analyze import sobol as analysis

    names, second = list(design.axes), design.second_order
    expected = design.points * (len(names) + 2 if not second else 2 * len(names) + 2)
    demand_values(y, expected)
    demand_variation(y)
    step = expected // design.points
    demand_variation(np.concatenate([y[::step], y[step - 1 :: step]]))
    with warnings.catch_warnings(action="ignore"):
        result = analysis.analyze(
            problem(design),
            y,
            calc_second_order=second,
            num_resamples=RESAMPLES,
            seed=max(1, design.seed),  # it takes a seed of 0 for none
        )
    influences = [
        Influence(
            name,
            Index(float(result["ST"][k]), float(result["ST_conf"][k])),
            Index(float(result["S1"][k]), float(result["S1_conf"][k])),
        )
        for k, name in enumerate(names)
    ]
    pairs = [
        PairIndex(
            (names[j], names[k]), Index(float(result["S2"][j, k]), float(result["S2_conf"][j, k]))
        )
        for j in range(len(names) if second else 0)
        for k in range(j + 1, len(names))
    ]
    return influences, pairs


def morris(design: Morris, y: np.ndarray) -> list[Influence]:
    """The elementary effects of values (K,) of the cells of a design, in its order. Or
    InputError."""
    demand("SALib", "an analysis of sensitivity", "experiments")
    from SALib.analyze import morris as analysis

    demand_values(y, design.trajectories * (len(design.axes) + 1))
    demand_variation(y)
    result = analysis.analyze(
        problem(design),
        unit_sample(design),
        y,
        num_resamples=RESAMPLES,
        num_levels=design.levels,
        seed=design.seed,
    )
    root = math.sqrt(design.trajectories)
    return [
        Influence(
            name,
            Index(float(result["mu_star"][k]), float(result["mu_star_conf"][k])),
            Index(float(result["mu"][k]), 1.96 * float(result["sigma"][k]) / root),
            float(result["sigma"][k]),
        )
        for k, name in enumerate(design.axes)
    ]


def demand_values(y: np.ndarray, cells: int) -> None:
    """Refuse what is not a number for each cell of a design. Raises InputError."""
    if y.shape != (cells,):
        raise InputError(f"{y.size} values are not allowed: the design has {cells} cells")
    missing = int((~np.isfinite(y)).sum())
    if missing:
        raise InputError(f"{missing} of {cells} cells have no value: an index needs all of them")


def demand_variation(y: np.ndarray) -> None:
    """Refuse values that are all the same: there is nothing to explain. Raises InputError."""
    if float(y.std()) <= SAME * max(1.0, float(np.abs(y).max())):
        raise InputError(f"it is {y[0]:.6g} in every cell: there is nothing to explain")


def noise_share(values: Sequence[Sequence[float]]) -> float | None:
    """The share of the variance between cells that is chance: that of the mean of a cell's runs.

    None where cells have one run each.

    >>> noise_share([[0.0, 2.0], [10.0, 12.0]])
    0.04
    """
    if min(map(len, values)) < 2:
        return None
    within = float(np.mean([np.var(value, ddof=1) / len(value) for value in values]))
    between = float(np.var([np.mean(value) for value in values]))
    return within / between


NOISY = 0.2
"""Share of chance from which on it is said that more runs are needed."""
BENT = 0.5
"""Sigma over mu* from which on an effect is said to depend on where one is."""


@dataclass(frozen=True)
class Sensitivity:
    """What one thing that is measured depends on, the axis with the largest total first."""

    observable: str
    kind: str
    """`sobol` or `morris`."""
    influences: list[Influence]
    pairs: list[PairIndex]
    """Of a design with the second order."""
    noise: float | None
    """Share of the variance between cells that is chance; None: a cell has one run only."""
    cells: int
    seeds: int

    @property
    def symbols(self) -> tuple[str, str]:
        """What total and alone are called."""
        return ("S_T", "S_1") if self.kind == "sobol" else ("mu*", "mu")

    @property
    def value(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self) | {"words": list(self.words())}

    def words(self) -> Iterator[str]:
        """The order of the axes and what else is to be known, a sentence each."""
        yield self.order()
        for influence, other in zip(self.influences, self.influences[1:], strict=False):
            if not are_distinct(influence.total, other.total):
                yield (
                    f"{influence.axis} and {other.axis} cannot be told apart: their intervals are "
                    "wider "
                    "than they are different"
                )
        unseen = [
            influence.axis
            for influence in self.influences
            if influence.total.value <= influence.total.half
        ]
        if unseen:
            yield f"no influence is seen of {' and '.join(unseen)}"
        yield from self.describe_interactions()
        if self.noise is None:
            yield "how much of it is chance is not known: that takes two seeds or more"
        else:
            more = ": more seeds are needed" if self.noise > NOISY else ""
            yield f"chance makes up {self.noise:.0%} of the variance between cells{more}"

    def order(self) -> str:
        """The order of the axes, with numbers."""
        first, *rest = self.influences
        lines = [f"{self.observable} depends most on {first.axis} ({self.format_total(first)})"]
        return ", then on ".join(
            [*lines, *(f"{influence.axis} ({self.format_total(influence)})" for influence in rest)]
        )

    def format_total(self, influence: Influence) -> str:
        """The total of an axis."""
        return f"{self.symbols[0]} {describe_index(influence.total)}"

    def describe_interactions(self) -> Iterator[str]:
        """What the axes do together, beyond what each does alone."""
        if self.kind == "morris":
            bent = [
                influence.axis for influence in self.influences
                if influence.total.value > influence.total.half
                and (influence.spread or 0.0) > BENT * influence.total.value
            ]  # fmt: skip
            if bent:
                yield f"the effect of {' and '.join(bent)} depends on where one is (sigma / mu*)"
            return
        alone = sum(influence.alone.value for influence in self.influences)
        yield f"each by itself, the axes explain {min(max(alone, 0.0), 1.0):.0%} of the variance"
        if self.pairs:
            most = max(self.pairs, key=lambda pair: pair.index.value)
            yield (
                f"the most that two do together is S_2 {describe_index(most.index)} of "
                + " and ".join(most.axes)
            )


def describe_index(index: Index) -> str:
    """An index with its interval.

    >>> describe_index(Index(0.5581, 0.0512))
    '0.56 ± 0.05'
    """
    return f"{index.value:.2f}" + (f" ± {index.half:.2f}" if index.half == index.half else "")


def are_distinct(index: Index, other: Index) -> bool:
    """Whether two indices differ by more than chance, as far as their intervals say."""
    return abs(index.value - other.value) > math.hypot(index.half, other.half)


def analyse(sweep: Sweep, reader: StoreReader, observable: str | None = None) -> list[Sensitivity]:
    """What each thing that is measured, or one of them, depends on. Raises InputError."""
    design = design_of(sweep)
    columns = sweep.making.columns
    if observable is not None and observable not in columns:
        raise unknown("observable", observable, columns, str(reader.folder))
    names = [observable] if observable is not None else columns
    numbers = reader.plan
    runs = runs_of(sweep, reader, names)
    sensitivities: list[Sensitivity] = []
    for name in names:
        values = [runs[number][name] for number in numbers]
        y = np.array([np.mean(run_values) for run_values in values])
        try:
            if isinstance(design, Saltelli):
                influences, pairs = sobol(design, y)
            else:
                influences, pairs = morris(design, y), []
        except InputError as refusal:
            others = [column for column in columns if column != name]
            hint = f"; take another with --observable {others[0]}" if others else ""
            raise InputError(f"{name} cannot be analysed: {refusal}{hint}") from None
        influences.sort(key=lambda influence: -influence.total.value)
        kind = "sobol" if isinstance(design, Saltelli) else "morris"
        seeds = sweep.file.replicates.count
        sensitivities.append(
            Sensitivity(name, kind, influences, pairs, noise_share(values), len(numbers), seeds)
        )
    return sensitivities


def design_of(sweep: Sweep) -> Saltelli | Morris:
    """The design that indices can be found from. Raises InputError."""
    designs, replicates = sweep.file.design, sweep.file.replicates
    kinds = ", ".join(design.kind for design in designs) or "none"
    if len(designs) != 1 or not isinstance(designs[0], Saltelli | Morris):
        where = sweep.places.describe("kind", "design", 0 if designs else None)
        raise InputError(
            f"design {kinds} is not allowed: one of kind saltelli, for Sobol's indices, or morris, "
            f"for elementary effects, is needed ({where})"
        )
    if replicates.seeds != "common" or replicates.precision is not None:
        key, table = ("seeds", "replicates")
        if replicates.seeds == "common":
            key, table = "observable", "replicates.precision"
        raise InputError(
            "every cell needs the same seeds, or their differences would count as influence: "
            f'take seeds = "common" and no precision ({sweep.places.describe(key, table)})'
        )
    if not sweep.making.columns:
        raise InputError("nothing has one value for each run: [[observe]] something at its end")
    return designs[0]


def runs_of(
    sweep: Sweep, reader: StoreReader, names: list[str]
) -> dict[int, dict[str, list[float]]]:
    """The values of all runs by cell and name. Raises InputError if a run has none."""
    replicates = sweep.file.replicates
    seeds = range(replicates.first, replicates.first + replicates.count)
    cells = set(reader.plan)
    found: dict[int, dict[str, list[float]]] = {cell: {n: [] for n in names} for cell in cells}
    again = f"flockscope sensitivity {reader.folder}"
    broken = censored = runs = 0
    for cell, seed, status, _, _, _, _, *values in reader.runs(names):
        if seed not in seeds:
            continue
        runs += 1
        broken += status in BROKEN
        censored += status == "gave-up"
        for name, value in zip(names, values, strict=True):
            found[cell][name].append(math.nan if value is None else float(value))
    of = len(cells) * len(seeds)
    if runs < of:
        raise InputError(f"{of - runs} of {of} runs are not made yet: `{again}` makes them")
    if broken:
        raise InputError(
            f"{broken} of {counted(of, 'run')} failed, and an index needs all of them: "
            f"`flockscope sweep show {reader.folder}` names them, `{again} --retry-failed` makes "
            "them again"
        )
    if censored:
        raise InputError(
            f"{censored} of {counted(of, 'run')} gave up before what [stop] waits for came, and an "
            f"index needs all of them: raise ticks = {sweep.file.run.ticks} "
            f"({sweep.places.describe('ticks', 'run')}), or narrow the axes"
        )
    for name in names:
        missing = sum(value != value for columns in found.values() for value in columns[name])
        if missing:
            raise InputError(
                f"{name} cannot be analysed: {missing} of {of} runs have no value, and an index "
                "needs all of them"
            )
    return found
