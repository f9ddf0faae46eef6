"""Runs a second of a sweep, beside a plain loop over flocks.

    uv run python benchmarks/studies/sweep_rate.py [--workers 2] [--runs 4000]

Three kinds of runs: 50 and 300 agents for 100 ticks, and 1000 agents for 1000. Processor time of a
run, in the loop and in a sweep with all that it begins; by the clock the sweep is faster by the
number of cores that it has for itself.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from pathlib import Path

from batch_run import core_seconds

from agents import Flock
from app.studies.sweeps.checked_sweep import Sweep
from app.studies.sweeps.sweep_api import StudyArguments
from app.studies.sweeps.sweep_runner import run_sweep

KINDS = ((50, 100, 1.0), (300, 100, 0.5), (1000, 1000, 0.05))
"""Agents, ticks, and the share of the runs that is asked for."""
ETA = [0.0, 1.5, 3.0, 4.5]


def plain_loop(agents: int, ticks: int, runs: int) -> float:
    """Seconds of processor time of a run in a loop."""
    started = time.process_time()
    for seed in range(1, runs // len(ETA) + 1):
        for eta in ETA:
            flock = Flock("vem", agents=agents, eta=eta, rng=seed)
            flock.run(ticks)
            flock.observe("polarisation")
    return (time.process_time() - started) / runs


def measure_sweep(sweep: Sweep, workers: int) -> tuple[float, float, int]:
    """Processor time of a run, runs a second by the clock, and bytes on disk."""
    with tempfile.TemporaryDirectory() as folder:
        core, clock = core_seconds(), time.perf_counter()
        done = run_sweep(sweep, Path(folder), workers=workers)
        rate = done.made / (time.perf_counter() - clock)
        size = (Path(folder) / "runs.sqlite").stat().st_size
    return (core_seconds() - core) / done.made, rate, size


def main() -> None:
    """Print what a run costs in a loop and in a sweep."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--workers", type=int, default=2, help="runs at a time")
    arguments.add_argument("--runs", type=int, default=4000, help="runs of the shortest kind")
    options = arguments.parse_args()
    heads = ("agents x ticks", "runs", "loop, ms", "sweep, ms", "more", "runs/s", "bytes/run")
    print("".join(f"{head:>15}" for head in heads))
    for agents, ticks, share in KINDS:
        runs = max(len(ETA) * 2, int(options.runs * share) // len(ETA) * len(ETA))
        study = StudyArguments(
            "vem", runs // len(ETA), ticks, observe=["polarisation"], words={"agents": agents}
        )
        sweep = study.sweep({"kind": "grid", "axes": {"eta": ETA}}, None)
        plain_loop(agents, ticks, len(ETA))
        loop = plain_loop(agents, ticks, min(runs, 800))
        cost, rate, size = measure_sweep(sweep, options.workers)
        cells = (f"{agents} x {ticks}", runs, f"{1e3 * loop:.3f}", f"{1e3 * cost:.3f}")
        more = f"{100.0 * (cost / loop - 1.0):+.0f} %"
        print(
            "".join(
                f"{value!s:>15}" for value in (*cells, more, f"{rate:.0f}", f"{size / runs:.0f}")
            )
        )


if __name__ == "__main__":
    main()
