"""How fast flocks find their way: a run of 300 s of Wu et al. 2023, in seconds on one core.

    uv run python benchmarks/engine/navigators.py [--quick]

Each figure is the least of several runs from the start, without the time to compile. A tick is one
look and one decision of every agent; there are n_sub of them in the paper's step of 0.1 s.
"""

from __future__ import annotations

import argparse
import time

from agents import Flock

SPAN = 300.0
"""Seconds that each run stands for, as in the paper."""
CONTESTANTS = (
    ("boundary-points", "wu2023-multi", 60, 5.0),
    ("boundary-points", "wu2023-multi", 60, 1.0),
    ("boundary-points", "wu2023-multi", 30, 5.0),
    ("boundary-points", "wu2023-independent", 30, 5.0),
    ("olfati-saber", "wu2023-independent", 30, 5.0),
)


def least_time(model: str, world: str, agents: int, n_sub: float, rounds: int) -> tuple[float, int]:
    """Seconds that a run takes, the least of `rounds`, and its ticks."""
    least, ticks = float("inf"), 0
    for _ in range(rounds):
        flock = Flock(model, agents=agents, world=world, rng=1, n_sub=n_sub)
        flock.run(1)
        ticks = round(SPAN / flock.dt) - 1
        begin = time.perf_counter()
        flock.run(ticks)
        least = min(least, time.perf_counter() - begin)
    return least, ticks


def main() -> None:
    """Run each and print it."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--quick", action="store_true", help="fewer rounds")
    rounds = 2 if arguments.parse_args().quick else 7
    print(f"{SPAN:g} s on one core, least of {rounds} runs")
    print(f"{'model':18}{'world':22}{'agents':>7}{'n_sub':>7}{'seconds':>10}{'us/tick':>10}")
    for model, world, agents, n_sub in CONTESTANTS:
        seconds, ticks = least_time(model, world, agents, n_sub, rounds)
        per_tick = 1e6 * seconds / ticks
        print(f"{model:18}{world:22}{agents:7}{n_sub:7g}{seconds:10.3f}{per_tick:10.1f}")


if __name__ == "__main__":
    main()
