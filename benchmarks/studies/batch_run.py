"""What a study costs by `mesa.batch_run`, `flockscope.batch_run` and `flockscope.sweep`.

    uv run python benchmarks/studies/batch_run.py [--workers 2] [--runs 400]

Runs of the Vicsek model over four strengths of noise, with their polarisation at the end.
Milliseconds of a core for each run, all processes and their start among them, and seconds by the
clock; every number of the one has to be that of the other to the bit.
"""

from __future__ import annotations

import argparse
import resource
import time
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

import mesa

from flockscope import Flock, batch_run, sweep

KINDS = ((50, 100, 1.0), (300, 100, 1.0), (1000, 1000, 0.1))
"""Agents, ticks, and the share of the runs that is asked for."""
ETA = [0.0, 1.5, 3.0, 4.5]
Found = dict[tuple[float, int], float]
"""Noise and seed -> polarisation."""


def run_with_mesa(
    agents: int,
    ticks: int,
    seeds: Iterable[int],
    workers: int,
    batch: Callable[..., Any] = mesa.batch_run,
) -> Found:
    """The study as Mesa makes it, or another `batch` of the same arguments."""
    rows = batch(
        Flock,
        {"model": "vem", "agents": agents, "eta": ETA},
        rng=list(seeds),
        max_steps=ticks,
        number_processes=workers,
        display_progress=False,
    )
    return {(row["eta"], row["rng"]): row["polarisation"] for row in rows}


def run_as_sweep(agents: int, ticks: int, seeds: Iterable[int], workers: int) -> Found:
    """The study as a sweep."""
    results = sweep(
        "vem",
        agents=agents,
        vary={"eta": ETA},
        runs=len(list(seeds)),
        ticks=ticks,
        observe=["polarisation"],
        workers=workers,
    )
    table = results.columns
    keys = zip(table["eta"], table["seed"], strict=True)
    return dict(zip(keys, table["polarisation"], strict=True))


WAYS = {
    "mesa.batch_run": run_with_mesa,
    "flockscope.batch_run": partial(run_with_mesa, batch=batch_run),
    "flockscope.sweep": run_as_sweep,
}


def core_seconds() -> float:
    """Seconds of a core so far, of this process and of those that it has ended."""
    uses = map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(use.ru_utime + use.ru_stime for use in uses)


def measure_study(make: Callable[..., Found], *arguments: Any) -> tuple[Found, float, float]:
    """What it finds, seconds of a core and by the clock."""
    core, clock = core_seconds(), time.perf_counter()
    result = make(*arguments)
    return result, core_seconds() - core, time.perf_counter() - clock


def main() -> None:
    """Print a line for each kind of run."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--runs", type=int, default=400)
    options = parser.parse_args()
    flock = Flock("vem", agents=50, eta=1.5, rng=1)
    flock.run(2)
    flock.step()
    for agents, ticks, share in KINDS:
        seeds = range(1, max(1, round(options.runs * share) // len(ETA)) + 1)
        runs = len(ETA) * len(seeds)
        rows = []
        founds = []
        for name, make in WAYS.items():
            result, core, clock = measure_study(make, agents, ticks, seeds, options.workers)
            founds.append(result)
            rows.append(f"{name} {1e3 * core / runs:7.2f} ms of a core, {clock:6.2f} s")
        is_same = all(found == founds[0] for found in founds)
        same = "the same numbers" if is_same else "OTHER NUMBERS"
        print(f"{runs:5} runs of {agents:4} agents x {ticks:4}: {'; '.join(rows)}; {same}")


if __name__ == "__main__":
    main()
