"""A flock at its start: in its box, and how its speeds, headings and distances are spread."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from agents.observables.order import polarisation
from app.studies.experiment import Experiment, flock_of
from app.studies.figures.gathering import draw_box
from app.studies.measure import RARE, SHARE, Measure, Number, Settings
from worlds.queries.clearance import clearance

if TYPE_CHECKING:
    from agents import Flock

# How flocks begin: the flock at tick 0, before anything has moved; thesis, figures 5.3 and 5.6.


class BeginningSettings(Settings):
    """Nothing is to be said but the world: a flock is made, and looked at."""

    kind: ClassVar[str] = "beginning"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("agents", "agents", "Agents that fly", "agents", whole=True),
        Measure("obstacles", "obstacles", "Obstacles", "obstacles", whole=True),
        Measure(
            "crashed", "crashed", "Agents that have crashed", "agents", whole=True, bounds=RARE
        ),
        Measure(
            "inside",
            "inside",
            "Agents inside an obstacle or out of the box",
            "agents",
            whole=True,
            bounds=RARE,
        ),
        Measure("clear", "clear", "Least distance to what is solid", "length", "nothing is solid"),
        Measure("pair", "pair", "Least distance of two agents", "length", "one agent"),
        Measure("p", "p", "Polarisation", "1", bounds=SHARE),
        Measure("speed", "speed", "Mean speed", "length/s"),
        Measure("spread", "spread", "Standard deviation of the speeds", "length/s"),
    )

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Measure the flock as it is made."""
        between()
        low, size = np.array(flock.world.low), np.array(flock.world.size)
        clear = clearance(flock.world, flock.position)
        out = ((flock.position < low) | (flock.position > low + size)).any(axis=1)
        pairs = nearest_distances(flock)
        solid = flock.world.is_solid
        return {
            "agents": int(flock.active.sum()),
            "obstacles": len(flock.world.obstacles),
            "crashed": len(flock.crashes.tick),
            "inside": int((out | (solid & (clear <= 0.0))).sum()),
            "clear": float(clear.min()) if solid else None,
            "pair": float(pairs.min()) if len(pairs) > 1 else None,
            "p": polarisation(flock.heading),
            "speed": float(flock.speed.mean()),
            "spread": float(flock.speed.std()),
        }

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """None is run; making a flock counts as one."""
        return 1.0


def nearest_distances(flock: Flock) -> np.ndarray:
    """Distance of each agent to the nearest other one, (N,), length; across edges that wrap."""
    apart = flock.position[:, None] - flock.position
    size = np.where(flock.world.images, flock.world.size, np.inf)
    apart -= np.where(np.isinf(size), 0.0, size) * np.round(apart / size)
    distance = np.linalg.norm(apart, axis=2)
    np.fill_diagonal(distance, np.inf)
    return distance.min(axis=1)


RAMP = ("#d9b8ea", "#7b2fa8", "#2e0a47")
"""Violet, the darker the faster, as in the thesis."""
BARS, CHANCE = "#8e5bb0", "#1f9d63"
BINS = 10


def draw_start(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw the first row's flock of that seed before its first tick."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LinearSegmentedColormap, Normalize

    case = experiment.cases[0]
    flock = flock_of(case, seed)
    figure.set_size_inches(12.0, 6.4)
    left, right = figure.subfigures(1, 2, width_ratios=[1.75, 1.0])
    axes = left.subplots(subplot_kw={"projection": "3d"})
    fastest = float(flock.speed.max())
    scale = Normalize(0.0, fastest)
    ramp = LinearSegmentedColormap.from_list("speed", RAMP)
    draw_box(axes, flock, list(ramp(scale(flock.speed[flock.active]))))
    blocks = f", {len(flock.world.obstacles)} blocks" if flock.world.obstacles else ""
    axes.set_title(f"{case.agents} agents{blocks}, seed {seed}, before the first tick", loc="left")
    bar = left.colorbar(
        ScalarMappable(scale, ramp), ax=axes, location="bottom", shrink=0.45, aspect=30, pad=0.0
    )
    bar.outline.set_visible(False)
    bar.set_label("speed / (length/s)", fontsize=9)
    panels = right.subplots(3, 1)
    draw_spread(panels[0], flock.speed, (0.0, fastest), "speed / (length/s)")
    draw_spread(panels[1], flock.heading[:, 2], (-1.0, 1.0), "upward part of the heading")
    near = nearest_distances(flock)
    draw_spread(
        panels[2],
        near,
        (0.0, float(near.max())),
        "distance to the nearest agent / length",
        even=False,
    )


def draw_spread(
    axes: Any, values: np.ndarray, span: tuple[float, float], words: str, even: bool = True
) -> None:
    """Draw how many agents have which value (N,); `even`: beside what chance makes of each bin."""
    axes.hist(values, bins=BINS, range=span, color=BARS, rwidth=0.92)
    if even:
        axes.axhline(len(values) / BINS, color=CHANCE, linewidth=1.3, linestyle=(0, (4, 3)))
        axes.annotate(
            "dashed: evenly spread", (1.0, 1.0), xycoords="axes fraction", xytext=(0, 3),
            textcoords="offset points", ha="right", fontsize=8, color=CHANCE,
        )  # fmt: skip
    axes.set_xlim(*span)
    axes.xaxis.get_major_locator().set_params(nbins=5)
    axes.set_xlabel(words)
    axes.set_ylabel("agents")


PICTURES = {"start": draw_start}
