"""Where neighbours are about an individual, and how it turns by their places."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np

from agents.observables.neighbour_map import NeighbourMap, neighbour_map
from app.studies.charts.array_charts import draw_field
from app.tracks.measures.track_measure import (
    MeasureChart,
    MeasureInput,
    MeasureResult,
    Progress,
    TrackMeasure,
    needs_neighbours_in_plane,
)
from worlds.input_error import InputError

SPACINGS = 6.0
"""Half the side of a map that nobody asked for, in median distances to the nearest neighbour."""
CELLS = 41
"""Along a side: odd, so that the individual is in the middle of one."""
SLICES = 20
"""Of the time, after each of which progress is told."""
LEAST_TURNS = 20
"""Turns that a cell's mean is of, at least."""


def maps(given: MeasureInput, progress: Progress, *, has_turns: bool) -> tuple[NeighbourMap, str]:
    """The map of all frames, and a sentence on its reach."""
    reach = given.options.map_reach
    if reach is not None and not 0.0 < reach < math.inf:
        raise InputError(f"map reach = {reach:g} {given.unit} is not allowed: a length > 0")
    said = f"the map reaches {reach:g} {given.unit}" if reach is not None else ""
    if reach is None:
        reach = SPACINGS * given.spacing
        said = (
            f"the map reaches {reach:.4g} {given.unit}, {SPACINGS:g} times the median distance to "
            "the nearest neighbour: --map-reach chooses another"
        )
    turn = np.degrees(given.motion.turn) if has_turns else None
    total: NeighbourMap | None = None
    sums = np.zeros((CELLS, CELLS))
    counts = np.zeros((CELLS, CELLS))
    for k, part in enumerate(np.array_split(np.arange(len(given.tracks.frame)), SLICES)):
        if len(part):
            place, heading = given.tracks.position[part], given.motion.heading[part]
            one = neighbour_map(place, heading, given.size, given.images, reach, CELLS,
                                None if turn is None else turn[part])  # fmt: skip
            if turn is not None and one.turn is not None and one.turns is not None:
                counts += one.turns
                sums += np.where(one.turns > 0, one.turn * one.turns, 0.0)
            total = one if total is None else NeighbourMap(
                one.edges, total.pairs + one.pairs, total.individuals + one.individuals, None, None
            )  # fmt: skip
        progress((k + 1) / SLICES)
    assert total is not None
    if turn is None:
        return total, said
    mean = np.divide(sums, counts, out=np.full_like(sums, np.nan), where=counts >= LEAST_TURNS)
    return total._replace(turn=mean, turns=counts.astype(np.int64)), said


def cells(total: NeighbourMap, **fields: np.ndarray) -> dict[str, np.ndarray]:
    """A row for each cell: its middle, to the right and ahead, and what is in it."""
    middle = (total.edges[1:] + total.edges[:-1]) / 2.0
    right, ahead = np.meshgrid(middle, middle)
    flat = {"right": right.ravel(), "ahead": ahead.ravel(), "pairs": total.pairs.ravel()}
    return flat | {name: value.ravel() for name, value in fields.items()}


def density(given: MeasureInput, progress: Progress) -> MeasureResult:
    """Neighbours per area about an individual that heads up."""
    total, said = maps(given, progress, has_turns=False)
    unit = given.unit
    chart = MeasureChart(
        f"to the right ({unit})", f"ahead ({unit})",
        lambda axes: draw_field(axes, total.edges, total.density, f"neighbours per {unit}²"),
        "where neighbours are", is_square=True,
    )  # fmt: skip
    front = total.pairs[CELLS // 2 + 1 :].sum()
    back = total.pairs[: CELLS // 2].sum()
    ratio = float(front / back) if back else math.nan
    return MeasureResult(
        {"individuals and frames": total.individuals, "neighbours in the map":
         int(total.pairs.sum()), "ahead for each behind": ratio},
        {"": cells(total, density=total.density)}, (chart,), (said,),
    )  # fmt: skip


def turning(given: MeasureInput, progress: Progress) -> MeasureResult:
    """How an individual turns with a neighbour in each place, and the odd part of that."""
    total, said = maps(given, progress, has_turns=True)
    assert total.turn is not None
    assert total.odd_turn is not None
    turn, odd, unit = total.turn, total.odd_turn, given.unit
    labels = f"to the right ({unit})", f"ahead ({unit})"
    charts = tuple(
        MeasureChart(*labels, partial(draw_turns, edges=total.edges, field=field), title, True)
        for field, title in ((turn, "how an individual turns"), (odd, "the odd part of it"))
    )  # fmt: skip
    left = odd[:, : CELLS // 2]
    weight = total.pairs[:, : CELLS // 2] * np.isfinite(left)
    mean = float((np.nan_to_num(left) * weight).sum() / weight.sum()) if weight.sum() else math.nan
    even = turn[np.isfinite(turn)]
    return MeasureResult(
        {"turn to a neighbour on the left, odd part (deg/s)": mean,
         "turn whatever is where (deg/s)": float(even.mean()) if len(even) else math.nan,
         "individuals and frames": total.individuals},
        {"": cells(total, turn=turn, odd_turn=odd)}, charts,
        (said, f"cells with fewer than {LEAST_TURNS} turns are grey",
         "above 0 is towards the left: a flock that mills turns whatever is where, which the odd "
         "part leaves out"),
    )  # fmt: skip


def draw_turns(axes: Any, edges: np.ndarray, field: np.ndarray) -> None:
    """Draw a map of turns."""
    draw_field(axes, edges, field, "turn to the left (deg/s)", is_signed=True)


def map_cost(frames: int, n: int) -> float:
    """Seconds for a map."""
    return 1.7e-8 * frames * n * n + 1e-6 * frames


MEASURES = (
    TrackMeasure(
        "neighbour-map", "Where neighbours are about an individual", "Katz et al. 2011", density,
        map_cost, needs_neighbours_in_plane,
    ),
    TrackMeasure(
        "turning-map", "How an individual turns by where a neighbour is", "Katz et al. 2011",
        turning, map_cost, needs_neighbours_in_plane,
    ),
)  # fmt: skip
