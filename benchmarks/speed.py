"""How fast: agent-steps per second, ours and others', in one run.

    uv run --group bench python benchmarks/speed.py [--quick]

Every contestant runs the 2-D Vicsek geometry at density 4 and r = 1 in float64; each figure is the
median of several rounds in which all contestants take turns, so that a drift of the machine's speed
reaches all of them. Mesa's boid flockers run their own rule at the same number of neighbours.
"""

from __future__ import annotations

import argparse
import math
import os
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass

from agents import Flock

DENSITY, R, V0, ETA = 4.0, 1.0, 0.03, 0.3


@dataclass
class Contestant:
    """Something that can run ticks of n agents."""

    name: str
    n: int
    ticks: int
    run: Callable[[int], object]


def ours(n: int, ticks: int, threads: int, label: str) -> Contestant:
    """flockscope, in one compiled call per round."""
    flock = Flock("vem", agents=n, size=math.sqrt(n / DENSITY), r=R, v0=V0, eta=ETA, rng=1,
                  threads=threads)  # fmt: skip
    flock.run(3)
    return Contestant(f"flockscope, {label}", n, ticks, flock.run)


def pyvicsek(n: int, ticks: int) -> Contestant:
    """The package pyvicsek (C++), which has vectorial noise."""
    import vicsek

    side = math.sqrt(n / DENSITY)
    particles = vicsek.initialize_random_particles(
        n_particles=n, box_length=side, speed=V0, n_dimensions=2, seed=0
    )
    model = vicsek.Vicsek(
        particles=particles, length=side, interaction_range=R, speed=V0, noise_factor=ETA
    )

    def run(ticks: int) -> None:
        for _ in range(ticks):
            model.step()

    return Contestant("pyvicsek (C++), 1 thread", n, ticks, run)


def mesa_boids(n: int, ticks: int) -> Contestant:
    """Mesa's own example, with as many neighbours in sight (4 pi)."""
    from mesa.examples.basic.boid_flockers.model import BoidFlockers, BoidsScenario

    side = 10.0 * math.sqrt(n / DENSITY)
    scenario = BoidsScenario(
        population_size=n, width=side, height=side, vision=10.0, speed=0.3, rng=1
    )
    model = BoidFlockers(scenario)

    def run(ticks: int) -> None:
        for _ in range(ticks):
            model.step()

    return Contestant("Mesa's boid flockers", n, ticks, run)


def race(contestants: list[Contestant], rounds: int) -> dict[str, float]:
    """Median agent-steps per second of each, over rounds in which all take turns."""
    rates: dict[str, list[float]] = {c.name: [] for c in contestants}
    for _ in range(rounds):
        for c in contestants:
            begin = time.perf_counter()
            c.run(c.ticks)
            rates[c.name].append(c.n * c.ticks / (time.perf_counter() - begin))
    return {name: statistics.median(values) for name, values in rates.items()}


def main() -> None:
    """Run the race and print it."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--quick", action="store_true", help="fewer and smaller rounds")
    quick = arguments.parse_args().quick
    large = 1_000_000
    contestants = [
        ours(100_000, 60, 1, "100 000 agents, 1 thread"),
        ours(100_000, 60, 2, "100 000 agents, 2 threads"),
        ours(300, 20_000, 1, "300 agents, batch"),
        pyvicsek(100_000, 1),
        mesa_boids(1_000, 1),
    ]
    if not quick:
        contestants[2:2] = [
            ours(large, 3, 1, "1 000 000 agents, 1 thread"),
            ours(large, 3, 2, "1 000 000 agents, 2 threads"),
        ]
    rate = race(contestants, 3 if quick else 9)
    base = rate[contestants[0].name]
    print(f"2-D Vicsek, density {DENSITY:g}, r = {R:g}, float64; {os.cpu_count()} cores")
    print(f"{'':42}{'agent-steps/s':>14}{'ticks/s':>12}{'ratio':>9}")
    for c in contestants:
        ratio = rate[c.name] / base
        print(f"{c.name:42}{rate[c.name]:14,.0f}{rate[c.name] / c.n:12,.1f}{ratio:9.4f}")
    two = rate[contestants[1].name] / base
    print(f"two threads over one, 100 000 agents: {two:.2f}")


if __name__ == "__main__":
    main()
