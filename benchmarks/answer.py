"""How soon the laboratory's simulation answers a command while it runs as fast as it can.

uv run python benchmarks/answer.py [agents ...]
"""

from __future__ import annotations

import math
import statistics
import sys
import time

from app.viewer.run.home import at_home
from app.viewer.run.picture import Wanted
from app.viewer.run.simulation import Simulation

COMMANDS = 40


def main(sizes: list[int]) -> None:
    """Measure and print."""
    print(f"{'agents':>8}{'median, ms':>12}{'worst, ms':>12}   of {COMMANDS} changes of eta")
    for agents in sizes:
        simulation = Simulation(at_home(agents=agents), speed=math.inf, running=True)
        simulation.ready.wait(60)
        simulation.want(Wanted(layers=True)).result(60)
        time.sleep(2.0)
        took = []
        for k in range(COMMANDS):
            time.sleep(0.05)
            begun = time.perf_counter()
            simulation.set("eta", 0.1 + 0.01 * k).result(60)
            took.append(1e3 * (time.perf_counter() - begun))
        simulation.close()
        print(f"{agents:8}{statistics.median(took):12.0f}{max(took):12.0f}")


if __name__ == "__main__":
    main([int(text) for text in sys.argv[1:]] or [1_000, 5_000, 50_000])
