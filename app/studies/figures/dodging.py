"""A flock that meets a block, and how one agent avoids it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
import shapely
from pydantic import Field

from app.studies.charts.boxes import draw_key
from app.studies.charts.mission_scene import draw_obstacles
from app.studies.charts.scheme_marks import (
    FAINT,
    INK,
    ZONE_COLOURS,
    arrow,
    draw_dart,
    set_square_view,
    sign,
    stroke,
    write_label,
)
from app.studies.experiment import Experiment, flock_of
from app.studies.figures.branching import add_block, block_of, push_on
from app.studies.figures.zoning import angle_between
from app.studies.measure import RARE, Measure, Number, Settings

if TYPE_CHECKING:
    from agents import Flock
    from agents.snapshot import FlockState

# Agents before a block, and what pushes them off: the thesis, figures 4.2, 4.4 and 4.6.

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
        before = add_block(flock, self.side)
        rng = np.random.default_rng(flock.seed)
        p = flock.parameters
        body, Q = p.body, p.Q  # type: ignore[attr-defined]
        off, unseen, turned, acts = 0.0, 0.0, 0.0, 0
        for _ in range(self.looks):
            place, heading = self.random_placement(before, rng)
            before.position[0], before.heading[0] = place, heading
            force = push_on(before, 0)
            to, away = nearest_direction(before, place)
            skin, ahead = away - 0.5 * body, float(to @ heading)
            if abs(skin - Q) < SURE or abs(ahead) < SURE:
                continue
            if skin < Q and ahead > 0.0:
                acts += 1
                expected = potential_slope(before, place)
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

    def random_placement(
        self, flock: FlockState, rng: np.random.Generator
    ) -> tuple[np.ndarray, np.ndarray]:
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


def nearest_direction(flock: FlockState, place: np.ndarray) -> tuple[np.ndarray, float]:
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


def potential_slope(flock: FlockState, place: np.ndarray) -> np.ndarray:
    """-grad U at a place, (2,), by differences."""
    steps = STEP * np.eye(2)
    return np.array(
        [(field(flock, place - s) - field(flock, place + s)) / (2.0 * STEP) for s in steps]
    )


FORCE, NOW, NEXT = "#c0392b", ZONE_COLOURS[2], "#1f9d63"
RANKS = ((-6.7, 4.3), (-4.4, 0.9), (-4.2, -1.2), (-5.9, -3.2), (-5.8, 2.3))
"""Where agents 1 to 5 stand, from the middle of the block, length: the thesis draws no numbers."""
NEAR = (-2.7, 1.9)
"""Where the agent that avoids stands."""
LEVELS = (0.05, 0.2, 0.8, 3.2)
"""Of the potential."""


def draw_meeting(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw agents that fly at the block, what pushes each, and where they are later."""
    settings = experiment.settings
    assert isinstance(settings, DodgingSettings)
    case = experiment.cases[0]
    several = replace(case, spec=case.spec.but(agents=len(RANKS)))
    flock: Any = add_block(flock_of(several, seed), settings.side)
    middle, p = centre_of(flock), flock.parameters
    flock.position[:] = middle + np.array(RANKS)
    flock.heading[:] = (1.0, 0.0)
    flock.speed[:] = p.v0
    figure.set_size_inches(12.4, 6.2)
    left, right = figure.subplots(1, 2)
    scene(left, flock)
    for row in range(len(flock.ids)):
        place = flock.position[row].copy()
        force = push_on(flock, row)
        pushed = bool(force.any())
        arrow(left, place, 1.1 * flock.heading[row], NOW, 1.6)
        draw_dart(left, place, flock.heading[row], INK if pushed else FAINT, 0.75)
        write_label(left, place, str(row + 1), INK, (-2, 13), 9.0)
        if pushed:
            unit = force / np.linalg.norm(force)
            arrow(left, place, 1.6 * unit, FORCE, 2.4, 9.0)
            words = f"$F_{row + 1}$ = {np.linalg.norm(force):.2g}"
            write_label(left, place + 1.6 * unit, words, FORCE, (-4, -11), 9.5)
    set_square_view(left, middle + np.array([-2.4, 0.4]), 6.4)
    left.set_title("(a) pushed are those that have the block ahead and within Q*", loc="left")
    ticks = round(9.0 / (p.v0 * p.tau))
    track = flock.trace(ticks)
    scene(right, flock)
    for row in range(len(flock.ids)):
        right.plot(*track[:, row].T, color=NOW, linewidth=1.2, zorder=4)
        draw_dart(right, flock.position[row], flock.heading[row], INK, 0.75)
    set_square_view(right, middle + np.array([-1.0, 0.8]), 8.4)
    right.set_title(f"(b) {ticks * flock.dt:.0f} s later, and the ways they took", loc="left")
    draw_key(
        figure,
        [
            sign(INK, "agent that a block pushes", ">"),
            sign(FAINT, "agent that it does not push", ">"),
            stroke(NOW, "velocity; way"),
            stroke(FORCE, "force (4.1)", width=2.4),
            stroke(FAINT, "range Q* of the field", (0, (4, 2)), 1.2),
        ],
        f"thesis, v_0 = {p.v0:g}; the thesis gives neither places nor eta, Q*, m: "
        f"here eta = {p.gain:g}, Q* = {p.Q:g}, m = {p.m:g}",
    )


