"""How fast: agent-steps per second, ours and others', in one run.

    uv run --group bench python benchmarks/engine/speed.py [--quick]

The 2-D Vicsek geometry at density 4 and r = 1 in float64. Everybody takes turns, and begins each
round from the same start. One thread is measured by its CPU time, two by the clock on the wall, and
a ratio of the two by the wall.
"""

from __future__ import annotations

import argparse
import os
from dataclasses import dataclass

from contestants import DENSITY, PEERS, R, mesa_boids, own_flight, own_flights
from turns import Contestant, Flight, take_turns

BATCH, BOIDS = 300, 1_000
"""Agents of a small flock whose ticks are short, and of Mesa's."""
SLOWER = 50
"""How many times fewer agent-steps Mesa's boids make in a round: they would take hours."""
SHORTEST = 5
"""Ticks of a round at least, of the largest flock."""


@dataclass(frozen=True)
class Row:
    """A line of the table."""

    contestant: Contestant
    threads: int = 1

    @property
    def clock(self) -> str:
        """What it is measured by."""
        return "cpu" if self.threads == 1 else "wall"

    def __str__(self) -> str:
        who = self.contestant
        least, median = who.least(self.clock), who.median(self.clock)
        return (
            f"{who.name:24}{who.agents:11,}{self.threads:9}{least:12.1f}{median:10.1f}"
            f"{1e9 / median:14,.0f}{1e9 / median / who.agents:12,.1f}"
        )


def ratio(title: str, fast: Row, slow: Row) -> str:
    """How many times as fast as another, a line; by the wall unless both have one thread."""
    clock = "cpu" if fast.clock == slow.clock == "cpu" else "wall"
    median = slow.contestant.median(clock) / fast.contestant.median(clock)
    least = slow.contestant.least(clock) / fast.contestant.least(clock)
    return f"{title:66}{clock:5}{median:9.2f}{least:9.2f}"


def main() -> None:
    """Run the race and print it."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--quick", action="store_true", help="fewer rounds, no largest flock")
    arguments.add_argument("--agents", type=int, default=100_000, help="the flock in the middle")
    arguments.add_argument("--rounds", type=int, help="9, or 3 of --quick")
    arguments.add_argument("--steps", type=int, default=2_000_000, help="agent-steps of a round")
    options = arguments.parse_args()
    middle, small, large = options.agents, options.agents // 10, 10 * options.agents

    def row(name: str, flight: Flight, agents: int, threads: int = 1) -> Row:
        steps = options.steps // SLOWER if agents == BOIDS else options.steps
        ticks = max(SHORTEST, steps // agents)
        return Row(Contestant(name, agents, ticks, flight), threads)

    def ourselves(agents: int, threads: int = 1) -> Row:
        return row("flockscope", own_flight(agents, threads=threads), agents, threads)

    one, two = ourselves(middle), ourselves(middle, 2)
    small_one, small_two = ourselves(small), ourselves(small, 2)
    twice = row("flockscope, two runs", own_flights(middle), 2 * middle, 2)
    larges = [] if options.quick else [ourselves(large), ourselves(large, 2)]
    peers = {
        name: row(name, flight, agents)
        for name, make in PEERS.items()
        for agents in (BOIDS if make is mesa_boids else middle,)
        if (flight := make(agents))
    }
    rows = [one, two, twice, small_one, small_two, *larges, ourselves(BATCH), *peers.values()]
    take_turns(
        [row.contestant for row in rows], options.rounds or (3 if options.quick else 9), "race"
    )

    print(f"2-D Vicsek, density {DENSITY:g}, r = {R:g}, float64; {os.cpu_count()} cores")
    print(f"{'':44}{'ns per agent-step':>22}{'agent-steps/s':>14}{'ticks/s':>12}")
    print(f"{'':24}{'agents':>11}{'threads':>9}{'least':>12}{'median':>10}{'(median)':>14}")
    print("\n".join(str(row) for row in rows))
    print(f"\n{'how many times as fast':66}{'clock':5}{'median':>9}{'least':>9}")
    print(ratio(f"two threads over one, {small:,} agents", small_two, small_one))
    print(ratio(f"two threads over one, {middle:,} agents", two, one))
    print(ratio(f"two runs at once over one, {middle:,} agents each", twice, one))
    for name, peer in peers.items():
        at = f"{name} at {peer.contestant.agents:,}"
        print(ratio(f"one thread, {middle:,} agents, over {at}", one, peer))
        if larges:
            print(ratio(f"two threads, {large:,} agents, over {at}", larges[1], peer))


if __name__ == "__main__":
    main()
