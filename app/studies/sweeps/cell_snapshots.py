"""How a flock of each cell of a map looks at its end, drawn small into the cell."""

from __future__ import annotations

from typing import Any

from agents.flock import Flock
from app.studies.runs.store_reader import StoreReader
from app.studies.sweeps.sweep_table import places_of, spec_at
from worlds.input_error import InputError

MOST = 150
"""Cells whose flocks are drawn."""
MOST_STEPS = 50_000_000
"""Steps of agents that are run again for it."""
PART = 0.84
"""Of a cell's width, the rest is its colour."""


def draw_snapshots(axes: Any, reader: StoreReader, at: dict[int, tuple[int, int]]) -> None:
    """Draw the flock of each cell's first run at its end; `at` is where a cell stands on the map.

    It is run again for that. Raises InputError if there are too many, or too long runs.
    """
    first: dict[int, tuple[int, int]] = {}
    for cell, seed, status, _, _, ticks, _ in reader.runs([]):
        if status in ("ok", "gave-up") and cell in at:
            first.setdefault(cell, (seed, ticks))
    steps = sum(
        ticks * reader.cells[cell]["identity"]["spec"]["agents"]
        for cell, (_, ticks) in first.items()
    )
    if len(first) > MOST or steps > MOST_STEPS:
        raise InputError(
            f"the flocks of {len(first)} cells, {steps:.2g} steps of agents, are too much to draw: "
            f"leave cells out with --where, {MOST} and {MOST_STEPS:.2g} are allowed"
        )
    places = places_of(reader)
    for cell, (seed, ticks) in first.items():
        flock = Flock(spec_at(reader, places[cell], seed))
        flock.run(ticks)
        column, row = at[cell]
        margin = 0.5 * (1.0 - PART)
        corner = column + margin, row + margin
        draw_flock(axes.inset_axes([*corner, PART, PART], transform=axes.transData), flock)


def draw_flock(inset: Any, flock: Flock) -> None:
    """Draw a flock from above: arrows along its headings, as large as its world or itself."""
    low, size = flock.world.low, flock.world.size
    position, heading = flock.position, flock.heading
    inset.quiver(
        *position.T[:2], *heading.T[:2],
        angles="xy", pivot="mid", scale=14.0, width=0.02, headwidth=5, color="black",
    )  # fmt: skip
    if all(flock.world.wraps[:2]):
        inset.set_xlim(low[0], low[0] + size[0])
        inset.set_ylim(low[1], low[1] + size[1])
    else:
        inset.margins(0.1)
    inset.set_aspect("equal", adjustable="box" if all(flock.world.wraps[:2]) else "datalim")
    inset.set_xticks([])
    inset.set_yticks([])
    inset.grid(False)
    inset.patch.set_alpha(0.75)
