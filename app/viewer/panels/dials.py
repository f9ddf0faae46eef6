"""What a slider spans, in which steps, and which controls are not at their default.

viser's slider is linear over all that is allowed. The page's script `dials.js` draws another in its
place, of what is told here; the value, its box and what the server takes of a browser stay viser's.
"""

from __future__ import annotations

import html
import json
import math
from dataclasses import dataclass
from decimal import Decimal
from typing import Any

import viser

from agents.models.declare import DeclaredParameter, Range, above, below, is_wide

FEWEST, MOST = 20, 200
"""Steps of a linear slider."""
DECIMALS = 8
"""The most that a box shows."""


@dataclass
class Dial:
    """The slider of one parameter."""

    one: DeclaredParameter
    control: Any
    shown: Range

    def fit(self) -> None:
        """Span what is proposed, and more where the value is outside: until the default is back."""
        value = self.control.value
        if value == self.one.default:
            self.shown = proposed(self.one)
        else:
            self.shown = widened(self.shown, value, allowed(self.one))

    def told(self) -> dict[str, Any]:
        """What the page is told of it."""
        low, high = self.shown
        return {
            "log": is_wide(low, high),
            "default": self.one.default,
            "stops": stops(low, high, step_of(self.one), self.one.default),
        }


class Dials:
    """The sliders of a panel, and the marks of all its controls."""

    def __init__(self, gui: viser.GuiApi):
        self.place = gui.add_html("")
        self.marks = gui.add_html("")
        self.dials: list[Dial] = []
        self.controls: list[tuple[DeclaredParameter, Any]] = []
        self.told: list[Any] = []
        """Of which sliders the page has been told what they span."""

    def clear(self) -> None:
        """The controls are gone."""
        self.dials, self.controls = [], []

    def add(self, one: DeclaredParameter, control: Any) -> None:
        """Another control."""
        self.controls.append((one, control))
        if one.kind == "number":
            self.dials.append(Dial(one, control, proposed(one)))

    def refresh(self) -> None:
        """Tell the page what sliders span and what is not at its default, if it is new."""
        for dial in self.dials:
            dial.fit()
        now = [(dial.control._impl.uuid, dial.shown) for dial in self.dials]
        if now != self.told:
            self.told = now
            told = {dial.control._impl.uuid: dial.told() for dial in self.dials}
            text = html.escape(json.dumps(told, separators=(",", ":")))
            self.place.content = f'<div data-dials="{text}" hidden></div>'
        marked = [made._impl.uuid for one, made in self.controls if made.value != one.default]
        content = marks(marked)
        if content != self.marks.content:
            self.marks.content = content


def marks(uuids: list[str]) -> str:
    """A style that marks the labels of controls."""
    if not uuids:
        return ""
    labels = ", ".join(f'label[for="{uuid}"]' for uuid in uuids)
    return (
        f"<style>:is({labels}) {{ color: var(--fs-accent); font-weight: 600; }}"
        f":is({labels})::before {{ content: '\u25cf\u2002'; font-size: 0.7em; }}</style>"
    )


def proposed(one: DeclaredParameter) -> Range:
    """What the slider of a number spans."""
    assert one.proposed is not None
    return one.proposed


def allowed(one: DeclaredParameter) -> Range:
    """What a number may be."""
    assert one.low is not None
    assert one.high is not None
    return one.low, one.high


def step_of(one: DeclaredParameter) -> float:
    """From one value to the next in a box."""
    low, high = allowed(one)
    return one.step or (high - low) / MOST


def widened(shown: Range, value: float, allowed: Range) -> Range:
    """A range that holds a value too, up to the next round number.

    A scale of logarithms has no place for 0; a value there stands at its left end.

    >>> widened((0.5, 20.0), 3.0, (0.1, 100.0)), widened((0.5, 20.0), 30.0, (0.1, 100.0))
    ((0.5, 20.0), (0.5, 50.0))
    """
    low, high = shown
    if value > high:
        high = min(allowed[1], above(value)) if value > 0.0 else allowed[1]
    elif value < low and (value > 0.0 or not is_wide(low, high)):
        low = max(allowed[0], below(value) if value > 0.0 else -above(-value) if value else 0.0)
    return low, high


def stops(low: float, high: float, step: float, default: float) -> list[float]:
    """The values that a slider can be put on: both ends, the default, and round ones between.

    On a scale of logarithms they have two figures; else they are multiples of the step, or of a
    rounder one where they would be too many, or too few.

    >>> stops(0.0, 1.0, 0.25, 0.3)[:8]
    [0.0, 0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35]
    >>> stops(1.0, 500.0, 1.0, 30.0)[:12]
    [1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7, 1.8, 1.9, 2.0, 2.1]
    """
    if is_wide(low, high):
        powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)))
        found = [float(f"{two}e{power - 1}") for power in powers for two in range(10, 100)]
    else:
        step = grain(low, high, step)
        places = 2 - math.floor(math.log10(step))
        found = [
            round(k * step, places) for k in range(math.ceil(low / step), math.ceil(high / step))
        ]
    return sorted({low, high, default, *(one for one in found if low < one < high)})


def grain(low: float, high: float, step: float) -> float:
    """The step of a linear slider; whole steps, which count something, are not divided."""
    steps = (high - low) / step
    if steps > MOST:
        return above((high - low) / MOST)
    return step if steps >= FEWEST or step >= 1.0 else below((high - low) / FEWEST)


def decimals(one: DeclaredParameter) -> int:
    """So many decimals has the box of a number: all of the declared ones, and three figures of the
    least of them."""
    numbers = [one.default, *allowed(one), step_of(one)]
    finest = min(abs(x) for x in numbers if x)
    written = (-int(Decimal(f"{x:.{DECIMALS}g}").normalize().as_tuple().exponent) for x in numbers)
    return min(DECIMALS, max(2, 2 - math.floor(math.log10(finest)), *written))
