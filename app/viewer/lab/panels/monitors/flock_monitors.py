"""What the monitors tell of the flock as it runs: cards, tables of two flocks, and bars."""

from __future__ import annotations

import html

from agents.catalogue import MODELS
from app.viewer.lab.panels.monitors.bars import layer_bars, size_bars
from app.viewer.lab.panels.monitors.comparison_table import compared, keeping_up, titled_columns
from app.viewer.lab.panels.monitors.crash_lists import counted
from app.viewer.lab.panels.monitors.more_numbers import SIZES, MoreNumbers
from app.viewer.measuring import observable_format
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.panels.monitors import CARDS, KEY
from app.viewer.panels.style import grid
from app.viewer.run.simulation_state import SimulationState
from app.viewer.scene.shown.frame import Frame
from worlds.mission import Mission

BLOCKS = (CARDS, "titles", "compared", "mission", "crash-count", "more", KEY, "bars")
"""From the top down."""
COMMON = ("agents", "ticks / s", "browsers")
"""What two flocks side by side have in common."""
CLOCK = ("tick", "time")
"""What they have in common where it is the same."""


def contents(
    state: SimulationState,
    frame: Frame,
    readings: FlockReadings,
    browsers: int,
    beside: FlockReadings | None,
    more: MoreNumbers,
    last: float,
) -> dict[str, str]:
    """The latest of everything by its block, HTML; of two flocks in two columns.

    `more` are the numbers that somebody has chosen, of the `last` ticks if they are of a run.
    """
    second, (model, name) = frame.beside, state.models
    if second is None or beside is None or name is None:
        return alone(state, frame, readings, browsers, more, last)
    models = model, name
    sides = (frame, readings), (second, beside)
    told, others = (numbers(state, one, read.values, browsers) for one, read in sides)
    same = (name for name in CLOCK if told.get(name) == others.get(name))
    common = (*COMMON, *same)
    in_common = {name: text for name, text in told.items() if name in common}

    def table(title: str, first: dict[str, str], second: dict[str, str]) -> str:
        return compared(title, models, first, second)

    tasks = (mission_numbers(one, read.values) for one, read in sides)
    named = list(zip(models, sides, strict=True))
    return {
        CARDS: grid(in_common, across=2 if len(in_common) == 4 else 3),
        "titles": titled_columns(*models) + keeping_up(frame, second),
        "compared": table("Flock", without(told, common), without(others, common)),
        "mission": table(mission_title(frame), *tasks),
        "more": table("More", *(more.numbers(read, last) for _, read in sides)),
        "crash-count": "".join(
            crash_count(read, len(one.ids), model) for model, (one, read) in named
        ),
        "bars": "".join(
            all_bars(one, read, SIZES in more.chosen, model) for model, (one, read) in named
        ),
    }


def alone(
    state: SimulationState,
    frame: Frame,
    readings: FlockReadings,
    browsers: int,
    more: MoreNumbers,
    last: float,
) -> dict[str, str]:
    """The latest of one flock."""
    return {
        "titles": "",
        "compared": "",
        CARDS: grid(numbers(state, frame, readings.values, browsers)),
        "mission": headed(mission_title(frame), mission_numbers(frame, readings.values)),
        "crash-count": crash_count(readings, len(frame.ids)),
        "more": headed("More numbers", more.numbers(readings, last)),
        "bars": all_bars(frame, readings, SIZES in more.chosen),
    }


def all_bars(frame: Frame, readings: FlockReadings, sizes: bool, model: str = "") -> str:
    """Bars of the layers of a flock that is led, and of its groups if wanted."""
    drawn = ""
    if frame.informed.any():
        drawn = layer_bars(readings.layers.tolist(), readings.unknown, model)
    if sizes and len(readings.sizes):
        drawn += size_bars(readings.sizes, model)
    return drawn


def numbers(
    state: SimulationState, frame: Frame, values: dict[str, float], browsers: int
) -> dict[str, str]:
    """The cards, name -> text."""
    return {
        "tick": observable_format.spaced(frame.tick),
        **({} if frame.unit == "ticks" else {"time": f"{frame.tick * frame.dt:.1f} {frame.unit}"}),
        "agents": observable_format.spaced(len(frame.ids)),
        "ticks / s": rate_text(state.rate),
        **observable_format.cards("flock", frame.world, values, MODELS[state.spec.model]),
        **({"browsers": str(browsers)} if browsers > 1 else {}),
    }


def crash_count(readings: FlockReadings, agents: int, model: str = "") -> str:
    """How many of so many agents have crashed, and when; nothing where nobody can.

    `model` says which of two flocks it is.
    """
    if readings.crashes is None:
        return ""
    whose = f"{html.escape(model)}: " if model else ""
    return f'<div class="fs-count">{whose}{counted(readings.crashes.tick, agents)}</div>'


def headed(title: str, values: dict[str, str], across: int = 3) -> str:
    """Cards under a title; nothing if there are none."""
    return f'<div class="fs-head">{title}</div>{grid(values, across)}' if values else ""


def without(values: dict[str, str], names: tuple[str, ...]) -> dict[str, str]:
    """All values but the named ones."""
    return {name: text for name, text in values.items() if name not in names}


def mission_title(frame: Frame) -> str:
    """What the cards of a mission, or of what is solid, are headed; nothing without either."""
    if frame.world.mission is not None:
        return "Mission"
    return "Safety" if frame.world.is_solid else ""


def mission_numbers(frame: Frame, values: dict[str, float]) -> dict[str, str]:
    """The cards of a mission, name -> text; only what this world and this flock have."""
    mission = frame.world.mission or Mission()
    told: dict[str, str] = {}
    if not mission_title(frame):
        return told
    told |= observable_format.cards("way", frame.world, values)
    if mission.path is not None and frame.informed.any():
        count = len(mission.path.waypoints)
        here = frame.progress.done + 1
        told["waypoint"] = f"{here} / {count}" if here <= count else "all done"
    if mission.goal is not None and "through" in values:
        told["arrived"] = f"{100 * values['through']:.0f} %"
    told |= observable_format.cards("team", frame.world, values)
    if "least-gap" in values:
        told["closest pair"] = observable_format.few(values["least-gap"])
    if "least-clearance" in values:
        told["to obstacle"] = observable_format.few(values["least-clearance"])
        told["collisions"] = f"{values['inside']:.0f}"
    return told


def rate_text(rate: float) -> str:
    """Ticks per second in few figures."""
    return f"{rate:.1f}" if rate < 100 else observable_format.few(rate)
