"""The way of one agent round obstacles: where it splits and rejoins, and what it aims at."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
from pydantic import Field

from app.studies.charts.boxes import draw_key
from app.studies.charts.mission_scene import GOAL, draw_obstacles, draw_world, extent, show_box
from app.studies.experiment import Experiment, flock_of
from app.studies.measure import Measure, Number, Settings

if TYPE_CHECKING:
    from agents import Flock

# An agent alone that goes round obstacles: Wu et al. 2023, figures 3 and 4.

A1, A2, A3, A4 = 1.0, 2.0, 3.0, 4.0
"""The scenarios of Wu et al. 2023, table 2, as the rule counts them."""
CLOCKWISE = "clockwise"
FAR = math.inf
"""What counts as the least of nothing."""


class DetourTrack(NamedTuple):
    """What one agent did in each tick: where it was when it decided, and what it then knew."""

    position: np.ndarray
    """(T, 2), m."""
    scenario: np.ndarray
    """A1 to A4, (T,)."""
    split: np.ndarray
    """The last split point, (T, 2), m."""
    rejoin: np.ndarray
    """The last rejoin point, (T, 2), m."""
    aim: np.ndarray
    """The expected position, (T, 2), m."""
    phase: np.ndarray
    """Phase of the boundary point that is aimed at, (T,), rad."""
    goal: np.ndarray
    """The gamma agent, (2,), m."""

    def distances_to_goal(self, places: np.ndarray) -> np.ndarray:
        """Distances of places (T, 2) to the gamma agent, (T,), m."""
        return np.linalg.norm(places - self.goal, axis=1)

    @property
    def split_ticks(self) -> np.ndarray:
        """Ticks at which a split point is set, int (S,): A1, and A3 where the way goes on."""
        return np.flatnonzero((self.scenario == A1) | (self.scenario == A3))

    @property
    def rejoin_ticks(self) -> np.ndarray:
        """Ticks at which a rejoin point is set, int (R,)."""
        before = np.vstack([np.zeros((1, 2)), self.rejoin[:-1]])
        return np.flatnonzero((self.rejoin != before).any(axis=1))


class DetourSettings(Settings):
    """How long an agent is followed."""

    kind: ClassVar[str] = "detours"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("splits", "splits", "Split points", "points", whole=True),
        Measure("rejoins", "rejoins", "Rejoin points", "points", whole=True),
        Measure("again", "A3", "Rejoin points at which the way goes on", "points", whole=True),
        Measure(
            "gained",
            "gained",
            "Least that a rejoin point is nearer than its split point",
            "m",
            "none",
            FAR,
        ),
        Measure(
            "behind",
            "behind",
            "Least that A2 is further from the goal than its split point",
            "m",
            "no A2",
            FAR,
        ),
        Measure(
            "off", "off", "Largest difference of the phase aimed at from (15), (16)", "rad", "never"
        ),
        Measure("away", "away", "Distance to the gamma agent at the end", "m"),
    )

    limit: float = Field(gt=0.0)
    """How long an agent is followed, s."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Follow the only agent of a flock."""
        between()
        course = self.follow_agent(flock)
        rejoins, twice = course.rejoin_ticks, course.scenario == A2
        to_goal = course.distances_to_goal(course.position)
        of_split = course.distances_to_goal(course.split)
        gained = of_split[rejoins - 1] - course.distances_to_goal(course.rejoin)[rejoins]
        behind = to_goal[twice] - of_split[twice]
        return {
            "splits": len(course.split_ticks),
            "rejoins": len(rejoins),
            "again": int((course.scenario == A3).sum()),
            "gained": float(gained.min()) if len(gained) else None,
            "behind": float(behind.min()) if len(behind) else None,
            "off": phase_error(flock, course),
            "away": float(np.linalg.norm(flock.position[0] - course.goal)),
        }

    def follow_agent(self, flock: Flock) -> DetourTrack:
        """The course of the flock's first agent from tick 0 to the limit."""
        ticks = int(self.ticks(None, flock.dt))
        at = {name: k for k, name in enumerate(flock.model.columns)}
        position, positions = np.empty((ticks, 2)), np.empty((ticks, len(at)))
        for tick in range(ticks):
            position[tick] = flock.position[0]
            flock.run(1)
            positions[tick] = flock.arrays.memory[:, 0]
        points = {
            name: positions[:, [at[f"{name}_x"], at[f"{name}_y"]]]
            for name in ("split", "rejoin", "aim")
        }
        return DetourTrack(
            position=position,
            scenario=positions[:, at["scenario"]],
            phase=positions[:, at["phase"]],
            goal=flock.goal_at([0])[0],
            **points,
        )

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All of them."""
        return round(self.limit / dt)


def phase_error(flock: Flock, course: DetourTrack) -> float | None:
    """Largest difference of the phase aimed at from that of sorted phases, rad; None: never."""
    errors = [
        abs(course.phase[tick] - boundary_end(flock, course, tick)[1])
        for tick in map(int, np.flatnonzero(course.scenario < A4))
        if len(perceived_points(flock, course.position[tick]))
    ]
    return float(max(errors)) if errors else None


def perceived_points(flock: Flock, place: np.ndarray) -> np.ndarray:
    """The boundary points that an agent at a place (2,) perceives, (K, 2), m."""
    surroundings = flock.engine.surroundings
    points = np.column_stack([surroundings.point_x, surroundings.point_y])
    r = flock.parameters.r  # type: ignore[attr-defined]
    return points[np.linalg.norm(points - place, axis=1) <= r]


def phases(flock: Flock, course: DetourTrack, tick: int) -> tuple[np.ndarray, np.ndarray]:
    """Boundary points perceived at a tick in the order of their phases, (K, 2) m, (K,) rad.

    Phases are counted from the split point in A2, else from the gamma agent, in [0, 2 pi).
    """
    place = course.position[tick]
    towards = (course.split[tick] if course.scenario[tick] == A2 else course.goal) - place
    points = perceived_points(flock, place)
    angle = np.arctan2(points[:, 1] - place[1], points[:, 0] - place[0])
    phase = (angle - np.arctan2(towards[1], towards[0])) % (2.0 * np.pi)
    order = np.argsort(phase)
    return points[order], phase[order]


def boundary_end(flock: Flock, course: DetourTrack, tick: int) -> tuple[np.ndarray, float]:
    """The expected position (15), (16) at a tick, by sorting: the point, (2,) m, and its phase.

    From small to large, or clockwise from large to small, the first phase that the next differs
    from by dtheta or more; else the last.
    """
    points, phase = phases(flock, course, tick)
    p = flock.parameters
    if p.sense == CLOCKWISE:  # type: ignore[attr-defined]
        points, phase = points[::-1], phase[::-1]
    gaps = np.abs(np.diff(phase)) >= p.dtheta  # type: ignore[attr-defined]
    m = int(gaps.argmax()) if gaps.any() else len(phase) - 1
    return points[m], float(phase[m])


SCENARIOS = {A1: "#c0392b", A2: "#2166ac", A3: "#8e44ad", A4: "#7a828c"}
WORDS = {
    A1: "A1, split point",
    A2: "A2, between",
    A3: "A3, rejoin and go on",
    A4: "A4, straight to the goal",
}
NO_GAP = {"shrinkA": 0, "shrinkB": 0}
INK, AIM, SENSED = "#3c434b", "#e08214", "#f1f4f8"
NEARBY = 7.2
"""Half the side of a close look, m."""
APART = 1.2
"""Distance from which on points have a name each, m."""


def draw_detour(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw the way of the first row's agent of that seed, and its distance to the goal."""
    flock, course = course_of(experiment, seed)
    case = experiment.cases[0]
    figure.set_size_inches(12.6, 6.2)
    scene, distance = figure.subplots(1, 2, width_ratios=[1.15, 1.0])
    draw_world(scene, flock.world)
    draw_way(scene, course)
    show_box(scene, *extent(flock.world, course.position, 2.0))
    scene.set_xlabel("x / m")
    scene.set_ylabel("y / m")
    scene.set_title(f"one agent, {case.label}, seed {seed}", loc="left")
    draw_distance(distance, course, flock.dt)
    draw_key(figure, signs(course), "S: split points; R: rejoin points; in A3 every place is both")


