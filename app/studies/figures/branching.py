"""A flock at several ticks, each agent in the colour of what it goes by; and how it moves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field

from agents.inspection import obstacle_push
from agents.observables.order import polarisation
from app.studies.charts.boxes import draw_key
from app.studies.charts.mission_scene import draw_obstacles
from app.studies.charts.scheme_marks import (
    FAINT,
    INK,
    ZONE_COLOURS,
    arrow,
    draw_dart,
    set_square_view,
    sign,
    stroke,
)
from app.studies.experiment import Experiment, flock_of
from app.studies.figures.zoning import BRANCHES, branch_of, neighbours_by_definition
from app.studies.judge.verdict import Verdict, verdicts_on
from app.studies.measure import PERCENT, Measure, Number, Settings
from worlds.obstacles import Box

if TYPE_CHECKING:
    from agents import Flock
    from agents.snapshot import FlockState

# Which way through the algorithm agents take: the thesis, figures 3.5 and 4.5.

MARGIN = 1.0
"""Around a block, in which nobody starts, length."""


class BranchingSettings(Settings):
    """How long a flock is followed, and how often it is looked at."""

    kind: ClassVar[str] = "branching"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("obstacle", "obstacle", "Of all: an obstacle ahead pushes", "%", bounds=PERCENT),
        Measure("nobody", "nobody", "Of all: nobody is noticed", "%", bounds=PERCENT),
        Measure("repelled", "(3.9)", "Of all: repelled", "%", bounds=PERCENT),
        Measure("aligned", "(3.10)", "Of all: align only", "%", bounds=PERCENT),
        Measure("attracted", "(3.11)", "Of all: attracted only", "%", bounds=PERCENT),
        Measure("both", "(3.12)", "Of all: align and are attracted", "%", bounds=PERCENT),
    )

    limit: int = Field(ge=1)
    """Ticks that a flock is followed."""
    every: int = Field(ge=1)
    """Ticks from one look to the next; the first is before the first tick."""
    block: float | None = Field(None, gt=0.0)
    """Side of a square block in the middle of the box, in the plane; None: the world as it is."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Count which way agents that fly take; of agents times looks."""
        flock = self.prepare_flock(flock)
        counts, pushed, all_of_them = np.zeros(len(BRANCHES)), 0, 0
        for tick in range(0, self.limit + 1, self.every):
            between()
            flock.run(tick - flock.tick)
            for row in np.flatnonzero(flock.active):
                counts[branch_of(neighbours_by_definition(flock, int(row)).zone)] += 1
                pushed += bool(push_on(flock, int(row)).any())
                all_of_them += 1
        shares = 100.0 * counts / max(1, all_of_them)
        values: dict[str, Number | None] = dict(zip(BRANCHES, shares.tolist(), strict=True))
        return values | {"obstacle": 100.0 * pushed / max(1, all_of_them)}

    def prepare_flock(self, flock: Flock) -> Flock:
        """The flock as it is followed: with the block, where there is to be one."""
        return flock if self.block is None else add_block(flock, self.block)

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All; a look costs as much as many."""
        return self.limit * (1.0 + 20.0 / self.every)


def add_block(flock: Flock, side: float) -> Flock:
    """The same flock at its start with a square block in the middle of its box.

    Agents that would stand in it, or at it, stand beside it.
    """
    world = flock.world
    middle = np.array(world.low) + 0.5 * np.array(world.size)
    low, high = middle - 0.5 * side, middle + 0.5 * side
    block = Box(shape="box", low=tuple(low.tolist()), high=tuple(high.tolist()))
    position = flock.position.copy()
    near = (np.abs(position - middle) < 0.5 * side + MARGIN).all(axis=1)
    position[near, 0] += side + 2.0 * MARGIN
    start = {"position": position, "heading": flock.heading.copy(), "speed": flock.speed.copy()}
    spec = flock.options.but(world=replace(world, obstacles=(block,)), size=None)
    return type(flock)(spec, start=start)


def block_of(flock: FlockState):
    """The block as a polygon of shapely."""
    return flock.world.obstacles[0].footprint()


def push_on(flock: Flock, row: int) -> np.ndarray:
    """The force (4.1) of the obstacles on an agent, as its rule has it, (dim,)."""
    surroundings, context = flock.engine.surroundings, flock.context
    return obstacle_push(flock, surroundings, context, row, flock.interpret)


# The algorithm as a chart, with the share of agents that takes each way.

FLOW_BLOCK, FILL, ASKS = "#7b5ea7", "#f4f6f9", "#fdf6e3"
HIGH, STEP = 0.62, 1.25
"""Height of a box, and from one to the next, in units of the chart."""
MIDDLE, RIGHT, EDGE = (0.0, 2.3), (5.6, 1.6), 7.7
"""The two columns of boxes: middle and half the width; and where ways lead down on the right."""


def draw_flowchart(figure: Any, experiment: Experiment, verdicts: list[Verdict], seed: int) -> None:  # noqa: ARG001
    """Draw the chart of the first row, its ways marked with the means of its runs."""
    label = experiment.cases[0].label
    share = {
        verdict.measure.name: verdict.summary.mean
        for measure in {verdict.measure.name for verdict in verdicts}
        for verdict in verdicts_on(verdicts, measure)
        if verdict.case.label == label and verdict.summary.runs
    }
    avoids = share.get("obstacle", 0.0) > 0.0
    figure.set_size_inches(10.4, 9.4 if avoids else 8.6)
    axes = figure.subplots()
    draw_chart(axes, share, avoids)
    runs = max(verdict.summary.runs for verdict in verdicts)
    draw_key(
        figure, [],
        f"per cent: of agents times looks of {runs} runs of {label}, how many went that way; "
        "questions are asked from the top down;\n(3.9) to (3.12) are one another's alternatives"
        + ("; an obstacle's push is added to what they give (the thesis puts it first)" if avoids
           else ""),
    )  # fmt: skip


def draw_chart(axes: Any, share: dict[str, float], avoids: bool) -> None:
    """Draw boxes from the top down, and ways between them."""
    seen_share = 100.0 - share["nobody"]
    left = seen_share - share["repelled"]
    box(axes, MIDDLE, 0.0, "random places, headings and speeds", FILL, INK)
    draw_arrow_down(axes, 0.0)
    box(axes, MIDDLE, -STEP, "look around: who is within $d_a$ and in view?", ASKS, INK)
    draw_arrow_down(axes, -STEP)
    steps = [
        ("anyone noticed?", f"no: {share['nobody']:.0f} %", "keep the heading", INK,
         f"yes: {seen_share:.0f} %"),
        ("anyone in zor?", f"yes: {share['repelled']:.0f} %", "(3.9) away from them",
         ZONE_COLOURS[0], f"no: {left:.0f} %"),
        ("only in zoo?", f"yes: {share['aligned']:.0f} %", "(3.10) align", ZONE_COLOURS[1],
         f"no: {left - share['aligned']:.0f} %"),
        ("only in zoa?", f"yes: {share['attracted']:.0f} %", "(3.11) go there", ZONE_COLOURS[2],
         f"no: {share['both']:.0f} %"),
    ]  # fmt: skip
    y = -2.0 * STEP
    for question, way, answer, colour, rest in steps:
        box(axes, MIDDLE, y, question, ASKS, INK)
        draw_arrow_across(axes, y, way, colour)
        box(axes, RIGHT, y, answer, FILL, colour)
        path(axes, [(RIGHT[0] + RIGHT[1], y), (EDGE, y)])
        draw_arrow_down(axes, y, rest)
        y -= STEP
    box(axes, MIDDLE, y, "(3.12) the mean of both", FILL, FLOW_BLOCK)
    path(axes, [(EDGE, -2.0 * STEP), (EDGE, y - 0.5 * STEP), (0.0, y - 0.5 * STEP)])
    draw_arrow_down(axes, y)
    y -= STEP
    if avoids:
        box(axes, MIDDLE, y, "an obstacle ahead, within $Q^*$?", ASKS, INK)
        draw_arrow_across(axes, y, f"yes: {share['obstacle']:.0f} %", FLOW_BLOCK)
        box(axes, RIGHT, y, "(4.2) add its push (4.1)", FILL, FLOW_BLOCK)
        draw_arrow_down(axes, y, f"no: {100.0 - share['obstacle']:.0f} %")
        corner = y - 0.72 * STEP
        path(axes, [(RIGHT[0], y - 0.5 * HIGH), (RIGHT[0], corner), (0.0, corner)])
        y -= STEP
    box(axes, MIDDLE, y, "turn by at most $\\theta_{max}\\,\\tau$, fly for $\\tau$", FILL, INK)
    back, side = -MIDDLE[1] - 0.7, -MIDDLE[1]
    path(axes, [(side, y), (back, y), (back, -STEP), (side, -STEP)], arrow=True)
    axes.text(back - 0.15, 0.5 * (y - STEP), "next tick", rotation=90, ha="right", va="center")
    axes.set(xlim=(back - 0.6, EDGE + 0.3), ylim=(y - 0.6, 0.6), xticks=[], yticks=[])
    axes.grid(visible=False)
    for spine in axes.spines.values():
        spine.set_visible(False)


def box(
    axes: Any, column: tuple[float, float], y: float, words: str, fill: str, colour: str
) -> None:
    """A box with words in a column (middle, half its width)."""
    from matplotlib.patches import FancyBboxPatch

    x, half = column
    shape = "round,pad=0,rounding_size=0.12"
    axes.add_patch(
        FancyBboxPatch((x - half, y - 0.5 * HIGH), 2.0 * half, HIGH, shape, facecolor=fill,
                       edgecolor=colour, linewidth=1.3, zorder=3)
    )  # fmt: skip
    axes.text(x, y, words, ha="center", va="center", color=colour, fontsize=10, zorder=5)


def path(axes: Any, corners: list[tuple[float, float]], arrow: bool = False) -> None:
    """A way along corners, that ends in an arrow or in another way."""
    axes.plot(*zip(*corners, strict=True), color=INK, linewidth=1.1, zorder=1)
    if arrow:
        axes.annotate(
            "", corners[-1], corners[-2], zorder=2,
            arrowprops={"arrowstyle": "-|>", "color": INK, "shrinkA": 0, "shrinkB": 0},
        )  # fmt: skip


def draw_arrow_down(axes: Any, y: float, words: str = "") -> None:
    """A way from the box at y of the middle to the one below it, with its share."""
    path(axes, [(0.0, y - 0.5 * HIGH), (0.0, y - STEP + 0.5 * HIGH)], arrow=True)
    if words:
        axes.text(0.12, y - 0.46 * STEP, words, ha="left", va="center", color=INK, fontsize=9)


def draw_arrow_across(axes: Any, y: float, words: str, colour: str) -> None:
    """A way from a question to its answer on the right, with its share above it."""
    begin, end = MIDDLE[1], RIGHT[0] - RIGHT[1]
    path(axes, [(begin, y), (end, y)], arrow=True)
    axes.text(0.5 * (begin + end), y + 0.08, words, ha="center", va="bottom", color=colour,
              fontsize=9.5)  # fmt: skip


BLOCK_COLOUR = "#c0392b"
COLOURS = (FAINT, ZONE_COLOURS[0], ZONE_COLOURS[1], ZONE_COLOURS[2], "#7b5ea7")
WORDS = ("notices nobody", "(3.9) away", "(3.10) aligns", "(3.11) goes there", "(3.12) both")
SHOWN = 4


def draw_steps(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw the first row's flock of that seed at four ticks, the last at the experiment's end."""
    settings = experiment.settings
    assert isinstance(settings, BranchingSettings)
    case = experiment.cases[0]
    flock = settings.prepare_flock(flock_of(case, seed))
    ticks = [0, *(round(settings.limit * share) for share in (0.1, 0.4, 1.0))]
    figure.set_size_inches(11.0, 11.0)
    for axes, tick, letter in zip(figure.subplots(2, 2).ravel(), ticks, "abcd", strict=True):
        flock.run(tick - flock.tick)
        pushes = draw_flock(axes, flock)
        p = polarisation(flock.heading[flock.active])
        pushed_text = f", {pushes} pushed by an obstacle" if flock.world.is_solid else ""
        axes.set_title(f"({letter}) tick {tick}: polarisation {p:.2f}{pushed_text}", loc="left")
    signs = [sign(colour, words, ">") for colour, words in zip(COLOURS, WORDS, strict=True)]
    if flock.world.is_solid:
        signs.append(stroke(BLOCK_COLOUR, "push of obstacles"))
    draw_key(
        figure,
        signs,
        f"a run of {case.label}, N = {case.agents}, seed {seed}; the thesis draws a scheme",
    )


