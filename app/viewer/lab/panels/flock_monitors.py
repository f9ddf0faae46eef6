"""What the monitors tell of the flock as it runs: cards, tables of two flocks, and bars."""

from __future__ import annotations

import html
from collections.abc import Callable

import numpy as np
import viser

from agents.catalogue import MODELS, short_model_name
from agents.state.agent_rows import CAUSES, Crashes
from app.viewer.lab.panels.numbers_table import SIZES, MoreNumbers
from app.viewer.measuring import observable_format
from app.viewer.measuring.flock_readings import FlockReadings
from app.viewer.panels.monitors import CARDS, KEY
from app.viewer.panels.shell import BLUE, block, grid
from app.viewer.run.paired_run import pace_note
from app.viewer.run.simulation_state import SimulationState
from app.viewer.scene.shown import palette
from app.viewer.scene.shown.frame import Frame
from worlds.mission import Mission

# Bars in the monitors: how many agents there are in each layer, or in each group.

MOST_BARS = 12


def layer_bars(counts: list[int], unknown: int, model: str = "") -> str:
    """Bars of how many agents are in each layer; deep layers go together in the last bar.

    `model` says which of two flocks they are of.
    """
    if len(counts) > MOST_BARS:
        counts = [*counts[: MOST_BARS - 1], sum(counts[MOST_BARS - 1 :])]
    most = max([*counts, unknown, 1])
    bars = "".join(
        bar(
            str(layer),
            count,
            most,
            palette.css(palette.LAYERS[min(layer, len(palette.LAYERS)) - 1]),
        )
        for layer, count in enumerate(counts, start=1)
    )
    bars += bar("?", unknown, most, palette.css(palette.UNKNOWN)) if unknown else ""
    return (
        '<h2 class="fs-head">Layers<span class="fs-quiet">'
        f"{html.escape(model) or 'steps from the information agent'}</span></h2>"
        f'<div class="fs-bars">{bars}</div>'
    )


def bar(label: str, count: int, most: int, colour: str) -> str:
    """One bar with its count above and its label below."""
    height = max(2, round(34 * count / most)) if count else 0
    return f'<div>{count}<i style="height:{height}px;background:{colour}"></i>{label}</div>'


def size_bars(sizes: np.ndarray, model: str = "") -> str:
    """Bars of how many agents each group has (G,), the largest first.

    `model` says which of two flocks they are of.
    """
    first_bars = sizes[:MOST_BARS].tolist()
    rest = (
        f"and {len(sizes) - len(first_bars)} more"
        if len(sizes) > len(first_bars)
        else "agents in each"
    )
    bars = "".join(
        bar(str(rank), size, first_bars[0], BLUE) for rank, size in enumerate(first_bars, 1)
    )
    return (
        f'<h2 class="fs-head">Groups<span class="fs-quiet">{html.escape(model)} {rest}</span>'
        f'</h2><div class="fs-bars">{bars}</div>'
    )


# The monitors of two flocks side by side: one table, a column for each model.

NOTHING = "–"


def titled_columns(first: str, second: str) -> str:
    """The titles of two models (their names), each with the line by which plots show it."""
    lines = "".join(
        f'<div><i class="fs-line fs-{kind}"></i>{html.escape(MODELS[name].title)}</div>'
        for name, kind in ((first, "solid"), (second, "dashed"))
    )
    return f'<div class="fs-pair-titles">{lines}</div>'


def compare_table(
    title: str, models: tuple[str, str], first: dict[str, str], second: dict[str, str]
) -> str:
    """A table of what two flocks have, name -> text; what one lacks is left open."""
    if not first and not second:
        return ""
    rows = "".join(
        f"<tr><td>{html.escape(name)}</td><td>{first.get(name, NOTHING)}</td>"
        f"<td>{second.get(name, NOTHING)}</td></tr>"
        for name in dict.fromkeys([*first, *second])
    )
    head = "".join(
        f'<th><i class="fs-line fs-{kind}"></i>{html.escape(short_model_name(name))}</th>'
        for name, kind in zip(models, ("solid", "dashed"), strict=True)
    )
    return f'<table class="fs-pair"><tr><th>{html.escape(title)}</th>{head}</tr>{rows}</table>'


