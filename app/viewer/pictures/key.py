"""What a picture says beside the scene: what colours mean, a scale, which run it is."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from agents.models.declare import declared, describe
from agents.observables.of_agents import OWN
from app.viewer.pictures.shot import Shot
from app.viewer.scene.shown import palette
from app.viewer.scene.shown.colouring import COLOURINGS, DIRECTIONS, MEASURED
from app.worlds.world_picture import GOAL, INK, PATH
from worlds.mission import Mission
from worlds.number_text import counted
from worlds.world import World

GREY = "#5b6673"
DENSE = palette.srgb("#8893a3")
"""The colour of what is dense and not aligned, in the legend."""
WHEEL = 180
"""Sectors of the wheel of headings."""


def title(shot: Shot) -> str:
    """The model, for people, and the one beside it if there is one."""
    beside = shot.made.frame.beside
    if shot.made.frame.seen is not None:
        return shot.now.world.source + (f" and {beside.title}" if beside else "")
    return shot.now.model.title + (f" beside {beside.title}" if beside else "")


def caption(shot: Shot) -> str:
    """Model, world, agents and seed, on one line."""
    now, unit = shot.now, length_unit(shot)
    size = " × ".join(f"{side:.4g}" for side in now.world.size)
    frame = shot.made.frame
    informed = int(now.informed.sum())
    seen = shot.made.frame.seen
    if seen is not None:
        return f"tracks, {size}{unit} · {int(seen.sum())} of {len(seen)} individuals seen"
    of_kinds = {
        name: int(np.count_nonzero(frame.kind == number))
        for number, name in enumerate(frame.kinds.names)
        if number and frame.kind is not None
    }
    who = counted(len(now.ids) - informed - sum(of_kinds.values()), "agent")
    who += f" and {counted(informed, 'information agent')}" if informed else ""
    who += "".join(f", {number} of kind {name}" for name, number in of_kinds.items())
    return f"{now.model.name} in {now.world.name}, {size}{unit} · {who} · seed {now.seed}"


def changes(shot: Shot) -> str:
    """The parameters that are not as the model's paper has them; empty: all are."""
    if shot.made.frame.seen is not None:
        return ""
    values = shot.now.all_parameters
    found = [
        f"{one.name} = {in_short(values[one.name])}" + ("" if one.unit == "1" else f" {one.unit}")
        for one in declared(shot.now.model.parameters)
        if one.name in values and values[one.name] != one.default
    ]
    return ", ".join(found)


def in_short(value: Any) -> str:
    """A parameter's value for people."""
    return f"{value:g}" if isinstance(value, float) else str(value)


def moment(shot: Shot) -> str:
    """Tick and time."""
    now, unit = shot.now, shot.now.model.body.unit
    if shot.made.frame.seen is not None:
        return f"{now.elapsed:.2f} s"
    return f"tick {now.tick}" + ("" if unit == "ticks" else f" · {now.elapsed:.2f} {unit}")


def length_unit(shot: Shot) -> str:
    """The unit of lengths behind a number, "" where the model's paper names none."""
    unit = shot.now.model.in_units("length")
    return "" if unit == "length" else f" {unit}"


def nice(length: float) -> float:
    """The largest of 1, 2 and 5 times a power of ten that is no longer.

    >>> nice(0.83), nice(49.0), nice(2.0)
    (0.5, 20.0, 2.0)
    """
    power = 10.0 ** math.floor(math.log10(length) + 1e-12)
    return float(next(k * power for k in (5, 2, 1) if k * power <= length * (1.0 + 1e-9)))


def ruler(shot: Shot, longest: float) -> tuple[float, str]:
    """A nice length that is no longer, and its words."""
    length = nice(longest)
    unit = length_unit(shot) or (" lengths" if length != 1.0 else " length")
    return length, f"{length:g}{unit}"


def coloured_by(shot: Shot) -> str:
    """What the colours stand for."""
    look = shot.made.look
    if shot.made.shows_density:
        return "mean heading"
    if look.colour != MEASURED:
        title = COLOURINGS[look.colour].title
        return look.colour if title is None else title
    if look.measured.startswith(OWN):
        name = look.measured.removeprefix(OWN)
        fields = shot.now.model.parameters.model_fields
        one = describe(name, fields[name]) if name in fields else None
        return look.measured + ("" if one is None or one.unit == "1" else f" ({one.unit})")
    unit = shot.now.model.unit_of(look.measured) if look.measured in shot.now.model.columns else "1"
    return look.measured.replace("_", " ") + ("" if unit == "1" else f" ({unit})")


