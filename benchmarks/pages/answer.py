"""How soon the laboratory's simulation answers a command while it runs as fast as it can.

    uv run python benchmarks/pages/answer.py [agents ...]

And how soon a flock of another model moves once it was chosen, with all kernels on the disk: the
first time in a process, when they are loaded, and again.
"""

from __future__ import annotations

import math
import statistics
import subprocess
import sys
import time

from app.viewer.run.frame_builder import FrameRequest
from app.viewer.run.run_preset import preset_spec
from app.viewer.run.simulation import Simulation

COMMANDS = 40
MODELS = ("vem", "couzin", "reynolds", "hwvem-nav", "guarded", "squashing-cars")


def main(sizes: list[int]) -> None:
    """Measure and print."""
    print(f"{'agents':>8}{'median, ms':>12}{'worst, ms':>12}   of {COMMANDS} changes of eta")
    for agents in sizes:
        simulation = Simulation(preset_spec(agents=agents), speed=math.inf, running=True)
        simulation.ready.wait(60)
        simulation.set_request(FrameRequest(layers=True)).result(60)
        time.sleep(2.0)
        took = []
        for k in range(COMMANDS):
            time.sleep(0.05)
            started = time.perf_counter()
            simulation.set("eta", 0.1 + 0.01 * k).result(60)
            took.append(1e3 * (time.perf_counter() - started))
        simulation.close()
        print(f"{agents:8}{statistics.median(took):12.0f}{max(took):12.0f}")


def change_models() -> None:
    """Measure and print how soon another model moves."""
    warm = ["flockscope", "warm", *MODELS, "--quiet"]
    subprocess.run(warm, check=True, stdout=subprocess.DEVNULL)
    simulation = Simulation(preset_spec(), speed=math.inf, running=True)
    simulation.ready.wait(60)
    simulation.set_request(FrameRequest(layers=True)).result(60)
    took: list[list[float]] = [[], []]
    for times in took:
        for model in MODELS:
            started = time.perf_counter()
            simulation.setup(preset_spec(model)).result(60)
            simulation.go().result(60)
            while not has_run(simulation, model):
                time.sleep(0.002)
            times.append(1e3 * (time.perf_counter() - started))
            time.sleep(0.5)
    simulation.close()
    print(f"\n{'another model moves after':28}{'median, ms':>12}{'worst, ms':>12}")
    for title, times in zip(("first", "again"), took, strict=True):
        print(f"{title:28}{statistics.median(times):12.0f}{max(times):12.0f}")


def has_run(simulation: Simulation, model: str) -> bool:
    """Whether a flock of that model has been run."""
    run = simulation.run
    return run is not None and run.flock.spec.model == model and run.flock.tick > 0


if __name__ == "__main__":
    main([int(text) for text in sys.argv[1:]] or [1_000, 5_000, 50_000])
    change_models()
