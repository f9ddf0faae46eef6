"""Draws how cost grows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib
from contestants import PEERS
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullLocator
from sweeps import HOMES, SEEING, Point, Sweep

from app.figure import LOOK, write_figure

COLOURS = ("#2166ac", "#b07d12", "#1f9d63", "#e08214", "#c0392b", "#8e44ad")
COLOUR = dict(zip(HOMES, COLOURS, strict=True))
"""Of a model; on a mission it keeps that of its rule."""
GREY, DASHES = "#6b747e", ("--", ":", "-.")
STYLE: dict[str, dict[str, Any]] = {
    name: {"color": COLOUR[name.removesuffix("-nav")], "marker": "o", "markersize": 3.5}
    for name in (*HOMES, *SEEING)
} | {name: {"color": GREY, "linestyle": dash} for name, dash in zip(PEERS, DASHES, strict=True)}


def draw(
    sweeps: Mapping[str, Sweep], points_by_name: Mapping[str, Sequence[Point]], path: Path
) -> None:
    """Draw each sweep, and the cost of a neighbour over neighbours, as PNG or SVG."""
    with matplotlib.rc_context(LOOK):
        figure = Figure((11.0, 6.6), layout="constrained")
        agents, density, near, obstacles = figure.subplots(2, 2).flat
        for axes, name in ((agents, "agents"), (density, "density"), (obstacles, "obstacles")):
            lines(axes, [(point.name, point.value, point.least) for point in points_by_name[name]])
            axes.set_title(f"Over {sweeps[name].title}", loc="left")
            axes.set(xlabel=sweeps[name].axis, ylabel="ns per agent-step")
            axes.set_xticks(sweeps[name].values)
        lines(
            near,
            [
                (point.name, point.neighbours, point.least / point.neighbours)
                for point in points_by_name["density"]
                if point.neighbours
            ],
        )
        near.set_title("Over neighbours, the same runs", loc="left")
        near.set(xlabel="neighbours of an agent", ylabel="ns per neighbour")
        signs = {
            sign.get_label(): sign for axes in figure.axes for sign in axes.get_lines()
        }  # a model may be in one of them only
        figure.legend(
            signs.values(), signs, loc="outside lower center", ncols=5, fontsize=9, handlelength=3
        )
        write_figure(figure, path, dots=90)


def lines(axes: Any, points: Sequence[tuple[str, float, float]]) -> None:
    """Draw a line for each name through its points."""
    for name in dict.fromkeys(name for name, _, _ in points):
        x, y = zip(*[(x, y) for point, x, y in points if point == name], strict=True)
        axes.plot(x, y, label=name, linewidth=1.6, **STYLE[name])
    axes.set(xscale="log", yscale="log")
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
        axis.set_major_formatter(lambda x, _: f"{x:,.7g}" if x < 1e6 else f"{x / 1e6:g} M")
        axis.set_minor_locator(NullLocator())
    axes.grid(True, axis="both")
