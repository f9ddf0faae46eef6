"""Layers of a flock with the flow of information, and how one UAV's direction comes about."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from app.studies.charts.boxes import draw_key
from app.studies.experiment import Experiment, flock_of
from app.studies.measure import Measure, Number, Settings

if TYPE_CHECKING:
    from agents import Flock
    from agents.inspection import Inspection

# Flocks whose layers and weights are looked at agent by agent: Liu et al. 2021, figure 2.


class LayeringSettings(Settings):
    """Nothing is to be said but the world: a flock is looked at before its first tick."""

    kind: ClassVar[str] = "layering"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("deepest", "deepest", "Deepest layer that is known", "layer", whole=True),
        Measure("cut_off", "cut off", "UAVs of no layer", "UAVs", whole=True),
        Measure(
            "off", "off", "UAVs whose layer is not that of the shortest way", "UAVs", whole=True
        ),
        Measure(
            "upper", "upper", "UAVs that heed a lower layer's neighbour more", "UAVs", whole=True
        ),
        Measure("angle", "angle", "Largest angle of a heading from the sum of vectors", "deg"),
    )

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Look at all UAVs, then let them fly for a tick and compare."""
        between()
        n = len(flock.ids)
        layers = flock.layers()
        is_known = layers <= n
        near = [flock.inspect(row) for row in range(n)]
        sums = np.array([vectors(flock, inspection).sum(axis=0) for inspection in near])
        upside_down = sum(heeds_lower(inspection, layers, n) for inspection in near)
        flock.run(1)
        steers = ~flock.informed & (np.linalg.norm(sums, axis=1) > 0.0)
        return {
            "deepest": int(layers[is_known].max()),
            "cut_off": int((~is_known).sum()),
            "off": int((layers != shortest_ways(flock_links(near), flock.informed)).sum()),
            "upper": upside_down,
            "angle": float(
                np.degrees(between_angles(sums, flock.heading)[steers].max(initial=0.0))
            ),
        }

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """One, and looking at every UAV costs as much as many."""
        return 1000.0


def flock_links(near: list[Inspection]) -> np.ndarray:
    """Which UAVs (row) know of which (column), (N, N) bool."""
    linked = np.zeros((len(near), len(near)), bool)
    for inspection in near:
        linked[inspection.row, inspection.neighbours] = True
    return linked


def shortest_ways(linked: np.ndarray, informed: np.ndarray) -> np.ndarray:
    """Layers by the shortest sequence of neighbours, (N,) int; N + 1 where there is none.

    The information UAVs are layer 1; a UAV that is n links away from them is in layer n + 1.
    """
    n = len(linked)
    layers = np.where(informed, 1, n + 1)
    for layer in range(1, n + 1):
        reached = linked[layers == layer].any(axis=0) & (layers > n)
        layers[reached] = layer + 1
    return layers


def shortest_way(layers: np.ndarray, linked: np.ndarray, row: int) -> list[int]:
    """Rows from an information UAV to `row`, each a layer further than the one before."""
    way = [row]
    while layers[way[0]] > 1:
        above = np.flatnonzero(linked[way[0]] & (layers == layers[way[0]] - 1))
        way.insert(0, int(above[0]))
    return way


def vectors(flock: Flock, inspection: Inspection) -> np.ndarray:
    """What each neighbour adds to the direction (18), h_ij times its heading, (M, dim)."""
    total = inspection.weights.sum()
    share = inspection.weights / total if total > 0.0 else inspection.weights
    return share[:, None] * flock.heading[inspection.neighbours]


def heeds_lower(inspection: Inspection, layers: np.ndarray, unknown: int) -> bool:
    """Whether a neighbour weighs as much as one of a layer nearer to the information UAV, or more.

    `unknown`: layers above it are not known.
    """
    their_layers = layers[inspection.neighbours]
    counts = their_layers <= unknown
    most: dict[int, float] = {}
    least: dict[int, float] = {}
    for layer, weight in zip(
        their_layers[counts].tolist(), inspection.weights[counts].tolist(), strict=True
    ):
        most[layer] = max(most.get(layer, 0.0), weight)
        least[layer] = min(least.get(layer, math.inf), weight)
    return any(most[low] >= least[up] > 0.0 for up in least for low in most if low > up)