def describe_pace(frame: Frame, beside: Frame) -> str:
    """How the two keep the same time, in small print; nothing if tick by tick."""
    note = pace_note(frame, beside)
    return f'<div class="fs-quiet">{html.escape(note)}</div>' if note else ""


# Who has crashed: how many, when, against what, and the latest of them one by one.

LATEST = 5
"""Crashes in the list."""
EARLY = 100
"""The tick up to which the thesis counts what comes of the start."""

Show = Callable[[viser.ClientHandle, int, bool], None]
"""Shows a row of the flock, or of the one beside, in one browser."""


class CrashLists:
    """The latest crashes of the flock, and of the one beside it."""

    def __init__(self, gui: viser.GuiApi, show: Show):
        self.first, self.second = (CrashList(gui, show, beside) for beside in (False, True))

    def refresh(self, readings: FlockReadings, beside: FlockReadings | None) -> None:
        """Show the latest crashes, with the names of the models if there are two."""
        if beside is None:
            self.first.refresh(readings.crashes)
            self.second.refresh(None)
            return
        for crash_list, read in ((self.first, readings), (self.second, beside)):
            crash_list.refresh(read.crashes, read.flock.model.name)


class CrashList:
    """The latest crashes of one flock, each with a button that points the camera at it."""

    def __init__(self, gui: viser.GuiApi, show: Show, beside: bool):
        self.show = show
        self.beside = beside
        self.rows: dict[str, int] = {}
        """What the buttons show: identity -> row."""
        self.list = gui.add_html("", visible=False)
        self.buttons = gui.add_button_group(
            "Show",
            ("1",),
            hint="Point this browser's camera at an agent that has crashed",
            visible=False,
        )
        self.buttons.on_click(self.select_crash)

    async def select_crash(self, event: viser.GuiEvent) -> None:
        row = self.rows.get(event.target.value)
        if event.client is not None and row is not None:
            self.show(event.client, row, self.beside)

    def refresh(self, crashes: Crashes | None, model: str = "") -> None:
        """Show the latest crashes of a flock; nothing if there are none.

        `model` says which of two flocks it is.
        """
        some = crashes is not None and len(crashes) > 0
        if self.list.visible != some:
            self.list.visible = self.buttons.visible = some
        if crashes is None or not some:
            return
        self.list.content = block(crash_table(crashes, model))
        rows = {str(crashes.id[at]): int(crashes.row[at]) for at in latest_crashes(crashes)}
        if rows != self.rows:
            self.rows = rows
            self.buttons.options = tuple(rows)


def latest_crashes(crashes: Crashes) -> range:
    """Where the latest crashes are, newest first."""
    last = len(crashes) - 1
    return range(last, max(-1, last - LATEST), -1)


def crash_table(crashes: Crashes, model: str = "") -> str:
    """The latest crashes as a table, newest first; `model` says which of two flocks it is."""
    rows = "".join(
        f"<tr><td>{crashes.tick[at]}</td><td>{crashes.id[at]}</td>"
        f"<td>{CAUSES[int(crashes.cause[at])]}</td><td>{place(crashes.place[at])}</td></tr>"
        for at in latest_crashes(crashes)
    )
    return (
        f'<h2 class="fs-head">Latest crashes<span class="fs-quiet">{html.escape(model)}</span>'
        '</h2><table class="fs-list"><tr><th>tick</th><th>agent</th><th>touched</th><th>at</th>'
        f"</tr>{rows}</table>"
    )


def crash_counts(ticks: np.ndarray, agents: int) -> str:
    """How many have crashed, and when.

    >>> crash_counts(np.array([0, 0, 7, 230]), 50)
    'Crashed <b>4</b> of 50 (2 at the start, 1 up to tick 100, 1 after tick 100)'
    """
    if not len(ticks):
        return f"Crashed <b>0</b> of {agents}"
    early = int(np.count_nonzero(ticks == 0))
    late = int(np.count_nonzero(ticks > EARLY))
    parts = {
        "at the start": early,
        f"up to tick {EARLY}": len(ticks) - early - late,
        f"after tick {EARLY}": late,
    }
    reported = ", ".join(f"{count} {words}" for words, count in parts.items() if count)
    return f"Crashed <b>{len(ticks)}</b> of {agents} ({reported})"


