"""How much memory: bytes per agent, with agents made on demand and with all of Mesa's.

uv run python benchmarks/engine/memory.py [--agents 1000000]
"""

from __future__ import annotations

import argparse
import gc
import math
import multiprocessing
import os
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

from agents import Flock


def resident() -> int:
    """Memory of this process that is in RAM, bytes (Linux)."""
    gc.collect()
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def bytes_per_agent(n: int) -> tuple[float, float]:
    """Build a flock, run it, ask for its agents: bytes of arrays only, and with every Mesa agent.

    To be called in a process that has freed no memory which a flock could use again.
    """
    first = Flock("vem", agents=100, rng=1)
    first.run(1)
    empty = resident()
    flock = Flock("vem", agents=n, size=math.sqrt(n / 4.0), eta=0.3, rng=1)
    flock.run(2)
    arrays = resident()
    assert len(flock.agents) == n
    members = resident()
    return (arrays - empty) / n, (members - empty) / n


def peak_per_agent(n: int) -> float:
    """Bytes of an agent at most while a flock is built and run, over what a small one needs.

    To be called in a process that has done nothing else.
    """
    Flock("vem", agents=100, rng=1).run(1)
    empty = peak()
    Flock("vem", agents=n, size=math.sqrt(n / 4.0), eta=0.3, rng=1).run(2)
    return (peak() - empty) / n


def peak() -> int:
    """Memory of this process that was in RAM at most, bytes (Linux)."""
    # Not `getrusage`: a process that is begun by a large one has that one's peak.
    status = Path("/proc/self/status").read_text()
    return 1024 * int(status.partition("VmHWM:")[2].split()[0])


def main() -> None:
    """Measure and print."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--agents", type=int, default=1_000_000)
    n = arguments.parse_args().agents
    arrays, members = bytes_per_agent(n)
    print(f"{n:,} agents in 2-D")
    print(f"arrays only, agents made on demand: {arrays:6.0f} bytes per agent")
    print(f"with every Mesa agent made:         {members:6.0f} bytes per agent")
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as fresh:
        most = fresh.submit(peak_per_agent, n).result()
    print(f"arrays only, at most:               {most:6.0f} bytes per agent")


if __name__ == "__main__":
    main()
