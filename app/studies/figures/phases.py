"""Maps of polarisation and angular momentum with the phases, and both there and back."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field

from app.studies.charts.boxes import draw_key
from app.studies.charts.mean_line import INTERVAL_WORDS, draw_mean_bars
from app.studies.experiment import Case
from app.studies.judge.statistics import MeasureSummary
from app.studies.judge.verdict import Verdict, name
from app.studies.measure import PERCENT, SHARE, Measure, Number, Settings
from worlds.input_error import InputError

if TYPE_CHECKING:
    from agents import Flock

# Runs in which a group without walls takes a shape: Couzin et al. 2002, figure 3 and after.

PHASES = ("fragments", "swarm", "torus", "dynamic parallel", "highly parallel")
"""Names of Couzin et al. 2002, and one for groups that have come apart."""
TRIES = 300
"""How often agents that detect nobody are placed anew before a start is refused."""


class PhaseSettings(Settings):
    """How long a group is left alone and followed, and from what on it counts as which phase."""

    kind: ClassVar[str] = "phases"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("p", "p", "Polarisation (4)", "1", bounds=SHARE),
        Measure("m", "m", "Angular momentum (5)", "1"),
        Measure("largest", "largest", "Agents in the largest group", "%", bounds=PERCENT),
        Measure("mixing", "mixing", "Change of places between two looks, of the radius", "1"),
        Measure("phase", "phase", "Phase by these measures", "1", whole=True, words=PHASES),
    )

    settle: int = Field(ge=0)
    """Ticks before a group is looked at, from its start."""
    hold: int = Field(ge=0)
    """Ticks before it is looked at after a parameter was changed."""
    looks: int = Field(ge=1)
    """How often it is looked at; the measures are means over the looks."""
    every: int = Field(ge=1)
    """Ticks between two looks."""
    whole: float = Field(95.0, gt=0.0, le=100.0)
    """Share of the agents in the largest group below which a group has come apart, %."""
    polarised: float = Field(0.5, gt=0.0, lt=1.0)
    """p from which on a group is parallel."""
    mills: float = Field(0.5, gt=0.0, lt=1.0)
    """m from which on a group that is not parallel is a torus."""
    mixes: float = Field(0.04, gt=0.0)
    """Mixing from which on a parallel group is dynamic."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Let the group settle, then look at it."""
        if flock.tick == 0:
            place_in_sight(flock)
        between()
        flock.run(self.hold if flock.tick else self.settle)
        before = centred_positions(flock)
        samples = []
        for _ in range(self.looks):
            between()
            flock.run(self.every)
            now = centred_positions(flock)
            radius = float(np.sqrt((now**2).sum(axis=1).mean()))
            samples.append(
                (
                    flock.observe("polarisation"),
                    flock.observe("angular-momentum"),
                    100.0 * flock.observe("largest-group") / len(flock.ids),
                    float(np.sqrt(((now - before) ** 2).sum(axis=1).mean())) / radius,
                )
            )
            before = now
        p, m, largest, mixing = (float(mean) for mean in np.mean(samples, axis=0))
        phase = PHASES.index(self.phase_of(p, m, largest, mixing))
        return {"p": p, "m": m, "largest": largest, "mixing": mixing, "phase": phase}

    def phase_of(self, p: float, m: float, largest: float, mixing: float) -> str:
        """The phase of a run with these measures, one of `PHASES`.

        >>> settings = PhaseSettings(world="open", settle=0, hold=0, looks=1, every=1)
        >>> settings.phase_of(0.2, 0.7, 100.0, 1.1)
        'torus'
        """
        if largest < self.whole:
            return "fragments"
        if p >= self.polarised:
            return "dynamic parallel" if mixing >= self.mixes else "highly parallel"
        return "torus" if m >= self.mills else "swarm"

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All of them, from the start."""
        return self.settle + self.looks * self.every


def centred_positions(flock: Flock) -> np.ndarray:
    """Where the agents are, seen from their centre, (N, dim), length."""
    return flock.position - flock.position.mean(axis=0)


def place_in_sight(flock: Flock) -> None:
    """Place agents anew, within the box, until each detects at least one other, as the paper has.

    An agent detects those in its zone of repulsion and those that are in its field of view and no
    further than the zone of attraction reaches. Raises InputError if that does not come about.
    """
    low, size = np.array(flock.world.low), np.array(flock.world.size)
    for _ in range(TRIES):
        alone = ~detects(flock)
        if not alone.any():
            return
        n = int(alone.sum())
        flock.position[alone] = low + flock.rng.uniform(0.0, 1.0, (n, len(low))) * size
        direction = flock.rng.normal(size=(n, len(low)))
        flock.heading[alone] = direction / np.linalg.norm(direction, axis=1, keepdims=True)
    raise InputError(
        f"agents = {len(flock.ids)} cannot be placed in {size.tolist()} so that each detects "
        f"another within {flock.reach:g}"
    )


def detects(flock: Flock) -> np.ndarray:
    """Whether each agent detects at least one other, (N,) bool."""
    p = flock.parameters
    pairs = flock.links()
    i, j = np.concatenate([pairs, pairs[:, ::-1]]).T
    apart = flock.position[j] - flock.position[i]
    distance = np.linalg.norm(apart, axis=1)
    along = (apart * flock.heading[i]).sum(axis=1)
    edge = np.cos(np.radians(0.5 * p.alpha))  # type: ignore[attr-defined]
    near = (distance < p.r_r) | (along >= edge * distance)  # type: ignore[attr-defined]
    return np.bincount(i[near], minlength=len(flock.ids)) > 0


# Phases over the parameters of a sweep: what was measured at each place, and what is claimed.


@dataclass(frozen=True)
class PhasePoint:
    """One place of the map: the runs of a case."""

    case: Case
    p: MeasureSummary
    m: MeasureSummary
    phase: str
    """The commonest."""
    share: float
    """Of the runs that are in it, in [0, 1]."""

    @property
    def x(self) -> float:
        """The value of the sweep's parameter."""
        return float(self.case.value or 0.0)

    @property
    def y(self) -> float:
        """The value of its second parameter."""
        return float(self.case.at or 0.0)


