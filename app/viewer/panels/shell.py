"""What every page has in common: its look, and where its panels are."""

from __future__ import annotations

import viser

from app.viewer.panels.style import CSS

LEFT, RIGHT = 310, 330
"""Widths of the panels, pixels."""


def dress(gui: viser.GuiApi, label: str) -> None:
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
