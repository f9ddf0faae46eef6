"""What a load costs: speed, power, endurance and how the wings beat."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from app.figure import new_figure, write_figure
from app.results_folder import PICTURES, make_folder

# A figure in the house's look, written as PNG and SVG.

LIFT, THRUST, POWER, FAINT, OTHER = "#2166ac", "#2a9d5c", "#c0392b", "#9aa3ad", "#b07d12"


def write_figures(
    draw: Callable[[Any], None], title: str, folder: Path, name: str
) -> dict[str, Path]:
    """Let `draw` fill a figure and write NAME.png and NAME.svg; the files by kind.

    Raises InputError if they cannot be written.
    """
    files = {kind: folder / f"{name}.{kind}" for kind in PICTURES}
    with new_figure() as figure:
        draw(figure)
        figure.suptitle(title, x=0.01, ha="left")
        make_folder(folder)
        for path in files.values():
            write_figure(figure, path)
    return files


# Lift, thrust and power over a wing beat.


class Beat(NamedTuple):
    """What is drawn over a wing beat; arrays (K,), and bands (2, K) or None."""

    phase: np.ndarray
    """[0, 1)."""
    flap: np.ndarray
    """deg."""
    twist: np.ndarray
    """deg."""
    lift: np.ndarray
    """N."""
    thrust: np.ndarray
    """N."""
    power: np.ndarray
    """W."""
    bands: dict[str, np.ndarray]
    """Least and largest over several beats, by name."""


NAMES = ("lift", "thrust", "power")


def single_beat(beat: Any) -> Beat:
    """The only wing beat of a `History`."""
    phase = np.arange(beat.time.size) / beat.time.size
    flap, twist = np.degrees(beat.flap), np.degrees(beat.twist)
    return Beat(phase, flap, twist, beat.lift, beat.thrust, beat.power, {})


def mean_beat(track: Any, per_beat: int) -> Beat:
    """The mean wing beat of a `History` of whole beats with `per_beat` instants each."""
    complete = track.time.size // per_beat * per_beat

    def by_beat(name: str) -> np.ndarray:
        return getattr(track, name)[:complete].reshape(-1, per_beat)

    bands = {name: np.stack((by_beat(name).min(0), by_beat(name).max(0))) for name in NAMES}
    mean = {name: by_beat(name).mean(0) for name in NAMES}
    flap, twist = (np.degrees(by_beat(name)[0]) for name in ("flap", "twist"))
    return Beat(np.arange(per_beat) / per_beat, flap, twist, **mean, bands=bands)


def draw_beat(figure: Any, beat: Beat, weight: float) -> None:
    """Four panels: how the wings are driven, lift, thrust and power; `weight` in N."""
    figure.set_size_inches(10.0, 6.4)
    panels = figure.subplots(2, 2, sharex=True).ravel()
    phase = np.append(beat.phase, 1.0)

    def line(axes: Any, values: np.ndarray, colour: str, label: str) -> None:
        axes.plot(phase, np.append(values, values[0]), color=colour, linewidth=1.8, label=label)

    line(panels[0], beat.flap, LIFT, "flap $\\varphi$, wings up")
    line(panels[0], beat.twist, OTHER, "twist $\\eta$ of the tip, nose up")
    panels[0].set_title("wings / deg")
    low, high = panels[0].get_ylim()
    panels[0].set_ylim(low - 0.25 * (high - low), high)
    panels[0].legend(fontsize=9, loc="lower left", ncols=2)
    captions = zip(
        NAMES, ("lift / N", "thrust less drag / N", "power of the shafts / W"), strict=True
    )
    for axes, (name, title), colour in zip(
        panels[1:], captions, (LIFT, THRUST, POWER), strict=True
    ):
        values = getattr(beat, name)
        if name in beat.bands:
            low, high = (np.append(value, value[0]) for value in beat.bands[name])
            axes.fill_between(phase, low, high, color=colour, alpha=0.18, linewidth=0.0)
        line(axes, values, colour, "")
        axes.axhline(values.mean(), color=colour, linewidth=1.0, linestyle="--")
        axes.annotate(
            f"mean {0.0 if abs(values.mean()) < 5e-4 else values.mean():.3g}",
            (1.0, values.mean()),
            xytext=(0, 3),
            textcoords="offset points",
            ha="right",
            fontsize=9,
            color=colour,
        )
        axes.set_title(title)
    panels[1].axhline(weight, color=FAINT, linewidth=1.0)
    panels[1].annotate(
        "weight", (0.0, weight), xytext=(2, -11), textcoords="offset points", fontsize=8
    )
    for axes in panels[2:]:
        axes.set_xlabel("wing beats")
    for axes in panels:
        axes.axhline(0.0, color="#7a828c", linewidth=0.6)
        axes.set_xlim(0.0, 1.0)


# The U curve: what a metre and a second of flight cost over speed.


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


# A flight over time.


def draw_history(figure: Any, flown: Any, trimmed: Any) -> None:
    """Four panels of a flown `History`; behind it in grey the flight without a push."""
    figure.set_size_inches(10.0, 6.4)
    panels = figure.subplots(2, 2, sharex=True).ravel()
    curves = (
        ("speed", "speed / m/s", LIFT, 1.0),
        ("pitch", "pitch / deg", OTHER, np.degrees(1.0)),
        ("height", "height / m", THRUST, 1.0),
        ("power", "power of the shafts / W", POWER, 1.0),
    )
    for axes, (name, title, colour, factor) in zip(panels, curves, strict=True):
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