def phase_points(verdicts: list[Verdict]) -> list[PhasePoint]:
    """All places, those of maps and those of ways there and back, in the order of the cases."""
    by_case: dict[int, dict[str, Verdict]] = {}
    for verdict in verdicts:
        by_case.setdefault(id(verdict.case), {})[verdict.measure.name] = verdict
    return [
        PhasePoint(row["p"].case, row["p"].summary, row["m"].summary, *row["phase"].commonest_word)
        for row in by_case.values()
    ]


def map_points(verdicts: list[Verdict]) -> list[PhasePoint]:
    """The places of the map."""
    return [spot for spot in phase_points(verdicts) if not spot.case.way]


def way_points(verdicts: list[Verdict]) -> list[tuple[PhasePoint, PhasePoint]]:
    """The places of the way there, each with the same place on the way back."""
    points = phase_points(verdicts)
    outward = [spot for spot in points if spot.case.way == "there"]
    back = [spot for spot in points if spot.case.way == "back"]
    return list(zip(outward, back[::-1], strict=True))


P_COLOURS, M_COLOURS = "Blues", "Purples"
THERE, BACK = "#2166ac", "#c0392b"
LETTERS = {
    "fragments": "F",
    "swarm": "S",
    "torus": "T",
    "dynamic parallel": "D",
    "highly parallel": "H",
}
WORDS = (
    "S swarm, T torus, D dynamic parallel, H highly parallel, F (hatched) fragments: the "
    "phase of most runs; small letters: of less than 80 % of them"
)
HATCH = "#8a93a077"
SURE = 0.8
"""Share of the runs from which on a letter is large."""


