"""What a short run costs beside its ticks: making a flock, a call, a step, and a thousand runs.

    uv run python benchmarks/studies/short_runs.py [--workers 2] [--runs 400]

300 agents of the Vicsek model. Of each figure the least of several rounds, as CPU time and by the
clock: others on the machine make both longer. A run goes from its seed to its polarisation after
100 ticks; runs are shared among worker processes that have compiled already.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from typing import NamedTuple

from agents import Flock

AGENTS, TICKS, ROUNDS = 300, 100, 20


class Cost(NamedTuple):
    """Seconds of one core, and by the clock."""

    cpu: float
    wall: float

    def less(self, other: Cost, share: float) -> Cost:
        """What is left without a share of another cost."""
        return Cost(self.cpu - share * other.cpu, self.wall - share * other.wall)


def least_cost(work: Callable[[], object], times: int) -> Cost:
    """What one call of `work` costs at least, over rounds of so many calls."""
    rounds = []
    for _ in range(ROUNDS):
        cpu, wall = time.process_time(), time.perf_counter()
        for _ in range(times):
            work()
        rounds.append(((time.process_time() - cpu) / times, (time.perf_counter() - wall) / times))
    return Cost(*map(min, zip(*rounds, strict=True)))


def new_flock(seed: int = 1) -> Flock:
    """A flock at tick 0."""
    return Flock("vem", agents=AGENTS, rng=seed)


def calls() -> dict[str, Cost]:
    """What making a flock and calling it cost, by what is done."""
    flock = new_flock()
    flock.run(1)
    tick = least_cost(lambda: flock.run(1), 200)
    long = least_cost(lambda: flock.run(TICKS), 10)
    per_tick = long.less(tick, 1.0)
    return {
        f"making a flock of {AGENTS}": least_cost(new_flock, 20),
        "making it and its first tick": least_cost(lambda: new_flock().run(1), 20),
        "run(1) beside the tick itself": tick.less(per_tick, 1.0 / (TICKS - 1)),
        "run(1)": tick,
        "step() with one observable": least_cost(flock.step, 200),
    }


def results(seeds: Sequence[int]) -> tuple[list[float], float]:
    """What runs of these seeds come to, and the CPU time that they took."""
    started = time.process_time()
    rows = []
    for seed in seeds:
        flock = new_flock(seed)
        flock.run(TICKS)
        rows.append(flock.observe("polarisation"))
    return rows, time.process_time() - started


def sweep(workers: int, runs: int) -> Cost:
    """What a run costs at least where worker processes share many."""
    parts = [range(first, runs, 4 * workers) for first in range(4 * workers)]
    rounds = []
    with ProcessPoolExecutor(workers, get_context("spawn")) as pool:
        list(pool.map(results, [range(1)] * 4 * workers))
        for _ in range(5):
            started = time.perf_counter()
            done = list(pool.map(results, parts))
            wall = time.perf_counter() - started
            rounds.append((sum(cpu for _, cpu in done) / runs, wall / runs))
    return Cost(*map(min, zip(*rounds, strict=True)))


def main() -> None:
    """Print the costs of the calls, then how many runs a second the workers make."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--workers", type=int, default=2, help="worker processes")
    arguments.add_argument("--runs", type=int, default=400, help="runs of a round")
    options = arguments.parse_args()
    print(f"{'':34}{'CPU, us':>10}{'clock, us':>11}")
    for name, cost in calls().items():
        print(f"{name:34}{1e6 * cost.cpu:10.1f}{1e6 * cost.wall:11.1f}")
    run = sweep(options.workers, options.runs)
    print(f"{f'a run of {TICKS} ticks, in a worker':34}{1e6 * run.cpu:10.0f}")
    print(
        f"{options.workers} workers: {1.0 / run.wall:.0f} runs a second by the clock, "
        f"{options.workers / run.cpu:.0f} with a core for each"
    )


if __name__ == "__main__":
    main()
