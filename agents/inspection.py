"""One agent seen from close: its state, whom it listens to and how much."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from agents.engine.block import Me, Near
from agents.engine.noise import tick_key
from agents.observables.neighbours import separation

if TYPE_CHECKING:
    from agents.flock import Flock


@dataclass(frozen=True)
class Inspection:
    """What is known of one agent and of those it listens to."""

    id: int
    row: int
    neighbours: np.ndarray
    """Rows of its neighbours, int (M,)."""
    separation: np.ndarray
    """Vectors to their nearest images, (M, dim), length."""
    weights: np.ndarray
    """How much it listens to each, (M,), as its rule weighs them."""
    signals: dict[str, float]
    """What it tells its neighbours beside position and heading."""


def as_me(flock: Flock, row: int, signals: np.ndarray) -> Me:
    """A row as rules see themselves."""
    x, y, *z = (float(c) for c in flock.position[row])
    ux, uy, *uz = (float(c) for c in flock.heading[row])
    key: Any = np.uint64(tick_key(flock.seed, flock.tick))
    return Me(
        x,
        y,
        z[0] if z else 0.0,
        ux,
        uy,
        uz[0] if uz else 0.0,
        float(flock.speed[row]),
        signals,
        int(flock.ids[row]),
        flock.tick,
        key,
        len(flock.ids),
    )


def inspect(flock: Flock, row: int) -> Inspection:
    """Inspect the agent of a row (0 to N - 1)."""
    world, rule = flock.world, flock.model.rule
    apart = separation(flock.position[row], flock.position, world.size, world.images)
    d2 = (apart**2).sum(axis=1)
    rows = np.flatnonzero((d2 > 0.0) & (d2 <= flock.reach**2))
    apart = apart[rows]
    signals = flock.signals()
    own = signals[:, row].copy()
    weights = np.ones(len(rows))
    if rule.weigh is not None and len(rows) and not flock.informed[row]:
        me = as_me(flock, row, own)
        flat = np.zeros((3, len(rows)))
        flat[: world.dim] = flock.position[row][:, None] + apart.T
        turned = np.zeros((3, len(rows)))
        turned[: world.dim] = flock.heading[rows].T
        x, y, z = flat
        ux, uy, uz = turned
        told = np.ascontiguousarray(signals[:, rows])
        near = Near(len(rows), x, y, z, ux, uy, uz, told)
        rule.weigh(me, near, flock.law.parameters, weights)
    if flock.informed[row]:
        weights[:] = 0.0
    return Inspection(
        int(flock.ids[row]),
        row,
        rows,
        apart,
        weights,
        dict(zip(rule.signals, own.tolist(), strict=True)),
    )
