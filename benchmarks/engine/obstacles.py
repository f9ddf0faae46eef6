"""Obstacles: how long a survey takes, and how many questions a second its surroundings answers.

uv run python benchmarks/engine/obstacles.py [--edges 10000] [--reach 6]
"""

from __future__ import annotations

import argparse
import math
import time

import numpy as np

from worlds.compilation import entry
from worlds.obstacles import Disc, Wall
from worlds.queries.surroundings import Surroundings, line_of_sight, nearest_surface, points_within
from worlds.queries.survey import survey_world
from worlds.shape import SEGMENTS
from worlds.world import World

SIDE = 100.0
REPEATS = 5


@entry
def surfaces(surroundings, place, _):
    """The sum of all nearest distances that are finite, so that none is left out."""
    total = 0.0
    for i in range(place.shape[0]):
        at = nearest_surface(surroundings, place[i, 0], place[i, 1], 0.0)
        total += at.distance if at.distance < math.inf else 0.0
    return total


@entry
def sights(surroundings, place, _):
    """How many places see the next one."""
    total = 0.0
    for i in range(place.shape[0] - 1):
        a, b = place[i], place[i + 1]
        total += line_of_sight(surroundings, a[0], a[1], 0.0, b[0], b[1], 0.0)
    return total


@entry
def points(surroundings, place, found):
    """How many boundary points are within reach of the places."""
    total = 0.0
    for i in range(place.shape[0]):
        total += points_within(surroundings, place[i, 0], place[i, 1], surroundings.reach, found)
    return total


def yard(edges: int, rng: np.random.Generator) -> World:
    """A square with about so many edges of obstacles: half of them discs, half walls."""
    discs = [
        Disc(centre=(float(x), float(y)), radius=float(r))
        for x, y, r in rng.uniform((0, 0, 0.3), (SIDE, SIDE, 2.0), (edges // 2 // SEGMENTS, 3))
    ]
    walls = [
        Wall(start=(float(x), float(y)), end=(float(x + u), float(y + v)), thickness=0.2)
        for x, y, u, v in rng.uniform((0, 0, -2, -2), (SIDE, SIDE, 2, 2), (edges // 2 // 4, 4))
    ]
    return World("yard", (SIDE, SIDE), ("solid", "solid"), obstacles=(*discs, *walls))


def rate(question, surroundings: Surroundings, place: np.ndarray) -> float:
    """Questions per second, the best of some rounds."""
    buffer = np.empty(surroundings.most_points, np.int32)
    question(surroundings, place[:2], buffer)
    seconds = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        question(surroundings, place, buffer)
        seconds.append(time.perf_counter() - start)
    return len(place) / min(seconds)


def main() -> None:
    """Survey a yard, ask from everywhere, print."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--edges", type=int, default=10_000)
    arguments.add_argument("--reach", type=float, default=6.0)
    options = arguments.parse_args()
    rng = np.random.default_rng(1)
    world = yard(options.edges, rng)
    seconds = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        surroundings = survey_world(world, options.reach)
        seconds.append(time.perf_counter() - start)
    print(
        f"{len(surroundings.edge):,} edges of {len(surroundings.span):,} outlines, "
        f"{len(surroundings.point_x):,} boundary points, reach {options.reach:g}"
    )
    print(f"survey: {min(seconds):.3f} s")
    place = rng.uniform(0.0, SIDE, (100_000, 2))
    near = place + rng.uniform(-options.reach, options.reach, place.shape)
    pairs = np.stack([place, near], axis=1).reshape(-1, 2)
    for name, question, where in (
        ("nearest surfaces", surfaces, place),
        ("lines of sight", sights, pairs),
        ("boundary points within reach", points, place),
    ):
        print(f"{name}: {rate(question, surroundings, where) / 1e6:.2f} million a second")


if __name__ == "__main__":
    main()
