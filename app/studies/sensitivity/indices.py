"""Sobol's and Morris' indices of what a design has given, by SALib; refused where it prints zeros.

One value that is missing, or values that are all the same, give SALib indices of exactly 0 with
intervals of 0. So nothing reaches it but a number for each cell, not all of them the same.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from app.studies.sweeps.given.designs import problem, unit_sample
from app.studies.sweeps.given.sweep_file import Morris, Saltelli
from worlds.input_error import InputError
from worlds.plug_ins import demand

RESAMPLES = 1000
"""Draws with which intervals are found."""
SAME = 1e-12
"""Deviation of the cells, as a share of what is measured, that is rounding."""


@dataclass(frozen=True)
class Index:
    """A number with half of its 95 % interval; nan where that is not known."""

    value: float
    half: float = math.nan


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
        found = analysis.analyze(
            problem(design),
            y,
            calc_second_order=second,
            num_resamples=RESAMPLES,
            seed=max(1, design.seed),  # it takes a seed of 0 for none
        )
    influences = [
        Influence(
            name,
            Index(float(found["ST"][k]), float(found["ST_conf"][k])),
            Index(float(found["S1"][k]), float(found["S1_conf"][k])),
        )
        for k, name in enumerate(names)
    ]
    pairs = [
        PairIndex(
            (names[j], names[k]), Index(float(found["S2"][j, k]), float(found["S2_conf"][j, k]))
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
    found = analysis.analyze(
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
            Index(float(found["mu_star"][k]), float(found["mu_star_conf"][k])),
            Index(float(found["mu"][k]), 1.96 * float(found["sigma"][k]) / root),
            float(found["sigma"][k]),
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
    within = float(np.mean([np.var(one, ddof=1) / len(one) for one in values]))
    between = float(np.var([np.mean(one) for one in values]))
    return within / between
