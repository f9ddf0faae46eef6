"""An agent alone that goes round obstacles: Wu et al. 2023, figures 3 and 4."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np
from pydantic import Field

from app.studies.kinds.kind_settings import Measure, Number, Settings

if TYPE_CHECKING:
    from agents import Flock

A1, A2, A3, A4 = 1.0, 2.0, 3.0, 4.0
"""The scenarios of Wu et al. 2023, table 2, as the rule counts them."""
CLOCKWISE = "clockwise"
FAR = math.inf
"""What counts as the least of nothing."""


class DetourTrack(NamedTuple):
    """What one agent did in each tick: where it was when it decided, and what it then knew."""

    position: np.ndarray
    """(T, 2), m."""
    scenario: np.ndarray
    """A1 to A4, (T,)."""
    split: np.ndarray
    """The last split point, (T, 2), m."""
    rejoin: np.ndarray
    """The last rejoin point, (T, 2), m."""
    aim: np.ndarray
    """The expected position, (T, 2), m."""
    phase: np.ndarray
    """Phase of the boundary point that is aimed at, (T,), rad."""
    goal: np.ndarray
    """The gamma agent, (2,), m."""

    def away(self, places: np.ndarray) -> np.ndarray:
        """Distances of places (T, 2) to the gamma agent, (T,), m."""
        return np.linalg.norm(places - self.goal, axis=1)

    @property
    def splits(self) -> np.ndarray:
        """Ticks at which a split point is set, int (S,): A1, and A3 where the way goes on."""
        return np.flatnonzero((self.scenario == A1) | (self.scenario == A3))

    @property
    def rejoins(self) -> np.ndarray:
        """Ticks at which a rejoin point is set, int (R,)."""
        before = np.vstack([np.zeros((1, 2)), self.rejoin[:-1]])
        return np.flatnonzero((self.rejoin != before).any(axis=1))


class DetourSettings(Settings):
    """How long an agent is followed."""

    kind: ClassVar[str] = "detours"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("splits", "splits", "Split points", "points", whole=True),
        Measure("rejoins", "rejoins", "Rejoin points", "points", whole=True),
        Measure("again", "A3", "Rejoin points at which the way goes on", "points", whole=True),
        Measure(
            "gained",
            "gained",
            "Least that a rejoin point is nearer than its split point",
            "m",
            "none",
            FAR,
        ),
        Measure(
            "behind",
            "behind",
            "Least that A2 is further from the goal than its split point",
            "m",
            "no A2",
            FAR,
        ),
        Measure(
            "off", "off", "Largest difference of the phase aimed at from (15), (16)", "rad", "never"
        ),
        Measure("away", "away", "Distance to the gamma agent at the end", "m"),
    )

    limit: float = Field(gt=0.0)
    """How long an agent is followed, s."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Follow the only agent of a flock."""
        between()
        course = self.followed(flock)
        rejoins, twice = course.rejoins, course.scenario == A2
        to_goal = course.away(course.position)
        of_split = course.away(course.split)
        gained = of_split[rejoins - 1] - course.away(course.rejoin)[rejoins]
        behind = to_goal[twice] - of_split[twice]
        return {
            "splits": len(course.splits),
            "rejoins": len(rejoins),
            "again": int((course.scenario == A3).sum()),
            "gained": float(gained.min()) if len(gained) else None,
            "behind": float(behind.min()) if len(behind) else None,
            "off": phase_error(flock, course),
            "away": float(np.linalg.norm(flock.position[0] - course.goal)),
        }

    def followed(self, flock: Flock) -> DetourTrack:
        """The course of the flock's first agent from tick 0 to the limit."""
        ticks = int(self.ticks(None, flock.dt))
        at = {name: k for k, name in enumerate(flock.model.columns)}
        position, known = np.empty((ticks, 2)), np.empty((ticks, len(at)))
        for tick in range(ticks):
            position[tick] = flock.position[0]
            flock.run(1)
            known[tick] = flock.arrays.memory[:, 0]
        points = {
            name: known[:, [at[f"{name}_x"], at[f"{name}_y"]]]
            for name in ("split", "rejoin", "aim")
        }
        return DetourTrack(
            position=position,
            scenario=known[:, at["scenario"]],
            phase=known[:, at["phase"]],
            goal=flock.goal_at([0])[0],
            **points,
        )

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All of them."""
        return round(self.limit / dt)


def phase_error(flock: Flock, course: DetourTrack) -> float | None:
    """Largest difference of the phase aimed at from that of sorted phases, rad; None: never."""
    errors = [
        abs(course.phase[tick] - boundary_end(flock, course, tick)[1])
        for tick in map(int, np.flatnonzero(course.scenario < A4))
        if len(perceived(flock, course.position[tick]))
    ]
    return float(max(errors)) if errors else None


def perceived(flock: Flock, place: np.ndarray) -> np.ndarray:
    """The boundary points that an agent at a place (2,) perceives, (K, 2), m."""
    surroundings = flock.engine.surroundings
    points = np.column_stack([surroundings.point_x, surroundings.point_y])
    r = flock.parameters.r  # type: ignore[attr-defined]
    return points[np.linalg.norm(points - place, axis=1) <= r]


def phases(flock: Flock, course: DetourTrack, tick: int) -> tuple[np.ndarray, np.ndarray]:
    """Boundary points perceived at a tick in the order of their phases, (K, 2) m, (K,) rad.

    Phases are counted from the split point in A2, else from the gamma agent, in [0, 2 pi).
    """
    place = course.position[tick]
    towards = (course.split[tick] if course.scenario[tick] == A2 else course.goal) - place
    points = perceived(flock, place)
    angle = np.arctan2(points[:, 1] - place[1], points[:, 0] - place[0])
    phase = (angle - np.arctan2(towards[1], towards[0])) % (2.0 * np.pi)
    order = np.argsort(phase)
    return points[order], phase[order]


def boundary_end(flock: Flock, course: DetourTrack, tick: int) -> tuple[np.ndarray, float]:
    """The expected position (15), (16) at a tick, by sorting: the point, (2,) m, and its phase.

    From small to large, or clockwise from large to small, the first phase that the next differs
    from by dtheta or more; else the last.
    """
    points, phase = phases(flock, course, tick)
    p = flock.parameters
    if p.sense == CLOCKWISE:  # type: ignore[attr-defined]
        points, phase = points[::-1], phase[::-1]
    gaps = np.abs(np.diff(phase)) >= p.dtheta  # type: ignore[attr-defined]
    m = int(gaps.argmax()) if gaps.any() else len(phase) - 1
    return points[m], float(phase[m])
