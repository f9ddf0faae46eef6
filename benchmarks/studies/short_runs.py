"""What a short run costs beside its ticks: making a flock, a call, a step, and ways to make many.

    uv run python benchmarks/studies/short_runs.py [--workers 2] [--runs 400] [--rounds 5]

300 agents of the Vicsek model. Of each figure the least of several rounds, as CPU time and by the
clock: others on the machine make both longer. A run goes from its seed to its polarisation after
100 ticks, with four strengths of noise. The ways to make many take turns, and have all that they
begin counted, processes too. Bare ticks: the compiled loop called with arrays that are there.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import NamedTuple

import mesa
import numpy as np
from batch_run import core_seconds

from agents import Flock
from agents.engine.arrays import Arrays
from app.studies.experiment_reader import read_file
from app.studies.experiment_runner import run_experiment
from app.studies.sweeps.sweep_api import StudyArguments
from app.studies.sweeps.sweep_job import RunRequest
from app.studies.sweeps.sweep_runner import run_sweep
from app.studies.workers.process_executor import ProcessExecutor
from app.studies.workers.run_executors import Task
from flockscope import batch_run

AGENTS, TICKS, ROUNDS = 300, 100, 20
ETA = [0.0, 1.5, 3.0, 4.5]
PAPER = f"""
title = "Short runs"
source = "this benchmark"
picture = "models"
runs = 1
[settings]
world = "wrap"
desired = 0.9984
hold = {TICKS}
limit = {TICKS}
[sizes]
{AGENTS} = 8.552
"""
"""Its runs wait for an order that does not come before they are given up."""


class Cost(NamedTuple):
    """Seconds of one core, and by the clock."""

    cpu: float
    wall: float

    def less(self, other: Cost, share: float) -> Cost:
        """What is left without a share of another cost."""
        return Cost(self.cpu - share * other.cpu, self.wall - share * other.wall)


def least_cost(work: Callable[[], object], times: int) -> Cost:
    """What one call of `work` costs at least, over rounds of so many calls."""
    rounds = []
    for _ in range(ROUNDS):
        cpu, wall = time.process_time(), time.perf_counter()
        for _ in range(times):
            work()
        rounds.append(((time.process_time() - cpu) / times, (time.perf_counter() - wall) / times))
    return Cost(*map(min, zip(*rounds, strict=True)))


def new_flock(seed: int = 1) -> Flock:
    """A flock at tick 0."""
    return Flock("vem", agents=AGENTS, rng=seed)


def calls() -> dict[str, Cost]:
    """What making a flock and calling it cost, by what is done."""
    flock = new_flock()
    flock.run(1)
    tick = least_cost(lambda: flock.run(1), 200)
    long = least_cost(lambda: flock.run(TICKS), 10)
    per_tick = long.less(tick, 1.0)
    return {
        f"making a flock of {AGENTS}": least_cost(new_flock, 20),
        "making it and its first tick": least_cost(lambda: new_flock().run(1), 20),
        "run(1) beside the tick itself": tick.less(per_tick, 1.0 / (TICKS - 1)),
        "run(1)": tick,
        "step() with one observable": least_cost(flock.step, 200),
    }


def bare_ticks(runs: int) -> Callable[[], object]:
    """The compiled loop alone, from as many starts as there are runs."""
    flocks = [Flock("vem", agents=AGENTS, eta=eta, rng=1) for eta in ETA]
    engines = [(flock.engine, flock.context) for flock in flocks]
    starts = []
    for seed in range(runs // len(ETA)):
        flocks[0].restart(seed)
        starts.append(flocks[0].arrays)

    def make() -> None:
        for start in starts:
            for engine, context in engines:
                engine.arrays = Arrays._make(map(np.array, start))
                engine.run(context, 0, TICKS)

    return make


def new_flocks(runs: int) -> None:
    """A flock for each run."""
    for seed in range(runs // len(ETA)):
        for eta in ETA:
            flock = Flock("vem", agents=AGENTS, eta=eta, rng=seed)
            flock.run(TICKS)
            flock.observe("polarisation")


def same_flocks(runs: int) -> None:
    """A flock for each strength of noise, begun again for each run."""
    flocks = [Flock("vem", agents=AGENTS, eta=eta) for eta in ETA]
    for seed in range(runs // len(ETA)):
        for flock in flocks:
            flock.restart(seed)
            flock.run(TICKS)
            flock.observe("polarisation")


def as_sweep(runs: int, workers: int) -> None:
    """A sweep, kept in a folder as `flockscope sweep run` does."""
    study = StudyArguments(
        "vem", runs // len(ETA), TICKS, observe=["polarisation"], words={"agents": AGENTS}
    )
    sweep = study.sweep({"kind": "grid", "axes": {"eta": ETA}}, None)
    with tempfile.TemporaryDirectory() as folder:
        run_sweep(sweep, Path(folder), workers=workers)


def as_paper(runs: int, workers: int) -> None:
    """An experiment of a paper, kept as `flockscope paper` does."""
    rows = [
        f'[[rows]]\nmodel = "vem"\nagents = {AGENTS}\nparameters = {{ eta = {eta} }}\n'
        f"published.k_con.mean = {TICKS}.0\n"
        for eta in ETA
    ]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "short.toml"
        path.write_text(PAPER + "".join(rows), encoding="utf-8")
        experiment = read_file(path)
        run_experiment(
            experiment,
            Path(folder),
            runs=runs // len(ETA),
            seed=1,
            workers=workers,
            tell=None,
            at=lambda *_: None,
        )


def as_batch(batch: Callable[..., object], runs: int, processes: int) -> None:
    """A batch, as Mesa makes it or as flockscope does."""
    batch(
        Flock,
        {"model": "vem", "agents": AGENTS, "eta": ETA},
        rng=list(range(runs // len(ETA))),
        max_steps=TICKS,
        number_processes=processes,
        display_progress=False,
    )


def begin_process() -> None:
    """Begin a process for runs, as sweeps do, and have one run of a tick made by it."""
    study = StudyArguments("vem", 1, 1, observe=["polarisation"], words={"agents": AGENTS})
    sweep = study.sweep(None, None)
    with ProcessExecutor(sweep.making, 1) as processes:
        task = Task(1, 1, RunRequest(sweep.cells[0].spec))
        processes.run([task], lambda *_: None)


def take_turns(ways: dict[str, Callable[[], object]], rounds: int) -> dict[str, Cost]:
    """What each way costs at least, all processes with it."""
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in ways}
    for _ in range(rounds):
        for name, make in ways.items():
            core, clock = core_seconds(), time.perf_counter()
            make()
            found[name].append((core_seconds() - core, time.perf_counter() - clock))
    return {name: Cost(*map(min, zip(*costs, strict=True))) for name, costs in found.items()}


def main() -> None:
    """Print the costs of the calls, then those of the ways to make many runs."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--workers", type=int, default=2, help="runs at a time")
    arguments.add_argument("--runs", type=int, default=400, help="runs of a round")
    arguments.add_argument("--rounds", type=int, default=5)
    options = arguments.parse_args()
    runs, workers = max(1, options.runs // len(ETA)) * len(ETA), options.workers
    print(f"{'':34}{'CPU, us':>10}{'clock, us':>11}")
    for name, cost in calls().items():
        print(f"{name:34}{1e6 * cost.cpu:10.1f}{1e6 * cost.wall:11.1f}")
    bare = "bare ticks"
    costs = take_turns(
        {
            bare: bare_ticks(runs),
            "flocks begun again": partial(same_flocks, runs),
            "a loop over new flocks": partial(new_flocks, runs),
            "a sweep": partial(as_sweep, runs, workers),
            "a paper": partial(as_paper, runs, workers),
            "flockscope.batch_run": partial(as_batch, batch_run, runs, workers),
            "mesa.batch_run, 1 process": partial(as_batch, mesa.batch_run, runs, 1),
            f"mesa.batch_run, {workers} processes": partial(
                as_batch, mesa.batch_run, runs, workers
            ),
        },
        options.rounds,
    )
    print(f"\n{runs} runs, {workers} at a time{'':9}{'CPU, ms a run':>16}{'over bare':>11}", end="")
    print(f"{'clock, s':>10}")
    for name, cost in costs.items():
        ratio = cost.cpu / costs[bare].cpu
        print(f"{name:34}{1e3 * cost.cpu / runs:10.2f}{ratio:11.2f}{cost.wall:10.2f}")
    process = take_turns({"": begin_process}, options.rounds)[""]
    print(f"\na process for runs begins within {process.cpu:.1f} s of a core")


if __name__ == "__main__":
    main()
