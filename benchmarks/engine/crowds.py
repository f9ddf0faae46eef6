"""Large flocks among many obstacles: what the obstacles cost, and how many ticks a second are left.

    uv run python benchmarks/engine/crowds.py

Each figure is the median of several rounds in which all contestants take turns.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from turns import Contestant, flight_of, take_turns

from agents import Flock
from worlds.generators import generate
from worlds.mission import Goal, Mission
from worlds.obstacles import Disc
from worlds.world import World

ROUNDS = 7


def grove_in_square(side: float, discs: int, radius: float) -> World:
    """An open square with a regular grove of discs, each of 128 edges."""
    rows = math.isqrt(discs - 1) + 1
    gap = side / rows
    centres = [((k % rows + 0.5) * gap, (k // rows + 0.5) * gap) for k in range(discs)]
    grove = tuple(Disc(centre=centre, radius=radius) for centre in centres)
    return World("grove", (side, side), ("open", "open"), obstacles=grove)


def scattered_start(world: World, agents: int) -> dict[str, np.ndarray]:
    """A start spread evenly over the free part of a world."""
    flock = Flock("vem", agents=agents, world=world, rng=1)
    return {"position": flock.position.copy(), "heading": flock.heading.copy()}


def tick_times(flocks: dict[str, Flock], ticks: int) -> dict[str, float]:
    """Median seconds of a tick of each flock."""
    turns = [Contestant(name, 1, ticks, flight_of(flock)) for name, flock in flocks.items()]
    take_turns(turns, ROUNDS)
    return {turn.name: 1e-9 * turn.median("wall") for turn in turns}


def price_of_obstacles() -> None:
    """1 000 navigating UAVs, among 10 000 edges and in the open plane."""
    world = grove_in_square(side=40.0, discs=80, radius=1.0)
    start = scattered_start(world, 1000)
    empty = dataclasses.replace(world, name="plain", obstacles=())
    times = tick_times(
        {
            "among 10 240 edges": Flock("hwvem-nav", start=start, world=world, rng=1),
            "in the open plane": Flock("hwvem-nav", start=start, world=empty, rng=1),
        },
        40,
    )
    for name, seconds in times.items():
        print(f"1 000 agents of hwvem-nav {name}: {1e6 * seconds:.0f} us a tick")
    among, free = times.values()
    print(f"what the obstacles add: {among / free - 1.0:+.0%} (target: at most +50 %)\n")


def large_crowd() -> None:
    """10 000 boundary-point agents among 1 000 obstacles."""
    discs = generate(
        "discs", 1, (1200.0, 1200.0), edges="open", count=1000, radius_low=2.0, radius_high=5.0
    )
    mission = Mission(goal=Goal(route=((1250.0, 600.0),)))
    world = dataclasses.replace(discs, mission=mission)
    start = scattered_start(world, 10_000)
    flocks = {
        f"n_sub = {n_sub}": Flock("boundary-points", start=start, world=world, rng=1, n_sub=n_sub)
        for n_sub in (1, 5)
    }
    for name, seconds in tick_times(flocks, 10).items():
        n_sub = int(name[-1])
        print(
            f"10 000 agents of boundary-points among 1 000 obstacles, {name}: "
            f"{1.0 / seconds:.1f} ticks/s, {1.0 / (n_sub * seconds):.1f} steps of 0.1 s a second"
        )


def main() -> None:
    """Run both and print them."""
    price_of_obstacles()
    large_crowd()


if __name__ == "__main__":
    main()
