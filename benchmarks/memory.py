"""How much memory: bytes per agent, with agents made on demand and with all of Mesa's.

uv run python benchmarks/memory.py [--agents 1000000]
"""

from __future__ import annotations

import argparse
import gc
import math
import os
from pathlib import Path

from agents import Flock


def resident() -> int:
    """Memory of this process that is in RAM, bytes (Linux)."""
    gc.collect()
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def main() -> None:
    """Build a flock, run it, ask for its agents; print what each cost."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--agents", type=int, default=1_000_000)
    n = arguments.parse_args().agents
    first = Flock("vem", agents=100, rng=1)
    first.run(1)
    empty = resident()
    flock = Flock("vem", agents=n, size=math.sqrt(n / 4.0), eta=0.3, rng=1)
    flock.run(2)
    arrays = resident()
    assert len(flock.agents) == n
    members = resident()
    print(f"{n:,} agents in 2-D")
    print(f"arrays only, agents made on demand: {(arrays - empty) / n:6.0f} bytes per agent")
    print(f"with every Mesa agent made:         {(members - empty) / n:6.0f} bytes per agent")


if __name__ == "__main__":
    main()