def has_wheel(shot: Shot) -> bool:
    """Whether headings are explained by a wheel."""
    return shot.made.shows_density or COLOURINGS[shot.made.look.colour].has_wheel


def signs(shot: Shot, of_world: list[Any]) -> list[Any]:
    """The signs of the legend: colours that a wheel does not explain, then the world."""
    from matplotlib.lines import Line2D

    mark = "s" if shot.made.frame.cars is not None else ">"
    made: list[Any] = [
        Line2D([], [], color=colour, marker=mark, markersize=8, linestyle="none",
               markeredgecolor="white", markeredgewidth=0.4, label=words)
        for words, colour in shot.entries
    ]  # fmt: skip
    return made + of_world


def signs_of(world: World, is_solid: bool, path: str = PATH, goal: str = GOAL) -> list[Any]:
    """The signs of what stands in a world; `path` and `goal` are their colours."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    made: list[Any] = []
    if is_solid:
        made.append(Patch(facecolor=palette.css(palette.SOLID), label="obstacle"))
    mission = world.mission or Mission()
    if mission.path:
        made.append(Line2D([], [], color=path, linestyle=(0, (4, 2)),
                           label="path of the information agents"))  # fmt: skip
    if mission.goal:
        made.append(Line2D([], [], color=goal, marker="*", markersize=11, linestyle="none",
                           label="goal"))  # fmt: skip
    return made


def faint_sign(*greys: str) -> Any:
    """What is said of a picture of density, beside the wheel of headings: that those not aligned
    are grey, and what else is."""
    from matplotlib.patches import Patch

    label = f"faint: sparse; grey: {' or '.join(('not aligned', *greys))}"
    return Patch(facecolor=palette.css(DENSE), label=label)


def draw_wheel(axes: Any, dim: int, of_density: bool) -> None:
    """The colours of headings in the plane, as a compass; in space a word on climbing."""
    from matplotlib.collections import PolyCollection

    angle = np.linspace(0.0, 2.0 * np.pi, WHEEL + 1)
    rim = np.column_stack([np.cos(angle), np.sin(angle)])
    sectors = np.stack([0.52 * rim[:-1], rim[:-1], rim[1:], 0.52 * rim[1:]], axis=1)
    middle = 0.5 * (angle[:-1] + angle[1:])
    colour = palette.heading_colours(np.column_stack([np.cos(middle), np.sin(middle)]))
    axes.add_collection(
        PolyCollection(list(sectors), facecolors=colour, edgecolors=colour, linewidths=0.3)
    )
    east, north, west, south = DIRECTIONS
    for words, x, y, side in (
        (east.replace(" ", "\n"), 1.2, 0, "left"),
        (north, 0, 1.3, "center"),
        (west, -1.2, 0, "right"),
        (south, 0, -1.3, "center"),
    ):
        axes.text(x, y, words, ha=side, va="center", fontsize=8, color=GREY)
    if dim == 3 and not of_density:
        axes.text(0, -1.72, "lighter: climbing", ha="center", va="center", fontsize=8, color=GREY)
    axes.set(xlim=(-2.0, 2.0), ylim=(-1.9, 1.5), aspect="equal", xticks=[], yticks=[])
    axes.spines[:].set_visible(False)
    axes.set_facecolor("none")


def draw_ruler(figure: Any, axes: Any, shot: Shot, y: float) -> None:
    """The scale bar of a plan, below the left edge of the world, at y, a share of the figure."""
    low, high = axes.get_xlim()
    length, words = ruler(shot, 0.22 * (high - low))
    begin = max(low, min(shot.now.world.low[0], high - length))
    ends = axes.transData.transform([(begin, 0.0), (begin + length, 0.0)])[:, 0]
    left, right = ends / figure.bbox.width
    bar(figure, (left, right), y, words)


def bar(figure: Any, x: tuple[float, float], y: float, words: str) -> None:
    """A bar with end marks from x to x at y, shares of the figure, and words behind it."""
    from matplotlib.lines import Line2D

    tall = 4.0 * figure.dpi / 72.0 / figure.bbox.height
    for xs, ys in (
        (x, (y, y)),
        ((x[0], x[0]), (y - tall, y + tall)),
        ((x[1], x[1]), (y - tall, y + tall)),
    ):
        figure.add_artist(Line2D(xs, ys, color=INK, linewidth=1.6, solid_capstyle="butt"))
    gap = 6.0 * figure.dpi / 72.0 / figure.bbox.width
    figure.text(x[1] + gap, y, words, va="center", ha="left", fontsize=10, color=INK)
