"""What every page has in common: its look, and where its panels are."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable, Mapping
from typing import Any

import viser

from app.package_files import STATIC

# How the HTML in the panels looks: cards, keys, bars and tables.

BLUE, ORANGE, GREEN, RED, GREY = "#1c7ed6", "#d97706", "#2f9e44", "#e03131", "#868e96"
VIOLET = "#8b5cf6"
"""Of curves and dots: they stand out from a light and from a dark ground, 3 to 1."""

ROOM = 8
"""Letters that fit a card in its usual type."""

CSS = f"<style>{(STATIC / 'panels.css').read_text('utf-8')}</style>"


def block(content: str) -> str:
    """Content of a panel in the house's type and spacing."""
    return f'<div class="fs">{content}</div>'


def cards(values: dict[str, str]) -> str:
    """A grid of cards, name -> value, as content of a panel."""
    return block(grid(values))


def grid(values: dict[str, str], across: int = 3) -> str:
    """A grid of cards, name -> value, so many in a row."""
    cards = "".join(
        f'<div class="fs-card{" fs-long" if len(value) > ROOM else ""}">'
        f"<span>{name}</span><b>{value}</b></div>"
        for name, value in values.items()
    )
    columns = f' style="grid-template-columns:repeat({across},1fr)"' if across != 3 else ""
    return f'<div class="fs-cards"{columns}>{cards}</div>'


def key(entries: list[tuple[str, str]], drawn: bool = False, hollow: bool = False) -> str:
    """A key to colours: (label, css colour), of what is `drawn` in the scene or of curves.

    `hollow`: of outlines.
    """
    style = "border:2px solid" if hollow else "background:"
    marks = "".join(
        f'<span><i style="{style} {colour}"></i>{label}</span>' for label, colour in entries
    )
    return f'<div class="fs-key{" fs-drawn" if drawn else ""}">{marks}</div>'


def table(rows: dict[str, str]) -> str:
    """A table of two columns."""
    html_rows = "".join(f"<tr><td>{name}</td><td>{value}</td></tr>" for name, value in rows.items())
    return f'<table class="fs-table">{html_rows}</table>'


LEFT, RIGHT = 310, 330
"""Widths of the panels, pixels."""


def set_look(gui: viser.GuiApi, label: str) -> None:
    """Give a page the house's look."""
    gui.configure_theme(
        control_width="large",
        show_logo=False,
        show_share_button=False,
        brand_color=(28, 105, 176),
    )
    gui.set_panel_label(label)
    gui.add_html(CSS)


def dock(gui: viser.GuiApi, left: viser.PanelHandle) -> None:
    """Put the monitors to the left and the controls to the right."""
    left.dock_left()
    left.set_width(LEFT)
    gui.main_panel.dock_right()
    gui.main_panel.set_width(RIGHT)


# A window over one browser's page, to look at something large while the run goes on.

MARK = block('<div class="fs-page fs-short fs-large"></div>')
"""By it the page knows what Escape and a click beside it close, and how wide it is."""

SETTLED = 0.1
"""Seconds until a browser has done what it was told last: what it is to change must be there."""


class Sheets:
    """Windows of one kind, at most one in each browser."""

    def __init__(self, server: viser.ViserServer, fill: Callable[[viser.GuiApi], Any]):
        """`fill` puts into a window what is in it, and returns what changes there."""
        self.fill = fill
        self.open: dict[int, Any] = {}
        """By browser, what is in its window."""
        self.lock = threading.Lock()
        """Held while what is in windows is changed: nothing is to be closed meanwhile."""
        server.on_client_disconnect(self.remove_client)

    def show(self, client: viser.ClientHandle, title: str) -> None:
        """Open one in a browser, unless one is open there."""
        if client.client_id in self.open:
            return
        gui = client.gui
        modal = gui.add_modal(title)
        with modal:
            gui.add_html(CSS + MARK)
            filled = self.fill(gui)
            done = gui.add_button("Close", icon=viser.Icon.X, color="gray")

        async def close(_event: viser.GuiEvent) -> None:
            with self.lock:
                was_open = self.open.pop(client.client_id, None) is not None
            if was_open:
                await asyncio.sleep(SETTLED)
                modal.close()

        done.on_click(close)
        self.open[client.client_id] = filled

    async def remove_client(self, client: viser.ClientHandle) -> None:
        """A browser is there no more."""
        with self.lock:
            self.open.pop(client.client_id, None)

    def update_each(self, change: Callable[[Any], None]) -> None:
        """Change what is in every window."""
        with self.lock:
            for filled in self.open.values():
                change(filled)


# Keys for what is done often. viser itself moves the camera with W A S D Q E and the arrows.

KEYS = {
    "space": "Go or pause",
    "T": "Step one tick",
    "R": "Reset: the same run from its start",
    "N": "Setup: a new flock",
    "pageup": "Faster",
    "pagedown": "Slower",
    "1": "Camera: top-down",
    "2": "Camera: perspective",
    "3": "Camera: side",
    "F": "Camera: follow the clicked agent",
    "B": "Camera: ride along on the clicked agent, and off again",
    "C": "Colour by the next quantity",
    "L": "Links on or off",
    "H": "Guide",
    "U": "Rule: undo the last change of a parameter",
    "Z": "World: undo",
    "Y": "World: redo",
    "delete": "World: delete the selected obstacle",
    "escape": "World: a click selects again; camera: the ride ends",
}
"""Key -> what it does; every one has an action in some call of `add_hotkeys`."""
OWN_KEYS = {
    "P": "Panels: only the plots, then none, then all again",
    "M": "Light or dark",
    "X": "Size of the text: S, M or L",
    "G": "Gallery of scenes, models and worlds",
}
"""Keys that act in one browser alone, by its page: look.js, and in the laboratory gallery.js."""


def add_hotkeys(
    gui: viser.GuiApi,
    actions: dict[str, Callable[[viser.ClientHandle], Any]],
    keys: Mapping[str, str] = KEYS,
) -> None:
    """Give keys actions, which take the browser where they were pressed.

    A key may have several actions; `keys` say what each does.
    """
    for key, action in actions.items():
        command: Any = gui.add_command(keys[key], hotkey=key)  # type: ignore[arg-type]
        command.on_trigger(viser_action(action))


def viser_action(action: Callable[[viser.ClientHandle], Any]) -> Callable:
    """The action as viser calls it: in order, on its event loop."""

    async def run(event: Any) -> None:
        if event.client is not None:
            action(event.client)

    return run
