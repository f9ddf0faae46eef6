"""What a UAV does about obstacles: the angles of one occasion, and many occasions round shapes."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
import shapely
from pydantic import Field

from app.studies.charts.boxes import draw_key
from app.studies.charts.mission_scene import draw_obstacles, show_box
from app.studies.experiment import Experiment, flock_of
from app.studies.figures.layering import between_angles
from app.studies.measure import Measure, Number, Settings

if TYPE_CHECKING:
    from agents import Flock
    from worlds.world import World

# A UAV put down near obstacles again and again: Liu et al. 2021, figure 3.

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
    def distances(self) -> np.ndarray:
        """Distance to the nearest point, (K,), length."""
        return np.linalg.norm(self.nearest - self.position, axis=1)

    @property
    def angles_ahead(self) -> np.ndarray:
        """Angle of the nearest point from the heading that it had, (K,), deg."""
        return np.degrees(between_angles(self.before, self.nearest - self.position))

    @property
    def turn_angles(self) -> np.ndarray:
        """Angle from the old heading to the new one, (K,), deg."""
        return np.degrees(between_angles(self.before, self.after))

    @property
    def tangent_errors(self) -> np.ndarray:
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
        probes = self.probe_flock(flock)
        reach, angle = p.r_avoid, np.degrees(p.theta_obstruct)  # type: ignore[attr-defined]
        sure = (np.abs(probes.distances - reach) > SURE[0]) & (
            np.abs(probes.angles_ahead - angle) > SURE[1]
        )
        acts = (probes.distances < reach) & (probes.angles_ahead < angle) & ~probes.corner
        return {
            "avoids": int((acts & sure).sum()),
            "off": float(probes.tangent_errors[acts & sure].max(initial=0.0)),
            "turned": float(probes.turn_angles[acts & sure].max(initial=0.0)),
            "corners": int((probes.corner & sure).sum()),
            "kept": float(probes.turn_angles[~acts & sure].max(initial=0.0)),
        }

    def probe_flock(self, flock: Flock) -> Probes:
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
    shapes = [obstacle.footprint() for obstacle in world.obstacles]
    solid = shapely.union_all(shapes)
    places: list[np.ndarray] = []
    while len(places) < count:
        x0, y0, x1, y1 = shapes[rng.integers(len(shapes))].bounds
        low, high = np.array([x0, y0]) - around, np.array([x1, y1]) + around
        place = rng.uniform(low, high)
        if LEAST < solid.distance(shapely.Point(place)) <= around:
            places.append(place)
    return np.array(places)


def nearest_points(world: World, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The nearest obstacle point of places (K, 2), (K, 2), and whether it is a corner, (K,).

    Discs are round here; the corners of others are those of their outlines.
    """
    best = np.full(len(places), np.inf)
    nearest, corner = np.empty_like(places), np.zeros(len(places), bool)
    for obstacle in world.obstacles:
        nearest_place, sharp = nearest_of(obstacle, places)
        away = np.linalg.norm(nearest_place - places, axis=1)
        nearer = away < best
        best[nearer], nearest[nearer], corner[nearer] = (
            away[nearer],
            nearest_place[nearer],
            sharp[nearer],
        )
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


BEFORE, AFTER, KEEPS, NEAREST, INK = "#7a828c", "#2166ac", "#e08214", "#1f9d63", "#3c434b"
MARGIN = 0.75
"""Shown around an obstacle, length."""
TURNS = 25.0, 65.0
"""Turn of the occasion that is drawn large, deg."""
ARROW = 0.22
"""Length of an arrow round the shapes, length."""


