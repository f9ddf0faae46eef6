"""Who runs the 2-D Vicsek geometry: flockscope, pyvicsek, C++ by hand; and Mesa's boids.

All begin each round from the same random start, flockscope's own, whose rows are numbered along
space, at density 4 with r = 1 in float64. Making them is not timed, nor is flockscope's first tick,
which meets its memory for the first time. pyvicsek's noise is vectorial, the others' angular;
Mesa's boids run their own rule at the same number of neighbours.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable

import numpy as np
from reference import COMPILER, reference
from turns import Contestant, Taken, clocked

from agents import Flock

DENSITY, R, V0, ETA = 4.0, 1.0, 0.03, 0.3


def side(n: int, density: float = DENSITY) -> float:
    """Side of the square of n agents."""
    return math.sqrt(n / density)


def flock(n: int, density: float, threads: int = 1) -> Flock:
    """flockscope's own, at its start."""
    size = side(n, density)
    return Flock("vem", agents=n, size=size, r=R, v0=V0, eta=ETA, rng=1, threads=threads)


def start(n: int, density: float) -> tuple[np.ndarray, np.ndarray]:
    """Where all begin: positions and headings, (n, 2) each."""
    made = flock(n, density)
    return made.position.copy(), made.heading.copy()


def left_out(name: str, why: str) -> None:
    """Say that somebody does not take part."""
    print(f"{name} is left out: {why}", file=sys.stderr)


def ours(n: int, ticks: int, threads: int = 1, density: float = DENSITY) -> Contestant:
    """flockscope, in one compiled call per round."""

    def turn() -> Taken:
        made = flock(n, density, threads)
        made.run(1)
        return clocked(lambda: made.run(ticks))

    return Contestant("flockscope", n * ticks, turn)


def by_hand(n: int, ticks: int, density: float = DENSITY) -> list[Contestant]:
    """`vicsek.cpp`, in one call per round; nobody without a compiler."""
    run = reference()
    if run is None:
        left_out("C++ by hand", f"there is no {COMPILER}; CXX names another compiler")
        return []
    position, heading = start(n, density)

    def turn() -> Taken:
        columns = [np.ascontiguousarray(one) for one in (*position.T, *heading.T)]
        return clocked(lambda: run(n, side(n, density), R, V0, ETA, 1, ticks, *columns))

    return [Contestant("C++ by hand, half stencil", n * ticks, turn)]


def pyvicsek(n: int, ticks: int, density: float = DENSITY) -> list[Contestant]:
    """The package pyvicsek, whose kernel is C++; nobody if it is not installed."""
    try:
        import vicsek
    except ImportError:
        left_out("pyvicsek", "it is not installed, `uv run --group bench` brings it")
        return []
    model = vicsek.Vicsek(
        particles=vicsek.initialize_random_particles(n, side(n, density), V0, 2),
        length=side(n, density), interaction_range=R, speed=V0, noise_factor=ETA,
    )  # fmt: skip
    position, heading = start(n, density)

    def turn() -> Taken:
        model.positions, model.velocities = position, V0 * heading
        return clocked(repeated(model.step, ticks))

    return [Contestant("pyvicsek (C++)", n * ticks, turn)]


def mesa_boids(n: int, ticks: int, density: float = DENSITY) -> Contestant:
    """Mesa's own example, at a vision of 10 in a square as many times larger."""
    from mesa.examples.basic.boid_flockers.model import BoidFlockers, BoidsScenario

    length = 10.0 * side(n, density)

    def turn() -> Taken:
        scenario = BoidsScenario(
            population_size=n, width=length, height=length, vision=10.0, speed=0.3, rng=1
        )
        return clocked(repeated(BoidFlockers(scenario).step, ticks))

    return Contestant("Mesa's boid flockers", n * ticks, turn)


def repeated(step: Callable[[], object], ticks: int) -> Callable[[], None]:
    """So many steps."""

    def run() -> None:
        for _ in range(ticks):
            step()

    return run
