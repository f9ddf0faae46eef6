"""A UAV put down near obstacles again and again: Liu et al. 2021, figure 3."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np
import shapely
from pydantic import Field

from app.studies.kinds.kind_settings import Measure, Number, Settings
from app.studies.kinds.layering import between_angles

if TYPE_CHECKING:
    from agents import Flock
    from worlds.world import World

AROUND = 1.4
"""How far around obstacles it is put down, of r_avoid."""
CORNER = 1e-9
"""A nearest point that is no further than this from a corner is the corner, length."""
LEAST = 0.01
"""How near it is put down at least, length: a circle and its 128 sides are 2e-4 apart."""
SURE = 0.01, 2.0
"""Distance (length) and angle (deg) to the edge of the occasion within which nothing is expected:
the flock's circles have 128 sides."""


class Probes(NamedTuple):
    """Where a UAV was put down, what was nearest to it, and which heading it took; K times."""

    position: np.ndarray
    """(K, 2), length."""
    before: np.ndarray
    """The heading that it had, unit vectors (K, 2)."""
    after: np.ndarray
    """The heading a tick later, unit vectors (K, 2)."""
    nearest: np.ndarray
    """The nearest point of all obstacles, (K, 2), length."""
    corner: np.ndarray
    """Whether it is a corner, which has no tangent, (K,) bool."""

    @property
    def away(self) -> np.ndarray:
        """Distance to the nearest point, (K,), length."""
        return np.linalg.norm(self.nearest - self.position, axis=1)

    @property
    def ahead(self) -> np.ndarray:
        """Angle of the nearest point from the heading that it had, (K,), deg."""
        return np.degrees(between_angles(self.before, self.nearest - self.position))

    @property
    def turned(self) -> np.ndarray:
        """Angle from the old heading to the new one, (K,), deg."""
        return np.degrees(between_angles(self.before, self.after))

    @property
    def off(self) -> np.ndarray:
        """Angle of the new heading from the tangent at the nearest point, either way, (K,), deg."""
        normal = self.nearest - self.position
        tangent = np.column_stack([-normal[:, 1], normal[:, 0]])
        angle = np.degrees(between_angles(tangent, self.after))
        return np.minimum(angle, 180.0 - angle)


class TangentSettings(Settings):
    """How often the UAV is put down."""

    kind: ClassVar[str] = "tangents"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("avoids", "avoids", "Times that it is to act", "times", whole=True),
        Measure("off", "off tangent", "Largest angle from the tangent of those", "deg"),
        Measure("turned", "turned", "Largest turn of those", "deg"),
        Measure(
            "corners", "corners", "Times that the nearest point is a corner", "times", whole=True
        ),
        Measure("kept", "kept", "Largest turn of all other times", "deg"),
    )

    looks: int = Field(400, ge=1)
    """Times that it is put down, at random near the obstacles."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Put it down, again and again, each time for a tick."""
        between()
        p = flock.parameters
        found = self.probed(flock)
        reach, angle = p.r_avoid, np.degrees(p.theta_obstruct)  # type: ignore[attr-defined]
        sure = (np.abs(found.away - reach) > SURE[0]) & (np.abs(found.ahead - angle) > SURE[1])
        acts = (found.away < reach) & (found.ahead < angle) & ~found.corner
        return {
            "avoids": int((acts & sure).sum()),
            "off": float(found.off[acts & sure].max(initial=0.0)),
            "turned": float(found.turned[acts & sure].max(initial=0.0)),
            "corners": int((found.corner & sure).sum()),
            "kept": float(found.turned[~acts & sure].max(initial=0.0)),
        }

    def probed(self, flock: Flock) -> Probes:
        """What a flock of one UAV does, put down where the flock's seed says."""
        rng = np.random.default_rng(flock.seed)
        around = AROUND * flock.parameters.r_avoid  # type: ignore[attr-defined]
        places = places_near(flock.world, rng, self.looks, around)
        angle = rng.uniform(0.0, 2.0 * np.pi, self.looks)
        before = np.column_stack([np.cos(angle), np.sin(angle)])
        after = np.empty_like(before)
        for k in range(self.looks):
            flock.position[0], flock.heading[0] = places[k], before[k]
            flock.run(1)
            after[k] = flock.heading[0]
        nearest, corner = nearest_points(flock.world, places)
        return Probes(places, before, after, nearest, corner)

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """One for each time."""
        return float(self.looks)


def places_near(world: World, rng: np.random.Generator, count: int, around: float) -> np.ndarray:
    """Random places outside of obstacles, but within `around` (length) of one, (count, 2)."""
    shapes = [one.footprint() for one in world.obstacles]
    solid = shapely.union_all(shapes)
    found: list[np.ndarray] = []
    while len(found) < count:
        x0, y0, x1, y1 = shapes[rng.integers(len(shapes))].bounds
        low, high = np.array([x0, y0]) - around, np.array([x1, y1]) + around
        place = rng.uniform(low, high)
        if LEAST < solid.distance(shapely.Point(place)) <= around:
            found.append(place)
    return np.array(found)


def nearest_points(world: World, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The nearest obstacle point of places (K, 2), (K, 2), and whether it is a corner, (K,).

    Discs are round here; the corners of others are those of their outlines.
    """
    best = np.full(len(places), np.inf)
    nearest, corner = np.empty_like(places), np.zeros(len(places), bool)
    for one in world.obstacles:
        found, sharp = nearest_of(one, places)
        away = np.linalg.norm(found - places, axis=1)
        nearer = away < best
        best[nearer], nearest[nearer], corner[nearer] = away[nearer], found[nearer], sharp[nearer]
    return nearest, corner


def nearest_of(obstacle: object, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same for a single obstacle."""
    if getattr(obstacle, "shape", "") == "disc":
        centre = np.array(obstacle.centre)  # type: ignore[attr-defined]
        out = places - centre
        out /= np.linalg.norm(out, axis=1, keepdims=True)
        return centre + obstacle.radius * out, np.zeros(len(places), bool)  # type: ignore[attr-defined]
    ring = obstacle.footprint().exterior  # type: ignore[attr-defined]
    at = ring.interpolate(ring.project(shapely.points(places)))
    nearest = shapely.get_coordinates(at)
    corners = np.array(ring.coords)
    gap = np.linalg.norm(nearest[:, None] - corners, axis=2).min(axis=1)
    return nearest, gap <= CORNER
