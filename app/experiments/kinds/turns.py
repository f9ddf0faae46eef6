"""Runs in which one agent turns and the others follow: Attanasi et al. 2014, figures 2 and 4."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from pydantic import Field

from app.experiments.kinds.settings import Measure, Number, Settings
from worlds.refusal import Refusal

if TYPE_CHECKING:
    from agents import Flock


@dataclass(frozen=True)
class Turn:
    """How the turn of one agent came to the others."""

    away: np.ndarray
    """Distance of each agent to the one that turned, when it did, (N,), length."""
    delay: np.ndarray
    """Time after the turn at which each turns half as fast as it ever does, (N,)."""
    distance: np.ndarray
    """Middles of the rings about the one that turned, (K,), length."""
    median: np.ndarray
    """The median delay of the agents of each ring, (K,)."""
    sound: float
    """c_s of the linear theory, length per time."""

    @property
    def exponent(self) -> float:
        """a of distance ~ delay^a: 1 for a wave, 1/2 for what diffuses."""
        return float(np.polyfit(np.log(self.median), np.log(self.distance), 1)[0])

    @property
    def speed(self) -> float:
        """Rings that the turn comes across per time, length per time."""
        return float(np.polyfit(self.median, self.distance, 1)[0])


class Turns(Settings):
    """By how much one agent turns, how long the others are followed, and how far from it."""

    kind: ClassVar[str] = "turns"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("exponent", "a", "Exponent of distance over delay", "1"),
        Measure("speed", "c", "Speed at which the turn spreads", "length/s"),
        Measure("ratio", "c/c_s", "That speed over that of the linear theory", "1"),
    )

    turn: float = Field(gt=0.0, le=90.0)
    """Angle by which the information agent turns, deg."""
    limit: float = Field(gt=0.0)
    """Time over which the others are then followed."""
    nearest: float = Field(gt=0.0)
    """Distance at which the first ring about the one that turned begins, length."""
    furthest: float = Field(gt=0.0)
    """Distance at which the last one ends."""
    rings: int = Field(ge=3)

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Let one agent turn and see when the others do."""
        one = self.turned(flock, between)
        return {
            "exponent": one.exponent,
            "speed": one.speed,
            "ratio": one.speed / one.sound,
        }

    def turned(self, flock: Flock, between: Callable[[], None] = lambda: None) -> Turn:
        """All fly along x until the information agent turns. Raises Refusal unless there is one."""
        if flock.informed.sum() != 1:
            raise Refusal(f"informed = {flock.informed.sum()}: one agent is to turn")
        first = int(np.argmax(flock.informed))
        flock.heading[:] = np.eye(flock.world.dim)[0]
        angle = math.radians(self.turn)
        flock.heading[first, :2] = math.cos(angle), math.sin(angle)
        away, sound = distances(flock, first), sound_of(flock)
        rate = self.rates(flock, between)
        delay = flock.dt * ((rate >= 0.5 * rate.max(axis=0)).argmax(axis=0) + 0.5)
        edges = np.linspace(self.nearest, self.furthest, self.rings + 1)
        ring = np.digitize(away, edges) - 1
        within = [ring == k for k in range(self.rings)]
        median = np.array([np.median(delay[rows]) for rows in within])
        middle = np.array([away[rows].mean() for rows in within])
        return Turn(away, delay, middle, median, sound)

    def rates(self, flock: Flock, between: Callable[[], None]) -> np.ndarray:
        """By how much each turns in each tick from now on, (T, N), as lengths of chords."""
        made = []
        for _ in range(round(self.limit / flock.dt)):
            between()
            before = flock.heading.copy()
            flock.run(1)
            made.append(np.linalg.norm(flock.heading - before, axis=1))
        return np.array(made)

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All of them."""
        return self.limit / dt


def distances(flock: Flock, row: int) -> np.ndarray:
    """Distance of each agent to that of a row, to the nearest image, (N,), length."""
    apart = flock.position - flock.position[row]
    size = np.array(flock.world.size)
    apart -= np.where(flock.world.images, size * np.round(apart / size), 0.0)
    return np.linalg.norm(apart, axis=1)


def sound_of(flock: Flock) -> float:
    """c_s = sqrt(J sum_j d_ij^2 / (2 dim chi)) of the flock as it flies, its mean over i.

    Of neighbours on a lattice a apart along each axis that is a sqrt(J / chi).
    """
    p = flock.parameters
    pairs = flock.links()
    apart = flock.position[pairs[:, 0]] - flock.position[pairs[:, 1]]
    size = np.array(flock.world.size)
    apart -= np.where(flock.world.images, size * np.round(apart / size), 0.0)
    each = 2.0 * (apart**2).sum() / len(flock.ids)
    return math.sqrt(p.J * each / (2.0 * flock.world.dim * p.chi))  # type: ignore[attr-defined]
