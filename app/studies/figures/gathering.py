"""Crashes at the start of every run beside the published runs, and crashes over time."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise, product
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field, field_validator

from agents.observables.groups import group_labels, group_sizes
from agents.observables.neighbours import links
from agents.observables.order import polarisation
from app.studies.charts.boxes import draw_key, runs_with_value
from app.studies.experiment import Experiment, flock_of
from app.studies.figures.convergence import PUBLISHED
from app.studies.judge.verdict import Verdict, verdicts_on
from app.studies.measure import PERCENT, RARE, RARE_PERCENT, SUCCESS, Measure, Number, Settings
from worlds.number_text import counted

if TYPE_CHECKING:
    from agents import Flock

# Runs in which a flock gathers and agents may crash: the thesis, chapters 5 and 6, figure 3.7.


class GatheringSettings(Settings):
    """When a flock is looked at, and which crashes are late."""

    kind: ClassVar[str] = "gathering"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("at_0", "at 0", "Crashes at tick 0", "agents", whole=True, bounds=RARE),
        Measure("early", "early", "Crashes later, but not late", "agents", whole=True, bounds=RARE),
        Measure("late", "late", "Late crashes", "agents", whole=True, bounds=RARE),
        Measure(
            "crashed",
            "crashed",
            "Agents that crash after tick 0, of those that flew then",
            "%",
            "nobody flew",
            bounds=RARE_PERCENT,
        ),
        Measure("groups", "groups", "Groups of those that fly", "groups", whole=True),
        Measure(
            "one",
            "one",
            "Runs in which all that fly are one group",
            "%",
            whole=True,
            bounds=SUCCESS,
        ),
        Measure(
            "largest",
            "largest",
            "Those that fly that are in the largest group",
            "%",
            bounds=PERCENT,
        ),
        Measure("p", "p", "Polarisation of those that fly", "1"),
    )

    looks: list[int] = Field(min_length=1)
    """Ticks at which a run is looked at, each later than the one before; crashes so far count."""
    late: int = Field(100, ge=0)
    """Tick after which a crash is late."""
    words: dict[str, str] = Field(default_factory=dict)
    """What the paper sees, by tick."""

    @field_validator("looks")
    @classmethod
    def _rise(cls, looks: list[int]) -> list[int]:
        if any(b <= a for a, b in pairwise([0, *looks])):
            raise ValueError("looks must be above 0 and rise")
        return looks

    @field_validator("words")
    @classmethod
    def _at_ticks(cls, words: dict[str, str]) -> dict[str, str]:
        if not all(tick.isdigit() for tick in words):
            raise ValueError("words need ticks")
        return words

    @property
    def stops(self) -> list[int]:
        """The looks."""
        return self.looks

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Run to the next look."""
        tick = next(tick for tick in self.looks if tick > flock.tick)
        between()
        flock.run(tick - flock.tick)
        return self.measured(flock)

    def measured(self, flock: Flock) -> dict[str, Number | None]:
        """The measures of a flock as it stands."""
        when = flock.crashes.tick
        up = flock.active
        sizes = group_sizes(groups_of(flock))
        return {
            "at_0": int((when == 0).sum()),
            "early": int(((when > 0) & (when <= self.late)).sum()),
            "late": int((when > self.late).sum()),
            "crashed": share_crashed(when, len(up)),
            "groups": len(sizes),
            "one": 100 * int(len(sizes) == 1),
            "largest": 100.0 * float(sizes[0] / up.sum()) if len(sizes) else None,
            "p": polarisation(flock.heading[up]) if up.any() else None,
        }

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """Those of one look."""
        return self.looks[-1] / len(self.looks)


def share_crashed(when: np.ndarray, agents: int) -> float | None:
    """Of agents that flew after tick 0, those that crashed later, %; `when`: ticks of crashes."""
    flew = agents - int((when == 0).sum())
    return 100.0 * float((when > 0).sum() / flew) if flew else None


def groups_of(flock: Flock) -> np.ndarray:
    """The group of each agent that flies, int (M,), 0 the largest: nearer than d_a hang together.

    d_a is the radius of the zone of attraction, as the thesis's model has it.
    """
    position = flock.position[flock.active]
    d_a = flock.parameters.d_a  # type: ignore[attr-defined]
    return group_labels(len(position), links(position, d_a, flock.world.size, flock.world.images))


# A flock in its box, drawn in three dimensions: who hangs together, who lies on the floor.

GROUPS = ("#2166ac", "#d9822b", "#1f9d63", "#8e44ad", "#b8860b", "#16808a")
"""Colours of the largest groups; alone are those of one."""
ALONE, CRASHED = "#7a828c", "#c0392b"
SOLID, EDGE, FLOOR = "#9fb4cc", "#aab2bd", "#eef1f4"
LENGTH = 0.06
"""Length of an arrow, of the box's longest side."""


