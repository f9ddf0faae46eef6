"""What a load costs: speed, power, endurance and how the wings beat."""

from __future__ import annotations

from typing import Any

from app.flight.canvas import FAINT, LIFT, OTHER, POWER, THRUST

ROOM = 1.08
"""Of the largest value, how high a panel goes."""
ABOVE = 4.0
"""Degrees above the angles, for their names."""


def draw_load(figure: Any, rows: list[dict[str, Any]], battery: str) -> None:
    """Four panels over the load, from the values of flights in the order of their loads."""
    figure.set_size_inches(10.0, 6.6)
    speed, power, lasts, wings = figure.subplots(2, 2, sharex=True).ravel()
    loads = [row["load"] for row in rows]

    def line(axes: Any, name: str, colour: str, label: str = "", marker: str = "o") -> None:
        values = [row[name] for row in rows]
        axes.plot(loads, values, color=colour, marker=marker, markersize=4.5, label=label)

    line(speed, "speed", LIFT)
    speed.set_title("speed / m/s")
    line(power, "power", POWER, "shafts")
    line(power, "power_without_regain", FAINT, "shafts, nothing regained", "s")
    power.set_title("power / W")
    line(lasts, "endurance", THRUST, "endurance / h")
    far = lasts.twinx()
    line(far, "range", OTHER, "range / km", "s")
    far.spines["right"].set(visible=True, edgecolor=OTHER)
    far.tick_params(axis="y", colors=OTHER)
    far.grid(visible=False)
    far.set_ylabel("range / km", color=OTHER)
    lasts.set_title(f"endurance / h: {battery}", fontsize=10)
    line(wings, "amplitude", LIFT, "flap amplitude A")
    line(wings, "tail", OTHER, "tail angle", "s")
    line(wings, "pitch", THRUST, "mean pitch", "^")
    wings.set_title("angles / deg")
    for axes in (speed, power, lasts, far):
        axes.set_ylim(0.0, ROOM * axes.get_ylim()[1])
    wings.set_ylim(top=wings.get_ylim()[1] + ABOVE)
    power.legend(fontsize=9, loc="upper left")
    wings.legend(fontsize=9, loc="upper left", ncols=3)
    handles = [*lasts.get_lines(), *far.get_lines()]
    lasts.legend(handles=handles, fontsize=9, loc="lower left")
    for axes in (lasts, wings):
        axes.set_xlabel("load / g")
