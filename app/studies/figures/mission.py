"""A mission at six instants: where the flock is in the scene, and how it looks from close."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
from pydantic import Field

from agents import Flock
from agents.observables.following import KERNELS
from agents.run_records import MissionRecord, fly
from app.studies.charts.mission_scene import (
    AGENT,
    INFORMED,
    LOST,
    PATH,
    draw_agents,
    draw_links,
    draw_trails,
    draw_world,
    extent,
    show_box,
)
from app.studies.experiment import Case, Experiment, flock_of
from app.studies.measure import COUNT, EITHER, RARE, RARE_PERCENT, Measure, Number, Settings
from worlds.queries.clearance import clearance

if TYPE_CHECKING:
    from agents import Flock
    from agents.run_records import MissionRecord

# Runs of a mission from its start to the end: Liu et al. 2021, section 3.2; Wu et al. 2023.

FAR = math.inf


class MissionSettings(Settings):
    """How long a mission may last, and when the flock counts as settled."""

    kind: ClassVar[str] = "mission"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("ticks", "ticks", "Ticks that the mission lasted", "ticks", whole=True),
        Measure(
            "arrived",
            "arrived",
            "Whether the path was flown to its end",
            "1",
            whole=True,
            bounds=EITHER,
        ),
        Measure(
            "success", "P_s", "Agents that have followed all the time", "%", bounds=RARE_PERCENT
        ),
        Measure(
            "d_obs",
            "D_obs",
            "Least distance to an obstacle",
            "length",
            "never near one",
            FAR,
            bounds=RARE,
        ),
        Measure(
            "d_ind",
            "D_ind",
            "Least distance of two that follow",
            "length",
            "none follow",
            FAR,
            bounds=RARE,
        ),
        Measure(
            "d_pair",
            "d_pair",
            "Least distance of two agents",
            "length",
            "one agent",
            FAR,
            bounds=RARE,
        ),
        Measure(
            "d_least",
            "d_least",
            "Least distance to anything",
            "length",
            "never near",
            FAR,
            bounds=RARE,
        ),
        Measure(
            "settled",
            "settled",
            "Time until the centre stays at the goal",
            "s",
            "never",
            FAR,
            bounds=COUNT,
            limited=True,
        ),
        Measure(
            "through",
            "through",
            "Agents that came to the goal",
            "%",
            "no goal",
            bounds=RARE_PERCENT,
        ),
    )
    measured_by: ClassVar[tuple[Callable, ...]] = KERNELS

    limit: float = Field(gt=0.0)
    """Time after which a run ends, in the body's unit: ticks or s."""
    within: float = Field(2.0, gt=0.0)
    """Distance of the flock's centre to the goal within which it is there, length."""
    spacing: float | None = Field(None, gt=0.0)
    """Distance that the agents of a flock at its goal keep, length."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Fly the mission and measure it."""
        ticks = round(self.limit / flock.dt)
        return self.measure_record(fly(flock, ticks, every=ticks, between=between))

    def measure_record(self, record: MissionRecord) -> dict[str, Number | None]:
        """The measures of a mission."""
        goal = len(record.away) > 0
        led = bool(record.informed.any())
        near = min(record.least_pair, record.least_obstacle)
        return {
            "ticks": record.ticks,
            "arrived": int(record.arrived),
            "success": 100.0 * record.success if led else None,
            "d_obs": finite(record.least_obstacle),
            "d_ind": finite(record.least_pair_of_followers) if led else None,
            "d_pair": finite(record.least_pair),
            "d_least": finite(near),
            "settled": record.settled(self.within) if goal else None,
            "through": 100.0 * record.through(self.spacing) if goal and self.spacing else None,
        }

    def limits_of(
        self, measure: Measure, values: Mapping[str, Sequence[Number | None]]
    ) -> list[float | None]:
        """As for all, but for a run that ended earlier, at the end of its path."""
        limits = super().limits_of(measure, values)
        ended = values.get("arrived")
        if not (measure.limited and ended):
            return limits
        return [None if early else limit for limit, early in zip(limits, ended, strict=True)]

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All of them."""
        return self.limit / dt

    def compile(self, flock: Flock) -> None:
        """Compile what measures a mission."""
        fly(flock, 1)


def finite(value: float) -> float | None:
    """A distance; None for that to nothing, which is infinite."""
    return value if math.isfinite(value) else None


# One run of an experiment flown again for a picture, with all of its positions.

FRAMES = 1500
"""Positions kept of a run, about."""


class FlownMission(NamedTuple):
    """A flock at the end of its mission, and how it went."""

    flock: Flock
    record: MissionRecord


def fly_mission(
    experiment: Experiment, case: Case, seed: int, every: int | None = None
) -> FlownMission:
    """Fly the run of a case with that seed; keep every so many ticks, or about FRAMES in all."""
    settings = experiment.settings
    assert isinstance(settings, MissionSettings)
    flock = flock_of(case, seed)
    ticks = round(settings.limit / flock.dt)
    return FlownMission(flock, fly(flock, ticks, every=every or max(1, ticks // FRAMES)))


# A whole mission of one run: the scene with every trajectory, and two details of it.

SETUP = np.array([8.0, 4.6])
DETAIL = np.array([2.4, 1.38])
"""Half the sides of the details, length."""
NEAR = "#1d5fd1"
PASSAGE = "#c0392b"


def draw_mission(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw the first row's run of that seed."""
    case = experiment.cases[0]
    flight = fly_mission(experiment, case, seed)
    figure.set_size_inches(12.4, 8.2)
    panels = figure.subplot_mosaic([["all", "all"], ["setup", "detail"]], height_ratios=[1.12, 1.0])
    page, setup, detail = panels["all"], panels["setup"], panels["detail"]
    for axes in panels.values():
        draw_world(axes, flight.flock.world)
        draw_trails(axes, flight.record.position, colours(flight))
        leaders = flight.record.position[:, flight.record.informed]
        draw_trails(axes, leaders, [INFORMED] * leaders.shape[1], 2.0, 1.0)
        draw_agents(axes, flight.record.position[0], colours(flight), 5.0)
    draw_agents(page, flight.record.position[-1], colours(flight), 10.0)
    record = flight.record
    show_box(page, *extent(flight.flock.world, record.position[:, record.follows], 1.0))
    page.set_title(
        f"{case.label}, N = {case.agents}, seed {seed}: {record.success:.0%} follow to the end, "
        f"{record.ticks} ticks",
        loc="left",
    )
    low, high = busiest_corner(flight)
    show_box(setup, low, high)
    draw_detail_frame(page, low, high, PASSAGE)
    frame(setup, PASSAGE, "the obstacles")
    row, place = closest_approach(flight)
    show_box(detail, place - DETAIL, place + DETAIL)
    draw_detail_frame(page, place - DETAIL, place + DETAIL, NEAR)
    frame(detail, NEAR, "an agent avoids an obstacle")
    detail.plot(*record.position[:, row, :2].T, "-", color=NEAR, linewidth=2.0, zorder=4)
    detail.plot(*record.position[:, row, :2].T, ".", color=NEAR, markersize=5, zorder=4.1)
    signs(figure)


