"""Numbers of the flock as it runs: cards, the key to the colours, and the layers."""

from __future__ import annotations

import html

import viser

from app.viewer.frame import Frame
from app.viewer.panels.style import block, cards, key
from app.viewer.readings import Readings
from app.viewer.scene import palette
from app.viewer.state import State

MOST_BARS = 12


class Monitors:
    """The top of the left panel."""

    def __init__(self, gui: viser.GuiApi):
        self.cards = gui.add_html(cards({"tick": "–"}))
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
    ) -> None:
        """Show the latest of everything."""
        self.cards.content = cards(numbers(state, frame, readings.values, browsers))
        entries = [(html.escape(words), css) for words, css in legend]
        self.key.content = block(
            f'<div class="fs-head">Colour: {html.escape(colour)}</div>{key(entries)}'
        )
        self.layers.visible = bool(frame.informed.any())
        if self.layers.visible:
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


def rate_text(rate: float) -> str:
    """Ticks per second in few figures."""
    return f"{rate:.1f}" if rate < 100 else spaced(round(rate))


def spaced(number: int) -> str:
    """A number with its thousands apart."""
    return f"{number:,}".replace(",", "\N{NARROW NO-BREAK SPACE}")


def layer_bars(counts: list[int], unknown: int) -> str:
    """Bars of how many agents are in each layer; deep layers go together in the last bar."""
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
        f'steps from the information agent</span></div><div class="fs-bars">{bars}</div>'
    )


def bar(label: str, count: int, most: int, colour: str) -> str:
    """One bar with its count above and its label below."""
    height = max(2, round(34 * count / most)) if count else 0
    return f'<div>{count}<i style="height:{height}px;background:{colour}"></i>{label}</div>'
