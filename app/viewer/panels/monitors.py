"""The top of the left panel: what is told in numbers, and what the colours mean."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence
from functools import cache

import numpy as np
import viser

from app.front.viser_internals import is_connected
from app.viewer.measuring.observable_format import format_short, format_thousands
from app.viewer.panels.shell import block, grid, key
from app.viewer.scene.cameras.flock_in_sight import FlockInSight
from app.viewer.scene.shown import palette
from app.viewer.scene.shown.colouring import COLOURINGS, DIRECTIONS, STEEP
from app.viewer.scene.shown.drawing_style import (
    SINGLES_UP_TO,
    DrawingStyle,
    legend,
    shows_density,
)
from app.viewer.scene.shown.frame import Frame

# The colours of headings as a wheel, which lies as the scene does when it is seen from above.

ROUND = 72
"""Colours of the wheel that are given, evenly; the browser blends those between."""
UPWARDS = 16
"""The same from a dive straight down to a climb straight up."""


@cache
def wheel(dim: int) -> str:
    """HTML of the wheel; in space with a bar that says how climbing and diving look."""
    words = "".join(f"<span>{words}</span>" for words in DIRECTIONS)
    round_ = f'<div class="fs-wheel">{words}<i style="background:{level_gradient()}"></i></div>'
    caption = '<div class="fs-quiet">as seen from above</div>'
    if dim == 3:
        names = "".join(f"<span>{name}</span>" for name in STEEP)
        sample = f'<i style="background:{climb_gradient()}"></i>'
        caption += f'<div class="fs-climb">{sample}<div>{names}</div></div>'
    return f'<div class="fs-headings fs-drawn">{round_}<div>{caption}</div></div>'


def level_gradient() -> str:
    """A CSS gradient of the level headings: +x to the right, and then against the clock."""
    azimuth = -np.linspace(0.0, 2.0 * np.pi, ROUND + 1)
    return gradient("conic-gradient(from 90deg", np.stack([np.cos(azimuth), np.sin(azimuth)]))


def climb_gradient() -> str:
    """A CSS gradient of the headings from straight down to straight up, over +x."""
    rise = np.linspace(-0.5 * np.pi, 0.5 * np.pi, UPWARDS + 1)
    return gradient("linear-gradient(0deg", np.stack([np.cos(rise), 0.0 * rise, np.sin(rise)]))


def gradient(kind: str, headings: np.ndarray) -> str:
    """A CSS gradient of the colours of headings (dim, K)."""
    return f"{kind},{','.join(map(palette.css, palette.heading_colours(headings.T)))})"


# One line in each browser on a flock of which no agent can be told apart.


def describe_sight(flocks: Sequence[FlockInSight]) -> str:
    """What is drawn of flocks in a browser, HTML; empty where every agent is drawn."""
    return "".join(f'<div class="fs-quiet">{describe_flock(flock)}</div>' for flock in flocks)


def describe_flock(flock: FlockInSight) -> str:
    """The same of one flock."""
    count = format_thousands(flock.count)
    if flock.as_singles:
        return f"{count} agents in sight, drawn one by one. Zoom out for their density."
    if flock.typical is None:
        near = f", the nearest {format_thousands(flock.near)} one by one" if flock.near else ""
        return (
            f"Density of {count} agents in sight{near}. Hue: mean heading. Faint: few behind each "
            "other. Grey: not aligned, or steep. Zoom in for single agents."
        )
    return (
        f"Density of {count} agents in sight. Hue: mean heading. Faint: sparse, half strength at "
        f"{format_short(flock.typical)} per length². Grey: not aligned. Zoom in to "
        f"{format_thousands(SINGLES_UP_TO)} for single agents."
    )


class SightLines:
    """The line of each browser that has one; of others nothing is made."""

    def __init__(self, server: viser.ViserServer, place: viser.GuiTabHandle, below: float):
        """`place` is the tab that it stands in, `below` the order of what it stands below."""
        self.place, self.order = place, below + 0.5
        self.lines: dict[int, viser.GuiHtmlHandle] = {}
        """By browser."""
        server.on_client_disconnect(self.remove_client)

    def show(self, client: viser.ClientHandle, flocks: Sequence[FlockInSight]) -> None:
        """Show what one browser sees."""
        text, line = describe_sight(flocks), self.lines.get(client.client_id)
        if line is None and text and is_connected(client):
            with self.place:
                line = client.gui.add_html("", order=self.order)
            self.lines[client.client_id] = line
        if line is not None:
            line.content, line.visible = block(text), bool(text)

    async def remove_client(self, client: viser.ClientHandle) -> None:
        """A browser is there no more."""
        self.lines.pop(client.client_id, None)


CARDS, KEY = "cards", "key"
"""The blocks that every page has."""


class Monitors:
    """Blocks of HTML below each other, by name; each hidden while it is empty."""

    def __init__(self, gui: viser.GuiApi, names: Sequence[str], first: str):
        """`first` is the card that stands there until there is anything to tell."""
        self.blocks: dict[str, viser.GuiHtmlHandle] = {}
        self.add(gui, names)
        self.show({CARDS: grid({first: "–"})})

    def add(self, gui: viser.GuiApi, names: Sequence[str]) -> None:
        """Blocks below whatever has come into the panel since."""
        self.blocks |= {name: gui.add_html("", visible=False) for name in names}

    def sight_lines(self, server: viser.ViserServer, place: viser.GuiTabHandle) -> SightLines:
        """Room below the key to colours for a line of each browser."""
        return SightLines(server, place, self.blocks[KEY].order)

    def show(self, contents: Mapping[str, str]) -> None:
        """Show the content of some blocks."""
        for name, content in contents.items():
            place = self.blocks[name]
            place.visible = bool(content)
            if content:
                place.content = block(content)

    def colours(self, look: DrawingStyle, frame: Frame) -> None:
        """Say what the colours mean."""
        entries = [(html.escape(words), css) for words, css in legend(look, frame)]
        head = f'<h2 class="fs-head">Colour: {html.escape(look.measured or look.colour)}</h2>'
        has_wheel = COLOURINGS[look.colour].has_wheel or shows_density(frame)
        headings = wheel(frame.dim) if has_wheel else ""
        self.show({KEY: head + headings + key(entries, drawn=True)})
