"""Who runs the 2-D Vicsek geometry: flockscope, pyvicsek, C++ by hand; and Mesa's boids.

All begin each round from the same random start, flockscope's own, whose rows are numbered along
space, at density 4 with r = 1 in float64. Making them is not timed, nor is flockscope's first tick,
which meets its memory for the first time. pyvicsek's noise is vectorial, the others' angular;
Mesa's boids run their own rule at the same number of neighbours.
"""

from __future__ import annotations

import functools
import math
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from types import ModuleType

import numpy as np
from reference import COMPILER, reference
from turns import Flight, Taken, time_work

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
    state = flock(n, density)
    return state.position.copy(), state.heading.copy()


def own_flight(n: int, density: float = DENSITY, threads: int = 1) -> Flight:
    """flockscope, in one compiled call per round."""

    def fly(ticks: int) -> Taken:
        state = flock(n, density, threads)
        state.run(1)
        return time_work(lambda: state.run(ticks))

    return fly


def own_flights(n: int, density: float = DENSITY) -> Flight:
    """Two of our flocks of n agents that run at once, each with one thread."""

    def fly(ticks: int) -> Taken:
        two = [flock(n, density) for _ in range(2)]
        for rival in two:
            rival.run(1)
        with ThreadPoolExecutor(2) as pool:
            return time_work(lambda: list(pool.map(lambda rival: rival.run(ticks), two)))

    return fly


@functools.cache
def compile_cpp() -> Callable[..., None] | None:
    """`vicsek.cpp`, compiled once; None, with a word, without a compiler."""
    run = reference()
    if run is None:
        print(f"C++ is left out: no {COMPILER}; CXX names another compiler", file=sys.stderr)
    return run


def cpp_flight(n: int, density: float = DENSITY) -> Flight | None:
    """`vicsek.cpp`, in one call per round; None without a compiler."""
    run = compile_cpp()
    if run is None:
        return None
    position, heading = start(n, density)

    def fly(ticks: int) -> Taken:
        columns = [np.ascontiguousarray(column) for column in (*position.T, *heading.T)]
        return time_work(lambda: run(n, side(n, density), R, V0, ETA, 1, ticks, *columns))

    return fly


@functools.cache
def pyvicsek_or_not() -> ModuleType | None:
    """The package pyvicsek, None, with a word, if it is not installed."""
    try:
        import vicsek
    except ImportError:
        print("pyvicsek is left out: `uv run --group bench` installs it", file=sys.stderr)
        return None
    return vicsek


def pyvicsek(n: int, density: float = DENSITY) -> Flight | None:
    """The package pyvicsek, whose kernel is C++; None if it is not installed."""
    vicsek = pyvicsek_or_not()
    if vicsek is None:
        return None
    model = vicsek.Vicsek(
        particles=vicsek.initialize_random_particles(n, side(n, density), V0, 2),
        length=side(n, density), interaction_range=R, speed=V0, noise_factor=ETA,
    )  # fmt: skip
    position, heading = start(n, density)

    def fly(ticks: int) -> Taken:
        model.positions, model.velocities = position, V0 * heading
        return time_work(lambda: repeat(model.step, ticks))

    return fly


def mesa_boids(n: int, density: float = DENSITY) -> Flight:
    """Mesa's own example, at a vision of 10 in a square as many times larger."""
    from mesa.examples.basic.boid_flockers.model import BoidFlockers, BoidsScenario

    length = 10.0 * side(n, density)

    def fly(ticks: int) -> Taken:
        scenario = BoidsScenario(
            population_size=n, width=length, height=length, vision=10.0, speed=0.3, rng=1
        )
        model = BoidFlockers(scenario)
        return time_work(lambda: repeat(model.step, ticks))

    return fly


def repeat(step: Callable[[], object], ticks: int) -> None:
    """So many steps."""
    for _ in range(ticks):
        step()


PEERS = {
    "C++ by hand": cpp_flight,
    "pyvicsek (C++)": pyvicsek,
    "Mesa's boid flockers": mesa_boids,
}
"""The others, by name: made from a number of agents and a density, or None."""