def draw_phases(figure: Any, verdicts: list[Verdict]) -> None:
    """Draw the maps above, the ways there and back below."""
    points, ways = map_points(verdicts), way_points(verdicts)
    rows = [
        names
        for names, points_there in ((["p", "m"], points), (["up", "um"], ways))
        if points_there
    ]
    figure.set_size_inches(12.4, 1.0 + (4.6 if points else 0.0) + (3.4 if ways else 0.0))
    heights = [4.6 if "p" in names else 3.4 for names in rows]
    panels = figure.subplot_mosaic(rows, height_ratios=heights)
    if points:
        draw_map(
            figure, panels["p"], points, [s.p.mean for s in points], P_COLOURS, "polarisation p"
        )
        draw_map(
            figure, panels["m"], points, [s.m.mean for s in points], M_COLOURS, "angular momentum m"
        )
    if ways:
        draw_ways(panels["up"], ways, "p")
        draw_ways(panels["um"], ways, "m")
        handles = panels["up"].get_legend_handles_labels()[0]
        draw_key(figure, handles, f"{WORDS}; {INTERVAL_WORDS}")


def draw_map(
    figure: Any, axes: Any, points: list[PhasePoint], values: list[float], colours: str, title: str
) -> None:
    """Draw a map as equal squares, whatever the steps between the values."""
    from matplotlib.patches import Rectangle

    xs, ys = sorted({spot.x for spot in points}), sorted({spot.y for spot in points})
    grid = np.full((len(ys), len(xs)), np.nan)
    for spot, value in zip(points, values, strict=True):
        grid[ys.index(spot.y), xs.index(spot.x)] = value
    mesh = axes.pcolormesh(grid, cmap=colours, vmin=0.0, vmax=1.0, edgecolors="white", linewidth=1)
    for spot, value in zip(points, values, strict=True):
        letter = LETTERS[spot.phase] if spot.share >= SURE else LETTERS[spot.phase].lower()
        x, y = xs.index(spot.x), ys.index(spot.y)
        if spot.phase == "fragments":
            axes.add_patch(
                Rectangle((x, y), 1.0, 1.0, fill=False, hatch="///", linewidth=0, edgecolor=HATCH)
            )
        axes.text(
            x + 0.5,
            y + 0.5,
            f"{letter}\n{value:.2f}",
            ha="center",
            va="center",
            fontsize=8,
            linespacing=1.1,
            color="white" if value > 0.55 else "#2b3138",
        )
    sweep = points[0].case.own_sweep
    axes.grid(visible=False)
    axes.set_xticks(np.arange(len(xs)) + 0.5, [f"{x:g}" for x in xs])
    axes.set_yticks(np.arange(len(ys)) + 0.5, [f"{y:g}" for y in ys])
    axes.tick_params(length=0)
    axes.set_xlabel(symbol(sweep.parameter))
    axes.set_ylabel(symbol(sweep.against))
    axes.set_title(title, loc="left")
    for spine in axes.spines.values():
        spine.set_visible(False)
    figure.colorbar(mesh, ax=axes, fraction=0.03, pad=0.01)


def draw_ways(axes: Any, ways: list[tuple[PhasePoint, PhasePoint]], measure: str) -> None:
    """Draw a measure on the way there and on the way back."""
    for k, (colour, marker, label, arrow) in enumerate(
        [(THERE, "o", "wider and wider", ">"), (BACK, "s", "narrower and narrower", "<")]
    ):
        summaries = [getattr(pair[k], measure) for pair in ways]
        places = [pair[k].x for pair in ways]
        draw_mean_bars(axes, places, summaries, colour, label, marker=marker, linewidth=1.8)
        middle = len(ways) // 2
        (x0, y0), (x1, y1) = [(ways[i][k].x, summaries[i].mean) for i in (middle, middle + 1)]
        axes.plot(0.5 * (x0 + x1), 0.5 * (y0 + y1), arrow, color=colour, markersize=9)
    sweep = ways[0][0].case.own_sweep
    fixed = ", ".join(f"{symbol(key)} = {name(value)}" for key, value in sweep.fixed.items())
    axes.set_title(f"{symbol(sweep.parameter)} up and down within a run, {fixed}", loc="left")
    axes.set_xlabel(symbol(sweep.parameter))
    axes.set_ylabel(measure)
    axes.set_ylim(-0.03, 1.05)


def symbol(parameter: str) -> str:
    """A parameter as a formula writes it."""
    return {"dr_o": r"$\Delta r_o$", "dr_a": r"$\Delta r_a$"}.get(parameter, parameter)


PICTURES = {"phases": draw_phases}
