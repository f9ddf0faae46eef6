"""The top of the left panel: what is told in numbers, and what the colours mean."""

from __future__ import annotations

import html
from collections.abc import Mapping, Sequence

import viser

from app.viewer.panels.style import block, grid, key
from app.viewer.panels.wheel import wheel
from app.viewer.scene.shown.colouring import COLOURINGS
from app.viewer.scene.shown.drawing_style import DrawingStyle, legend
from app.viewer.scene.shown.frame import Frame

CARDS, KEY = "cards", "key"
"""The blocks that every page has."""


class Monitors:
    """Blocks of HTML below each other, by name; each hidden while it is empty."""

    def __init__(self, gui: viser.GuiApi, names: Sequence[str], first: str):
        """`first` is the card that stands there until there is anything to tell."""
        self.blocks = {name: gui.add_html("", visible=False) for name in names}
        self.show({CARDS: grid({first: "–"})})

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
        head = f'<div class="fs-head">Colour: {html.escape(look.measured or look.colour)}</div>'
        headings = wheel(frame.dim) if COLOURINGS[look.colour].has_wheel else ""
        self.show({KEY: head + headings + key(entries, drawn=True)})