def draw_flock(axes: Any, flock: Any) -> int:
    """Draw a flock in its box; how many are pushed by an obstacle."""
    low, size = np.array(flock.world.low), np.array(flock.world.size)
    draw_obstacles(axes, flock.world)
    axes.add_patch(frame(low, size))
    place = np.where(flock.world.wraps, low + (flock.position - low) % size, flock.position)
    pushed = 0
    for row in np.flatnonzero(flock.active):
        branch = branch_of(neighbours_by_definition(flock, int(row)).zone)
        draw_dart(axes, place[row], flock.heading[row], COLOURS[branch], 0.042 * size[0])
        force = push_on(flock, int(row))
        if force.any():
            pushed += 1
            length = 0.03 + 0.05 * np.tanh(float(np.linalg.norm(force)))
            arrow(
                axes,
                place[row],
                length * size[0] * force / np.linalg.norm(force),
                BLOCK_COLOUR,
                1.3,
            )
    set_square_view(axes, low + 0.5 * size, 0.52 * float(size.max()))
    return pushed


def frame(low: np.ndarray, size: np.ndarray) -> Any:
    """The box."""
    from matplotlib.patches import Rectangle

    return Rectangle(tuple(low), *size, fill=False, edgecolor="#aab2bd", linewidth=1.0)


