"""The columns of recordings and saved states: what each holds and in which unit."""

from __future__ import annotations

from typing import NamedTuple

from agents.models.model import Model
from worlds.world import World

AXES = "xyz"
PAST = "past"
"""The column of a saved state that holds what messages on their way tell."""
LEG = "leg"


class Column(NamedTuple):
    """A column, a value for each agent and tick."""

    name: str
    unit: str
    """1 for pure numbers, names and yes or no."""
    meaning: str


def crash_columns(dim: int) -> list[str]:
    """Columns of a crash record: the tick of the crash or -1, what it touched, and where."""
    return ["crash_tick", "crash_cause", *("crash_" + letter for letter in AXES[:dim])]


def columns_of(model: Model, world: World, with_past: bool = False) -> list[Column]:
    """The columns that a run of a model in a world is recorded in, in their order."""
    length, axes = model.in_units("length"), AXES[: world.dim]
    columns = [
        Column("tick", "ticks", "ticks done since the start"),
        Column("id", "1", "identity of the agent, which keeps it for the whole run"),
        *(Column(axis, length, f"position along {axis}") for axis in axes),
        *(Column("u" + axis, "1", f"heading, a unit vector, along {axis}") for axis in axes),
        Column("speed", model.in_units("length/time"), "speed along the heading"),
        Column("informed", "1", "whether it is an information agent"),
    ]
    if world.mission is not None and world.mission.path is not None:
        columns.append(Column(LEG, "1", "waypoints of the path that it has left behind"))
    if model.body.touches is not None:
        tick, cause, *places = crash_columns(world.dim)
        columns += [
            Column(tick, "ticks", "tick at whose beginning it crashed, -1 while it has not"),
            Column(cause, "1", "what it touched: 1 another agent, 2 an obstacle or a wall, else 0"),
            *(Column(name, length, f"where it crashed, along {name[-1]}") for name in places),
        ]
    columns += [Column(name, model.unit_of(name), kind(model, name)) for name in model.columns]
    if with_past:
        columns.append(Column(PAST, "1", "what messages on their way tell"))
    return columns


def kind(model: Model, name: str) -> str:
    """What one of a model's own columns is."""
    if name in model.signals:
        return "what agents tell each other"
    return "what an agent keeps to itself" if name in model.rule.memory else "measured of the agent"