def draw_tangents(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw the occasions of the first row and that seed."""
    settings = experiment.settings
    assert isinstance(settings, TangentSettings)
    flock = flock_of(experiment.cases[0], seed)
    probes = settings.probe_flock(flock)
    figure.set_size_inches(12.8, 5.4)
    panels = figure.subplots(1, 3, width_ratios=[1.0, 1.0, 1.0])
    discs = [obstacle for obstacle in flock.world.obstacles if obstacle.shape == "disc"]
    pointed = [obstacle for obstacle in flock.world.obstacles if obstacle.shape == "polygon"]
    draw_occasion(panels[0], flock, probes, discs[0])
    for axes, obstacle, words in (
        (panels[1], discs[0], "(b) round a disc: along the tangent"),
        (panels[2], pointed[-1], "(c) at corners without a tangent: as before"),
    ):
        draw_obstacles(axes, flock.world)
        draw_all(axes, probes)
        x0, y0, x1, y1 = obstacle.footprint().bounds
        middle = 0.5 * np.array([x0 + x1, y0 + y1])
        half = 0.5 * max(x1 - x0, y1 - y0) + MARGIN
        show_box(axes, middle - half, middle + half)
        remove_axes(axes)
        axes.set_title(words, loc="left")
    draw_key(
        figure, signs(), f"a UAV put down {settings.looks} times near the obstacles, seed {seed}"
    )


def choose_probe(probes: Probes, shape: Any, reach: float) -> int:
    """The occasion that is drawn large: at this obstacle, a clear turn, not too near."""
    at = np.linalg.norm(probes.nearest - np.array(shape.centre), axis=1)
    good = (
        (at < shape.radius + 1e-6)
        & (probes.turn_angles > TURNS[0])
        & (probes.turn_angles < TURNS[1])
        & (probes.distances < 0.8 * reach)
    )
    return int(np.argmax(np.where(good, probes.distances, -1.0)))


def draw_occasion(axes: Any, flock: Any, probes: Probes, shape: Any) -> None:
    """Draw one occasion with the names of the paper's (20) to (22)."""
    from matplotlib.patches import Circle, Wedge

    p = flock.parameters
    k = choose_probe(probes, shape, p.r_avoid)
    place, point = probes.position[k], probes.nearest[k]
    draw_obstacles(axes, flock.world)
    way = np.degrees(np.arctan2(*probes.before[k][::-1]))
    half = np.degrees(p.theta_obstruct)
    axes.add_patch(
        Wedge(
            place,
            p.r_avoid,
            way - half,
            way + half,
            facecolor="#fdf0dd",
            edgecolor="none",
            zorder=1,
        )
    )
    axes.add_patch(Circle(place, p.r_avoid, fill=False, edgecolor=KEEPS, linewidth=1.1, zorder=2.5))
    axes.plot(
        *np.array([place, point]).T, color=NEAREST, linewidth=1.2, linestyle=(0, (3, 2)), zorder=4
    )
    along = probes.after[k]
    axes.plot(
        *np.array([point - 0.75 * along, point + 0.75 * along]).T,
        color=INK,
        linewidth=1.0,
        zorder=3,
    )
    axes.plot(*point, "o", color=NEAREST, markersize=9, zorder=6, markeredgecolor="white")
    axes.plot(*place, "o", color=INK, markersize=8, zorder=6, markeredgecolor="white")
    for heading, colour, words in (
        (probes.before[k], BEFORE, "$\\theta_i$, wanted"),
        (probes.after[k], AFTER, "$\\theta_{obs}$, taken"),
    ):
        tip = place + 0.42 * heading
        axes.annotate(
            "", tip, place, zorder=7,
            arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 2.2, "shrinkA": 0,
                        "mutation_scale": 15, "shrinkB": 0},
        )  # fmt: skip
        write_label(axes, place + 0.47 * heading, heading, words, colour)
    edge = place - p.r_avoid * (point - place) / probes.distances[k]
    write_label(axes, edge, edge - place, f"$r_{{avoid}}$ = {p.r_avoid:g}", KEEPS)
    show_box(axes, place - 1.05, place + 1.05)
    remove_axes(axes)
    axes.set_title(
        f"(a) the nearest point is {probes.angles_ahead[k]:.0f}° ahead: "
        f"it turns by {probes.turn_angles[k]:.0f}°",
        loc="left",
    )


def remove_axes(axes: Any) -> None:
    """Take ticks and spines away."""
    axes.set(xticks=[], yticks=[])
    for spine in axes.spines.values():
        spine.set_visible(False)


def write_label(axes: Any, at: np.ndarray, way: np.ndarray, words: str, colour: str) -> None:
    """Write words beyond a place, on the side that a way (2,) leads to."""
    axes.annotate(
        words, at, (6.0 * np.sign(way[0]), 8.0 * way[1] / max(1e-9, float(np.linalg.norm(way)))),
        textcoords="offset points", ha="left" if way[0] > 0.0 else "right", va="center",
        color=colour, fontsize=10, zorder=8,
    )  # fmt: skip


def draw_all(axes: Any, probes: Probes) -> None:
    """Draw all occasions: the heading before in grey, the one after in colour."""
    turned = probes.turn_angles > 1e-6
    style: dict[str, Any] = {
        "angles": "xy", "scale_units": "xy", "scale": 1.0 / ARROW, "width": 0.006, "clip_on": True,
    }  # fmt: skip
    axes.quiver(*probes.position.T, *probes.before.T, color=BEFORE, alpha=0.6, zorder=4, **style)
    for rows, colour in ((turned, AFTER), (~turned & probes.corner, KEEPS)):
        axes.quiver(
            *probes.position[rows].T, *probes.after[rows].T, color=colour, zorder=5, **style
        )


def signs() -> list[Any]:
    """What is what."""
    from matplotlib.lines import Line2D

    arrow: dict[str, Any] = {"marker": ">", "linestyle": "none", "markersize": 8}
    return [
        Line2D([], [], color=BEFORE, label="heading before", **arrow),
        Line2D([], [], color=AFTER, label="after, along the tangent", **arrow),
        Line2D([], [], color=KEEPS, label="at a corner: kept", **arrow),
        Line2D([], [], color=NEAREST, marker="o", linestyle="none", label="nearest obstacle point"),
    ]


PICTURES = {"tangents": draw_tangents}
