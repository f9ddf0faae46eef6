"""What ranks cost and gain, and what very large flocks need of a cluster.

    uv run python benchmarks/engine/ranks.py [--agents 1000000] [--quick]

A flock of vem at density 4 in one process and in two ranks take turns; the bits are compared. CPU
time is that of all processes, without what it takes to begin them. The needs are computed, by the
formulas of `Needs`.
"""

from __future__ import annotations

import argparse
import math
import time
from dataclasses import dataclass

import numpy as np
from turns import Contestant, Flight, Taken, flight_of, take_turns

from agents import Flock
from agents.strips.strip_engine import EXCHANGE

DENSITY, R, V0 = 4.0, 1.0, 0.03
MESSAGE = 8 + 8 * 2 + 8 * 2 + 8 + 1 + 8 + 4
"""Bytes of an agent that is sent: row, position, heading, speed, informed, id, leg; in a plane."""
HELD = MESSAGE + 8 * 4 + 4 * 3
"""Bytes of an agent of a rank: that, and its sorted copy."""
MERGED = 2 * MESSAGE
"""Bytes of an agent more, while ghosts are merged."""
CELL = 8
"""Bytes of a cell. Each rank lays those of the whole box."""
SIZES = ((100_000_000, 16), (1_000_000_000, 100))


@dataclass(frozen=True)
class Needs:
    """What a flock of vem needs of a cluster, in strips of equal width."""

    agents: int
    ranks: int

    @property
    def side(self) -> float:
        """Of the box, length."""
        return math.sqrt(self.agents / DENSITY)

    @property
    def together(self) -> int:
        """Ticks between two exchanges, as `StripEngine.ticks_together` has them."""
        wider = 2.0 * (R + 2.0 * V0)
        return max(1, int(math.sqrt(EXCHANGE * self.side / self.ranks / wider)))

    @property
    def ghosts(self) -> float:
        """Of a rank: both sides times cell and halo times height times density."""
        halo = (self.together - 1) * (R + 2.0 * V0)
        return 2.0 * (R + halo) * self.side * DENSITY

    @property
    def traffic(self) -> float:
        """Bytes that a rank sends in a tick."""
        return self.ghosts * MESSAGE / self.together

    @property
    def memory(self) -> float:
        """Bytes of a rank at most."""
        rows = self.agents / self.ranks + self.ghosts
        return rows * (HELD + MERGED) + CELL * self.agents / DENSITY

    @property
    def first(self) -> float:
        """Bytes of the process that begins the run, while it sends: all rows, twice."""
        return 2.0 * MESSAGE * self.agents

    def line(self) -> str:
        """A line of the table."""
        share = self.ghosts * self.ranks / self.agents
        return (
            f"{self.agents:>14,}{self.ranks:>7}{self.together:>7}{share:>9.0%}"
            f"{1e-6 * self.traffic:>10.1f} MB{1e-9 * self.memory:>9.1f} GB"
            f"{1e-9 * self.first:>9.0f} GB"
        )


HEADER = (
    f"{'agents':>14}{'ranks':>7}{'ticks':>7}{'ghosts':>9}{'sent a tick':>13}{'a rank':>12}"
    f"{'the first':>12}"
)


def flock(agents: int, ranks: int) -> Flock:
    """A flock at density 4."""
    size = math.sqrt(agents / DENSITY)
    return Flock("vem", agents=agents, size=size, r=R, v0=V0, eta=0.3, rng=1, ranks=ranks)


def flight_of_ranks(shared: Flock) -> Flight:
    """A flock in ranks, whose CPU time is that of all its processes."""

    def spent() -> float:
        return time.process_time() + sum(shared.processes.client.run(time.process_time).values())

    def fly(ticks: int) -> Taken:
        cpu, wall = spent(), time.perf_counter()
        shared.run(ticks)
        wall = time.perf_counter() - wall
        return Taken(spent() - cpu, wall)

    return fly


def main() -> None:
    """Measure, compute, print."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--agents", type=int, default=1_000_000)
    arguments.add_argument("--ticks", type=int, default=60, help="of a turn")
    arguments.add_argument("--rounds", type=int, default=5)
    arguments.add_argument("--quick", action="store_true", help="20 000 agents, one round")
    options = arguments.parse_args()
    agents, rounds = (20_000, 1) if options.quick else (options.agents, options.rounds)
    one, two = flock(agents, 1), flock(agents, 2)
    turns = [
        Contestant("one process", agents, options.ticks, flight_of(one)),
        Contestant("two ranks", agents, options.ticks, flight_of_ranks(two)),
    ]
    take_turns(turns, rounds)
    same = np.array_equal(one.position, two.position)
    print(
        f"ns of an agent-step, {agents:,} agents, {options.ticks} ticks a call, least of {rounds}"
    )
    for turn in turns:
        print(f"{turn.name:14}{turn.least():8.0f} CPU{turn.least('wall'):8.0f} wall")
    print(f"the same bits: {'yes' if same else 'no'}\n")
    print(HEADER)
    for size in SIZES:
        print(Needs(*size).line())


if __name__ == "__main__":
    main()
