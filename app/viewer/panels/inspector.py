"""The card of the agent that was clicked."""

from __future__ import annotations

import html
from collections.abc import Callable

import numpy as np
import viser

from agents.inspection import Inspection
from app.viewer.frame import Frame
from app.viewer.panels.style import block, table

MOST_NEIGHBOURS = 6


class Inspector:
    """A window of its own, there only while an agent is inspected."""

    def __init__(self, gui: viser.GuiApi, close: Callable[[], None]):
        self.panel = gui.add_panel(visible=False)
        with self.panel.add_tab("Agent", viser.Icon.ZOOM_IN):
            self.card = gui.add_html("")
            button = gui.add_button("Close", icon=viser.Icon.X, color="gray")
        self.panel.float(x=12, y=-12, width=250)

        async def closed(_event: viser.GuiEvent) -> None:
            close()

        button.on_click(closed)

    def refresh(self, frame: Frame) -> None:
        """Show the inspected agent as it is now, or nothing."""
        seen = frame.inspected
        if self.panel.visible != (seen is not None):
            self.panel.visible = seen is not None
        if seen is not None:
            self.card.content = block(card(frame, seen))


def card(frame: Frame, seen: Inspection) -> str:
    """What is known of the agent and of those it listens to."""
    rows = {html.escape(name): html.escape(value) for name, value in facts(frame, seen).items()}
    if frame.group is not None and seen.row < len(frame.group):
        rows["group"] = str(int(frame.group[seen.row]) + 1)
    rows["neighbours"] = str(len(seen.neighbours))
    kind = " · information agent" if frame.informed[seen.row] else ""
    heard = listened(frame, seen)
    return f'<div class="fs-head">Agent {seen.id}{kind}</div>{table(rows)}{heard}'


def facts(frame: Frame, seen: Inspection) -> dict[str, str]:
    """An agent's state in words, name -> value with unit."""
    ux = frame.heading[seen.row]
    told = {
        "position": "(" + ", ".join(f"{value:.2f}" for value in frame.position[seen.row]) + ")",
        "heading": f"{np.degrees(np.arctan2(ux[1], ux[0])) % 360:.0f}°",
    }
    if frame.dim == 3:
        told["climb"] = f"{np.degrees(np.arcsin(np.clip(ux[2], -1, 1))):+.0f}°"
    told["speed"] = f"{frame.speed[seen.row]:.3g} per tick"
    signals = {
        name: f"{value:g}" if np.isfinite(value) else "unknown"
        for name, value in seen.signals.items()
    }
    return told | signals


def listened(frame: Frame, seen: Inspection) -> str:
    """Whom it listens to, and how much."""
    weights = np.asarray(seen.weights, float)
    total = weights.sum()
    if not len(weights) or not total > 0:
        return '<div class="fs-quiet">It listens to nobody.</div>'
    rows = ""
    for place in np.argsort(-weights)[:MOST_NEIGHBOURS]:
        share = 100 * weights[place] / total
        width = 100 * weights[place] / weights.max()
        rows += (
            f"<tr><td>{frame.ids[seen.neighbours[place]]}</td>"
            f'<td style="width:60%"><div class="fs-weight" style="width:{width:.1f}%"></div></td>'
            f"<td>{share:.0f} %</td></tr>"
        )
    more = len(weights) - MOST_NEIGHBOURS
    rest = f'<tr><td colspan="3">and {more} more</td></tr>' if more > 0 else ""
    return f'<div class="fs-head">Listens to</div><table class="fs-table">{rows}{rest}</table>'