def course_of(experiment: Experiment, seed: int) -> tuple[Any, DetourTrack]:
    """The first row's flock of that seed after its course, and the course."""
    settings = experiment.settings
    assert isinstance(settings, DetourSettings)
    flock = flock_of(experiment.cases[0], seed)
    return flock, settings.follow_agent(flock)


def draw_coloured_line(axes: Any, along: np.ndarray, course: DetourTrack) -> None:
    """Draw a line (T, 2) in the colours of the scenarios."""
    from matplotlib.collections import LineCollection

    pieces = np.stack([along[:-1], along[1:]], axis=1)
    colours = [SCENARIOS.get(code, INK) for code in course.scenario[:-1]]
    axes.add_collection(LineCollection(list(pieces), colors=colours, linewidths=2.2, zorder=4))


def draw_way(axes: Any, course: DetourTrack) -> None:
    """Draw the way with its split and rejoin points."""
    draw_coloured_line(axes, course.position, course)
    axes.plot(*course.position[0], "o", color=INK, markersize=7, zorder=6, markeredgecolor="white")
    for ticks, marker, colour, letter, shift in points_of(course):
        for number, tick in enumerate(ticks[spaced_indices(course.position[ticks])], 1):
            place = course.position[tick]
            axes.plot(*place, marker, color=colour, markersize=8, zorder=7, markeredgecolor="white")
            axes.annotate(
                f"${letter}_{{{number}}}$", place, shift, textcoords="offset points", ha="center",
                va="center", color=colour, fontsize=11, zorder=8,
            )  # fmt: skip


