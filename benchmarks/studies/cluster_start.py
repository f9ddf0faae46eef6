"""What a node's first run waits for: kernels compiled there, by another node, or kept from before.

    uv run python benchmarks/studies/cluster_start.py [--model vem] [--nodes 4]

Each node is a process that begins, makes a run of ten ticks and measures it. `own`: nodes with a
folder of kernels each, empty; `shared`: one empty folder for all, in which the first compiles while
the others wait; `kept`: the same folder, once it is full. Processor time of all nodes; by the clock
a node is as fast as its machine. The memory is that of the largest process that made a run.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

FIRST = """
from agents import Flock
flock = Flock({model!r}, agents=50, rng=1)
flock.run(10)
flock.observe("polarisation")
"""


def measure_start(model: str, caches: list[Path]) -> tuple[float, float]:
    """Processor time of all nodes, and the seconds until the last one has made its run."""
    before, clock = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    command = [sys.executable, "-c", FIRST.format(model=model)]
    nodes = [
        subprocess.Popen(command, env=os.environ | {"FLOCKSCOPE_CACHE": str(cache)})
        for cache in caches
    ]
    codes = [node.wait() for node in nodes]
    if any(codes):
        sys.exit("a node has failed")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return spent, time.perf_counter() - clock


def main() -> None:
    """Print what nodes cost until their first run is made."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--model", default="vem")
    arguments.add_argument("--nodes", type=int, default=4)
    options = arguments.parse_args()
    print(f"{'kernels':10}{'nodes':>8}{'processor, s':>15}{'a node, s':>12}{'by clock, s':>14}")
    with tempfile.TemporaryDirectory() as folder:
        own = [Path(folder) / str(node) for node in range(options.nodes)]
        shared = [Path(folder) / "shared"] * options.nodes
        for name, caches in (("own", own), ("shared", shared), ("kept", shared)):
            spent, clock = measure_start(options.model, caches)
            each = spent / options.nodes
            print(f"{name:10}{options.nodes:8}{spent:15.1f}{each:12.1f}{clock:14.1f}")
    largest = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1e3
    print(f"memory of a process, MB: {largest:.0f}")


if __name__ == "__main__":
    main()
