"""The card of the agent that was clicked: a window of its own, which each browser puts beside it.

`card.js` does so, by what the card says of where the agent is drawn.
"""

from __future__ import annotations

import html
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
import viser

from app.viewer.lab.panels.agent.card import Fold, folds, head
from app.viewer.panels.form import sight
from app.viewer.panels.style import block
from app.viewer.scene.shown.frame import Frame

LOOKING = (
    '<div class="fs-quiet">Looking closer … a model is compiled for this the first time.</div>'
)
FOLDS: tuple[Fold, ...] = ("rest", "zones", "forces", "heard")
"""What is folded up at first, from the top down; each browser unfolds for itself."""
WIDTH = 248


class Inspector:
    """There only while an agent is inspected."""

    def __init__(self, gui: viser.GuiApi, close: Callable[[], None]):
        self.panel = gui.add_panel(visible=False)
        self.folds: dict[Fold, tuple[Any, Any]] = {}
        with self.panel.add_tab("Agent", viser.Icon.ZOOM_IN):
            self.head = gui.add_html("")
            for name in FOLDS:
                with gui.add_folder("", expand_by_default=False, visible=False) as folder:
                    self.folds[name] = folder, gui.add_html("")
            button = gui.add_button("Close", icon=viser.Icon.X, color="gray")
        self.panel.float(x=WIDTH // 4, y=-12, width=WIDTH)

        async def closed(_event: viser.GuiEvent) -> None:
            close()

        button.on_click(closed)

    def refresh(self, frame: Frame, row: int | None, at: Iterable[float] = ()) -> None:
        """Show the agent of a row as it is now; nothing for None or a row that is not there.

        `at` (3,) is where it is drawn.
        """
        wanted = row is not None and row < len(frame.ids)
        if wanted and not self.panel.visible:
            self.panel.expand()  # on a phone, and where somebody has made it small
        sight(self.panel, wanted)
        if not wanted or row is None:
            return
        seen, told = frame.inspected, {}
        words = LOOKING
        if seen is not None:
            words, told = head(frame, seen), folds(frame, seen)
        place = " ".join(f"{one:.4f}" for one in np.asarray(at, float))
        mark = f'data-agent="{html.escape(frame.title)} {frame.ids[row]}" data-at="{place}"'
        self.head.content = block(
            f'<div class="fs-agent" data-panel="{self.panel._impl.uuid}" {mark}>{words}</div>'
        )
        for name, (folder, content) in self.folds.items():
            sight(folder, name in told)
            if name in told:
                folder.label, content.content = told[name][0], block(told[name][1])