def points_of(course: DetourTrack) -> list[tuple[np.ndarray, str, str, str, tuple[float, float]]]:
    """Split and rejoin points: their ticks, marker, colour, letter and where the letter stands.

    On a way that comes nearer to the goal all the time (A3) each place is both: its first and its
    last are drawn.
    """
    splits = np.flatnonzero(course.scenario == A1)
    again = course.scenario[course.rejoin_ticks - 1] == A3
    follows = course.scenario[np.minimum(course.rejoin_ticks + 1, len(course.scenario) - 1)] == A3
    return [
        (splits, "s", SCENARIOS[A1], "S", (-9.0, -11.0)),
        (course.rejoin_ticks[~(again & follows)], "D", GOAL, "R", (9.0, 11.0)),
    ]


def spaced_indices(places: np.ndarray) -> list[int]:
    """Which of places (K, 2) are far enough from those before to bear a name of their own."""
    indices: list[int] = []
    for k, place in enumerate(places):
        if all(np.linalg.norm(place - places[j]) > APART for j in indices):
            indices.append(k)
    return indices


def draw_distance(axes: Any, course: DetourTrack, dt: float) -> None:
    """Draw the distance to the goal over time, and that of the split point while it counts."""
    time = dt * np.arange(len(course.position))
    away = course.distances_to_goal(course.position)
    draw_coloured_line(axes, np.column_stack([time, away]), course)
    follows = course.scenario < A4
    level = np.where(follows, course.distances_to_goal(course.split), np.nan)
    axes.plot(time, level, color=SCENARIOS[A1], linewidth=1.1, linestyle=(0, (4, 3)), zorder=3)
    for ticks, marker, colour, letter, shift in points_of(course):
        for number, tick in enumerate(ticks[spaced_indices(course.position[ticks])], 1):
            axes.plot(
                time[tick], away[tick], marker, color=colour, markersize=7, zorder=7,
                markeredgecolor="white",
            )  # fmt: skip
            axes.annotate(
                f"${letter}_{{{number}}}$", (time[tick], away[tick]), (shift[0], -shift[1]),
                textcoords="offset points", ha="center", va="center", color=colour, fontsize=11,
            )  # fmt: skip
    late = np.flatnonzero(away > 1.0)
    end = time[min(len(time) - 1, int(1.15 * (late[-1] if len(late) else len(time))))]
    axes.set_xlim(-0.02 * end, end)
    axes.set_ylim(0.0, 1.08 * float(away.max()))
    axes.set_xlabel("time / s")
    axes.set_ylabel("distance to the goal / m")
    axes.set_title("dashed: the distance of the split point", loc="left")


