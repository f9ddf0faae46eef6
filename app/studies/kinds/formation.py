"""Runs in which it is measured what birds save by each other's upwash; thesis, section 2.3."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from pydantic import Field

from app.studies.kinds.kind_settings import PERCENT, RARE, SHARE, Measure, Number, Settings

if TYPE_CHECKING:
    from agents import Flock


class FormationSettings(Settings):
    """How long a flock is left alone and looked at, and what a share of induced drag is worth."""

    kind: ClassVar[str] = "formation"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("saved", "saved", "Induced drag saved", "%", "all have crashed"),
        Measure("power", "power", "Power saved", "%", "all have crashed"),
        Measure("joules", "per metre", "Energy that a bird saves per metre", "mJ/m", "not known"),
        Measure(
            "best",
            "best",
            "Birds that save more than half",
            "%",
            "all have crashed",
            bounds=PERCENT,
        ),
        Measure("p", "p", "Polarisation", "1", "all have crashed", bounds=SHARE),
        Measure("groups", "groups", "Groups at the end", "groups", whole=True),
        Measure("largest", "largest", "Birds in the largest group at the end", "%", bounds=PERCENT),
        Measure("crashes", "crashes", "Crashes", "agents", whole=True, bounds=RARE),
    )

    settle: int = Field(ge=0)
    """Ticks before a flock is looked at."""
    looks: int = Field(ge=1)
    """How often it is looked at; savings and polarisation are means over the looks."""
    every: int = Field(ge=1)
    """Ticks between two looks."""
    induced: float = Field(0.35, ge=0.0, le=1.0)
    """Share of the power that is induced: assumed."""
    energy: float | None = Field(None, gt=0.0)
    """What a bird alone needs for a metre, J/m; None where lengths are no metres."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Let the flock settle, then look at it."""
        between()
        flock.run(self.settle)
        shares, polarised = [], []
        for _ in range(self.looks):
            between()
            flock.run(self.every)
            shares.append(flock.signal("saved")[flock.active])
            polarised.append(flock.observe("polarisation"))
        every = np.concatenate(shares)
        saved = float(every.mean()) if len(every) else None
        power = None if saved is None else self.induced * saved
        joules = None if power is None or self.energy is None else 1000.0 * power * self.energy
        return {
            "saved": None if saved is None else 100.0 * saved,
            "power": None if power is None else 100.0 * power,
            "joules": joules,
            "best": None if saved is None else 100.0 * float((every > 0.5).mean()),
            "p": None if saved is None else float(np.mean(polarised)),
            "groups": int(flock.observe("groups")),
            "largest": 100.0 * flock.observe("largest-group") / len(flock.ids),
            "crashes": len(flock.crashes),
        }

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All of them."""
        return self.settle + self.looks * self.every


def followed(flock: Flock, ticks: int, every: int) -> tuple[np.ndarray, np.ndarray]:
    """Times (K,), s, and the mean share (K,) of induced drag that those that fly save then."""
    time, saved = [], []
    while flock.tick < ticks:
        flock.run(every)
        time.append(flock.elapsed)
        saved.append(flock.signal("saved")[flock.active].mean())
    return np.array(time), np.array(saved)
