"""How the turn of one agent comes to the others: distance over delay, and the exponents of runs."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from textwrap import fill
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field

from app.studies.charts.boxes import draw_key
from app.studies.experiment import Experiment, flock_of
from app.studies.judge.verdict import Verdict, verdicts_on
from app.studies.measure import Measure, Number, Settings
from worlds.input_error import InputError

if TYPE_CHECKING:
    from agents import Flock

# Runs in which one agent turns and the others follow: Attanasi et al. 2014, figures 2 and 4.


@dataclass(frozen=True)
class Turn:
    """How the turn of one agent came to the others."""

    distance: np.ndarray
    """Mean distance of the agents of each ring to the one that turned, (K,), length."""
    delay: np.ndarray
    """Time after the turn at which a ring first turns half as fast as it ever does, (K,)."""
    order: float
    """Polarisation of the flock when the turn began."""
    sound: float
    """c_s of the linear theory, length per time."""

    @property
    def exponent(self) -> float:
        """a of distance ~ delay^a: 1 for a wave, 1/2 for what diffuses."""
        return float(np.polyfit(np.log(self.delay), np.log(self.distance), 1)[0])

    @property
    def speed(self) -> float:
        """At which the turn comes from ring to ring, length per time."""
        return float(np.polyfit(self.delay, self.distance, 1)[0])


class TurnSettings(Settings):
    """How long a flock flies before one agent turns, by how much, and what is then looked at."""

    kind: ClassVar[str] = "turns"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("exponent", "a", "Exponent of distance over delay", "1"),
        Measure("speed", "c", "Speed at which the turn spreads", "length/s"),
        Measure("ratio", "c/c_s", "That speed over that of the linear theory", "1"),
        Measure("order", "order", "Polarisation when the turn begins", "1"),
    )

    settle: int = Field(ge=0)
    """Ticks from a start in which all are aligned to the turn, where there is noise."""
    turn: float = Field(gt=0.0, le=90.0)
    """Angle by which the information agent turns, deg."""
    limit: float = Field(gt=0.0)
    """Time over which the others are then followed."""
    nearest: float = Field(gt=0.0)
    """Distance at which the first ring about the one that turned begins, length."""
    furthest: float = Field(gt=0.0)
    """Distance at which the last one ends."""
    rings: int = Field(ge=3)

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Let one agent turn and see when the others do."""
        turn = self.turn_flock(flock, between)
        return {
            "exponent": turn.exponent,
            "speed": turn.speed,
            "ratio": turn.speed / turn.sound,
            "order": turn.order,
        }

    def turn_flock(self, flock: Flock, between: Callable[[], None] = lambda: None) -> Turn:
        """All are aligned, until the information agent turns. Raises InputError unless there is
        one.

        Where there is noise the flock flies on twice from the same tick, with the same noise: once
        without the turn. What differs is the turn.
        """
        if flock.informed.sum() != 1:
            raise InputError(f"informed = {flock.informed.sum()}: one agent is to turn")
        first = int(np.argmax(flock.informed))
        flock.heading[:] = np.eye(flock.world.dim)[0]
        still: np.ndarray = flock.heading.copy()
        if flock.parameters.T > 0.0:  # type: ignore[attr-defined]
            between()
            flock.run(self.settle)
            start_tick = flock.tick
            saved = [array.copy() for array in (flock.position, flock.heading, flock.arrays.memory)]
            still = self.headings(flock, between)
            flock.position[:], flock.heading[:], flock.arrays.memory[:] = saved
            flock.tick = start_tick
        away, order = distances(flock, first), float(flock.observe("polarisation"))
        sound, angle = sound_speed(flock), math.radians(self.turn)
        ux, uy = flock.heading[first, :2]
        flock.heading[first, 0] = math.cos(angle) * ux - math.sin(angle) * uy
        flock.heading[first, 1] = math.sin(angle) * ux + math.cos(angle) * uy
        aside = np.zeros(flock.world.dim)
        aside[:2] = -uy, ux
        deviation = (self.headings(flock, between) - still) @ aside
        ring = np.digitize(away, np.linspace(self.nearest, self.furthest, self.rings + 1)) - 1
        within = [ring == k for k in range(self.rings)]
        rate = np.diff([deviation[:, rows].mean(axis=1) for rows in within], axis=1)
        reached = rate >= 0.5 * rate.max(axis=1, keepdims=True)
        return Turn(
            np.array([away[rows].mean() for rows in within]),
            flock.dt * (reached.argmax(axis=1) + 0.5),
            order,
            sound,
        )

    def headings(self, flock: Flock, between: Callable[[], None]) -> np.ndarray:
        """Headings at every tick from now on, (T + 1, N, dim)."""
        headings = [flock.heading.copy()]
        for _ in range(round(self.limit / flock.dt)):
            between()
            flock.run(1)
            headings.append(flock.heading.copy())
        return np.array(headings)

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All of them, with noise."""
        return self.settle + 2.0 * self.limit / dt


def distances(flock: Flock, row: int) -> np.ndarray:
    """Distance of each agent to that of a row, to the nearest image, (N,), length."""
    apart = flock.position - flock.position[row]
    size = np.array(flock.world.size)
    apart -= np.where(flock.world.images, size * np.round(apart / size), 0.0)
    return np.linalg.norm(apart, axis=1)


def sound_speed(flock: Flock) -> float:
    """c_s = sqrt(J sum_j d_ij^2 / (2 dim chi)) of the flock as it flies, its mean over i.

    Of neighbours on a lattice a apart along each axis that is a sqrt(J / chi).
    """
    p = flock.parameters
    pairs = flock.links()
    apart = flock.position[pairs[:, 0]] - flock.position[pairs[:, 1]]
    size = np.array(flock.world.size)
    apart -= np.where(flock.world.images, size * np.round(apart / size), 0.0)
    each = 2.0 * (apart**2).sum() / len(flock.ids)
    return math.sqrt(p.J * each / (2.0 * flock.world.dim * p.chi))  # type: ignore[attr-defined]


COLOURS = ("#2166ac", "#5aa9c9", "#1f9d63", "#c0392b", "#0b2545", "#8e44ad", "#b07d12")
LINE = "#3c434b"


def draw_turns(figure: Any, experiment: Experiment, verdicts: list[Verdict], seed: int) -> None:
    """Draw the run of that seed of each row to the left, the exponents of all runs to the right."""
    settings = experiment.settings
    assert isinstance(settings, TurnSettings)
    figure.set_size_inches(11.4, 5.6)
    ways, exponents = figure.subplots(1, 2, width_ratios=[1.7, 1.0])
    for k, case in enumerate(experiment.cases):
        turn = settings.turn_flock(flock_of(case, seed))
        colour = COLOURS[k % len(COLOURS)]
        ways.plot(turn.delay, turn.distance, "o-", color=colour, linewidth=1.4, label=case.label)
    time = np.array([1.0, settings.limit])
    ways.plot(time, 2.2 * time, "--", color=LINE, linewidth=1.0)
    ways.plot(time, 7.0 * time**0.5, ":", color=LINE, linewidth=1.2)
    ways.set(
        xscale="log",
        yscale="log",
        xlabel="delay / s",
        ylabel="distance to the one that turned / length",
        ylim=(0.8 * settings.nearest, 1.25 * settings.furthest),
        xlim=(0.1, settings.limit),
    )
    ways.set_yticks([4, 8, 16], ["4", "8", "16"])
    ways.set_xticks([0.1, 1, 10], ["0.1", "1", "10"])
    ways.minorticks_off()
    ways.set_title(f"seed {seed}: rings about the one that turned", loc="left")
    points = verdicts_on(verdicts, "exponent")
    for k, point in enumerate(points):
        values = [value for value in point.values if value is not None]
        aside = np.random.default_rng(0).uniform(-0.22, 0.22, len(values))
        colour = COLOURS[k % len(COLOURS)]
        exponents.plot(k + aside, values, ".", color=colour, markersize=4, alpha=0.6)
    for level in (0.5, 1.0):
        exponents.axhline(level, color=LINE, linewidth=0.9, linestyle=":")
    labels = [fill(point.case.label, 10) for point in points]
    exponents.set_xticks(range(len(points)), labels, fontsize=8)
    exponents.set_ylim(0.0, 1.4)
    exponents.set_ylabel("exponent a of distance ~ delay$^a$")
    exponents.set_title("all runs", loc="left")
    draw_key(
        figure,
        ways.get_legend_handles_labels()[0],
        "dashed, a = 1: a wave; dotted, a = 1/2: what diffuses",
    )


PICTURES = {"turns": draw_turns}
