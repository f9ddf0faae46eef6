"""A plot on a page: a chart, to be looked at large and to be taken along."""

from __future__ import annotations

from collections.abc import Callable

import viser

from app.viewer.panels.chart import LARGE_HEIGHT, LARGE_POINTS, NOTHING, Chart, ChartContents
from app.viewer.panels.large_window import Sheets
from app.viewer.panels.plotted import KINDS, Plotted
from app.viewer.panels.sending import Sender

LARGE = "Large"
"""The button that shows a plot large; static/plots.js presses it when a plot is clicked."""


class Plot:
    """A chart with its buttons, and the same chart in every browser that looks at it large."""

    def __init__(
        self,
        server: viser.ViserServer,
        title: str,
        take: Callable[[], Plotted | None],
        sender: Sender,
        label: str = "",
    ):
        """`take` says, when somebody asks, what the plot shows; None for nothing.

        `label` stands at the buttons.
        """
        self.title, self.take, self.sender = title, take, sender
        self.label = label or f"{title} as"
        self.shown = self.shown_large = NOTHING
        self.chart = Chart(server.gui)
        self.buttons = server.gui.add_button_group(
            self.label,
            (LARGE, *KINDS),
            visible=False,
            hint="Large: over the page, also by a click on the plot. CSV: every value that is "
            "kept, with its unit. PNG, SVG: a figure to print",
        )
        self.buttons.on_click(self.pressed)
        self.sheets = Sheets(server, self.large)

    def show(self, shown: ChartContents, head: str = "") -> None:
        """Draw curves; where they are shown large, below another head."""
        self.shown, self.shown_large = shown, shown._replace(head=head or shown.head)
        self.chart.show(shown)
        self.buttons.visible = bool(shown.curves)
        self.sheets.each(lambda chart: chart.show(self.shown_large))

    def large(self, gui: viser.GuiApi) -> Chart:
        """What is in a window that shows it large."""
        chart = Chart(gui, LARGE_HEIGHT, LARGE_POINTS)
        chart.show(self.shown_large)
        gui.add_button_group(self.label, KINDS).on_click(self.pressed)
        return chart

    async def pressed(self, event: viser.GuiEvent) -> None:
        client, wanted = event.client, event.target.value
        if client is None:
            return
        if wanted == LARGE:
            self.sheets.show(client, self.title)
        elif wanted in KINDS and (plotted := self.take()) is not None:
            await self.sender.send(client, plotted.file(wanted), lambda: plotted.content(wanted))
