"""Runs in which a group without walls takes a shape: Couzin et al. 2002, figure 3 and after."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from pydantic import Field

from agents.state.start import random_headings
from app.studies.kinds.kind_settings import PERCENT, SHARE, Measure, Number, Settings
from worlds.input_error import InputError

if TYPE_CHECKING:
    from agents import Flock

PHASES = ("fragments", "swarm", "torus", "dynamic parallel", "highly parallel")
"""Names of Couzin et al. 2002, and one for groups that have come apart."""
TRIES = 300
"""How often agents that detect nobody are placed anew before a start is refused."""


class PhaseSettings(Settings):
    """How long a group is left alone and followed, and from what on it counts as which phase."""

    kind: ClassVar[str] = "phases"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("p", "p", "Polarisation (4)", "1", bounds=SHARE),
        Measure("m", "m", "Angular momentum (5)", "1"),
        Measure("largest", "largest", "Agents in the largest group", "%", bounds=PERCENT),
        Measure("mixing", "mixing", "Change of places between two looks, of the radius", "1"),
        Measure("phase", "phase", "Phase by these measures", "1", whole=True, words=PHASES),
    )

    settle: int = Field(ge=0)
    """Ticks before a group is looked at, from its start."""
    hold: int = Field(ge=0)
    """Ticks before it is looked at after a parameter was changed."""
    looks: int = Field(ge=1)
    """How often it is looked at; the measures are means over the looks."""
    every: int = Field(ge=1)
    """Ticks between two looks."""
    whole: float = Field(95.0, gt=0.0, le=100.0)
    """Share of the agents in the largest group below which a group has come apart, %."""
    polarised: float = Field(0.5, gt=0.0, lt=1.0)
    """p from which on a group is parallel."""
    mills: float = Field(0.5, gt=0.0, lt=1.0)
    """m from which on a group that is not parallel is a torus."""
    mixes: float = Field(0.04, gt=0.0)
    """Mixing from which on a parallel group is dynamic."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Let the group settle, then look at it."""
        if flock.tick == 0:
            bring_in_sight(flock)
        between()
        flock.run(self.hold if flock.tick else self.settle)
        before = places(flock)
        seen = []
        for _ in range(self.looks):
            between()
            flock.run(self.every)
            now = places(flock)
            radius = float(np.sqrt((now**2).sum(axis=1).mean()))
            seen.append(
                (
                    flock.observe("polarisation"),
                    flock.observe("angular-momentum"),
                    100.0 * flock.observe("largest-group") / len(flock.ids),
                    float(np.sqrt(((now - before) ** 2).sum(axis=1).mean())) / radius,
                )
            )
            before = now
        p, m, largest, mixing = (float(mean) for mean in np.mean(seen, axis=0))
        phase = PHASES.index(self.phase_of(p, m, largest, mixing))
        return {"p": p, "m": m, "largest": largest, "mixing": mixing, "phase": phase}

    def phase_of(self, p: float, m: float, largest: float, mixing: float) -> str:
        """The phase of a run with these measures, one of `PHASES`.

        >>> settings = PhaseSettings(world="open", settle=0, hold=0, looks=1, every=1)
        >>> settings.phase_of(0.2, 0.7, 100.0, 1.1)
        'torus'
        """
        if largest < self.whole:
            return "fragments"
        if p >= self.polarised:
            return "dynamic parallel" if mixing >= self.mixes else "highly parallel"
        return "torus" if m >= self.mills else "swarm"

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All of them, from the start."""
        return self.settle + self.looks * self.every


def places(flock: Flock) -> np.ndarray:
    """Where the agents are, seen from their centre, (N, dim), length."""
    return flock.position - flock.position.mean(axis=0)


def bring_in_sight(flock: Flock) -> None:
    """Place agents anew, within the box, until each detects at least one other, as the paper has.

    An agent detects those in its zone of repulsion and those that are in its field of view and no
    further than the zone of attraction reaches. Raises InputError if that does not come about.
    """
    low, size = np.array(flock.world.low), np.array(flock.world.size)
    for _ in range(TRIES):
        alone = ~detects(flock)
        if not alone.any():
            return
        n = int(alone.sum())
        flock.position[alone] = low + flock.rng.uniform(0.0, 1.0, (n, len(low))) * size
        flock.heading[alone] = random_headings(flock.rng, n, len(low))
    raise InputError(
        f"agents = {len(flock.ids)} cannot be placed in {size.tolist()} so that each detects "
        f"another within {flock.reach:g}"
    )


def detects(flock: Flock) -> np.ndarray:
    """Whether each agent detects at least one other, (N,) bool."""
    p = flock.parameters
    pairs = flock.links()
    i, j = np.concatenate([pairs, pairs[:, ::-1]]).T
    apart = flock.position[j] - flock.position[i]
    distance = np.linalg.norm(apart, axis=1)
    along = (apart * flock.heading[i]).sum(axis=1)
    edge = np.cos(np.radians(0.5 * p.alpha))  # type: ignore[attr-defined]
    near = (distance < p.r_r) | (along >= edge * distance)  # type: ignore[attr-defined]
    return np.bincount(i[near], minlength=len(flock.ids)) > 0