def place(where: np.ndarray) -> str:
    """A place in few figures.

    >>> place(np.array([1.234, 0.0, 23.9]))
    '1.2, 0.0, 23.9'
    """
    return ", ".join(f"{value:.1f}" for value in where)


BLOCKS = (CARDS, "titles", "compared", "mission", "crash-count", "more", KEY)
"""From the top down."""
BELOW = ("bars",)
"""Those below the plots, which are to be seen without scrolling."""
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
        return single_contents(state, frame, readings, browsers, more, last)
    models = model, name
    sides = (frame, readings), (second, beside)
    texts, others = (numbers(state, frame, read.values, browsers) for frame, read in sides)
    same = (name for name in CLOCK if texts.get(name) == others.get(name))
    common = (*COMMON, *same)
    in_common = {name: text for name, text in texts.items() if name in common}

    def table(title: str, first: dict[str, str], second: dict[str, str]) -> str:
        return compare_table(title, models, first, second)

    tasks = (mission_numbers(frame, read.values) for frame, read in sides)
    named = list(zip(models, sides, strict=True))
    return {
        CARDS: grid(in_common, across=2 if len(in_common) == 4 else 3),
        "titles": titled_columns(*models) + describe_pace(frame, second),
        "compared": table("Flock", leave_out(texts, common), leave_out(others, common)),
        "mission": table(mission_title(frame), *tasks),
        "more": table("More", *(more.numbers(read, last) for _, read in sides)),
        "crash-count": "".join(
            crash_count(read, len(frame.ids), model) for model, (frame, read) in named
        ),
        "bars": "".join(
            all_bars(frame, read, SIZES in more.chosen, model) for model, (frame, read) in named
        ),
    }


def single_contents(
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
        "mission": titled_cards(mission_title(frame), mission_numbers(frame, readings.values)),
        "crash-count": crash_count(readings, len(frame.ids)),
        "more": titled_cards("More numbers", more.numbers(readings, last)),
        "bars": all_bars(frame, readings, SIZES in more.chosen),
    }


def all_bars(frame: Frame, readings: FlockReadings, sizes: bool, model: str = "") -> str:
    """Bars of the layers of a flock that is led, and of its groups if wanted."""
    bars_html = ""
    if frame.informed.any():
        bars_html = layer_bars(readings.layers.tolist(), readings.unknown, model)
    if sizes and len(readings.sizes):
        bars_html += size_bars(readings.sizes, model)
    return bars_html


def numbers(
    state: SimulationState, frame: Frame, values: dict[str, float], browsers: int
) -> dict[str, str]:
    """The cards, name -> text."""
    return {
        "tick": observable_format.format_thousands(frame.tick),
        **({} if frame.unit == "ticks" else {"time": f"{frame.tick * frame.dt:.1f} {frame.unit}"}),
        "agents": observable_format.format_thousands(len(frame.ids)),
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
    return f'<div class="fs-count">{whose}{crash_counts(readings.crashes.tick, agents)}</div>'


def titled_cards(title: str, values: dict[str, str], across: int = 3) -> str:
    """Cards under a title; nothing if there are none."""
    return f'<h2 class="fs-head">{title}</h2>{grid(values, across)}' if values else ""


def leave_out(values: dict[str, str], names: tuple[str, ...]) -> dict[str, str]:
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
    rows: dict[str, str] = {}
    if not mission_title(frame):
        return rows
    rows |= observable_format.cards("way", frame.world, values)
    if mission.path is not None and frame.informed.any():
        count = len(mission.path.waypoints)
        next_goal = frame.progress.done + 1
        rows["waypoint"] = f"{next_goal} / {count}" if next_goal <= count else "all done"
    if mission.goal is not None and "through" in values:
        rows["arrived"] = f"{100 * values['through']:.0f} %"
    rows |= observable_format.cards("team", frame.world, values)
    if "least-gap" in values:
        rows["closest pair"] = observable_format.format_short(values["least-gap"])
    if "least-clearance" in values:
        rows["to obstacle"] = observable_format.format_short(values["least-clearance"])
        rows["collisions"] = f"{values['inside']:.0f}"
    return rows


def rate_text(rate: float) -> str:
    """Ticks per second in few figures."""
    return f"{rate:.1f}" if rate < 100 else observable_format.format_short(rate)
