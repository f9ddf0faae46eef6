"""Agents before a block, and what pushes them off: the thesis, figures 4.2, 4.4 and 4.6."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar

import numpy as np
import shapely
from pydantic import Field

from app.studies.kinds.branching import block_of, push_on, with_block
from app.studies.kinds.kind_settings import RARE, Measure, Number, Settings
from app.studies.kinds.zoning import angle_between

if TYPE_CHECKING:
    from agents import Flock
    from agents.snapshot import FlockState

STEP = 1e-5
"""Of differences of the potential, length."""
LEAST, SURE = 0.3, 0.02
"""Distance from the skin at which it is put down at least, and to the edge of an occasion (length,
cosine) within which nothing is asked."""


class DodgingSettings(Settings):
    """The block, and how often an agent is put down near it."""

    kind: ClassVar[str] = "dodging"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("acts", "acts", "Times that the block pushes", "times", whole=True),
        Measure("off", "off", "Largest error of the push from -grad U (4.1), as a share", "1"),
        Measure("unseen", "unseen", "Largest push of a block that is not ahead", "1"),
        Measure("turned", "turned", "Largest turn in a tick", "deg"),
        Measure("hits", "hits", "Flights at the block that end in it", "flights", whole=True,
                bounds=RARE),
    )  # fmt: skip

    side: float = Field(3.0, gt=0.0)
    """Of the block, a square in the middle of the box, length."""
    looks: int = Field(200, ge=1)
    """Times that an agent is put down near it, at random."""
    flights: int = Field(20, ge=1)
    """Times that an agent flies straight at it from out of its range."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Ask the rule about an agent near the block, and let it fly at it."""
        between()
        before = with_block(flock, self.side)
        rng = np.random.default_rng(flock.seed)
        p = flock.parameters
        body, Q = p.body, p.Q  # type: ignore[attr-defined]
        off, unseen, turned, acts = 0.0, 0.0, 0.0, 0
        for _ in range(self.looks):
            place, heading = self.placed(before, rng)
            before.position[0], before.heading[0] = place, heading
            force = push_on(before, 0)
            to, away = nearest(before, place)
            skin, ahead = away - 0.5 * body, float(to @ heading)
            if abs(skin - Q) < SURE or abs(ahead) < SURE:
                continue
            if skin < Q and ahead > 0.0:
                acts += 1
                expected = slope(before, place)
                off = max(off, float(np.linalg.norm(force - expected) / np.linalg.norm(expected)))
            else:
                unseen = max(unseen, float(np.linalg.norm(force)))
            before.run(1)
            turned = max(turned, angle_between(heading, before.heading[0]))
        return {
            "acts": acts,
            "off": off,
            "unseen": unseen,
            "turned": turned,
            "hits": sum(self.flies_into(before, rng) for _ in range(self.flights)),
        }

    def placed(self, flock: FlockState, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        """A random place around the block and a random heading, (2,) each."""
        shape = block_of(flock)
        x0, y0, x1, y1 = shape.bounds
        reach = flock.parameters.Q + flock.parameters.body  # type: ignore[attr-defined]
        least = 0.5 * flock.parameters.body + LEAST  # type: ignore[attr-defined]
        while True:
            place = rng.uniform([x0 - reach, y0 - reach], [x1 + reach, y1 + reach])
            if shape.distance(shapely.Point(place)) > least:
                angle = rng.uniform(-np.pi, np.pi)
                return place, np.array([np.cos(angle), np.sin(angle)])

    def flies_into(self, flock: Flock, rng: np.random.Generator) -> bool:
        """Whether an agent that flies at a random point of the block's front ends in it."""
        p = flock.parameters
        shape = block_of(flock)
        x0, y0, x1, y1 = shape.bounds
        middle, half = np.array([0.5 * (x0 + x1), 0.5 * (y0 + y1)]), 0.5 * (y1 - y0)
        aside = np.array([-half - p.Q - p.body, rng.uniform(-half, half)])  # type: ignore[attr-defined]
        flock.position[0], flock.heading[0] = middle + aside, (1.0, 0.0)
        flock.speed[0] = p.v0  # type: ignore[attr-defined]
        ticks = round(2.0 * (p.Q + self.side) / (p.v0 * p.tau))  # type: ignore[attr-defined]
        body = 0.5 * p.body  # type: ignore[attr-defined]
        track = flock.trace(ticks)[:, 0]
        return bool(shape.distance(shapely.points(track)).min() <= body)

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """One for each time, and the flights."""
        return self.looks + 200.0 * self.flights


def nearest(flock: FlockState, place: np.ndarray) -> tuple[np.ndarray, float]:
    """The unit vector (2,) to the block's nearest point, and its distance, length."""
    shape, point = block_of(flock), shapely.Point(place)
    at = np.array(shapely.get_coordinates(shapely.shortest_line(point, shape))[1])
    away = float(shape.distance(point))
    return (at - place) / away, away


def field(flock: FlockState, place: np.ndarray) -> float:
    """U of (4.1) at a place (2,): eta / 2 (1 / D - 1 / Q)^2, D from the body's skin."""
    p = flock.parameters
    d = float(block_of(flock).distance(shapely.Point(place))) - 0.5 * p.body  # type: ignore[attr-defined]
    gain, Q = p.gain, p.Q  # type: ignore[attr-defined]
    return 0.5 * gain * (1.0 / d - 1.0 / Q) ** 2 if d <= Q else 0.0


def slope(flock: FlockState, place: np.ndarray) -> np.ndarray:
    """-grad U at a place, (2,), by differences."""
    steps = STEP * np.eye(2)
    return np.array(
        [(field(flock, place - s) - field(flock, place + s)) / (2.0 * STEP) for s in steps]
    )
