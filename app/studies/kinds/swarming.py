"""Runs in which driven particles that attract and repel each other take a shape, or come apart."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from pydantic import Field

from agents.observables.neighbours import nearest_neighbour
from app.studies.kinds.kind_settings import SHARE, Measure, Number, Settings

if TYPE_CHECKING:
    from agents import Flock

SHAPES = ("disperses", "flock", "ring", "mill", "double mill", "disordered")
"""What a swarm becomes."""


class SwarmingSettings(Settings):
    """How long a swarm is left alone and followed, and from what on it has which shape.

    In the plane. The measures are means over the looks.
    """

    kind: ClassVar[str] = "swarming"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("p", "p", "Polarisation", "1", bounds=SHARE),
        Measure("m", "m", "Angular momentum: how far all mill one way round", "1"),
        Measure(
            "either",
            "|m|",
            "The same, either way round: 0.64 where nobody mills",
            "1",
            bounds=SHARE,
        ),
        Measure("radius", "R", "Gyration radius", "length"),
        Measure("spacing", "d", "Distance to the nearest other, median", "length"),
        Measure("hole", "hole", "Distance of the innermost from the centre, of R", "1"),
        Measure("side", "side", "1 where it stays together if and only if C l^2 < 1", "1"),
        Measure("phase", "phase", "Shape by these measures", "1", whole=True, words=SHAPES),
    )

    lasts: int = Field(ge=0)
    """Ticks before it is looked at."""
    looks: int = Field(ge=1)
    """How often it is looked at."""
    every: int = Field(ge=1)
    """Ticks between two looks."""
    wide: float = Field(gt=0.0)
    """R from which on it has come apart, length."""
    polarised: float = Field(0.5, gt=0.0, lt=1.0)
    """p from which on it is a flock."""
    mills: float = Field(0.8, gt=0.65, lt=1.0)
    """|m| from which on it mills; one way round if m is as much."""
    hollow: float = Field(0.8, gt=0.0, lt=1.0)
    """Distance of the innermost from which on what mills is a ring, of R."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Leave the swarm alone, then look at it."""
        between()
        flock.run(self.lasts)
        seen = []
        for _ in range(self.looks):
            between()
            flock.run(self.every)
            seen.append(shape_of(flock))
        p, m, either, radius, spacing, hole = (float(mean) for mean in np.mean(seen, axis=0))
        together = radius < self.wide
        return {
            "p": p,
            "m": m,
            "either": either,
            "radius": radius,
            "spacing": spacing,
            "hole": hole,
            "side": float(together == (room(flock) < 1.0)),
            "phase": SHAPES.index(self.phase_of(p, m, either, radius, hole)),
        }

    def phase_of(self, p: float, m: float, either: float, radius: float, hole: float) -> str:
        """The shape of a swarm with these measures, one of `SHAPES`.

        >>> settings = SwarmingSettings(world="open", lasts=0, looks=1, every=1, wide=10.0)
        >>> settings.phase_of(0.05, 0.1, 0.98, 1.5, 0.93), settings.phase_of(0, 0.9, 0.9, 1.5, 0.1)
        ('ring', 'mill')
        """
        if radius >= self.wide:
            return "disperses"
        if p >= self.polarised:
            return "flock"
        if either < self.mills:
            return "disordered"
        if hole >= self.hollow:
            return "ring"
        return "mill" if m >= self.mills else "double mill"

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All of them."""
        return self.lasts + self.looks * self.every


def room(flock: Flock) -> float:
    """C l^2: above 1 the Morse potential is H-stable in the plane, below it is catastrophic."""
    p = flock.parameters
    strength = p.C_r / p.C_a  # type: ignore[attr-defined]
    return float(strength * (p.l_r / p.l_a) ** 2)  # type: ignore[attr-defined]


def shape_of(flock: Flock) -> tuple[float, ...]:
    """Polarisation, angular momentum, the same either way round, radius, spacing and hole."""
    out = flock.position - flock.position.mean(axis=0)
    far = np.linalg.norm(out, axis=1)
    turning = (out[:, 0] * flock.heading[:, 1] - out[:, 1] * flock.heading[:, 0]) / far
    radius = flock.observe("gyration-radius")
    near = nearest_neighbour(flock.position, flock.world.size, flock.world.images)
    return (
        flock.observe("polarisation"),
        flock.observe("angular-momentum"),
        float(np.abs(turning).mean()),
        radius,
        float(np.median(near)),
        float(far.min()) / radius,
    )