def between_angles(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Angles between vectors (N, 2) and (N, 2), rad in [0, pi]; 0 where one has no length."""
    across = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return np.abs(np.arctan2(across, (a * b).sum(axis=1)))


COLOURS = ("#d6403a", "#0b2f66", "#12529b", "#2f7dc8", "#5fa4dc", "#8fc3e8", "#b6d8ee", "#d3e6f2")
"""Of layers 1, 2 and on; the last for all that follow."""
LOST, FLOW, WAY, INK = "#9aa3ad", "#1f9d63", "#e08214", "#3c434b"
RELATIVE = {
    -1: ("#0b2f66", "layer above $U_2$"),
    0: ("#2f7dc8", "its own"),
    1: ("#9aa3ad", "below"),
}
"""Colours and words of the vectors by how far their UAVs are below U_2."""
SHOWN = 6
"""Layer of U_1 in the paper."""
SHORT = 0.16
"""What is left out of an arrow at either end, length."""


def draw_layering(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw the first row's flock of that seed."""
    case = experiment.cases[0]
    flock = flock_of(case, seed)
    layers = flock.layers()
    near = [flock.inspect(row) for row in range(len(flock.ids))]
    linked = flock_links(near)
    first, second = first_uav(layers, linked), second_uav(layers, linked)
    figure.set_size_inches(12.6, 6.9)
    left, right = figure.subplots(1, 2, width_ratios=[1.15, 1.0])
    draw_topology(left, flock, layers, linked)
    way = shortest_way(layers, linked, first)
    left.plot(*flock.position[way].T, color=WAY, linewidth=3.4, zorder=3, solid_capstyle="round")
    for name, row in (("$U_1$", first), ("$U_2$", second)):
        left.annotate(
            name, flock.position[row], (11, 9), textcoords="offset points", fontsize=12, zorder=9,
            color=INK, bbox={"boxstyle": "round,pad=0.1", "facecolor": "white", "linewidth": 0},
        )  # fmt: skip
    left.set_title(
        f"(a) $U_1$ is in layer {layers[first]}: the shortest sequence has {len(way) - 1} links",
        loc="left",
    )
    added = vectors(flock, near[second])
    flock.run(1)
    below = layers[near[second].neighbours] - layers[second]
    draw_synthesis(right, added, below, flock.heading[second])
    draw_key(figure, signs(), f"{case.label}, N = {case.agents}, seed {seed}; numbers are layers")


def first_uav(layers: np.ndarray, linked: np.ndarray) -> int:
    """A UAV of the paper's layer, or the deepest less than it, with a neighbour of its own layer.

    By that neighbour alone it would be one layer further down.
    """
    for layer in range(min(SHOWN, int(layers[layers <= len(layers)].max())), 1, -1):
        for row in np.flatnonzero(layers == layer):
            if (linked[row] & (layers == layer)).any():
                return int(row)
    return int(layers.argmax())


def second_uav(layers: np.ndarray, linked: np.ndarray) -> int:
    """A UAV that hears the layer above it from more than one UAV, and other layers too."""

    def suits(row: int) -> tuple[int, int, int]:
        heard_layers = layers[linked[row]]
        upper = int((heard_layers == layers[row] - 1).sum())
        return min(upper, 2), len(set(heard_layers)), -len(heard_layers)

    rows = np.flatnonzero((layers > 2) & (layers <= SHOWN))
    return int(max(map(int, rows), key=suits, default=int(layers.argmax())))


def draw_topology(axes: Any, flock: Any, layers: np.ndarray, linked: np.ndarray) -> None:
    """Draw who knows of whom, who hears whom first, and the layer of each UAV."""
    from matplotlib.collections import LineCollection

    place = flock.position
    pairs = np.argwhere(np.triu(linked))
    axes.add_collection(
        LineCollection(list(place[pairs]), colors="#c9d1da", linewidths=0.8, zorder=1)
    )
    for row in range(len(place)):
        for above in np.flatnonzero(linked[row] & (layers == layers[row] - 1)):
            reach = place[row] - place[above]
            along = reach / np.linalg.norm(reach)
            start, end = place[above] + SHORT * along, place[row] - SHORT * along
            if (reach @ along) > 2.5 * SHORT:
                axes.annotate(
                    "", end, start, zorder=2,
                    arrowprops={
                        "arrowstyle": "-|>", "color": FLOW, "linewidth": 0.9,
                        "linestyle": (0, (4, 2)), "mutation_scale": 8, "shrinkA": 0,
                        "shrinkB": 0,
                    },
                )  # fmt: skip
    axes.scatter(
        *place.T, s=250, c=[colour_of(layer, len(place)) for layer in layers], edgecolors="white",
        linewidths=1.2, zorder=5, clip_on=False,
    )  # fmt: skip
    for at, layer in zip(place, layers, strict=True):
        axes.text(
            *at, "-" if layer > len(place) else str(layer), ha="center", va="center", fontsize=8.5,
            color="white" if layer < 5 or layer > len(place) else INK, zorder=6,
        )  # fmt: skip
    low, size = np.array(flock.world.low), np.array(flock.world.size)
    axes.set(
        xlim=(low[0] - 0.2, low[0] + size[0] + 0.1),
        ylim=(low[1] - 0.2, low[1] + size[1] + 0.1),
        xticks=[], yticks=[], aspect="equal",
    )  # fmt: skip
    axes.grid(visible=False)
    for spine in axes.spines.values():
        spine.set_visible(False)


def colour_of(layer: int, n: int) -> str:
    """The colour of a layer of a flock of n; grey where it is not known."""
    return LOST if layer > n else COLOURS[min(int(layer), len(COLOURS)) - 1]


def draw_synthesis(axes: Any, added: np.ndarray, below: np.ndarray, heading: np.ndarray) -> None:
    """Draw the vectors (M, 2) of the neighbours one after the other, their sum, the new heading.

    `below`: how many layers each neighbour is below U_2, -1 for the layer above it.
    """
    from matplotlib.lines import Line2D

    arrow: dict[str, Any] = {"angles": "xy", "scale_units": "xy", "scale": 1}
    at = np.zeros(2)
    corners = [at]
    for j in np.argsort(below, kind="stable"):
        colour = RELATIVE[int(np.clip(below[j], -1, 1))][0]
        axes.quiver(*at, *added[j], color=colour, width=0.007, zorder=5, **arrow)
        at = at + added[j]
        corners.append(at)
    axes.quiver(0.0, 0.0, *at, color=WAY, width=0.013, alpha=0.9, zorder=4, **arrow)
    end = 1.25 * float(np.linalg.norm(at)) * heading
    axes.plot(*np.array([[0.0, 0.0], end]).T, color=INK, linewidth=1.3, linestyle=(0, (1.5, 1.5)))
    axes.plot(0.0, 0.0, "o", color=INK, markersize=7, zorder=6)
    axes.annotate(
        "$U_2$", (0.0, 0.0), -16.0 * np.sign(at) - 6.0,
        textcoords="offset points", fontsize=12,
    )  # fmt: skip
    box = np.array([*corners, end])
    middle = 0.5 * (box.min(axis=0) + box.max(axis=0))
    half = 0.6 * float(np.ptp(box, axis=0).max())
    axes.set(
        xlim=(middle[0] - half, middle[0] + half),
        ylim=(middle[1] - half, middle[1] + half),
        xticks=[], yticks=[], aspect="equal",
    )  # fmt: skip
    axes.grid(visible=False)
    for spine in axes.spines.values():
        spine.set(visible=True, edgecolor="#c9d1da")
    lines = [Line2D([], [], color=colour, label=words) for colour, words in RELATIVE.values()]
    axes.legend(handles=lines, loc="best", fontsize=9)
    axes.set_title(f"(b) the direction of $U_2$ from its {len(added)} neighbours", loc="left")


def signs() -> list[Any]:
    """What is what."""
    from matplotlib.lines import Line2D

    dot: dict[str, Any] = {"marker": "o", "linestyle": "none", "markersize": 8}
    return [
        Line2D([], [], color=COLOURS[0], label="information UAV", **dot),
        Line2D([], [], color=COLOURS[1], label="layer 2", **dot),
        Line2D([], [], color=FLOW, linestyle=(0, (4, 2)), label="information flows"),
        Line2D([], [], color=WAY, linewidth=3.4, label="shortest sequence; sum of the vectors"),
        Line2D([], [], color=INK, linestyle=(0, (1.5, 1.5)), label="heading a tick later"),
    ]


PICTURES = {"layering": draw_layering}
