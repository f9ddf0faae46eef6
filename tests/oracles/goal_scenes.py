"""Small scenes for flocks that seek a goal: a few agents, obstacles that do not touch, a goal."""

import math
from dataclasses import dataclass

import numpy as np
from hypothesis import strategies as st

from agents import Flock
from worlds.mission import Goal, Mission
from worlds.obstacles import obstacle
from worlds.queries.clearance import clearance
from worlds.world import World

SIDE = 20.0
CONVEX = (
    {"shape": "disc", "centre": (5.0, 6.0), "radius": 2.0},
    {"shape": "wall", "start": (12.0, 3.0), "end": (16.0, 6.0), "thickness": 1.0},
    {"shape": "polygon", "points": [(11.0, 12.0), (16.0, 13.0), (12.0, 17.0)]},
)
BALLS = (
    {"shape": "sphere", "centre": (5.0, 6.0, 4.0), "radius": 2.0},
    {"shape": "sphere", "centre": (9.0, 9.0, 12.0), "radius": 3.0},
    {"shape": "sphere", "centre": (14.0, 5.0, 8.0), "radius": 1.0},
)
HOLLOW = {
    "shape": "c",
    "centre": (5.0, 14.0),
    "size": (5.0, 6.0),
    "thickness": 0.8,
    "opening": 200.0,
}


@dataclass(frozen=True)
class GoalScene:
    """Where agents are, how they move, what stands around and where they are to go."""

    position: np.ndarray
    velocity: np.ndarray
    obstacles: tuple
    goal: np.ndarray | None
    """(2, dim), position and velocity."""

    @property
    def dim(self):
        return self.position.shape[1]

    @property
    def world(self):
        """A box with open edges."""
        mission = None
        if self.goal is not None:
            speed = float(np.linalg.norm(self.goal[1]))
            far = self.goal[0] + 1000.0 * self.goal[1]
            route = [self.goal[0]] if speed == 0.0 else [self.goal[0], far]
            points = tuple(tuple(point.tolist()) for point in route)
            mission = Mission(goal=Goal(route=points, speed=speed))
        return World(
            "scene",
            (SIDE,) * self.dim,
            ("open",) * self.dim,
            obstacles=self.obstacles,
            mission=mission,
        )

    def flock(self, model, **parameters):
        """A flock of `model` in this scene."""
        speed = np.linalg.norm(self.velocity, axis=1)
        heading = np.where(
            speed[:, None] > 0.0,
            self.velocity / np.where(speed > 0.0, speed, 1.0)[:, None],
            np.eye(self.dim)[0],
        )
        start = {"position": self.position, "heading": heading, "speed": speed}
        return Flock(model, start=start, world=self.world, rng=1, **parameters)


def goal_scene(seed, agents, dim, hollow, obstacles, goal):
    """A scene drawn from a seed; `goal` is `none`, `static` or `moving`."""
    rng = np.random.default_rng(seed)
    known = BALLS if dim == 3 else (HOLLOW, *CONVEX) if hollow else CONVEX
    standing = tuple(obstacle(values) for values in known[:obstacles])
    low, high = (0.0, 12.0) if obstacles else (5.0, 11.0)
    place = np.zeros((2, dim))
    place[0] = rng.uniform(0.0, SIDE, dim)
    if goal == "moving":
        place[1] = rng.uniform(-2.0, 2.0, dim)
    velocity = rng.uniform(-3.0, 3.0, (agents, dim))
    world = GoalScene(np.empty((0, dim)), velocity, standing, None).world
    position = rng.uniform(low, high, (agents, dim))
    while (inside := clearance(world, position) <= 0.0).any():
        position[inside] = rng.uniform(low, high, (int(inside.sum()), dim))
    return GoalScene(position, velocity, standing, None if goal == "none" else place)


def goal_scenes(dims=(2, 3), hollow=False):
    """Scenes of 1 to 9 agents."""
    return st.builds(
        goal_scene,
        seed=st.integers(0, 2**32 - 1),
        agents=st.integers(1, 9),
        dim=st.sampled_from(dims),
        hollow=st.just(hollow),
        obstacles=st.integers(0, 4 if hollow else 3),
        goal=st.sampled_from(("none", "static", "static", "moving")),
    )


def velocity_of(flock):
    """Velocities of a flock, (N, dim), length per unit of time."""
    return flock.speed[:, None] * flock.heading


def goal_of(flock):
    """The gamma agent at the flock's next tick, (2, dim), or None."""
    goal = flock.world.mission and flock.world.mission.goal
    if not goal:
        return None
    here = flock.goal_at([flock.tick])[0]
    route = np.array(goal.route)
    if len(route) == 1 or goal.speed == 0.0:
        return np.array([here, np.zeros_like(here)])
    way = route[1] - route[0]
    return np.array([here, goal.speed * way / math.hypot(*way)])