def draw_box(axes: Any, flock: Any, shades: list[Any] | None = None) -> None:
    """Draw the box, its obstacles and the flock as it stands.

    `shades`: colours of those that fly; None: those of their groups.
    """
    from mpl_toolkits.mplot3d.art3d import (  # type: ignore[import-untyped]
        Line3DCollection,
        Poly3DCollection,
    )

    low, size = np.array(flock.world.low), np.array(flock.world.size)
    # Depth is left to the order of drawing: the floor would else hide those that lie on it.
    axes.computed_zorder = False
    axes.add_collection3d(Poly3DCollection([faces_of(low, size)[0]], facecolor=FLOOR))
    axes.add_collection3d(Line3DCollection(edges_of(low, size), colors=EDGE, linewidths=0.7))
    for obstacle in flock.world.obstacles:
        for outline, bottom, top in obstacle.spans():
            foot = low[2] if bottom is None else bottom
            height = (low[2] + size[2] if top is None else top) - foot
            x0, y0, x1, y1 = outline.bounds
            corner = np.array([x0, y0, foot])
            faces = faces_of(corner, np.array([x1 - x0, y1 - y0, height]))
            axes.add_collection3d(
                Poly3DCollection(
                    faces, facecolor=SOLID, edgecolor="white", linewidth=0.4, alpha=0.3
                )
            )
    draw_flock(axes, flock, LENGTH * float(size.max()), shades)
    axes.set(
        xlim=(low[0], low[0] + size[0]),
        ylim=(low[1], low[1] + size[1]),
        zlim=(low[2], low[2] + size[2]),
    )
    axes.set_proj_type("ortho")
    axes.set_box_aspect(size, zoom=1.1)
    axes.view_init(20, -60)
    axes.set_axis_off()


def draw_flock(axes: Any, flock: Any, length: float, shades: list[Any] | None = None) -> None:
    """Draw those that fly as arrows, those that have crashed as crosses."""
    up = flock.active
    place = np.where(flock.world.wraps, flock.position % flock.world.size, flock.position)
    if not up.all():
        axes.scatter(
            *place[~up].T, marker="x", s=16, color=CRASHED, linewidths=1.2, depthshade=False
        )
    fly, way = place[up], flock.heading[up] * length
    if len(fly):
        axes.quiver(
            *(fly - 0.5 * way).T,
            *way.T,
            colors=shades or colours(groups_of(flock)),
            linewidths=1.3,
            arrow_length_ratio=0.45,
        )


def colours(labels: np.ndarray) -> list[str]:
    """The colour of each agent's group; grey for those that are alone or in one of many."""
    sizes = np.bincount(labels)
    return [
        GROUPS[label] if label < len(GROUPS) and sizes[label] > 1 else ALONE for label in labels
    ]


