"""What a result that is handed in may cost, in numbers and in words."""

from __future__ import annotations

from agents.catalogue import MODELS
from agents.observables.catalogue import OBSERVABLES
from agents.spec import Spec
from worlds.refusal import Refusal

MOST_TICKS = 20_000
"""Of a run."""
MOST_AGENTS = 5_000
MOST_STEPS = 5_000_000
"""Agents times ticks: a second or two of a core."""
MOST_SEEN = 200_000
"""Agents times looks at what takes longer than a look at each agent."""


def demand_cheap(spec: Spec, ticks: int, observable: str, looks: int) -> None:
    """Refuse a run of so many ticks that would take too long for one of a class. Raises Refusal.

    `looks`: at how many of its ticks the observable is measured.
    """
    agents = (spec.agents or MODELS[spec.model].agents) + (spec.informed or 0)
    if agents > MOST_AGENTS:
        raise Refusal(f"{agents:,} agents are too many to hand in: at most {MOST_AGENTS:,}")
    if agents * ticks > MOST_STEPS:
        raise Refusal(
            f"{agents:,} agents for {ticks:,} ticks take too long: agents times ticks may be "
            f"{MOST_STEPS:,} at most, here {MOST_STEPS // ticks:,} agents"
        )
    one = OBSERVABLES[observable]
    if not one.quick and agents * looks > MOST_SEEN and one.over is None:
        raise Refusal(
            f"{one.name} of {agents:,} agents at each of {looks:,} ticks takes too long: agents "
            f"times ticks may be {MOST_SEEN:,} at most for it"
        )