def centre_of(flock: Any) -> np.ndarray:
    """The middle of the block, (2,)."""
    x0, y0, x1, y1 = block_of(flock).bounds
    return 0.5 * np.array([x0 + x1, y0 + y1])


def scene(axes: Any, flock: Any) -> None:
    """Draw the block, and how far its field reaches for an agent's middle."""
    draw_obstacles(axes, flock.world)
    rim = block_of(flock).buffer(flock.parameters.Q + 0.5 * flock.parameters.body)
    axes.plot(*np.array(rim.exterior.coords).T, color=FAINT, linewidth=1.2, linestyle=(0, (4, 2)))


def draw_avoidance(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw how the velocity of an agent before the block comes about, over the potential."""
    settings = experiment.settings
    assert isinstance(settings, DodgingSettings)
    case = experiment.cases[0]
    flock: Any = add_block(flock_of(case, seed), settings.side)
    middle, p = centre_of(flock), flock.parameters
    place = middle + np.array(NEAR)
    flock.position[0], flock.heading[0], flock.speed[0] = place, (1.0, 0.0), p.v0
    force = push_on(flock, 0)
    u, f = p.v0 * flock.heading[0], p.tau / p.m * force
    figure.set_size_inches(8.8, 7.2)
    axes = figure.subplots()
    draw_obstacles(axes, flock.world)
    draw_field(axes, flock, middle)
    flock.run(1)
    heading = flock.heading[0].copy()
    scale = 1.5 / p.v0
    arrow(axes, place, scale * u, NOW, 2.2)
    arrow(axes, place, scale * f, FORCE, 2.2)
    arrow(axes, place, scale * (u + f), NEXT, 2.2)
    for begin in (u, f):
        axes.plot(*np.array([place + scale * begin, place + scale * (u + f)]).T, color=FAINT,
                  linewidth=0.9, linestyle=(0, (3, 3)), zorder=6)  # fmt: skip
    arrow(axes, place, 1.1 * heading, "#7b5ea7", 1.6, 8.5)
    write_label(axes, place + scale * u, "$u$", NOW, (9, -9), 12.0)
    write_label(axes, place + scale * f, "$f$", FORCE, (-10, 8), 12.0)
    write_label(axes, place + scale * (u + f), "$u' = f + u$", NEXT, (6, 13), 12.0)
    track = flock.trace(round(6.0 / (p.v0 * p.tau)))[:, 0]
    axes.plot(*track.T, color=INK, linewidth=1.1, zorder=3, linestyle=(0, (1.5, 1.5)))
    draw_dart(axes, place, np.array([1.0, 0.0]), INK, 0.42)
    set_square_view(axes, middle + np.array([-0.9, 1.2]), 3.9)
    draw_key(
        figure,
        [
            stroke(NOW, "u: velocity now"),
            stroke(FORCE, "f: tau/m times the force"),
            stroke(NEXT, "u': wished"),
            stroke("#7b5ea7", "heading a tick later"),
            stroke(INK, "way", (0, (1.5, 1.5)), 1.2),
        ],
        f"thesis, v_0 = {p.v0:g}; lines around the block: the potential (4.1), U = "
        f"{', '.join(f'{level:g}' for level in LEVELS)}; eta = {p.gain:g}, Q* = {p.Q:g} and "
        f"m = {p.m:g} are ours:\nthe thesis gives none; f is (4.1) downhill, the print of (4.2) "
        "has it uphill",
    )


def draw_field(axes: Any, flock: Any, middle: np.ndarray) -> None:
    """Draw lines of equal potential around the block."""
    half, cells = 5.2, 90
    at = np.linspace(-half, half, cells)
    shape = block_of(flock).buffer(0.5 * flock.parameters.body + 0.02)
    values = np.full((cells, cells), np.nan)
    for (row, column), _ in np.ndenumerate(values):
        place = middle + np.array([at[column], at[row]])
        if not shape.covers(shapely.Point(place)):
            values[row, column] = field(flock, place)
    lines = axes.contour(middle[0] + at, middle[1] + at, values, levels=LEVELS, colors="#c98b80",
                         linewidths=0.9, zorder=1.5)  # fmt: skip
    axes.clabel(lines, fontsize=7.5, fmt="%g")


PICTURES = {"meeting": draw_meeting, "avoidance": draw_avoidance}
