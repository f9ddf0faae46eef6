"""Runs a second of a sweep, beside a plain loop over flocks.

    uv run python benchmarks/studies/sweep_rate.py [--workers 2] [--runs 4000]

Three kinds of runs: 50 and 300 agents for 100 ticks, and 1000 agents for 1000. Processor time of a
run, in the loop and in a sweep with all of its processes; by the clock the sweep is faster by the
number of cores that it has for itself. What a sweep takes before its first run is left out of its
rate, and what its processes take to begin, measured by a sweep of a run each, out of its time.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
import time
from pathlib import Path

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
    """Processor time and runs a second by the clock once all processes run, and bytes on disk."""
    marks: list[tuple[float, float]] = []

    def at(share: float, _left: float, words: str) -> None:
        if share > 0.0:
            marks.append((time.perf_counter(), float(words.split()[0])))

    with tempfile.TemporaryDirectory() as folder:
        before = resource.getrusage(resource.RUSAGE_CHILDREN), time.process_time()
        done = run_sweep(sweep, Path(folder), workers=workers, at=at)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        spent = after.ru_utime + after.ru_stime - before[0].ru_utime - before[0].ru_stime
        spent += time.process_time() - before[1]
        size = (Path(folder) / "runs.sqlite").stat().st_size
    (first, some), (last, all_of_them) = marks[0], marks[-1]
    rate = (all_of_them - some) / max(last - first, 1e-9)
    return spent / done.made, rate, size


def measure_start(sweep: Sweep, workers: int) -> float:
    """Seconds of processor time that a sweep takes beside its runs: processes that begin."""
    with tempfile.TemporaryDirectory() as folder:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        run_sweep(sweep, Path(folder), workers=workers, limit=workers)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main() -> None:
    """Print what a run costs in a loop and in a sweep."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--workers", type=int, default=2, help="processes")
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
        start = measure_start(sweep, options.workers)
        cost, rate, size = measure_sweep(sweep, options.workers)
        cost -= start / runs
        cells = (f"{agents} x {ticks}", runs, f"{1e3 * loop:.3f}", f"{1e3 * cost:.3f}")
        more = f"{100.0 * (cost / loop - 1.0):+.0f} %"
        print(
            "".join(
                f"{value!s:>15}" for value in (*cells, more, f"{rate:.0f}", f"{size / runs:.0f}")
            )
        )


if __name__ == "__main__":
    main()
