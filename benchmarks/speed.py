"""How fast: agent-steps per second, ours and others', in one run.

    uv run --group bench python benchmarks/speed.py [--quick]

The 2-D Vicsek geometry at density 4 and r = 1 in float64. Everybody takes turns, and begins each
round from the same start. One thread is measured by its CPU time, two by the clock on the wall, and
a ratio of the two by the wall.
"""

from __future__ import annotations

import argparse
import os
from dataclasses import dataclass

from contestants import DENSITY, R, by_hand, mesa_boids, ours, pyvicsek
from turns import Contestant, take_turns

BATCH, BOIDS = 300, 1_000
SHORTEST = 5
"""Ticks of a round at least, of the largest flock."""


@dataclass(frozen=True)
class Row:
    """A line of the table."""

    contestant: Contestant
    agents: int
    threads: int = 1

    @property
    def clock(self) -> str:
        """What it is measured by."""
        return "cpu" if self.threads == 1 else "wall"

    def __str__(self) -> str:
        least, median = (
            getattr(self.contestant, which)(self.clock) for which in ("least", "median")
        )
        return (
            f"{self.contestant.name:26}{self.agents:11,}{self.threads:9}{1e9 * least:12.1f}"
            f"{1e9 * median:10.1f}{1.0 / median:14,.0f}{1.0 / median / self.agents:12,.1f}"
        )


def ratio(title: str, fast: Row, slow: Row) -> str:
    """How many times as fast as another, a line; by the wall unless both have one thread."""
    clock = "cpu" if fast.clock == slow.clock == "cpu" else "wall"
    median = slow.contestant.median(clock) / fast.contestant.median(clock)
    least = slow.contestant.least(clock) / fast.contestant.least(clock)
    return f"{title:62}{clock:5}{median:9.2f}{least:9.2f}"


def main() -> None:
    """Run the race and print it."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--quick", action="store_true", help="fewer rounds, no largest flock")
    arguments.add_argument("--agents", type=int, default=100_000, help="the flock in the middle")
    arguments.add_argument("--rounds", type=int, help="9, or 3 of --quick")
    arguments.add_argument("--steps", type=int, default=2_000_000, help="agent-steps of a round")
    given = arguments.parse_args()

    def flown(agents: int, threads: int = 1) -> Row:
        ticks = max(SHORTEST, given.steps // agents)
        return Row(ours(agents, ticks, threads), agents, threads)

    middle, small, large = given.agents, given.agents // 10, 10 * given.agents
    ticks = max(SHORTEST, given.steps // middle)
    peers = [Row(one, middle) for one in pyvicsek(middle, ticks)]
    hands = [Row(one, middle) for one in by_hand(middle, ticks)]
    one, two = flown(middle), flown(middle, 2)
    small_one, small_two = flown(small), flown(small, 2)
    larges = [] if given.quick else [flown(large), flown(large, 2)]
    boids = Row(mesa_boids(BOIDS, 1), BOIDS)
    rows = [one, two, small_one, small_two, *larges, flown(BATCH), *hands, *peers, boids]
    take_turns([row.contestant for row in rows], given.rounds or (3 if given.quick else 9))

    print(f"2-D Vicsek, density {DENSITY:g}, r = {R:g}, float64; {os.cpu_count()} cores")
    print(f"{'':26}{'':11}{'':9}{'ns per agent-step':>22}{'agent-steps/s':>14}{'ticks/s':>12}")
    print(f"{'':26}{'agents':>11}{'threads':>9}{'least':>12}{'median':>10}{'(median)':>14}")
    print("\n".join(str(row) for row in rows))
    print(f"\n{'how many times as fast':62}{'clock':5}{'median':>9}{'least':>9}")
    ratios = [
        *(ratio(f"one thread over pyvicsek, {middle:,} agents", one, row) for row in peers),
        *(ratio(f"one thread over C++ by hand, {middle:,} agents", one, row) for row in hands),
        ratio(f"two threads over one, {small:,} agents", small_two, small_one),
        ratio(f"two threads over one, {middle:,} agents", two, one),
        *(
            ratio(f"two threads, {large:,} agents, over pyvicsek at {middle:,}", larges[1], row)
            for row in peers
            if larges
        ),
    ]
    print("\n".join(ratios))


if __name__ == "__main__":
    main()
