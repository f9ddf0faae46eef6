"""The regions about an agent, and the force between two agents over their distance."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np
from pydantic import Field

from app.studies.charts.boxes import draw_key
from app.studies.charts.scheme_marks import INK, arrow, set_square_view, sign, stroke, write_label
from app.studies.experiment import Experiment, flock_of
from app.studies.measure import Measure, Number, Settings

if TYPE_CHECKING:
    from agents import Flock

# Two agents put down at distances from each other: Wu et al. 2023, figure 2 and (12).

FORCE = "alpha gradient"
"""What the rule calls the term that (12) weighs."""
CLEAR = 0.02
"""Share of r within which of it nothing is asked: the force fades to 0 there."""


class Pushes(NamedTuple):
    """What one agent does to another; K distances."""

    distance: np.ndarray
    """(K,), m."""
    force: np.ndarray
    """Of the rule along the line to the other, (K,), m/s^2; below 0 it repels."""
    bare: np.ndarray
    """The same without the weight of (12), (K,), counted apart from the rule."""

    @property
    def weight(self) -> np.ndarray:
        """eta(d) as the rule has it, (K,)."""
        return self.force / self.bare


class RegionSettings(Settings):
    """How often two agents are put down."""

    kind: ClassVar[str] = "regions"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("off", "off", "Largest error of the weight from (12), as a share of it", "1"),
        Measure("warning", "d_e", "Distance at which the weight jumps to tau_s", "m"),
        Measure("separation", "separation", "Weakest push nearer than d_e", "m/s^2"),
        Measure("early", "early warning", "Strongest push between d_e and d", "m/s^2"),
        Measure("attraction", "attraction", "Strongest pull beyond d", "m/s^2"),
        Measure("wrong", "wrong", "Times that the force points the wrong way", "times", whole=True),
    )

    looks: int = Field(200, ge=10)
    """Distances, drawn at random within r."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Put two agents down, again and again, and ask the rule what one does to the other."""
        between()
        p = flock.parameters
        rng = np.random.default_rng(flock.seed)
        r: float = p.r  # type: ignore[attr-defined]
        found = self.measure_pushes(
            flock, np.sort(rng.uniform(CLEAR * r, (1.0 - CLEAR) * r, self.looks))
        )
        d, d_e, want = found.distance, warning_distance(flock), p.d  # type: ignore[attr-defined]
        weight = weights(flock, d)
        near, middle, far = d < d_e, (d >= d_e) & (d <= want), d > want
        return {
            "off": float(np.abs(found.weight / weight - 1.0).max()),
            "warning": self.jump_distance(flock),
            "separation": float(-found.force[near].max()),
            "early": float(-found.force[middle].min()),
            "attraction": float(found.force[far].max()),
            "wrong": int((found.force[~far] > 0.0).sum() + (found.force[far] < 0.0).sum()),
        }

    def measure_pushes(self, flock: Flock, distance: np.ndarray) -> Pushes:
        """What the second agent of a flock does to the first at distances (K,), m."""
        middle = np.array(flock.world.low) + 0.5 * np.array(flock.world.size)
        force = np.empty(len(distance))
        for k, away in enumerate(distance):
            flock.position[:2] = middle
            flock.position[1, 0] += away
            force[k] = flock.inspect(0).forces[FORCE][0]
        return Pushes(distance, force, bare_force(flock, distance))

    def jump_distance(self, flock: Flock) -> float:
        """The distance at which the rule's weight falls from tau_s, m; by halving [0, d]."""
        low, high = 0.1, float(flock.parameters.d)  # type: ignore[attr-defined]
        most: float = flock.parameters.tau_s  # type: ignore[attr-defined]
        for _ in range(40):
            middle = 0.5 * (low + high)
            near = self.measure_pushes(flock, np.array([middle])).weight[0] > 0.5 * most
            low, high = (middle, high) if near else (low, middle)
        return 0.5 * (low + high)

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """None is run; looking counts as one each."""
        return float(self.looks)


def warning_distance(flock: Flock) -> float:
    """d_e = d_min + 2 p_max dt (12), m."""
    p = flock.parameters
    return p.d_min + 2.0 * p.p_max * p.dt  # type: ignore[attr-defined]


def weights(flock: Flock, distance: np.ndarray) -> np.ndarray:
    """eta(d) of (12) at distances (K,), m."""
    p = flock.parameters
    far = np.where(distance <= p.d, p.tau_e, p.tau_a)  # type: ignore[attr-defined]
    return np.where(distance < warning_distance(flock), p.tau_s, far)  # type: ignore[attr-defined]


def bare_force(flock: Flock, distance: np.ndarray) -> np.ndarray:
    """The gain times phi_alpha |n| of (8) at distances (K,), m/s^2, with plain NumPy."""
    p = flock.parameters
    eps, a, b, h = p.eps, p.a, p.b, p.h  # type: ignore[attr-defined]

    def sigma(z):
        return (np.sqrt(1.0 + eps * z * z) - 1.0) / eps

    s = sigma(distance)
    share = s / sigma(p.r)  # type: ignore[attr-defined]
    fading = 0.5 * (1.0 + np.cos(np.pi * (share - h) / (1.0 - h)))
    rho = np.where(share < h, 1.0, np.where(share < 1.0, fading, 0.0))
    z = s - sigma(p.d) + abs(a - b) / np.sqrt(4.0 * a * b)  # type: ignore[attr-defined]
    phi = 0.5 * ((a + b) * z / np.sqrt(1.0 + z * z) + (a - b))
    return p.c1a * rho * phi * distance / np.sqrt(1.0 + eps * distance**2)  # type: ignore[attr-defined]


