"""Numbers of the flock as it runs: cards, the key to the colours, and the layers."""

from __future__ import annotations

import html
import math

import viser

from app.viewer.frame import Frame
from app.viewer.panels.compared import compared, keeping_up, titled_columns
from app.viewer.panels.style import block, cards, grid, key
from app.viewer.readings import Readings
from app.viewer.scene import palette
from app.viewer.state import State
from worlds.mission import Mission

MOST_BARS = 12
COMMON = ("agents", "ticks / s", "browsers")
"""What two flocks side by side have in common."""


class Monitors:
    """The top of the left panel."""

    def __init__(self, gui: viser.GuiApi):
        self.clock = gui.add_html("", visible=False)
        self.cards = gui.add_html(cards({"tick": "–"}))
        self.titles = gui.add_html("", visible=False)
        self.compared = gui.add_html("", visible=False)
        self.mission = gui.add_html("", visible=False)
        self.key = gui.add_html("")
        self.layers = gui.add_html("")

    def refresh(
        self,
        state: State,
        frame: Frame,
        readings: Readings,
        browsers: int,
        colour: str,
        legend: list[tuple[str, str]],
        beside: Readings | None = None,
    ) -> None:
        """Show the latest of everything; of two flocks in two columns."""
        told = numbers(state, frame, readings.values, browsers)
        show_block(self.clock, clock(frame))
        second, name = frame.beside, state.start.beside
        if second is not None and beside is not None and name is not None:
            models = state.start.model, name
            others = numbers(state, second, beside.values, browsers)
            common = (*COMMON, *(["tick"] if told["tick"] == others["tick"] else []))
            in_common = {name: text for name, text in told.items() if name in common}
            self.cards.content = block(grid(in_common, across=len(in_common)))
            show_block(self.titles, titled_columns(*models) + keeping_up(frame, second))
            flocks = without(told, common), without(others, common)
            show_block(self.compared, compared("Flock", models, *flocks))
            missions = (
                mission_numbers(frame, readings.values),
                mission_numbers(second, beside.values),
            )
            show_block(self.mission, compared(errand_title(frame), models, *missions))
        else:
            self.titles.visible = self.compared.visible = False
            self.cards.content = cards(told)
            show_block(self.mission, errand(frame, readings.values))
        entries = [(html.escape(words), css) for words, css in legend]
        self.key.content = block(
            f'<div class="fs-head">Colour: {html.escape(colour)}</div>{key(entries)}'
        )
        led = frame.informed.any() or (second is not None and second.informed.any())
        self.layers.visible = bool(led)
        if led and beside is not None and name is not None:
            self.layers.content = block(
                layer_bars(readings.layers.tolist(), readings.unknown, state.start.model)
                + layer_bars(beside.layers.tolist(), beside.unknown, name)
            )
        elif led:
            self.layers.content = block(layer_bars(readings.layers.tolist(), readings.unknown))


def numbers(state: State, frame: Frame, values: dict[str, float], browsers: int) -> dict[str, str]:
    """The cards, name -> text."""

    def shown(name: str, form: str) -> str:
        return format(values[name], form) if name in values else "–"

    return {
        "tick": spaced(frame.tick),
        "agents": spaced(len(frame.ids)),
        "ticks / s": rate_text(state.rate),
        "polarisation": shown("polarisation", ".3f"),
        "consistency": shown("consistency", ".4f"),
        "neighbours": shown("mean-neighbours", ".1f"),
        "groups": shown("groups", ".0f"),
        "largest group": shown("largest-group", ".0f"),
        "browsers": str(browsers),
    }


def without(values: dict[str, str], names: tuple[str, ...]) -> dict[str, str]:
    """All values but the named ones."""
    return {name: text for name, text in values.items() if name not in names}


def clock(frame: Frame) -> str:
    """The time, for models whose bodies count it in seconds; else nothing."""
    if frame.unit == "ticks":
        return ""
    return (
        f'<div class="fs-clock"><b>t = {frame.tick * frame.dt:.1f} {html.escape(frame.unit)}</b>'
        f" · tick {spaced(frame.tick)}</div>"
    )


def errand(frame: Frame, values: dict[str, float]) -> str:
    """Cards of how the mission stands and of what the agents have come close to; or nothing."""
    what = errand_title(frame)
    if not what:
        return ""
    return f'<div class="fs-head">{what}</div>{grid(mission_numbers(frame, values))}'


def errand_title(frame: Frame) -> str:
    """What the cards of a mission, or of what is solid, are headed; nothing without either."""
    if frame.world.mission is not None:
        return "Mission"
    return "Safety" if frame.world.is_solid else ""


def mission_numbers(frame: Frame, values: dict[str, float]) -> dict[str, str]:
    """The cards of a mission, name -> text; only what this world and this flock have."""
    mission = frame.world.mission or Mission()
    told = {}
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
        '<div class="fs-head">Layers<span class="fs-quiet">'
        f"{html.escape(model) or 'steps from the information agent'}</span></div>"
        f'<div class="fs-bars">{bars}</div>'
    )


def bar(label: str, count: int, most: int, colour: str) -> str:
    """One bar with its count above and its label below."""
    height = max(2, round(34 * count / most)) if count else 0
    return f'<div>{count}<i style="height:{height}px;background:{colour}"></i>{label}</div>'
