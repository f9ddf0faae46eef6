"""The U curve: what a metre and a second of flight cost over speed."""

from __future__ import annotations

from typing import Any

from app.flight.canvas import FAINT, LIFT, OTHER, POWER, THRUST


def draw_curve(figure: Any, rows: list[dict[str, Any]]) -> None:
    """Four panels over speed, from the values of trims in the order of their speeds."""
    figure.set_size_inches(10.0, 6.4)
    cost, power, wings, steady = figure.subplots(2, 2, sharex=True).ravel()
    speeds = [row["speed"] for row in rows]

    def line(axes: Any, name: str, colour: str, label: str = "") -> None:
        values = [row[name] for row in rows]
        axes.plot(speeds, values, color=colour, marker="o", markersize=4.5, label=label)

    line(cost, "energy_per_metre", POWER)
    best = min(rows, key=lambda row: row["energy_per_metre"])
    cost.annotate(
        f"least: {best['energy_per_metre']:.3g} J/m at {best['speed']:g} m/s",
        (best["speed"], best["energy_per_metre"]),
        xytext=(0, -14),
        textcoords="offset points",
        fontsize=9,
        ha="left",
    )
    cost.set_title("energy per metre / J/m")
    cost.set_ylim(bottom=0.0)

    line(power, "power", POWER, "shafts")
    towed = [row for row in rows if row["towing_power"] is not None]
    power.plot(
        [row["speed"] for row in towed],
        [row["towing_power"] for row in towed],
        color=FAINT,
        marker="s",
        markersize=3.5,
        label="drag times speed, wings still",
    )
    power.set_title("power / W")
    power.set_ylim(bottom=0.0)
    power.legend(fontsize=9)

    line(wings, "amplitude", LIFT, "flap amplitude A")
    line(wings, "tail", OTHER, "tail angle")
    line(wings, "pitch", THRUST, "mean pitch")
    wings.set_title("deg")
    wings.legend(fontsize=9)

    line(steady, "largest_multiplier", LIFT)
    steady.axhline(1.0, color=POWER, linewidth=1.0, linestyle="--")
    steady.annotate(
        "unstable above", (1.0, 1.0), xycoords=("axes fraction", "data"), xytext=(-2, 3),
        textcoords="offset points", ha="right", fontsize=9, color=POWER,
    )  # fmt: skip
    steady.set_ylim(0.0, max(1.15, *(1.05 * row["largest_multiplier"] for row in rows)))
    steady.set_title("largest Floquet multiplier")
    for axes in (wings, steady):
        axes.set_xlabel("speed / m/s")