def edges_of(low: np.ndarray, size: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """The twelve edges of a box."""
    corners = [np.array(corner) for corner in product((0.0, 1.0), repeat=3)]
    return [
        (low + a * size, low + b * size)
        for k, a in enumerate(corners)
        for b in corners[k + 1 :]
        if np.abs(a - b).sum() == 1.0
    ]


def faces_of(low: np.ndarray, size: np.ndarray) -> list[np.ndarray]:
    """The six faces of a box, (4, 3) each, the floor first."""
    faces = []
    for axis in (2, 1, 0):
        i, j = (k for k in range(3) if k != axis)
        for end in (0.0, 1.0):
            face = np.zeros((4, 3))
            face[:, axis] = end
            face[:, i] = (0.0, 1.0, 1.0, 0.0)
            face[:, j] = (0.0, 0.0, 1.0, 1.0)
            faces.append(low + face * size)
    return faces


# A flock that gathers: groups and polarisation over time, and one run in its box.

COLOURS = ("#2166ac", "#b07d12", "#1f9d63", "#c0392b", "#8e44ad")
CURVES = (("groups", "groups"), ("largest", "in the largest group / %"), ("p", "polarisation"))


def draw_gathering(figure: Any, experiment: Experiment, verdicts: list[Verdict], seed: int) -> None:
    """Draw the curves of all rows above, the first row's run of that seed below."""
    settings = experiment.settings
    assert isinstance(settings, GatheringSettings)
    captions = {int(tick): text for tick, text in settings.words.items()}
    letters = "abcdef"[: len(captions)]
    figure.set_size_inches(12.8, 8.0)
    above, below = figure.subfigures(2, 1, height_ratios=[1.0, 1.25])
    panels = above.subplots(1, 3)
    for axes, (measure, title) in zip(panels, CURVES, strict=True):
        draw_curve(axes, verdicts_on(verdicts, measure), experiment)
        axes.set_title(title, loc="left")
        axes.set_xlabel("tick")
        for tick in captions:
            axes.axvline(tick, color="#c3ccd6", linewidth=0.9, zorder=0.5)
    panels[0].set_ylim(0.0, None)
    panels[1].set_ylim(0.0, 104.0)
    panels[2].set_ylim(0.0, 1.04)
    case = experiment.cases[0]
    flock = flock_of(case, seed)
    boxes = below.subplots(1, len(captions), subplot_kw={"projection": "3d"}, squeeze=False)[0]
    for axes, letter, (tick, text) in zip(boxes, letters, captions.items(), strict=True):
        flock.run(tick - flock.tick)
        draw_box(axes, flock)
        title = f"({letter}) tick {tick}: {measure_gathering(settings, flock)}\n{text}"
        axes.set_title(title, loc="left", fontsize=9)
    draw_key(
        figure,
        signs(panels[0]),
        "above: mean and quartiles of the runs; below: a run of "
        f"{case.label}, seed {seed}, its groups in colours, over it what is measured of it, and in "
        "quotation marks what the source says of its own run",
    )


def measure_gathering(settings: GatheringSettings, flock: Flock) -> str:
    """What the picture shows, measured."""
    values = settings.measured(flock)
    groups, p = int(values["groups"] or 0), values["p"]
    return "nobody flies" if p is None else f"{counted(groups, 'group')}, p = {p:.2f}"


def draw_curve(axes: Any, points: list[Verdict], experiment: Experiment) -> None:
    """Draw a measure over the ticks, a line and a band for each row."""
    rows = list(dict.fromkeys(id(case.row) for case in experiment.cases))
    for row, colour in zip(rows, COLOURS, strict=False):
        mine = [point for point in points if id(point.case.row) == row and point.summary.runs]
        ticks = [verdict.case.tick for verdict in mine]
        quartiles = np.array([verdict.summary.quartiles for verdict in mine])
        if len(mine):
            axes.fill_between(ticks, quartiles[:, 0], quartiles[:, 2], color=colour, alpha=0.18)
            axes.plot(
                ticks,
                [runs_with_value(verdict.values).mean() for verdict in mine],
                color=colour,
                linewidth=1.8,
                label=mine[0].case.label,
            )


def signs(axes: Any) -> list[Any]:
    """What is what."""
    from matplotlib.lines import Line2D

    handles = axes.get_legend_handles_labels()[0]
    flies = Line2D([], [], color=GROUPS[0], marker=">", linestyle="none", label="largest group")
    lies = Line2D([], [], color=CRASHED, marker="x", linestyle="none", label="crashed")
    return [*handles, flies, lies]


WIDTH = 0.3


def draw_crashes(figure: Any, verdicts: list[Verdict]) -> None:
    """Draw both panels."""
    figure.set_size_inches(12.4, 5.2)
    left, right = figure.subplots(1, 2, width_ratios=[1.0, 1.15])
    rows: dict[int, list[Verdict]] = {}
    for verdict in verdicts:
        rows.setdefault(id(verdict.case.row), []).append(verdict)
    for x, (row, colour) in enumerate(zip(rows.values(), COLOURS, strict=False)):
        draw_start(left, x, verdicts_on(row, "at_0")[-1], colour)
        draw_course(right, row, colour)
    left.set_xticks(range(len(rows)), [row[0].case.label for row in rows.values()])
    left.tick_params(axis="x", length=0)
    left.set_ylabel("crashes at tick 0")
    left.set_ylim(-0.5, None)
    right.set_xscale("symlog", linthresh=1.0)
    right.set_xlabel("tick")
    right.set_ylabel("crashes so far, mean of the runs")
    right.set_ylim(0.0, None)
    right.minorticks_off()
    crash_signs(figure)


def draw_start(axes: Any, x: int, verdict: Verdict, colour: str) -> None:
    """Draw the crashes at tick 0: a dot for each run, the mean, and the published runs beside."""
    values = runs_with_value(verdict.values)
    aside = np.random.default_rng(0).uniform(-0.6 * WIDTH, 0.6 * WIDTH, values.size)
    axes.plot(x - 0.2 + aside, values, ".", color=colour, markersize=5, alpha=0.5)
    axes.plot([x - 0.2 - WIDTH / 2, x - 0.2 + WIDTH / 2], [values.mean()] * 2, color=colour, lw=2.4)
    if verdict.published and verdict.published.values:
        published = np.array(verdict.published.values)
        axes.plot(
            [x + 0.22] * published.size, published, "D", color=PUBLISHED, markersize=6, alpha=0.75
        )
        axes.plot([x + 0.1, x + 0.34], [published.mean()] * 2, color=PUBLISHED, lw=2.0)


def draw_course(axes: Any, row: list[Verdict], colour: str) -> None:
    """Draw the mean number of crashes up to each look."""
    counts = [verdicts_on(row, measure) for measure in ("at_0", "early", "late")]
    ticks = [verdict.case.tick for verdict in counts[0]]
    total = [sum(value.summary.mean for value in look) for look in zip(*counts, strict=True)]
    axes.plot(ticks, total, color=colour, marker="o", markersize=4, label=row[0].case.label)


def crash_signs(figure: Any) -> None:
    """Say what is what, below the panels."""
    from matplotlib.lines import Line2D

    course = figure.axes[1].get_legend_handles_labels()[0]
    thesis = Line2D(
        [], [], marker="D", color=PUBLISHED, linestyle="none", label="the thesis's five runs"
    )
    draw_key(figure, [*course, thesis], "dots: runs; bars: means")


PICTURES = {"crashes": draw_crashes, "gathering": draw_gathering}
