"""A beta agent beside a wall and beside a disc: where it is, and how it moves."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import Field

from app.studies.charts.boxes import draw_key
from app.studies.charts.mission_scene import draw_obstacles
from app.studies.charts.scheme_marks import INK, arrow, set_square_view, sign, stroke, write_label
from app.studies.experiment import Experiment, flock_of
from app.studies.measure import Measure, Number, Settings
from worlds.obstacles import Box, Disc
from worlds.queries.surroundings import nearest_surface

if TYPE_CHECKING:
    from agents import Flock
    from worlds.world import World

# An agent put down beside a wall or a disc, and its beta agent: Wu et al. 2023, figure 1.

BORDER = 0.05
"""How far from r, as a share of it, the agent is put down at most."""


class Projection(NamedTuple):
    """An agent and its beta agent."""

    q: np.ndarray
    """Of the agent, (2,), m."""
    p: np.ndarray
    """Its velocity, (2,), m/s."""
    q_hat: np.ndarray
    """Of the beta agent: the surface that the rule goes by, (2,), m."""
    p_hat: np.ndarray
    """Its velocity, from the force that the rule makes of it, (2,), m/s."""


class ProjectionSettings(Settings):
    """Beside what the agent is put down, and how often."""

    kind: ClassVar[str] = "projections"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("place", "place", "Largest error of the place, from (5) or (6)", "m"),
        Measure("along", "along", "Largest part of its velocity across the surface", "m/s"),
        Measure("velocity", "velocity", "Largest error of its velocity, from P p", "m/s"),
        Measure("printed", "printed", "Largest error of its velocity, as printed", "m/s"),
    )

    beside: Literal["wall", "disc"]
    looks: int = Field(100, ge=1)
    """Times that it is put down, at random within r."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Put it down, again and again, and ask the rule each time."""
        between()
        projections = self.find_projections(flock)
        expected = [self.equations(flock, projection) for projection in projections]
        normals = [
            (projection.q - projection.q_hat) / np.linalg.norm(projection.q - projection.q_hat)
            for projection in projections
        ]
        pairs = list(zip(projections, expected, strict=True))
        return {
            "place": max(float(np.linalg.norm(a.q_hat - b.q_hat)) for a, b in pairs),
            "along": max(
                abs(float(n @ projection.p_hat))
                for n, projection in zip(normals, projections, strict=True)
            ),
            "velocity": max(
                float(np.linalg.norm(a.p_hat - b.p_hat / self.shrinks(flock, a.q)))
                for a, b in pairs
            ),
            "printed": max(float(np.linalg.norm(a.p_hat - b.p_hat)) for a, b in pairs),
        }

    def find_projections(self, flock: Flock) -> list[Projection]:
        """The agent where the flock's seed puts it down, with its beta agents."""
        rng = np.random.default_rng(flock.seed)
        return [self.ask(flock, *self.random_placement(flock, rng)) for _ in range(self.looks)]

    def random_placement(
        self, flock: Flock, rng: np.random.Generator
    ) -> tuple[np.ndarray, np.ndarray]:
        """A random place beside the obstacle and a random velocity, (2,) each."""
        r = flock.parameters.r  # type: ignore[attr-defined]
        away = rng.uniform(0.5, (1.0 - BORDER) * r)
        angle = rng.uniform(-np.pi, np.pi)
        velocity = rng.uniform(0.5, 2.0) * np.array([np.cos(angle), np.sin(angle)])
        solid = obstacle_of(flock.world, self.beside)
        if self.beside == "disc":
            turn = rng.uniform(-np.pi, np.pi)
            out = np.array([np.cos(turn), np.sin(turn)])
            return np.array(solid.centre) + (solid.radius + away) * out, velocity
        x0, y0, x1, _ = solid.footprint().bounds
        return np.array([rng.uniform(x0, x1), y0 - away]), velocity

    def ask(self, flock: Flock, q: np.ndarray, p: np.ndarray) -> Projection:
        """What the rule makes of an agent at a place (2,) with a velocity (2,).

        Its consensus with the beta agent is c_2 b_ik (p_hat - p), by which p_hat is found.
        """
        speed = float(np.linalg.norm(p))
        flock.position[0], flock.heading[0], flock.speed[0] = q, p / speed, speed
        at = nearest_surface(flock.engine.surroundings, float(q[0]), float(q[1]), 0.0)
        q_hat = np.array([at.x, at.y])
        b = expected_weight(flock, float(np.linalg.norm(q_hat - q)))
        gain = flock.parameters.c2b * b  # type: ignore[attr-defined]
        return Projection(q, p, q_hat, p + flock.inspect(0).forces["beta consensus"] / gain)

    def equations(self, flock: Flock, projection: Projection) -> Projection:
        """The same by (5) for a wall, by (6) for a disc, with numbers of the obstacle's own."""
        solid = obstacle_of(flock.world, self.beside)
        if self.beside == "disc":
            y, mu = np.array(solid.centre), self.shrinks(flock, projection.q)
            a = (projection.q - y) / np.linalg.norm(projection.q - y)
        else:
            _, y0, _, _ = solid.footprint().bounds
            y, mu, a = np.array([0.0, y0]), 1.0, np.array([0.0, -1.0])
        along = np.eye(2) - np.outer(a, a)
        place = (
            mu * projection.q + (1.0 - mu) * y
            if mu < 1.0
            else along @ projection.q + (np.eye(2) - along) @ y
        )
        return Projection(projection.q, projection.p, place, mu * along @ projection.p)

    def shrinks(self, flock: Flock, q: np.ndarray) -> float:
        """mu = R / |q - y| of (6); 1 for a wall."""
        if self.beside == "wall":
            return 1.0
        solid = obstacle_of(flock.world, self.beside)
        return float(solid.radius / np.linalg.norm(q - np.array(solid.centre)))

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """None is run; looking counts as one each."""
        return float(self.looks)


