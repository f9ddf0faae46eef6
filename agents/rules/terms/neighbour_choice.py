"""A choice that rules may offer: neighbours are all within reach, or the k nearest.

Ballerini et al. 2008 found that a starling interacts with its six or seven nearest neighbours,
whatever their distance. A rule whose parameters have these two is shown those alone; the engine
picks them out (`agents.engine.neighbour_search`), and nothing in the rule's equation changes but
who counts.
"""

from __future__ import annotations

from typing import Literal

from agents.models.declare import Parameters, parameter


class Nearest(Parameters):
    """Who the neighbours of an agent are."""

    neighbours: Literal["metric", "nearest"] = parameter(
        "metric",
        "Neighbours: all within reach (metric), or the k nearest, whatever their distance "
        "(topological)",
        words="Neighbours",
        symbol="\\mathcal{N}_i",
        source="Ballerini et al. 2008",
    )
    k: float = parameter(
        7.0,
        "How many of the nearest are neighbours, where they are counted; the nearest whole number",
        words="Number of the nearest",
        symbol="n_c",
        low=1.0,
        high=100.0,
        proposed=(1.0, 20.0),
        step=1.0,
        source="Ballerini et al. 2008: 6.5 +- 0.9",
    )
