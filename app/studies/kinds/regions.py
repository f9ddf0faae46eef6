"""Two agents put down at distances from each other: Wu et al. 2023, figure 2 and (12)."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np
from pydantic import Field

from app.studies.kinds.kind_settings import Measure, Number, Settings

if TYPE_CHECKING:
    from agents import Flock

FORCE = "alpha gradient"
"""What the rule calls the term that (12) weighs."""
CLEAR = 0.02
"""Share of r within which of it nothing is asked: the force fades to 0 there."""


class Pushes(NamedTuple):
    """What one agent does to another; K distances."""

    distance: np.ndarray
    """(K,), m."""
    force: np.ndarray
    """Of the rule along the line to the other, (K,), m/s^2; below 0 it repels."""
    bare: np.ndarray
    """The same without the weight of (12), (K,), counted apart from the rule."""

    @property
    def weight(self) -> np.ndarray:
        """eta(d) as the rule has it, (K,)."""
        return self.force / self.bare


class RegionSettings(Settings):
    """How often two agents are put down."""

    kind: ClassVar[str] = "regions"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("off", "off", "Largest error of the weight from (12), as a share of it", "1"),
        Measure("warning", "d_e", "Distance at which the weight jumps to tau_s", "m"),
        Measure("separation", "separation", "Weakest push nearer than d_e", "m/s^2"),
        Measure("early", "early warning", "Strongest push between d_e and d", "m/s^2"),
        Measure("attraction", "attraction", "Strongest pull beyond d", "m/s^2"),
        Measure("wrong", "wrong", "Times that the force points the wrong way", "times", whole=True),
    )

    looks: int = Field(200, ge=10)
    """Distances, drawn at random within r."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Put two agents down, again and again, and ask the rule what one does to the other."""
        between()
        p = flock.parameters
        rng = np.random.default_rng(flock.seed)
        r: float = p.r  # type: ignore[attr-defined]
        found = self.pushes(flock, np.sort(rng.uniform(CLEAR * r, (1.0 - CLEAR) * r, self.looks)))
        d, d_e, want = found.distance, warning_distance(flock), p.d  # type: ignore[attr-defined]
        weight = weights(flock, d)
        near, middle, far = d < d_e, (d >= d_e) & (d <= want), d > want
        return {
            "off": float(np.abs(found.weight / weight - 1.0).max()),
            "warning": self.jump(flock),
            "separation": float(-found.force[near].max()),
            "early": float(-found.force[middle].min()),
            "attraction": float(found.force[far].max()),
            "wrong": int((found.force[~far] > 0.0).sum() + (found.force[far] < 0.0).sum()),
        }

    def pushes(self, flock: Flock, distance: np.ndarray) -> Pushes:
        """What the second agent of a flock does to the first at distances (K,), m."""
        middle = np.array(flock.world.low) + 0.5 * np.array(flock.world.size)
        force = np.empty(len(distance))
        for k, away in enumerate(distance):
            flock.position[:2] = middle
            flock.position[1, 0] += away
            force[k] = flock.inspect(0).forces[FORCE][0]
        return Pushes(distance, force, bare_force(flock, distance))

    def jump(self, flock: Flock) -> float:
        """The distance at which the rule's weight falls from tau_s, m; by halving [0, d]."""
        low, high = 0.1, float(flock.parameters.d)  # type: ignore[attr-defined]
        most: float = flock.parameters.tau_s  # type: ignore[attr-defined]
        for _ in range(40):
            middle = 0.5 * (low + high)
            near = self.pushes(flock, np.array([middle])).weight[0] > 0.5 * most
            low, high = (middle, high) if near else (low, middle)
        return 0.5 * (low + high)

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """None is run; looking counts as one each."""
        return float(self.looks)


def warning_distance(flock: Flock) -> float:
    """d_e = d_min + 2 p_max dt (12), m."""
    p = flock.parameters
    return p.d_min + 2.0 * p.p_max * p.dt  # type: ignore[attr-defined]


def weights(flock: Flock, distance: np.ndarray) -> np.ndarray:
    """eta(d) of (12) at distances (K,), m."""
    p = flock.parameters
    far = np.where(distance <= p.d, p.tau_e, p.tau_a)  # type: ignore[attr-defined]
    return np.where(distance < warning_distance(flock), p.tau_s, far)  # type: ignore[attr-defined]


def bare_force(flock: Flock, distance: np.ndarray) -> np.ndarray:
    """The gain times phi_alpha |n| of (8) at distances (K,), m/s^2, with plain NumPy."""
    p = flock.parameters
    eps, a, b, h = p.eps, p.a, p.b, p.h  # type: ignore[attr-defined]

    def sigma(z):
        return (np.sqrt(1.0 + eps * z * z) - 1.0) / eps

    s = sigma(distance)
    share = s / sigma(p.r)  # type: ignore[attr-defined]
    fading = 0.5 * (1.0 + np.cos(np.pi * (share - h) / (1.0 - h)))
    rho = np.where(share < h, 1.0, np.where(share < 1.0, fading, 0.0))
    z = s - sigma(p.d) + abs(a - b) / np.sqrt(4.0 * a * b)  # type: ignore[attr-defined]
    phi = 0.5 * ((a + b) * z / np.sqrt(1.0 + z * z) + (a - b))
    return p.c1a * rho * phi * distance / np.sqrt(1.0 + eps * distance**2)  # type: ignore[attr-defined]
