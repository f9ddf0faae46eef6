"""The colour of every agent, and what the colours mean."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from app.viewer.scene.shown import palette
from app.viewer.scene.shown.frame import SIMULATED, Frame

type Legend = list[tuple[str, str]]
"""What colours mean: (words, CSS colour)."""

OWN = "each its own"
"""A colour by identity, with which an agent is found again wherever it is told of."""
MEASURED = "measured"
"""Any number that each agent has: a signal of its model, or one of `OF_AGENTS`."""
KIND = "kind"
"""A colour for each kind of agents."""
MOST_NAMED = 24
"""Of more agents none is named beside its own colour."""
MOST_SAVED = 1.0
"""Share of the induced drag, saved or paid, from which on colours are full."""
DIRECTIONS = ("0° +x", "90° +y", "180°", "270°")
"""What stands around a wheel of headings, against the clock from the right."""
STEEP = ("climbing", "level", "diving")
"""What stands beside the colours of one that climbs, from the top down."""


@dataclass(frozen=True)
class Colouring:
    """What the colour of an agent may stand for; a new one is an entry of `COLOURINGS`.

    The panels, pictures, films and the command line read all of it from here.
    """

    colours: Callable[[Frame], np.ndarray]
    """The colours of the agents (N, 3), sRGB in [0, 1]."""
    legend: Callable[[Frame, str], Legend]
    """What they mean; the name is that of the number, where it is `MEASURED`."""
    of_cars: bool = False
    """Whether real cars can be coloured so."""
    needs: Callable[[Frame], bool] = lambda _: True
    """Whether a flock has what it stands for."""
    rescales: bool = False
    """Whether the numbers of its legend change from tick to tick."""
    has_leader: bool = False
    """Whether it has a colour of its own for information agents."""
    has_wheel: bool = False
    """Whether a wheel explains it, as headings."""
    labels: str = ""
    """What of a frame is computed only for it: `layer` or `group`."""
    title: str | None = None
    """What a picture calls it; None: its name."""


def _plain_colours(frame: Frame) -> np.ndarray:
    return np.tile(palette.PLAIN, (len(frame.position), 1))


def _label_colours(frame: Frame, labels: np.ndarray | None, colour: Callable) -> np.ndarray:
    """Colours of labels that were asked for a moment ago and may not be there yet."""
    if labels is None or len(labels) != len(frame.position):
        return np.tile(palette.UNKNOWN, (len(frame.position), 1))
    return colour(np.asarray(labels))


def _speed_legend(frame: Frame, _measured: str) -> Legend:
    full = frame.speed_scale
    speeds = np.array([0.0, 0.5, 1.0]) * full
    words = [f"{speed:.3g} {frame.pace_unit}" for speed in speeds]
    words[-1] += " or faster"
    return list(zip(words, map(palette.css, palette.speed_colours(speeds, full)), strict=True))


def _saving_legend(frame: Frame, _measured: str) -> Legend:
    if frame.saved is None:
        return [("not measured in this model", palette.css(palette.UNKNOWN))]
    shares = np.array([-1.0, -0.5, 0.0, 0.5, 1.0]) * MOST_SAVED
    words = [f"{100 * share:+.0f} %" if share else "0" for share in shares]
    words[0] += " (pays)"
    words[-1] += " of its induced drag"
    colours = map(palette.css, palette.saving_colours(shares, MOST_SAVED))
    return [*zip(words, colours, strict=True), ("unknown", palette.css(palette.UNKNOWN))]


def _own_legend(frame: Frame, _measured: str) -> Legend:
    """Each by its name, of few; the injected car is one of them."""
    injected = frame.cars is not None and frame.progress.goal is not None
    more = [("injected car", palette.css(palette.GOAL))] if injected else []
    if frame.live is not None:
        names = palette.car_colours(frame.live.roster)
        return [(name, palette.css(colour)) for name, colour in names.items()] + more
    if len(frame.ids) > MOST_NAMED:
        return [(f"{len(palette.OWN)} colours in turn", palette.css(palette.COLOURS[0])), *more]
    worn = np.asarray(frame.informed, bool) | frame.is_down | frame.is_caught
    if frame.cars is not None:
        worn |= frame.cars.predator
    noun = "agent" if frame.cars is None else "car"
    colours = palette.identity_colours(frame.ids)
    rows = [row for row in np.argsort(frame.ids) if not worn[row]]
    return [(f"{noun} {frame.ids[row]}", palette.css(colours[row])) for row in rows] + more


def _kind_colours(frame: Frame) -> np.ndarray:
    kind = np.zeros(len(frame.ids), int) if frame.kind is None else frame.kind
    return palette.colours_by_kind(kind, frame.kinds)


def _kind_legend(frame: Frame, _measured: str) -> Legend:
    colours = palette.kind_colours(frame.kinds)
    return list(zip(frame.kinds.names, map(palette.css, colours), strict=True))


def outlines(frame: Frame) -> Legend:
    """What the outlines of real cars mean: (state, CSS colour); nothing where there are none."""
    if frame.live is None:
        return []
    has_simulated = frame.live.is_in_state(SIMULATED).any()
    return [
        (state, palette.css(colour))
        for state, colour in palette.STATES.items()
        if state != SIMULATED or has_simulated
    ]


def _number_legend(frame: Frame, measured: str) -> Legend:
    unknown = ("unknown", palette.css(palette.UNKNOWN))
    if frame.measured is None or not np.isfinite(frame.measured).any():
        return [(f"no {measured} in this model", palette.css(palette.UNKNOWN))]
    low, high = palette.span(frame.measured)
    numbers = np.array([low, 0.5 * (low + high), high] if high > low else [low])
    colours = map(palette.css, palette.number_colours(numbers))
    entries = list(zip((f"{number:.3g}" for number in numbers), colours, strict=True))
    return entries if np.isfinite(frame.measured).all() else [*entries, unknown]


def _layer_legend(frame: Frame, _measured: str) -> Legend:
    last = len(palette.LAYERS)
    layers = np.empty(0, int) if frame.layer is None else np.asarray(frame.layer)
    present = layers[layers <= len(layers)]
    deepest = min(int(present.max(initial=1)), last)
    entries = [("layer 1: information agent", palette.css(palette.LAYERS[0]))]
    for layer in range(2, deepest + 1):
        words = f"layer {layer}" if layer < last else f"layer {last} and farther"
        entries.append((words, palette.css(palette.LAYERS[layer - 1])))
    return [*entries, ("unknown", palette.css(palette.UNKNOWN))]


def _group_legend(frame: Frame, _measured: str) -> Legend:
    count = 1 if frame.group is None else int(np.max(frame.group, initial=0)) + 1
    last = len(palette.GROUPS)
    words = ["largest group", *(f"group {rank}" for rank in range(2, last)), "smaller groups"]
    return list(zip(words, map(palette.css, palette.GROUPS), strict=True))[: min(count, last)]


COLOURINGS = {
    "heading": Colouring(
        lambda frame: palette.heading_colours(frame.heading),
        lambda *_: [],
        of_cars=True,
        has_wheel=True,
    ),
    OWN: Colouring(palette.frame_colours, _own_legend, of_cars=True),
    KIND: Colouring(_kind_colours, _kind_legend, needs=lambda frame: frame.kind is not None),
    "layer": Colouring(
        lambda frame: _label_colours(frame, frame.layer, palette.layer_colours),
        _layer_legend,
        needs=lambda frame: bool(frame.informed.any()),
        has_leader=True,
        labels="layer",
    ),
    "group": Colouring(
        lambda frame: _label_colours(frame, frame.group, palette.group_colours),
        _group_legend,
        labels="group",
    ),
    "speed": Colouring(
        lambda frame: palette.speed_colours(frame.speed, frame.speed_scale),
        _speed_legend,
        of_cars=True,
        rescales=True,
    ),
    "energy saved": Colouring(
        lambda frame: _label_colours(
            frame, frame.saved, lambda s: palette.saving_colours(s, MOST_SAVED)
        ),
        _saving_legend,
        needs=lambda frame: frame.saved is not None,
        title="drag saved",
    ),
    "plain": Colouring(
        _plain_colours, lambda *_: [("agent", palette.css(palette.PLAIN))], of_cars=True, title=""
    ),
    MEASURED: Colouring(
        lambda frame: _label_colours(frame, frame.measured, palette.number_colours),
        _number_legend,
        rescales=True,
    ),
}
"""By name, in the order in which they are offered; `MEASURED` stands for as many as there are."""