def obstacle_of(world: World, beside: str):
    """The first disc of a world, or the first wall: a box of which one side is looked at."""
    shape = Disc if beside == "disc" else Box
    return next(obstacle for obstacle in world.obstacles if isinstance(obstacle, shape))


def expected_weight(flock: Flock, distance: float) -> float:
    """b_ik = rho_h(|q_hat - q|_sigma / r_alpha) of (10), counted apart from the rule."""
    p = flock.parameters

    def sigma(z: float) -> float:
        return (np.sqrt(1.0 + p.eps * z * z) - 1.0) / p.eps  # type: ignore[attr-defined]

    share = sigma(distance) / sigma(p.r)  # type: ignore[attr-defined]
    h = p.h  # type: ignore[attr-defined]
    return 1.0 if share < h else 0.5 * (1.0 + float(np.cos(np.pi * (share - h) / (1.0 - h))))


ALPHA, BETA, MOVES, PRINTED, REACH = "#2166ac", "#c0392b", "#1f9d63", "#b07d12", "#9aa3ad"
SCALE = 1.6
"""Length of a velocity of 1 m/s, m."""
AWAY = 0.45, 0.75
"""Distance of the agent that is drawn, of r."""


def draw_projections(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw an occasion of the wall and one of the disc, of the rows' flocks of that seed."""
    figure.set_size_inches(12.4, 6.4)
    panels = figure.subplots(1, 2)
    letters = {"wall": ("a", "a wall, (5)"), "disc": ("b", "a disc, (6)")}
    settings = experiment.settings
    assert isinstance(settings, ProjectionSettings)
    for axes, (beside, (letter, words)) in zip(panels, letters.items(), strict=True):
        mine = settings.model_copy(update={"beside": beside})
        flock = flock_of(experiment.cases[0], seed)
        projections = mine.find_projections(flock)
        projection = max(projections, key=lambda each: drawing_score(each, flock, mine))
        draw_one(axes, flock, mine, projection)
        axes.set_title(f"({letter}) {words}", loc="left")
    draw_key(
        figure,
        [
            sign(ALPHA, "agent, q, and its velocity p"),
            sign(BETA, "beta agent, q̂, where the rule has it"),
            stroke(MOVES, "its velocity p̂, from the rule's force"),
            stroke(PRINTED, "as (6) prints it, mu P p", (0, (4, 2))),
            stroke(REACH, "sensing radius r"),
        ],
        f"an agent of {experiment.cases[0].label} put down at random beside the obstacle, seed "
        f"{seed}; the paper's scene has no numbers",
    )


def drawing_score(projection: Projection, flock: Any, settings: ProjectionSettings) -> float:
    """How well an occasion can be drawn: not too near, and its velocity slants to the surface."""
    r = flock.parameters.r
    x0, _, x1, _ = obstacle_of(flock.world, settings.beside).footprint().bounds
    central = abs(projection.q[0] - 0.5 * (x0 + x1)) < (
        2.5 if settings.beside == "wall" else x1 - x0
    )
    away = projection.q - projection.q_hat
    distance = float(np.linalg.norm(away))
    share = float(np.linalg.norm(projection.p_hat) / np.linalg.norm(projection.p))
    heads = float(away @ projection.p) < 0.0
    fits = AWAY[0] * r < distance < AWAY[1] * r and 0.5 < share < 0.85 and heads and central
    return float(fits) * (1.0 + np.linalg.norm(projection.p))


def draw_one(axes: Any, flock: Any, settings: ProjectionSettings, projection: Projection) -> None:
    """Draw an agent with its beta agent."""
    from matplotlib.patches import Circle

    r = flock.parameters.r
    draw_obstacles(axes, flock.world)
    axes.add_patch(
        Circle(
            (projection.q[0], projection.q[1]),
            r,
            fill=False,
            edgecolor=REACH,
            linewidth=1.2,
            zorder=3,
        )
    )
    axes.plot(
        *np.array([projection.q, projection.q_hat]).T,
        color=INK,
        linewidth=1.0,
        linestyle=(0, (3, 3)),
    )
    printed = settings.equations(flock, projection).p_hat
    arrow(axes, projection.q, SCALE * projection.p, ALPHA)
    arrow(axes, projection.q_hat, SCALE * projection.p_hat, MOVES, 2.4)
    if settings.beside == "disc":
        y = np.array(obstacle_of(flock.world, "disc").centre)
        axes.plot(*np.array([projection.q_hat, y]).T, color=INK,
                  linewidth=0.9, linestyle=(0, (1, 2)),
                  zorder=4)  # fmt: skip
        axes.plot(*y, "+", color=INK, markersize=10, zorder=6)
        write_label(axes, y, "$y_k$", shift=(14, -10))
        arrow(axes, projection.q_hat, SCALE * printed, PRINTED, 1.6, 9.0, (0, (4, 2)))
    axes.plot(*projection.q, "o", color=ALPHA, markersize=11, zorder=9, markeredgecolor="white")
    axes.plot(*projection.q_hat, "o", color=BETA, markersize=10, zorder=9, markeredgecolor="white")
    tip = projection.q + SCALE * projection.p
    write_label(axes, tip, "$p_i$", ALPHA, tuple(12.0 * np.sign(projection.p)))
    write_label(axes, projection.q_hat + SCALE * projection.p_hat, "$\\hat p_{i,k}$", MOVES,
         tuple(14.0 * np.sign(projection.p_hat)))  # fmt: skip
    out = (projection.q - projection.q_hat) / np.linalg.norm(projection.q - projection.q_hat)
    write_label(axes, projection.q, "$q_i$", ALPHA, tuple(16.0 * out))
    side = np.array([-out[1], out[0]])
    side *= -np.sign(side @ projection.p_hat)
    write_label(axes, projection.q_hat, "$\\hat q_{i,k}$", BETA, tuple(20.0 * side + 8.0 * out))
    shift, half = (4.0, 1.5 * r) if settings.beside == "disc" else (1.0, 1.25 * r)
    set_square_view(axes, projection.q - shift * out, half)


PICTURES = {"projections": draw_projections}
