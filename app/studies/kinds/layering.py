"""Flocks whose layers and weights are looked at agent by agent: Liu et al. 2021, figure 2."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from app.studies.kinds.kind_settings import Measure, Number, Settings

if TYPE_CHECKING:
    from agents import Flock
    from agents.inspection import Inspection


class LayeringSettings(Settings):
    """Nothing is to be said but the world: a flock is looked at before its first tick."""

    kind: ClassVar[str] = "layering"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("deepest", "deepest", "Deepest layer that is known", "layer", whole=True),
        Measure("cut_off", "cut off", "UAVs of no layer", "UAVs", whole=True),
        Measure(
            "off", "off", "UAVs whose layer is not that of the shortest way", "UAVs", whole=True
        ),
        Measure(
            "upper", "upper", "UAVs that heed a lower layer's neighbour more", "UAVs", whole=True
        ),
        Measure("angle", "angle", "Largest angle of a heading from the sum of vectors", "deg"),
    )

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Look at all UAVs, then let them fly for a tick and compare."""
        between()
        n = len(flock.ids)
        layers = flock.layers()
        known = layers <= n
        near = [flock.inspect(row) for row in range(n)]
        sums = np.array([vectors(flock, one).sum(axis=0) for one in near])
        upside_down = sum(heeds_lower(one, layers, n) for one in near)
        flock.run(1)
        steers = ~flock.informed & (np.linalg.norm(sums, axis=1) > 0.0)
        return {
            "deepest": int(layers[known].max()),
            "cut_off": int((~known).sum()),
            "off": int((layers != shortest_ways(flock_links(near), flock.informed)).sum()),
            "upper": upside_down,
            "angle": float(
                np.degrees(between_angles(sums, flock.heading)[steers].max(initial=0.0))
            ),
        }

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """One, and looking at every UAV costs as much as many."""
        return 1000.0


def flock_links(near: list[Inspection]) -> np.ndarray:
    """Which UAVs (row) know of which (column), (N, N) bool."""
    linked = np.zeros((len(near), len(near)), bool)
    for one in near:
        linked[one.row, one.neighbours] = True
    return linked


def shortest_ways(linked: np.ndarray, informed: np.ndarray) -> np.ndarray:
    """Layers by the shortest sequence of neighbours, (N,) int; N + 1 where there is none.

    The information UAVs are layer 1; a UAV that is n links away from them is in layer n + 1.
    """
    n = len(linked)
    layers = np.where(informed, 1, n + 1)
    for layer in range(1, n + 1):
        reached = linked[layers == layer].any(axis=0) & (layers > n)
        layers[reached] = layer + 1
    return layers


def shortest_way(layers: np.ndarray, linked: np.ndarray, row: int) -> list[int]:
    """Rows from an information UAV to `row`, each a layer further than the one before."""
    way = [row]
    while layers[way[0]] > 1:
        above = np.flatnonzero(linked[way[0]] & (layers == layers[way[0]] - 1))
        way.insert(0, int(above[0]))
    return way


def vectors(flock: Flock, one: Inspection) -> np.ndarray:
    """What each neighbour adds to the direction (18), h_ij times its heading, (M, dim)."""
    total = one.weights.sum()
    share = one.weights / total if total > 0.0 else one.weights
    return share[:, None] * flock.heading[one.neighbours]


def heeds_lower(one: Inspection, layers: np.ndarray, unknown: int) -> bool:
    """Whether a neighbour weighs as much as one of a layer nearer to the information UAV, or more.

    `unknown`: layers above it are not known.
    """
    theirs = layers[one.neighbours]
    counts = theirs <= unknown
    most: dict[int, float] = {}
    least: dict[int, float] = {}
    for layer, weight in zip(theirs[counts].tolist(), one.weights[counts].tolist(), strict=True):
        most[layer] = max(most.get(layer, 0.0), weight)
        least[layer] = min(least.get(layer, math.inf), weight)
    return any(most[low] >= least[up] > 0.0 for up in least for low in most if low > up)


def between_angles(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Angles between vectors (N, 2) and (N, 2), rad in [0, pi]; 0 where one has no length."""
    across = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return np.abs(np.arctan2(across, (a * b).sum(axis=1)))
