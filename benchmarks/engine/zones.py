"""Zones in three dimensions: agent-steps a second, and the run of the thesis in seconds.

    uv run python benchmarks/engine/zones.py [--quick] [--agents 100000]

Ratios are to the first line. "Widths of the thesis" are Couzin's zones of the radii and the density
of the thesis; "measured" is with the formation figure in the same pass. Each figure is the best of
several rounds, without the time to compile.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import replace
from typing import Any

from turns import Contestant, flight_of, take_turns

from agents import Flock, catalogue
from agents.bodies.flyer import FLYER
from agents.models.model import Model
from agents.rules.zones import ZONES

TICKS = 5
LIKE_THE_THESIS = {"r_r": 1.34, "dr_o": 1.16, "dr_a": 2.5}
BLIND = Model(ZONES, replace(FLYER, measures=(), measure=None), suffix="-unmeasured", dim=3)
"""The thesis's model without the formation figure."""


def side(agents: int, per: float, box: float) -> float:
    """Side of a cube with the density of `per` agents in a cube of side `box`."""
    return box * (agents / per) ** (1.0 / 3.0)


def contestants(agents: int) -> list[tuple[str, str, int, dict[str, Any]]]:
    """Title, model, threads and how its flock is made."""
    thesis = {"size": side(agents, 50, 24.0)}
    couzin = {"size": side(agents, 100, 40.0)}
    return [
        ("couzin, widths of the thesis", "couzin", 1, thesis | LIKE_THE_THESIS),
        ("couzin, widths of the thesis", "couzin", 2, thesis | LIKE_THE_THESIS),
        ("couzin, its own widths", "couzin", 1, couzin),
        ("couzin, its own widths", "couzin", 2, couzin),
        ("thesis, not measured", BLIND.name, 1, thesis | {"world": "thesis-sky"}),
        ("thesis, measured", "thesis", 1, thesis),
        ("safe, measured", "safe", 1, thesis),
    ]


def race_contestants(agents: int, rounds: int) -> list[tuple[str, int, float]]:
    """Title, threads and agent-steps a second, the best of `rounds`, of all contestants."""
    rivals = contestants(agents)
    turns = []
    for title, model, threads, rival in rivals:
        flock = Flock(model, agents=agents, dim=3, threads=threads, rng=1, **rival)
        turns.append(Contestant(title, agents, TICKS, flight_of(flock)))
    take_turns(turns, rounds, "zones")
    return [
        (title, threads, 1e9 / rival.least("wall"))
        for (title, _, threads, _), rival in zip(rivals, turns, strict=True)
    ]


def thesis_run(model: str, rounds: int) -> float:
    """Seconds that 50 agents take for 3 000 ticks, the least of `rounds`."""
    least = float("inf")
    for seed in range(rounds):
        flock = Flock(model, rng=seed)
        flock.run(1)
        begin = time.perf_counter()
        flock.run(2999)
        least = min(least, time.perf_counter() - begin)
    return least


def main() -> None:
    """Run each and print it."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--quick", action="store_true", help="fewer rounds")
    arguments.add_argument("--agents", type=int, default=100_000)
    options = arguments.parse_args()
    rounds = 2 if options.quick else 7
    catalogue.MODELS[BLIND.name] = BLIND
    print(f"{options.agents} agents in three dimensions, best of {rounds} rounds")
    rates = race_contestants(options.agents, rounds)
    first = rates[0][2]
    for title, threads, steps in rates:
        print(f"{title:30}{threads} thread(s){steps / 1e6:8.2f} M/s{steps / first:8.2f}")
    for model in ("thesis", "safe"):
        seconds = thesis_run(model, rounds)
        print(f"{model}: 50 agents, 3 000 ticks{seconds:8.3f} s")


if __name__ == "__main__":
    main()