def signs(course: DetourTrack) -> list[Any]:
    """What is what."""
    from matplotlib.lines import Line2D

    present = set(course.scenario.tolist())
    handles = [
        Line2D([], [], color=SCENARIOS[code], linewidth=2.4, label=words)
        for code, words in WORDS.items()
        if code in present
    ]
    goal = Line2D([], [], color=GOAL, marker="^", linestyle="none", label="gamma agent")
    return [*handles, goal]


def draw_expected(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw how the expected position comes about at an instant of A2, and at one of A1 or A3."""
    flock, course = course_of(experiment, seed)
    figure.set_size_inches(12.6, 6.9)
    panels = figure.subplots(1, 2)
    gaps = []
    for axes, letter, tick in zip(panels, "ab", instants(course), strict=True):
        if tick is not None:
            gaps.append(draw_instant(axes, flock, course, tick))
            words = WORDS[course.scenario[tick]].split(",")[0]
            axes.set_title(f"({letter}) {words} at {tick * flock.dt:.2f} s", loc="left")
    case = experiment.cases[0]
    draw_key(
        figure,
        expected_signs(any(gaps)),
        f"one agent, {case.label}, seed {seed}; numbers: order of the phases",
    )


def instants(course: DetourTrack) -> tuple[int | None, int | None]:
    """The middle of the longest time in A2, and the first split point at which A2 begins."""
    twice = course.scenario == A2
    if not twice.any():
        return None, int(course.split_ticks[0]) if len(course.split_ticks) else None
    edges = np.flatnonzero(np.diff(np.concatenate([[0], twice.astype(int), [0]])))
    begins, ends = edges[::2], edges[1::2]
    longest = int((ends - begins).argmax())
    middle = int(begins[longest] + (ends[longest] - begins[longest]) // 3)
    before = course.split_ticks[course.split_ticks < begins[longest]]
    return middle, int(before[-1]) if len(before) else None


def draw_instant(axes: Any, flock: Any, course: DetourTrack, tick: int) -> bool:
    """Draw what an agent perceives, its axis, the gap in phase, and the point that it aims at.

    Returns whether there is a gap; without one it aims at the last point.
    """
    from matplotlib.patches import Circle

    r = flock.parameters.r
    place = course.position[tick]
    draw_obstacles(axes, flock.world)
    axes.add_patch(Circle(place, r, facecolor=SENSED, edgecolor="#aab2bd", linewidth=1.0, zorder=1))
    axes.plot(*course.position[: tick + 1].T, color=INK, linewidth=1.0, alpha=0.6, zorder=3)
    points, phase = phases(flock, course, tick)
    aim, angle = boundary_end(flock, course, tick)
    axes.scatter(
        *points.T, s=26, c=phase, cmap="viridis", zorder=6, edgecolors="white", linewidths=0.5
    )
    for number, point in enumerate(points, 1):
        if number in (1, len(points)) or number % 5 == 0:
            out = (point - place) / np.linalg.norm(point - place)
            axes.annotate(
                str(number), point, 9.0 * out, textcoords="offset points", ha="center", va="center",
                fontsize=7.5, color=INK, zorder=7,
            )  # fmt: skip
    twice = course.scenario[tick] == A2
    target = course.split[tick] if twice else course.goal
    words, colour = ("axis to S", SCENARIOS[A1]) if twice else ("axis to the gamma agent", GOAL)
    along = (target - place) / np.linalg.norm(target - place)
    arrow: dict[str, Any] = {"arrowstyle": "-|>", "linewidth": 1.8, "mutation_scale": 14} | NO_GAP
    axes.annotate(
        "", place + 0.9 * NEARBY * along, place, zorder=5,
        arrowprops=arrow | {"color": colour},
    )  # fmt: skip
    write_label(axes, place + 0.9 * NEARBY * along, along, words, colour)
    if twice:
        axes.plot(*course.split[tick], "s", color=SCENARIOS[A1], markersize=8, zorder=7)
    axes.annotate("", aim, place, arrowprops=arrow | {"color": AIM}, zorder=6)
    write_label(
        axes, aim, aim - place, f"$\\hat q$, phase {np.degrees(angle):.0f}°", AIM, outward=True
    )
    axes.plot(*aim, "o", markersize=12, markerfacecolor="none", markeredgecolor=AIM, zorder=8,
              markeredgewidth=1.8)  # fmt: skip
    axes.plot(*place, "o", color=INK, markersize=9, zorder=8, markeredgecolor="white")
    show_box(axes, place - NEARBY, place + NEARBY)
    axes.set_xlabel("x / m")
    axes.set_ylabel("y / m")
    return draw_gap(axes, flock, place, points, aim)


def write_label(
    axes: Any, at: np.ndarray, way: np.ndarray, words: str, colour: str, outward: bool = False
) -> None:
    """Write words at a place, inside of the panel, on a ground of their own."""
    side = 1.0 if outward == (way[0] > 0.0) else -1.0
    axes.annotate(
        words, at, (14.0 * side, 17.0 if outward else -10.0), textcoords="offset points",
        ha="right" if side < 0.0 else "left", va="center", color=colour, fontsize=10, zorder=9,
        bbox={"boxstyle": "round,pad=0.2", "facecolor": "white", "edgecolor": "none", "alpha": 0.9},
    )  # fmt: skip


def draw_gap(axes: Any, flock: Any, place: np.ndarray, points: np.ndarray, aim: np.ndarray) -> bool:
    """Draw the gap in phase behind the point that is aimed at; whether there is one."""
    from matplotlib.patches import Wedge

    k = int(np.linalg.norm(points - aim, axis=1).argmin())
    step = -1 if flock.parameters.sense == "clockwise" else 1
    if not 0 <= k + step < len(points):
        return False
    edges = [points[k], points[k + step]][::step]
    first, last = (np.degrees(np.arctan2(*(edge - place)[::-1])) for edge in edges)
    axes.add_patch(
        Wedge(
            (place[0], place[1]),
            0.35 * flock.parameters.r,
            first,
            last,
            facecolor=AIM,
            alpha=0.25,
            zorder=2.5,
        )
    )
    return True


def expected_signs(gap: bool) -> list[Any]:
    """What is what."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    dot: dict[str, Any] = {"marker": "o", "linestyle": "none"}
    return [
        Line2D([], [], color=INK, markersize=9, label="the agent", **dot),
        Line2D(
            [], [], color="#31688e", markersize=6, label="boundary points that it perceives", **dot
        ),
        Line2D(
            [],
            [],
            color=AIM,
            markersize=11,
            markerfacecolor="none",
            label="expected position",
            **dot,
        ),
        *(
            [Patch(facecolor=AIM, alpha=0.25, label="gap of $\\Delta\\theta$ or more")]
            if gap
            else []
        ),
        Line2D([], [], color=SCENARIOS[A1], marker="s", linestyle="none", label="split point S"),
    ]


PICTURES = {"detour": draw_detour, "expected": draw_expected}
