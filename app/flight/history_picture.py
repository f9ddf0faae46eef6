"""A flight over time."""

from __future__ import annotations

from typing import Any

import numpy as np

from app.flight.canvas import FAINT, LIFT, OTHER, POWER, THRUST


def draw_history(figure: Any, flown: Any, trimmed: Any) -> None:
    """Four panels of a flown `History`; behind it in grey the flight without a push."""
    figure.set_size_inches(10.0, 6.4)
    panels = figure.subplots(2, 2, sharex=True).ravel()
    shown = (
        ("speed", "speed / m/s", LIFT, 1.0),
        ("pitch", "pitch / deg", OTHER, np.degrees(1.0)),
        ("height", "height / m", THRUST, 1.0),
        ("power", "power of the shafts / W", POWER, 1.0),
    )
    for axes, (name, title, colour, factor) in zip(panels, shown, strict=True):
        axes.plot(
            trimmed.time,
            factor * getattr(trimmed, name),
            color=FAINT,
            linewidth=1.0,
            label="in trim",
        )
        axes.plot(
            flown.time, factor * getattr(flown, name), color=colour, linewidth=1.4, label="flown"
        )
        axes.set_title(title)
        axes.set_xlim(0.0, flown.time[-1])
    panels[0].legend(fontsize=9)
    for axes in panels[2:]:
        axes.set_xlabel("time / s")
