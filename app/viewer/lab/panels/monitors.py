"""Numbers of the flock as it runs: cards, the key to the colours, and the layers."""

from __future__ import annotations

import html
import math

import viser

from agents.catalogue import MODELS
from app.viewer.lab.panels.bars import layer_bars, size_bars
from app.viewer.lab.panels.compared import compared, keeping_up, titled_columns
from app.viewer.lab.panels.crashes import counted
from app.viewer.lab.panels.more import SIZES, MoreNumbers
from app.viewer.measuring.measured import told as told_value
from app.viewer.measuring.readings import Readings
from app.viewer.panels.style import block, cards, grid, key
from app.viewer.run.state import State
from app.viewer.scene.shown.frame import Frame
from worlds.mission import Mission

COMMON = ("agents", "ticks / s", "browsers")
"""What two flocks side by side have in common."""
CLOCK = ("tick", "time")
"""What they have in common where it is the same."""


class Monitors:
    """The top of the left panel."""

    def __init__(self, gui: viser.GuiApi):
        self.cards = gui.add_html(cards({"tick": "–"}))
        self.titles = gui.add_html("", visible=False)
        self.compared = gui.add_html("", visible=False)
        self.mission = gui.add_html("", visible=False)
        self.crashes = gui.add_html("", visible=False)
        self.more = gui.add_html("", visible=False)
        self.key = gui.add_html("")
        self.bars = gui.add_html("", visible=False)

    def refresh(
        self,
        state: State,
        frame: Frame,
        readings: Readings,
        browsers: int,
        beside: Readings | None,
        more: MoreNumbers,
        last: float,
    ) -> None:
        """Show the latest of everything; of two flocks in two columns.

        `more` are the numbers that somebody has chosen, of the `last` ticks if they are of a run.
        """
        second, (model, name) = frame.beside, state.models
        if second is None or beside is None or name is None:
            self.alone(state, frame, readings, browsers, more, last)
            return
        models = model, name
        sides = (frame, readings), (second, beside)
        told, others = (numbers(state, one, read.values, browsers) for one, read in sides)
        same = (name for name in CLOCK if told.get(name) == others.get(name))
        common = (*COMMON, *same)
        in_common = {name: text for name, text in told.items() if name in common}
        self.cards.content = block(grid(in_common, across=min(4, len(in_common))))
        show_block(self.titles, titled_columns(*models) + keeping_up(frame, second))

        def table(title: str, first: dict[str, str], second: dict[str, str]) -> str:
            return compared(title, models, first, second)

        show_block(self.compared, table("Flock", without(told, common), without(others, common)))
        tasks = (mission_numbers(one, read.values) for one, read in sides)
        show_block(self.mission, table(errand_title(frame), *tasks))
        show_block(self.more, table("More", *(more.numbers(read, last) for _, read in sides)))
        named = zip(models, sides, strict=True)
        counts = (crash_count(read, len(one.ids), model) for model, (one, read) in named)
        show_block(self.crashes, "".join(counts))
        bars = [
            all_bars(one, read, SIZES in more.chosen, model)
            for (one, read), model in zip(sides, models, strict=True)
        ]
        show_block(self.bars, "".join(bars))

    def alone(
        self,
        state: State,
        frame: Frame,
        readings: Readings,
        browsers: int,
        more: MoreNumbers,
        last: float,
    ) -> None:
        """Show the latest of one flock."""
        self.titles.visible = self.compared.visible = False
        self.cards.content = cards(numbers(state, frame, readings.values, browsers))
        show_block(
            self.mission, headed(errand_title(frame), mission_numbers(frame, readings.values))
        )
        show_block(self.crashes, crash_count(readings, len(frame.ids)))
        show_block(self.more, headed("More numbers", more.numbers(readings, last)))
        show_block(self.bars, all_bars(frame, readings, SIZES in more.chosen))

    def colours(self, colour: str, legend: list[tuple[str, str]]) -> None:
        """Say what the colours mean."""
        entries = [(html.escape(words), css) for words, css in legend]
        self.key.content = block(
            f'<div class="fs-head">Colour: {html.escape(colour)}</div>{key(entries)}'
        )


