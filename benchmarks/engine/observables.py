"""What each observable costs, of 10 000 agents in the plane, in space and in a crowd.

    uv run python benchmarks/engine/observables.py

Each figure is the median of several measurements, in milliseconds.
"""

from __future__ import annotations

import statistics
import time

from agents import Flock
from agents.observables.catalogue import OBSERVABLES

ROUNDS = 3
AGENTS = 10_000
FLOCKS = {
    "plane": {"model": "vem", "eta": 3.0},
    "space": {"model": "vem", "eta": 3.0, "dim": 3},
    "crowd": {"model": "couzin", "dr_o": 4.0, "dr_a": 4.0},
}


def milliseconds(flock: Flock, name: str) -> float:
    """Median time of observing a flock, once what is compiled is there."""
    flock.observe(name)
    times = []
    for _ in range(ROUNDS):
        started = time.perf_counter()
        flock.observe(name)
        times.append(time.perf_counter() - started)
    return 1000.0 * statistics.median(times)


def main() -> None:
    """Print a row for each observable."""
    flocks = {name: Flock(agents=AGENTS, rng=1, **settings) for name, settings in FLOCKS.items()}
    for flock in flocks.values():
        flock.run(20)
    print(f"{'':24}" + "".join(f"{name:>10}" for name in flocks))
    neighbours = "".join(f"{flock.observe('mean-neighbours'):>10.1f}" for flock in flocks.values())
    print(f"{'neighbours within r':24}{neighbours}")
    for observable in OBSERVABLES.values():
        if observable.over is None:
            times = "".join(
                f"{milliseconds(flock, observable.name):>10.1f}" for flock in flocks.values()
            )
            print(f"{observable.name:24}{times}")


if __name__ == "__main__":
    main()
