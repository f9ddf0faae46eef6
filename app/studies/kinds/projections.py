"""An agent put down beside a wall or a disc, and its beta agent: Wu et al. 2023, figure 1."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import Field

from app.studies.kinds.kind_settings import Measure, Number, Settings
from worlds.obstacles import Box, Disc
from worlds.queries.surroundings import nearest_surface

if TYPE_CHECKING:
    from agents import Flock
    from worlds.world import World

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
        found = self.projected(flock)
        expected = [self.equations(flock, one) for one in found]
        normals = [(one.q - one.q_hat) / np.linalg.norm(one.q - one.q_hat) for one in found]
        pairs = list(zip(found, expected, strict=True))
        return {
            "place": max(float(np.linalg.norm(a.q_hat - b.q_hat)) for a, b in pairs),
            "along": max(abs(float(n @ one.p_hat)) for n, one in zip(normals, found, strict=True)),
            "velocity": max(
                float(np.linalg.norm(a.p_hat - b.p_hat / self.shrinks(flock, a.q)))
                for a, b in pairs
            ),
            "printed": max(float(np.linalg.norm(a.p_hat - b.p_hat)) for a, b in pairs),
        }

    def projected(self, flock: Flock) -> list[Projection]:
        """The agent where the flock's seed puts it down, with its beta agents."""
        rng = np.random.default_rng(flock.seed)
        return [self.ask(flock, *self.placed(flock, rng)) for _ in range(self.looks)]

    def placed(self, flock: Flock, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
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
        b = heed(flock, float(np.linalg.norm(q_hat - q)))
        gain = flock.parameters.c2b * b  # type: ignore[attr-defined]
        return Projection(q, p, q_hat, p + flock.inspect(0).forces["beta consensus"] / gain)

    def equations(self, flock: Flock, one: Projection) -> Projection:
        """The same by (5) for a wall, by (6) for a disc, with numbers of the obstacle's own."""
        solid = obstacle_of(flock.world, self.beside)
        if self.beside == "disc":
            y, mu = np.array(solid.centre), self.shrinks(flock, one.q)
            a = (one.q - y) / np.linalg.norm(one.q - y)
        else:
            _, y0, _, _ = solid.footprint().bounds
            y, mu, a = np.array([0.0, y0]), 1.0, np.array([0.0, -1.0])
        along = np.eye(2) - np.outer(a, a)
        place = mu * one.q + (1.0 - mu) * y if mu < 1.0 else along @ one.q + (np.eye(2) - along) @ y
        return Projection(one.q, one.p, place, mu * along @ one.p)

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
    return next(one for one in world.obstacles if isinstance(one, shape))


def heed(flock: Flock, distance: float) -> float:
    """b_ik = rho_h(|q_hat - q|_sigma / r_alpha) of (10), counted apart from the rule."""
    p = flock.parameters

    def sigma(z: float) -> float:
        return (np.sqrt(1.0 + p.eps * z * z) - 1.0) / p.eps  # type: ignore[attr-defined]

    share = sigma(distance) / sigma(p.r)  # type: ignore[attr-defined]
    h = p.h  # type: ignore[attr-defined]
    return 1.0 if share < h else 0.5 * (1.0 + float(np.cos(np.pi * (share - h) / (1.0 - h))))