def colours(flight: FlownMission) -> list[str]:
    """A colour for each agent: informed, following or lost."""
    record = flight.record
    return [
        INFORMED if informed else AGENT if follows else LOST
        for informed, follows in zip(record.informed, record.follows, strict=True)
    ]


def busiest_corner(flight: FlownMission) -> tuple[np.ndarray, np.ndarray]:
    """The corners of a box that holds the largest number of obstacles close to each other."""
    bounds = np.array([obstacle.footprint().bounds for obstacle in flight.flock.world.obstacles])
    centre = (bounds[:, :2] + bounds[:, 2:]) / 2.0
    inside = [(np.abs(centre - coordinate) <= SETUP).all(axis=1) for coordinate in centre]
    most = max(inside, key=np.count_nonzero)
    middle = (bounds[most, :2].min(axis=0) + bounds[most, 2:].max(axis=0)) / 2.0
    return middle - SETUP, middle + SETUP


def closest_approach(flight: FlownMission) -> tuple[int, np.ndarray]:
    """The agent that followed and came closest to an obstacle, and where (2,)."""
    record = flight.record
    ordinary = record.follows & ~record.informed
    rows = np.flatnonzero(ordinary if ordinary.any() else record.follows)
    row = int(rows[record.clearance[rows].argmin()])
    track = record.position[:, row]
    return row, track[clearance(flight.flock.world, track).argmin(), :2]


def draw_detail_frame(axes: Any, low: np.ndarray, high: np.ndarray, colour: str) -> None:
    """Draw the frame of a detail."""
    from matplotlib.patches import Rectangle

    axes.add_patch(
        Rectangle((low[0], low[1]), *(high - low), fill=False, edgecolor=colour, linewidth=1.2,
                  linestyle=(0, (2, 1.5)), zorder=7)
    )  # fmt: skip


