"""How much a browser may have this machine do by a sweep, in numbers and in words."""

from __future__ import annotations

from app.experiments.workers.processes import cores
from worlds.input_error import InputError

MOST_VALUES = 50
"""Of an axis."""
MOST_CELLS, MOST_RUNS_OF_CELL, MOST_RUNS = 400, 100, 5_000
MOST_AGENTS, MOST_TICKS = 3_000, 20_000
"""Of a run."""
MOST_STEPS = 10**10
"""Agents times ticks times runs."""
MOST_BEGUN = 100
"""Sweeps that a laboratory begins."""
MOST_WORKERS = 4
NICE = 10
"""How far the processes of a sweep give way to the laboratory's own."""


def workers() -> int:
    """Processes of a sweep: a core is left to the laboratory, where there are several."""
    return max(1, min(MOST_WORKERS, cores() - 1))


def words() -> str:
    """What may be begun, for people."""
    one = workers() == 1
    processes = "1 process that gives" if one else f"{workers()} processes that give"
    return (
        f"From the page at most {MOST_CELLS} cells, {MOST_RUNS:,} runs, {MOST_AGENTS:,} agents, "
        f"{MOST_TICKS:,} ticks and 10 thousand million steps of an agent; one sweep at a time, in "
        f"{processes} way to the laboratory. "
        "More: <code>flockscope sweep run FILE.toml</code>"
    )


def demand(cells: int, each: int, agents: int, ticks: int) -> None:
    """Refuse what is more than a browser may begin: `each` runs of each cell. Raises InputError."""
    for name, value, most in (
        ("cells", cells, MOST_CELLS),
        ("runs of a cell", each, MOST_RUNS_OF_CELL),
        ("runs", cells * each, MOST_RUNS),
        ("agents", agents, MOST_AGENTS),
        ("ticks", ticks, MOST_TICKS),
        ("steps of an agent", cells * each * agents * ticks, MOST_STEPS),
    ):
        if value > most:
            raise InputError(
                f"{value:,} {name} are not allowed from the page: {most:,} at most; "
                "`flockscope sweep run FILE.toml` takes more"
            )
