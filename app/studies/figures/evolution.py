"""One evolution from disorder to consistency: four snapshots of it, and Deg_con over the ticks."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from app.studies.charts.boxes import draw_key, runs_with_value
from app.studies.experiment import Experiment, flock_of
from app.studies.figures.convergence import ConvergenceSettings
from app.studies.judge.verdict import Verdict, verdicts_on
from app.studies.measure import SHARE, Measure, Number

if TYPE_CHECKING:
    from agents import Flock

# Runs from disorder to consistency, measured at both ends: Liu et al. 2021, figure 4.


class EvolutionSettings(ConvergenceSettings):
    """When a flock counts as consistent, and when a run is given up."""

    kind: ClassVar[str] = "evolution"
    measures: ClassVar[tuple[Measure, ...]] = (
        *ConvergenceSettings.measures,
        Measure("order_0", "order at 0", "Polarisation at the start", "1", bounds=SHARE),
        Measure("deg_0", "Deg_con at 0", "Degree of consistency (28) at the start", "1"),
        Measure("order", "order", "Polarisation when the run ends", "1", bounds=SHARE),
        Measure("deg", "Deg_con", "Degree of consistency (28) when the run ends", "1"),
    )

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """k_con (27), and the flock before and after; k_con is None if the run was given up."""
        before = {"order_0": order(flock), "deg_0": consistency(flock)}
        after = super().run(flock, between)
        return after | before | {"order": order(flock), "deg": consistency(flock)}


def order(flock: Flock) -> float:
    """The polarisation of a flock now, in [0, 1]."""
    return float(flock.observe("polarisation"))


def consistency(flock: Flock) -> float:
    """Deg_con (28) of a flock now, in [0, 1]."""
    return float(flock.observe("consistency"))


SHARES = (0.0, 0.25, 0.5, 1.0)
"""Instants of the snapshots, as shares of k_con."""
AFTER = 1.6
"""How far the curve goes on, of k_con."""
LINE, DESIRED, RUNS = "#2166ac", "#1f9d63", "#7a828c"
INFORMED = "#d6403a"
EDGE = 0.15
"""Room around the box, in which half of an arrow head may stand, length."""
RAMP = ("#2166ac", "#7b4fa3", "#e08214")
"""Colours of headings from that of the information UAV to the opposite one."""


def draw_evolution(figure: Any, experiment: Experiment, verdicts: list[Verdict], seed: int) -> None:
    """Draw the first row's run of that seed, and where all runs became consistent."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LinearSegmentedColormap, Normalize

    case, settings = experiment.cases[0], experiment.settings
    assert isinstance(settings, EvolutionSettings)
    k_con = settings.run(flock_of(case, seed), lambda: None)["k_con"]
    end = settings.limit if k_con is None else max(int(k_con), len(SHARES))
    instants = [round(share * end) for share in SHARES]
    figure.set_size_inches(12.6, 6.9)
    left, right = figure.subfigures(1, 2, width_ratios=[1.0, 1.0])
    boxes = left.subplots(2, 2)
    curve = right.subplots()
    ramp = LinearSegmentedColormap.from_list("away", RAMP)
    flock = flock_of(case, seed)
    times = runs_with_value(verdicts_on(verdicts, "k_con")[0].values)
    degrees = []
    for k in range(round(max(AFTER * end, times.max(initial=0.0) + 1.0)) + 1):
        if k in instants:
            at = instants.index(k)
            draw_flock(boxes.flat[at], flock, ramp)
            boxes.flat[at].set_title(f"({'abcd'[at]}) k = {k}", loc="left")
        degrees.append(consistency(flock))
        flock.run(1)
    draw_curve(curve, np.array(degrees), instants, settings.desired)
    curve.plot(
        times, np.full(times.size, settings.desired), "|", color=RUNS, markersize=9, alpha=0.6
    )
    curve.set_title(
        f"seed {seed}: " + ("not consistent" if k_con is None else f"consistent from k = {k_con}"),
        loc="left",
    )
    bar = left.colorbar(
        ScalarMappable(Normalize(0.0, 180.0), ramp),
        ax=boxes,
        location="bottom",
        ticks=[0, 45, 90, 135, 180],
        shrink=0.6,
        aspect=40,
    )
    bar.outline.set_visible(False)
    bar.set_label("heading, away from that of the information UAV / deg", fontsize=9)
    draw_key(figure, signs(times.size), "")


def draw_flock(axes: Any, flock: Any, ramp: Any) -> None:
    """Draw the flock in its box: arrow heads, coloured by how far their headings are off."""
    from matplotlib.patches import Rectangle

    low, size = np.array(flock.world.low), np.array(flock.world.size)
    place = np.where(flock.world.wraps, flock.position % size, flock.position)
    along = np.clip(flock.heading @ flock.heading[flock.informed][0], -1.0, 1.0)
    colour = ramp(np.arccos(along) / np.pi)
    for rows, colours, width in (
        (~flock.informed, colour[~flock.informed], 0.009),
        (flock.informed, INFORMED, 0.021),
    ):
        axes.quiver(
            *place[rows].T, *flock.heading[rows].T, color=colours, pivot="mid", units="width",
            width=width, scale=26, headwidth=4.4, headlength=5.0, headaxislength=4.4, zorder=5,
        )  # fmt: skip
    axes.add_patch(Rectangle((low[0], low[1]), *size, fill=False, edgecolor="#aab2bd"))
    axes.set(
        xlim=(low[0] - EDGE, low[0] + size[0] + EDGE),
        ylim=(low[1] - EDGE, low[1] + size[1] + EDGE),
        xticks=[],
        yticks=[],
        aspect="equal",
    )
    axes.grid(visible=False)
    for spine in axes.spines.values():
        spine.set_visible(False)


def draw_curve(axes: Any, degrees: np.ndarray, instants: list[int], desired: float) -> None:
    """Draw Deg_con (K,) over the ticks, with the instants of the snapshots."""
    axes.axhline(desired, color=DESIRED, linewidth=1.4)
    axes.annotate(
        f"$Deg_{{con}}^d$ = {desired:g}", (0.0, desired), (0, -14),
        textcoords="offset points", color=DESIRED, fontsize=9,
    )  # fmt: skip
    axes.plot(degrees, color=LINE, linewidth=2.0)
    axes.plot(instants, degrees[instants], "o", color=LINE, markersize=6, markeredgecolor="white")
    for letter, k in zip("abcd", instants, strict=True):
        axes.annotate(
            f"({letter})", (k, degrees[k]), (7, -11), textcoords="offset points", fontsize=9
        )
    axes.set_xlim(-0.02 * len(degrees), len(degrees) - 1)
    axes.xaxis.get_major_locator().set_params(integer=True)
    axes.set_xlabel("k / ticks")
    axes.set_ylabel("$Deg_{con}(k)$")


def signs(runs: int) -> list[Any]:
    """What is what."""
    from matplotlib.lines import Line2D

    return [
        Line2D([], [], color=INFORMED, marker=">", linestyle="none", label="information UAV"),
        Line2D([], [], color=LINE, linewidth=2.0, label="the run shown"),
        Line2D(
            [], [], color=RUNS, marker="|", markersize=9, linestyle="none",
            label=f"$k_{{con}}$ of all {runs} runs",
        ),
    ]  # fmt: skip


PICTURES = {"evolution": draw_evolution}