def frame(axes: Any, colour: str, words: str) -> None:
    """Make the axes the frame of a detail."""
    for spine in axes.spines.values():
        spine.set(visible=True, edgecolor=colour, linewidth=1.2, linestyle=(0, (2, 1.5)))
    axes.set_title(words, loc="left", color=colour)


def signs(figure: Any) -> None:
    """Say what is what."""
    from matplotlib.lines import Line2D

    lines = {"information UAV": INFORMED, "follows to the end": AGENT, "lost the flock": LOST}
    handles = [Line2D([], [], color=colour, linewidth=2, label=k) for k, colour in lines.items()]
    way = Line2D(
        [], [], color=PATH, marker="o", markersize=3.5, linestyle=(0, (5, 4)), label="path"
    )
    figure.legend(handles=[*handles, way], loc="outside lower left", ncols=4, fontsize=9)


INSTANTS = (1, 80, 320, 485, 560)
"""k of Liu et al. 2021, figure 8; the sixth is the end."""
HALF = np.array([4.4, 3.0])
"""Half the sides of a panel, length."""
COLOURS = ("#12427c", "#2f74b8", "#6aa9d8", "#a7cfe8")
"""Colours of layers 2, 3, 4 and further."""


def draw_snapshots(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw the first row's run of that seed."""
    case = experiment.cases[0]
    assert isinstance(experiment.settings, MissionSettings)
    end = fly_mission(experiment, case, seed).record.ticks
    figure.set_size_inches(12.4, 10.6)
    figure.get_layout_engine().set(h_pad=0.1)
    panels = figure.subplot_mosaic(
        [["all"] * 3, list("abc"), list("def")], height_ratios=[1.12, 1, 1]
    )
    panel = panels["all"]
    flock = flock_of(case, seed)
    draw_world(panel, flock.world)
    places = []
    for letter, k in zip("abcdef", (*(k for k in INSTANTS if k < end), end), strict=False):
        flock.run(k - flock.tick)
        near = flock.layers() <= len(flock.ids)
        middle = np.median(flock.position[near], axis=0)[:2]
        draw_one(panels[letter], flock, middle)
        panels[letter].set_title(f"({letter}) k = {k}", loc="left")
        panel.scatter(*flock.position[:, :2].T, s=8, c=layer_colours(flock), zorder=5)
        top = flock.position[near, 1].max()
        panel.annotate(
            f"({letter})", (middle[0], top), (0, 6), textcoords="offset points", ha="center"
        )
        places.append(flock.position[near])
    show_box(panel, *extent(flock.world, np.concatenate(places), 1.6))
    panel.set_title(f"{case.label}, N = {case.agents}, seed {seed}", loc="left")
    snapshot_signs(figure)


def draw_one(axes: Any, flock: Any, middle: np.ndarray) -> None:
    """Draw the flock around a place: links, and agents as arrow heads in their layer's colour."""
    draw_world(axes, flock.world)
    draw_links(axes, flock.position, flock.links())
    axes.quiver(
        *flock.position[:, :2].T, *flock.heading[:, :2].T, color=layer_colours(flock), zorder=5,
        pivot="mid", units="width", width=0.009, scale=30, headwidth=4.6, headlength=5.6,
        headaxislength=4.6,
    )  # fmt: skip
    show_box(axes, middle - HALF, middle + HALF)


def layer_colours(flock: Any) -> list[str]:
    """A colour for each agent by its layer; grey without a link to the information UAV."""
    n = len(flock.ids)
    return [
        LOST if layer > n else INFORMED if layer == 1 else COLOURS[min(layer - 2, len(COLOURS) - 1)]
        for layer in flock.layers()
    ]


def snapshot_signs(figure: Any) -> None:
    """Say what is what."""
    from matplotlib.lines import Line2D

    names = ["information UAV", "layer 2", "layer 3", "layer 4", "layer 5 and on", "cut off"]
    handles = [
        Line2D([], [], color=colour, marker=">", linestyle="none", label=name)
        for name, colour in zip(names, (INFORMED, *COLOURS, LOST), strict=True)
    ]
    figure.legend(handles=handles, loc="outside lower left", ncols=6, fontsize=9)


PICTURES = {"mission": draw_mission, "snapshots": draw_snapshots}
