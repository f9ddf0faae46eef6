"""The colour of every agent, and what the colours mean."""

from __future__ import annotations

import numpy as np

from app.viewer.scene.draw import own, palette
from app.viewer.scene.shown import look as look_module
from app.viewer.scene.shown.frame import Frame
from app.viewer.scene.shown.live import SIMULATED
from app.viewer.scene.shown.look import Look

MOST_NAMED = 24
"""Of more agents none is named beside its own colour."""
MOST_SAVED = 1.0
"""Share of the induced drag, saved or paid, from which on colours are full."""
DIRECTIONS = ("0° +x", "90° +y", "180°", "270°")
"""What stands around a wheel of headings, against the clock from the right."""
STEEP = ("climbing", "level", "diving")
"""What stands beside the colours of one that climbs, from the top down."""


def agent_colours(frame: Frame, look: Look) -> np.ndarray:
    """Colours (N, 3), sRGB in [0, 1]; information agents and predators
    wear their own, and so do the crashed."""
    colours = _colours(frame, look)
    colours[np.asarray(frame.informed, dtype=bool)] = palette.LEADER
    if frame.cars is not None:
        colours[frame.cars.predator] = palette.LEADER
    colours[frame.down] = palette.CRASHED
    return colours


def _colours(frame: Frame, look: Look) -> np.ndarray:
    count = len(frame.position)
    match look.colour:
        case "heading":
            return palette.by_heading(frame.heading)
        case "speed":
            return palette.by_speed(frame.speed, frame.speed_scale)
        case "layer":
            return _known(frame.layer, palette.by_layer, count)
        case "group":
            return _known(frame.group, palette.by_group, count)
        case look_module.OWN:
            return own.of_frame(frame)
        case look_module.MEASURED:
            return _known(frame.measured, palette.by_number, count)
        case "energy saved":
            return _known(frame.saved, lambda saved: palette.by_saving(saved, MOST_SAVED), count)
    return np.tile(palette.PLAIN, (count, 1))


def _known(labels: np.ndarray | None, colour, count: int) -> np.ndarray:
    """Colours of labels that were asked for a moment ago and may not be there yet."""
    if labels is None or len(labels) != count:
        return np.tile(palette.UNKNOWN, (count, 1))
    return colour(np.asarray(labels))


def legend(look: Look, frame: Frame) -> list[tuple[str, str]]:
    """What the colours mean, but for headings, which a wheel explains: (words, CSS colour)."""
    crashed = [("crashed", palette.css(palette.CRASHED))] if frame.down.any() else []
    hunted = frame.cars is not None and frame.cars.predator.any()
    predators = [("predator", palette.css(palette.LEADER))] if hunted else []
    return _legend(look, frame) + predators + crashed


def _legend(look: Look, frame: Frame) -> list[tuple[str, str]]:
    """What the colours of those that fly mean."""
    leader = [("information agent", palette.css(palette.LEADER))] if frame.informed.any() else []
    match look.colour:
        case "heading":
            return leader
        case "speed":
            return _speed_legend(frame.speed_scale, frame.pace_unit) + leader
        case "layer":
            return _layer_legend(frame)
        case "group":
            return _group_legend(frame) + leader
        case "energy saved":
            return _saving_legend(frame) + leader
        case look_module.OWN:
            return _own_legend(frame) + leader
        case look_module.MEASURED:
            return _number_legend(look, frame) + leader
    return [("agent", palette.css(palette.PLAIN)), *leader]


def _speed_legend(full: float, unit: str) -> list[tuple[str, str]]:
    speeds = np.array([0.0, 0.5, 1.0]) * full
    words = [f"{speed:.3g} {unit}" for speed in speeds]
    words[-1] += " or faster"
    return list(zip(words, map(palette.css, palette.by_speed(speeds, full)), strict=True))


def _saving_legend(frame: Frame) -> list[tuple[str, str]]:
    if frame.saved is None:
        return [("not measured in this model", palette.css(palette.UNKNOWN))]
    shares = np.array([-1.0, -0.5, 0.0, 0.5, 1.0]) * MOST_SAVED
    words = [f"{100 * share:+.0f} %" if share else "0" for share in shares]
    words[0] += " (pays)"
    words[-1] += " of its induced drag"
    colours = map(palette.css, palette.by_saving(shares, MOST_SAVED))
    return [*zip(words, colours, strict=True), ("unknown", palette.css(palette.UNKNOWN))]


def _own_legend(frame: Frame) -> list[tuple[str, str]]:
    """Each by its name, of few; the injected car is one of them."""
    injected = frame.cars is not None and frame.progress.goal is not None
    more = [("injected car", palette.css(palette.GOAL))] if injected else []
    if frame.live is not None:
        names = own.by_name(frame.live.roster)
        return [(name, palette.css(colour)) for name, colour in names.items()] + more
    if len(frame.ids) > MOST_NAMED:
        return [(f"{len(palette.OWN)} colours in turn", palette.css(own.COLOURS[0])), *more]
    worn = np.asarray(frame.informed, bool) | frame.down
    if frame.cars is not None:
        worn |= frame.cars.predator
    noun = "agent" if frame.cars is None else "car"
    colours = own.by_identity(frame.ids)
    rows = [row for row in np.argsort(frame.ids) if not worn[row]]
    return [(f"{noun} {frame.ids[row]}", palette.css(colours[row])) for row in rows] + more


def outlines(frame: Frame) -> list[tuple[str, str]]:
    """What the outlines of real cars mean: (state, CSS colour); nothing where there are none."""
    if frame.live is None:
        return []
    there = frame.live.are(SIMULATED).any()
    return [
        (state, palette.css(colour))
        for state, colour in palette.STATES.items()
        if state != SIMULATED or there
    ]


def _number_legend(look: Look, frame: Frame) -> list[tuple[str, str]]:
    unknown = ("unknown", palette.css(palette.UNKNOWN))
    if frame.measured is None or not np.isfinite(frame.measured).any():
        return [(f"no {look.measured} in this model", palette.css(palette.UNKNOWN))]
    low, high = palette.span(frame.measured)
    numbers = np.array([low, 0.5 * (low + high), high] if high > low else [low])
    colours = map(palette.css, palette.by_number(numbers))
    entries = list(zip((f"{number:.3g}" for number in numbers), colours, strict=True))
    return entries if np.isfinite(frame.measured).all() else [*entries, unknown]


def _layer_legend(frame: Frame) -> list[tuple[str, str]]:
    last = len(palette.LAYERS)
    layers = np.empty(0, int) if frame.layer is None else np.asarray(frame.layer)
    known = layers[layers <= len(layers)]
    deepest = min(int(known.max(initial=1)), last)
    entries = [("1 information agent", palette.css(palette.LAYERS[0]))]
    for layer in range(2, deepest + 1):
        words = f"layer {layer}" if layer < last else f"layer {last} and farther"
        entries.append((words, palette.css(palette.LAYERS[layer - 1])))
    return [*entries, ("unknown", palette.css(palette.UNKNOWN))]


def _group_legend(frame: Frame) -> list[tuple[str, str]]:
    count = 1 if frame.group is None else int(np.max(frame.group, initial=0)) + 1
    last = len(palette.GROUPS)
    words = ["largest group", *(f"group {rank}" for rank in range(2, last)), "smaller groups"]
    return list(zip(words, map(palette.css, palette.GROUPS), strict=True))[: min(count, last)]