def draw_motion(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw how the agents move at the start and at the end: arrows as long as they are fast."""
    settings = experiment.settings
    assert isinstance(settings, BranchingSettings)
    case = experiment.cases[0]
    flock = settings.prepare_flock(flock_of(case, seed))
    figure.set_size_inches(11.6, 6.3)
    for axes, tick, letter in zip(figure.subplots(1, 2), (0, settings.limit), "ab", strict=True):
        flock.run(tick - flock.tick)
        low, size = np.array(flock.world.low), np.array(flock.world.size)
        place = np.where(flock.world.wraps, low + (flock.position - low) % size, flock.position)
        axes.add_patch(frame(low, size))
        for at, heading, speed in zip(place, flock.heading, flock.speed, strict=True):
            arrow(axes, at, 0.035 * size[0] * speed * heading, ZONE_COLOURS[2], 1.5, 5.0)
        axes.plot(*place.T, "o", markersize=8, markerfacecolor="white", markeredgecolor=INK,
                  linestyle="none", zorder=6)  # fmt: skip
        set_square_view(axes, low + 0.5 * size, 0.52 * float(size.max()))
        axes.set_title(
            f"({letter}) tick {tick}: speeds {flock.speed.min():.1f} to {flock.speed.max():.1f}, "
            f"polarisation {polarisation(flock.heading):.2f}", loc="left",
        )  # fmt: skip
    draw_key(
        figure, [sign(INK, "agent", "o", hollow=True), stroke(ZONE_COLOURS[2], "its velocity")],
        f"a run of {case.label}, N = {case.agents}, seed {seed}; an arrow is as long as the agent "
        "is fast",
    )  # fmt: skip


PICTURES = {"steps": draw_steps, "motion": draw_motion, "flowchart": draw_flowchart}
