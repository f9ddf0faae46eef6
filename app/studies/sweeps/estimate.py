"""What a sweep will take, before it is run: cells, runs, time, disk; and what looks wrong."""

from __future__ import annotations

import time
import tomllib
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from typing import Any

from agents.flock import Flock
from app.package_files import EXPERIMENTS
from app.studies.sweeps.checked_sweep import Sweep, is_recorded
from app.studies.sweeps.sweep_cells import Cell
from app.studies.workers.kernels import compile_loop
from worlds.input_error import InputError

TRIED = 5
"""Cells whose first ticks are timed."""
ENOUGH = 0.02
"""Seconds after which ticks that are timed are enough."""
ROW = 40
"""Bytes of a run in the store, and of each of its columns beside."""
COLUMN, LOOK, FRAME = 9, 16, 60
"""Bytes of a column, of a look along a run, of an agent in a frame of a recording."""
PLAIN, NEAREST = "wrap-plain", "wrap"


@dataclass(frozen=True)
class SweepEstimate:
    """What is to be expected."""

    cells: int
    runs: int
    """Those of the first round, where a precision may ask for more."""
    most_runs: int
    seconds: float
    """Of one core, if every run lasts all of its ticks."""
    bytes: int

    @property
    def value(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)


def estimate(sweep: Sweep) -> SweepEstimate:
    """What a sweep will take, from the first ticks of some of its cells; nothing is kept."""
    distinct = list({cell.hash: cell for cell in sweep.cells}.values())
    replicates = sweep.file.replicates
    runs = len(distinct) * replicates.count
    most = runs
    if replicates.precision is not None:
        most = len(distinct) * replicates.precision.most
        most = min(most, max(runs, replicates.precision.budget or most))
    step = max(1, len(distinct) // TRIED)
    costs = [cost(sweep, cell) for cell in distinct[::step][:TRIED]]
    looks = sum(
        (sweep.making.ticks // measure.every) if measure.every else 0
        for measure in sweep.making.measures
    )
    size = ROW + COLUMN * len(sweep.making.columns) + LOOK * looks
    return SweepEstimate(
        len(distinct),
        runs,
        most,
        runs * sum(costs) / len(costs),
        runs * size + 1000 * len(distinct) + recording_bytes(sweep, distinct),
    )


def recording_bytes(sweep: Sweep, cells: Sequence[Cell]) -> int:
    """Bytes of the recordings."""
    total = 0
    for cell in cells:
        for record in sweep.file.record:
            if is_recorded(record, cell):
                frames = sweep.making.ticks // record.every + 2
                agents = cell.identity["spec"]["agents"] + (cell.identity["spec"]["informed"] or 0)
                total += (
                    frames * agents * FRAME * min(record.replicates, sweep.file.replicates.count)
                )
                break
    return total


def cost(sweep: Sweep, cell: Cell) -> float:
    """Seconds that a run of a cell may take."""
    began = time.perf_counter()
    flock = Flock(cell.spec.but(seed=sweep.file.replicates.first))
    elapsed = time.perf_counter() - began
    compile_loop(flock, None)
    ticks, seconds = 1, 0.0
    while seconds < ENOUGH and ticks <= sweep.making.ticks:
        began = time.perf_counter()
        flock.run(ticks)
        seconds = time.perf_counter() - began
        last, ticks = ticks, 2 * ticks
    per_tick = seconds / last
    looks = 0.0
    for measure, get in zip(sweep.making.measures, sweep.making.getters, strict=True):
        with suppress(Exception):  # of a run's own making: the run itself will tell
            get(flock)
            began = time.perf_counter()
            get(flock)
            times = measure.over or (sweep.making.ticks // measure.every if measure.every else 1)
            looks += times * (time.perf_counter() - began)
    return elapsed + per_tick * sweep.making.ticks + looks


def describe_other_worlds(sweep: Sweep) -> list[str]:
    """Warnings of worlds whose edges are not those of the papers that a model comes from."""
    used = {
        (str(cell.identity["spec"]["model"]), str(cell.identity["spec"]["world"]))
        for cell in sweep.cells
    }
    warnings: list[str] = []
    for model, world in sorted(used):
        if world not in (PLAIN, NEAREST):
            continue
        papers, other = papers_of(model), NEAREST if world == PLAIN else PLAIN
        names = [name for name, paper in papers if paper == other]
        if len(names) > sum(paper == world for _, paper in papers):
            more = f" and {len(names) - 1} more" if len(names) > 1 else ""
            warnings.append(
                f"{model} is in the world {world}, but {names[0]}{more} used {other}: across the "
                f"seam neighbours are {'not ' if other == PLAIN else ''}seen there, and the "
                "numbers are others"
            )
    return warnings


def papers_of(model: str) -> list[tuple[str, str]]:
    """The tables and figures of papers that run a model, each with its world."""
    papers: list[tuple[str, str]] = []
    for path in sorted(EXPERIMENTS.glob("*.toml")):
        with suppress(OSError, ValueError, InputError):
            values = tomllib.loads(path.read_text(encoding="utf-8"))
            rows = [*values.get("rows", ()), *values.get("sweeps", ())]
            if any(row.get("model") == model for row in rows):
                papers.append((path.stem, str(values["settings"].get("world"))))
    return papers
