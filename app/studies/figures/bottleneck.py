"""A crowd that leaves through a bottleneck: its flow beside that of people, and how it stands."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field

from app.studies.charts.boxes import draw_key
from app.studies.charts.colour_table import COLOURS, RULER
from app.studies.experiment import Experiment, flock_of
from app.studies.judge.verdict import Verdict
from app.studies.measure import COUNT, Measure, Number, Settings
from worlds.input_error import InputError

if TYPE_CHECKING:
    from agents import Flock

# Runs in which a crowd leaves a room through an exit: Adrian et al. 2020.

CHUNK = 200
"""Ticks between two looks at the world outside."""


class BottleneckSettings(Settings):
    """How long people have to get out."""

    kind: ClassVar[str] = "bottleneck"
    measures: ClassVar[tuple[Measure, ...]] = (
        Measure("flow", "J", "Flow, (N - 1) / (t_N - t_1); 0 if fewer than two got out", "1/s",
                bounds=COUNT),
        Measure("out", "out", "People who got out", "people", whole=True, bounds=COUNT),
        Measure("last", "t_N", "When the last of all got out", "s", "somebody stayed"),
    )  # fmt: skip

    limit: float = Field(gt=0.0)
    """For which a run lasts at most, s."""

    def run(self, flock: Flock, between: Callable[[], None]) -> dict[str, Number | None]:
        """Let people go until all are out, or time is up. Raises InputError without an exit."""
        if flock.world.mission is None or not flock.world.mission.exits:
            raise InputError(f"the world {flock.world.name!r} has no exit")
        left = round(self.limit / flock.dt)
        while left > 0 and not flock.has_ended:
            between()
            flock.advance(min(CHUNK, left), until_ended=True)
            left -= CHUNK
        flow = flock.observe("flow")
        return {
            "flow": float(flow) if np.isfinite(flow) else 0.0,
            "out": len(flock.exits),
            "last": float(flock.elapsed) if flock.has_ended else None,
        }

    def ticks(self, published: float | None, dt: float) -> float:  # noqa: ARG002
        """All of them."""
        return self.limit / dt


LOOK = 15.0
"""When the crowd of the first row is drawn, s."""


def draw_bottleneck(
    figure: Any, experiment: Experiment, verdicts: list[Verdict], seed: int
) -> None:
    """Draw the crowd of the first row on the left; who is out by when, of every row, beside it."""
    settings = experiment.settings
    assert isinstance(settings, BottleneckSettings)
    figure.set_size_inches(10.0, 5.2)
    plan, curve = figure.subplots(1, 2, width_ratios=[1.0, 1.5])
    for k, case in enumerate(experiment.cases):
        flock = flock_of(case, seed)
        if k == 0:
            flock.run(round(LOOK / flock.dt))
            draw_crowd(plan, flock, f"{case.label}, after {LOOK:g} s")
        settings.run(flock, lambda: None)
        time = np.append(flock.exits.tick * flock.dt, min(settings.limit, flock.elapsed))
        count = np.append(np.arange(1, len(time)), len(time) - 1)
        curve.step(time, count, where="post", color=COLOURS[k % len(COLOURS)], label=case.label)
    measured = [v.published.average for v in verdicts if v.published and v.measure.name == "flow"]
    if measured and measured[0] is not None:
        agents = experiment.cases[0].agents
        curve.plot([0.0, (agents - 1) / measured[0]], [1, agents], "--", color=RULER,
                   label=f"the experiment's flow, {measured[0]:.3g}/s")  # fmt: skip
    curve.set(
        xlabel="time / s", ylabel="people who are out", xlim=(0.0, settings.limit), ylim=(0, None)
    )
    handles = curve.get_legend_handles_labels()[0]
    draw_key(figure, handles, f"seed {seed}")


def draw_crowd(axes: Any, flock: Any, title: str) -> None:
    """Draw everybody among the walls."""
    from app.worlds.world_picture import draw_plan

    draw_plan(axes, flock.world)
    axes.plot(*flock.position.T, "o", color=COLOURS[0], markersize=3.5, zorder=6)
    axes.set(aspect="equal", xticks=[], yticks=[])
    axes.grid(visible=False)
    axes.set_title(title, loc="left")


PICTURES = {"bottleneck": draw_bottleneck}
