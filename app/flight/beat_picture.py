"""Lift, thrust and power over a wing beat."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from app.flight.canvas import FAINT, LIFT, OTHER, POWER, THRUST


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


def one_beat(beat: Any) -> Beat:
    """The only wing beat of a `History`."""
    phase = np.arange(beat.time.size) / beat.time.size
    flap, twist = np.degrees(beat.flap), np.degrees(beat.twist)
    return Beat(phase, flap, twist, beat.lift, beat.thrust, beat.power, {})


def averaged(track: Any, per_beat: int) -> Beat:
    """The mean wing beat of a `History` of whole beats with `per_beat` instants each."""
    whole = track.time.size // per_beat * per_beat

    def by_beat(name: str) -> np.ndarray:
        return getattr(track, name)[:whole].reshape(-1, per_beat)

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
    shown = zip(NAMES, ("lift / N", "thrust less drag / N", "power of the shafts / W"), strict=True)
    for axes, (name, title), colour in zip(panels[1:], shown, (LIFT, THRUST, POWER), strict=True):
        values = getattr(beat, name)
        if name in beat.bands:
            low, high = (np.append(one, one[0]) for one in beat.bands[name])
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