FILLS = ("#f6d5cf", "#fbe9c6", "#dbe8f6")
COLOURS = ("#c0392b", "#b07d12", "#2166ac")
NAMES = ("separation", "early warning", "attraction")
LONGEST, SHORTEST = 1.5, 0.5
"""Arrow of the strongest and of the weakest force, m."""
OTHERS = ((0.55, 65.0), (0.8, -40.0), (0.6, 170.0), (0.25, 100.0), (0.75, -110.0), (0.35, 15.0),
          (0.7, 128.0))  # fmt: skip
"""Other agents: share of the way through a region, and direction, deg; region by region."""
WEAKEST = 0.01
"""Force below which the axis is linear, m/s^2."""


def draw_regions(figure: Any, experiment: Experiment, seed: int) -> None:
    """Draw the regions of the first row's agents left, the force over the distance right."""
    settings = experiment.settings
    assert isinstance(settings, RegionSettings)
    flock: Any = flock_of(experiment.cases[0], seed)
    edges = [0.0, warning_distance(flock), flock.parameters.d, flock.parameters.r]
    figure.set_size_inches(12.4, 5.9)
    left, right = figure.subplots(1, 2, width_ratios=[1.0, 1.15])
    draw_rings(left, flock, settings, edges)
    draw_force(right, flock, settings, edges)
    signs = [sign(colour, name, "s") for colour, name in zip(COLOURS, NAMES, strict=True)]
    draw_key(
        figure, [*signs, stroke(INK, "what the rule makes of another agent")],
        f"two agents of {experiment.cases[0].label} put down at distances from each other; values "
        "of table 3; the paper's figure has no numbers",
    )  # fmt: skip


def draw_rings(axes: Any, flock: Any, settings: RegionSettings, edges: list[float]) -> None:
    """Draw the regions about an agent, and what others in them do to it."""
    from matplotlib.patches import Circle

    for outer, fill, colour in zip(edges[:0:-1], FILLS[::-1], COLOURS[::-1], strict=True):
        axes.add_patch(
            Circle((0.0, 0.0), outer, facecolor=fill, edgecolor=colour, linewidth=1.4, zorder=1)
        )
    for k, (share, angle) in enumerate(OTHERS):
        region = k % 3
        away = edges[region] + share * (edges[region + 1] - edges[region])
        out = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle))])
        force = float(settings.measure_pushes(flock, np.array([away])).force[0])
        strong = np.clip(np.log10(abs(force) / WEAKEST) / 7.0, 0.0, 1.0)
        length = SHORTEST + (LONGEST - SHORTEST) * strong
        # On the other agent: away from the middle where they repel each other.
        arrow(axes, away * out, -np.sign(force) * length * out, COLOURS[region], 2.0)
        axes.plot(*(away * out), "o", color=COLOURS[region], markersize=8, zorder=9,
                  markeredgecolor="white")  # fmt: skip
    axes.plot(0.0, 0.0, "o", color=INK, markersize=12, zorder=9, markeredgecolor="white")
    for name, edge, turn, colour in zip(
        ("$d_e$", "$d$", "$r$"), edges[1:], (-90.0, -78.0, -69.0), COLOURS, strict=True
    ):
        at = edge * np.array([np.cos(np.radians(turn)), np.sin(np.radians(turn))])
        write_label(axes, at, f"{name} = {edge:g} m", colour)
    set_square_view(axes, np.zeros(2), 1.06 * edges[-1])
    axes.set_title("(a) regions within the sensing radius of an agent", loc="left")


def draw_force(axes: Any, flock: Any, settings: RegionSettings, edges: list[float]) -> None:
    """Draw the force over the distance, with and without the weight of (12)."""
    for k, fill in enumerate(FILLS):
        axes.axvspan(edges[k], edges[k + 1], color=fill, alpha=0.6, zorder=0, linewidth=0.0)
        middle = 0.5 * (edges[k] + edges[k + 1])
        tau = (flock.parameters.tau_s, flock.parameters.tau_e, flock.parameters.tau_a)[k]
        axes.text(
            middle, 0.985, f"{NAMES[k]}\n$\\tau$ = {tau:g}", transform=axes.get_xaxis_transform(),
            ha="center", va="top", color=COLOURS[k], fontsize=9.5,
        )  # fmt: skip
    for k in range(3):
        distance = np.linspace(edges[k] + 1e-3, edges[k + 1] - 1e-3, 150)
        found = settings.measure_pushes(flock, distance)
        axes.plot(distance, found.force, color=INK, linewidth=2.2)
        axes.plot(distance, found.bare, color=INK, linewidth=1.1, linestyle=(0, (3, 2)))
    axes.axhline(0.0, color=INK, linewidth=0.8)
    axes.set_yscale("symlog", linthresh=WEAKEST)
    axes.set_ylim(-1e6, 1e3)
    axes.set_yticks([-1e5, -1e3, -10.0, -0.1, 0.0, 0.1, 10.0])
    axes.minorticks_off()
    axes.set_xlim(0.0, edges[-1])
    axes.set_xlabel("distance / m")
    axes.set_ylabel("force towards the other / m/s², below 0 they repel")
    axes.set_title("(b) the force with the weight (12); dashed: without", loc="left")


PICTURES = {"regions": draw_regions}
