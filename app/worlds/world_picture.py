"""The picture of a world, as PNG or SVG: a plan, and in space a side view below it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from app.figure import write_figure
from app.worlds.colours import LOOK, SOLID_EDGE
from app.worlds.plan import draw_plan, view
from app.worlds.rulers import ruled
from app.worlds.space_plan import draw_space
from worlds.number_text import counted
from worlds.world import World

LONG, TALL, NARROW = 8.6, 6.4, 5.6
"""Inches: the most width and height of a plan, the least width of a picture."""
AXES = ("x", "y", "z")


def draw_world(world: World, path: Path, points: np.ndarray | None = None) -> None:
    """Draw a world into a file, whose ending says PNG or SVG.

    `points` (P, 2) are the boundary points to show, if any. Raises InputError if the file cannot be
    written.
    """
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with matplotlib.rc_context(LOOK):  # type: ignore[arg-type]
        figure: Any = Figure(layout="constrained")
        FigureCanvasAgg(figure)
        if world.dim == 3:
            signs = draw_space(figure, world)
        else:
            axes = figure.subplots()
            signs = draw_plan(axes, world, points)
            width, height = np.subtract(*reversed(view(world)))
            scale = min(LONG / width, TALL / height)
            figure.set_size_inches(max(scale * width + 0.8, NARROW), scale * height + 1.5)
            ruled(axes, "x", "y")
        head(figure, world)
        if signs:
            figure.legend(
                handles=signs, loc="outside lower left", ncols=min(len(signs), 5), fontsize=9
            )
        write_figure(figure, path)


def head(figure: Any, world: World) -> None:
    """Title and, smaller, the size and the edges."""
    size = " × ".join(f"{side:g}" for side in world.size)
    edges = ", ".join(f"{a}: {edge}" for a, edge in zip(AXES, world.edges, strict=False))
    if len(set(world.edges)) == 1:
        edges = f"{world.edges[0]} edges"
    solid = len(world.obstacles)
    holds = counted(solid, "obstacle") if solid else "no obstacles"
    figure.suptitle(
        f"{world.title or world.name}\n" + f"{size} m, {edges}, {holds}",
        x=0.012,
        ha="left",
        color=SOLID_EDGE,
        linespacing=1.45,
    )
