"""What a sweep over a design of sensitivity says of each thing measured, in numbers and words."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from app.studies.runs.run_outcome import BROKEN
from app.studies.runs.store_reader import StoreReader
from app.studies.sensitivity.indices import (
    Index,
    Influence,
    PairIndex,
    morris,
    noise_share,
    sobol,
)
from app.studies.sweeps.checked_sweep import Sweep
from app.studies.sweeps.given.sweep_file import Morris, Saltelli
from worlds.input_error import InputError, unknown
from worlds.number_text import counted

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
        for one, other in zip(self.influences, self.influences[1:], strict=False):
            if not apart(one.total, other.total):
                yield (
                    f"{one.axis} and {other.axis} are not told apart: their intervals are wider "
                    "than they are different"
                )
        unseen = [one.axis for one in self.influences if one.total.value <= one.total.half]
        if unseen:
            yield f"no influence is seen of {' and '.join(unseen)}"
        yield from self.together()
        if self.noise is None:
            yield "how much of it is chance is not known: that takes two seeds or more"
        else:
            more = ": more seeds are needed" if self.noise > NOISY else ""
            yield f"chance makes up {self.noise:.0%} of the variance between cells{more}"

    def order(self) -> str:
        """The order of the axes, with numbers."""
        first, *rest = self.influences
        said = [f"{self.observable} depends most on {first.axis} ({self.of(first)})"]
        return ", then on ".join([*said, *(f"{one.axis} ({self.of(one)})" for one in rest)])

    def of(self, one: Influence) -> str:
        """The total of an axis."""
        return f"{self.symbols[0]} {in_words(one.total)}"

    def together(self) -> Iterator[str]:
        """What the axes do together, beyond what each does alone."""
        if self.kind == "morris":
            bent = [
                one.axis for one in self.influences
                if one.total.value > one.total.half and (one.spread or 0.0) > BENT * one.total.value
            ]  # fmt: skip
            if bent:
                yield f"the effect of {' and '.join(bent)} depends on where one is (sigma / mu*)"
            return
        alone = sum(one.alone.value for one in self.influences)
        yield f"each by itself, the axes explain {min(max(alone, 0.0), 1.0):.0%} of the variance"
        if self.pairs:
            most = max(self.pairs, key=lambda pair: pair.index.value)
            yield f"the most that two do together is S_2 {in_words(most.index)} of " + " and ".join(
                most.axes
            )


def in_words(index: Index) -> str:
    """An index with its interval.

    >>> in_words(Index(0.5581, 0.0512))
    '0.56 ± 0.05'
    """
    return f"{index.value:.2f}" + (f" ± {index.half:.2f}" if index.half == index.half else "")


def apart(one: Index, other: Index) -> bool:
    """Whether two indices differ by more than chance, as far as their intervals say."""
    return abs(one.value - other.value) > math.hypot(one.half, other.half)


def analysed(sweep: Sweep, kept: StoreReader, observable: str | None = None) -> list[Sensitivity]:
    """What each thing that is measured, or one of them, depends on. Raises InputError."""
    design = design_of(sweep)
    columns = sweep.making.columns
    if observable is not None and observable not in columns:
        raise unknown("observable", observable, columns, str(kept.folder))
    names = [observable] if observable is not None else columns
    numbers = kept.plan
    found = runs_of(sweep, kept, names)
    made: list[Sensitivity] = []
    for name in names:
        values = [found[number][name] for number in numbers]
        y = np.array([np.mean(one) for one in values])
        try:
            if isinstance(design, Saltelli):
                influences, pairs = sobol(design, y)
            else:
                influences, pairs = morris(design, y), []
        except InputError as refusal:
            others = [one for one in columns if one != name]
            hint = f"; take another with --observable {others[0]}" if others else ""
            raise InputError(f"{name} cannot be analysed: {refusal}{hint}") from None
        influences.sort(key=lambda one: -one.total.value)
        kind = "sobol" if isinstance(design, Saltelli) else "morris"
        seeds = sweep.file.replicates.count
        made.append(
            Sensitivity(name, kind, influences, pairs, noise_share(values), len(numbers), seeds)
        )
    return made


def design_of(sweep: Sweep) -> Saltelli | Morris:
    """The design that indices can be found from. Raises InputError."""
    designs, asked = sweep.file.design, sweep.file.replicates
    kinds = ", ".join(one.kind for one in designs) or "none"
    if len(designs) != 1 or not isinstance(designs[0], Saltelli | Morris):
        where = sweep.places.of("kind", "design", 0 if designs else None)
        raise InputError(
            f"design {kinds} is not allowed: one of kind saltelli, for Sobol's indices, or morris, "
            f"for elementary effects, is needed ({where})"
        )
    if asked.seeds != "common" or asked.precision is not None:
        key, table = ("seeds", "replicates")
        if asked.seeds == "common":
            key, table = "observable", "replicates.precision"
        raise InputError(
            "every cell needs the same seeds, or their differences would count as influence: "
            f'take seeds = "common" and no precision ({sweep.places.of(key, table)})'
        )
    if not sweep.making.columns:
        raise InputError("nothing has one value for each run: [[observe]] something at its end")
    return designs[0]


def runs_of(sweep: Sweep, kept: StoreReader, names: list[str]) -> dict[int, dict[str, list[float]]]:
    """The values of all runs by cell and name. Raises InputError if a run has none."""
    asked = sweep.file.replicates
    seeds = range(asked.first, asked.first + asked.count)
    cells = set(kept.plan)
    found: dict[int, dict[str, list[float]]] = {one: {n: [] for n in names} for one in cells}
    again = f"flockscope sensitivity {kept.folder}"
    broken = censored = runs = 0
    for cell, seed, status, _, _, _, _, *values in kept.runs(names):
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
            f"`flockscope sweep show {kept.folder}` names them, `{again} --retry-failed` makes "
            "them again"
        )
    if censored:
        raise InputError(
            f"{censored} of {counted(of, 'run')} gave up before what [stop] waits for came, and an "
            f"index needs all of them: raise ticks = {sweep.file.run.ticks} "
            f"({sweep.places.of('ticks', 'run')}), or narrow the axes"
        )
    for name in names:
        missing = sum(value != value for one in found.values() for value in one[name])
        if missing:
            raise InputError(
                f"{name} cannot be analysed: {missing} of {of} runs have no value, and an index "
                "needs all of them"
            )
    return found