def all_bars(frame: Frame, readings: Readings, sizes: bool, model: str = "") -> str:
    """Bars of the layers of a flock that is led, and of its groups if wanted."""
    drawn = ""
    if frame.informed.any():
        drawn = layer_bars(readings.layers.tolist(), readings.unknown, model)
    if sizes and len(readings.sizes):
        drawn += size_bars(readings.sizes, model)
    return drawn


def numbers(state: State, frame: Frame, values: dict[str, float], browsers: int) -> dict[str, str]:
    """The cards, name -> text; consistency only of models that have no zones."""

    def shown(name: str, form: str) -> str:
        return format(values[name], form) if name in values else "–"

    zoned = bool(MODELS[state.spec.model].rule.zones)
    return {
        "tick": spaced(frame.tick),
        **({} if frame.unit == "ticks" else {"time": f"{frame.tick * frame.dt:.1f} {frame.unit}"}),
        "agents": spaced(len(frame.ids)),
        "ticks / s": rate_text(state.rate),
        "polarisation": shown("polarisation", ".3f"),
        **({} if zoned else {"consistency": shown("consistency", ".4f")}),
        "rotation": shown("angular-momentum", ".3f"),
        "neighbours": shown("mean-neighbours", ".1f"),
        "groups": shown("groups", ".0f"),
        "largest group": shown("largest-group", ".0f"),
        **energy_numbers(values),
        **({"browsers": str(browsers)} if browsers > 1 else {}),
    }


def energy_numbers(values: dict[str, float]) -> dict[str, str]:
    """The cards of what flying in formation saves, name -> text; nothing where it is not known."""
    named = {"drag-saved": "drag saved", "energy-saved": "power saved"}
    return {
        words: told_value(name, values[name]) for name, words in named.items() if name in values
    }


def crash_count(readings: Readings, agents: int, model: str = "") -> str:
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


def errand_title(frame: Frame) -> str:
    """What the cards of a mission, or of what is solid, are headed; nothing without either."""
    if frame.world.mission is not None:
        return "Mission"
    return "Safety" if frame.world.is_solid else ""


def mission_numbers(frame: Frame, values: dict[str, float]) -> dict[str, str]:
    """The cards of a mission, name -> text; only what this world and this flock have."""
    mission = frame.world.mission or Mission()
    told: dict[str, str] = {}
    if not errand_title(frame):
        return told
    if "goal-distance" in values:
        where = "goal" if mission.goal is not None else "path's end"
        told[f"to {where}"] = length_text(values["goal-distance"])
    if mission.path is not None and frame.informed.any():
        count = len(mission.path.waypoints)
        here = frame.errand.done + 1
        told["waypoint"] = f"{here} / {count}" if here <= count else "all done"
    if mission.goal is not None and "through" in values:
        told["arrived"] = f"{100 * values['through']:.0f} %"
    if "following" in values:
        told["following"] = f"{100 * values['following']:.0f} %"
    if "least-gap" in values:
        told["closest pair"] = length_text(values["least-gap"])
    if "least-clearance" in values:
        told["to obstacle"] = length_text(values["least-clearance"])
        told["collisions"] = f"{values['inside']:.0f}"
    return told


def length_text(length: float) -> str:
    """A length in few figures; infinite ones are beyond what is looked at."""
    return f"{length:.3g}" if abs(length) < math.inf else "far"


def show_block(place: viser.GuiHtmlHandle, content: str) -> None:
    """Show content, or hide its place if there is none."""
    place.visible = bool(content)
    if content:
        place.content = block(content)


def rate_text(rate: float) -> str:
    """Ticks per second in few figures."""
    return f"{rate:.1f}" if rate < 100 else spaced(round(rate))


def spaced(number: int) -> str:
    """A number with its thousands apart."""
    return f"{number:,}".replace(",", "\N{NARROW NO-BREAK SPACE}")
