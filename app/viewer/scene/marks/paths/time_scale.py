"""How much time the height of what rises with time stands for: an upright axis at a corner."""

from __future__ import annotations

import math

import numpy as np
from viser import LabelHandle, SceneApi

from app.viewer.scene.draw.drawn_frame import Changes, Picture
from app.viewer.scene.draw.line_segments import add_lines, segments
from app.viewer.scene.shown import palette, tone

MOST = 5
"""Marks on the axis, at most."""
STEPS = (1.0, 2.0, 5.0)
"""Time between marks, times a power of ten."""
MARK = 0.022
"""Length of a mark as a multiple of the longest side."""
APART = 0.024
"""How far apart the words beside two marks are on the floor: they stay legible from above."""


class TimeScale:
    """The present is at the top, and what is about to be forgotten at the foot."""

    def __init__(self, scene: SceneApi, name: str) -> None:
        self._drawn: object = None
        self._lines = add_lines(scene, f"{name}/lines", thickness=1.6)
        self._labels: list[LabelHandle] = [
            scene.add_label(
                f"{name}/words/{k}",
                "",
                anchor="center-right",
                font_screen_scale=0.85,
                visible=False,
            )
            for k in range(MOST)
        ]

    def hide(self) -> Changes:
        """Draw nothing."""
        self._drawn = None
        return [(node, "visible", False) for node in (self._lines, *self._labels)]

    def draw(self, picture: Picture, height: float, risen: float) -> Changes:
        """Draw it where the whole length of a trail is `height` high on the display, of which
        there is a share `risen` so far."""
        frame, stage = picture.frame, picture.stage
        drawn = (stage, height, risen, picture.look.trail_length, frame.dt, frame.unit)
        if drawn == self._drawn:
            return []
        self._drawn = drawn
        span = picture.look.trail_length * frame.dt
        ages = marks(span)
        ages = ages[ages <= span * risen * (1.0 + 1e-9)]
        up = height * (risen - ages / span)
        corner = stage.half * [-1.0, 1.0, 0.0]
        foot = corner + up[:, None] * [0.0, 0.0, 1.0]
        end = foot - [MARK * stage.side, 0.0, 0.0]
        end[:, 1] -= APART * stage.side * np.arange(len(ages))
        axis = np.array([corner, corner])
        axis[1, 2] = height * risen
        lines = np.concatenate([axis[None], np.stack([foot, end], axis=1)])
        changes = segments(self._lines, lines, tone.single(palette.EDGE))
        for label, age, at in zip(self._labels, ages, end, strict=False):
            changes += [
                (label, "text", words(float(age), frame.unit)),
                (label, "position", at),
                (label, "visible", True),
            ]
        return changes + [(label, "visible", False) for label in self._labels[len(ages) :]]


def marks(span: float) -> np.ndarray:
    """Ages at round distances from 0 to at most `span`, at most `MOST` of them.

    >>> marks(0.6).tolist(), marks(20.0).tolist()
    ([0.0, 0.2, 0.4, 0.6], [0.0, 5.0, 10.0, 15.0, 20.0])
    """
    least = span / (MOST - 1)
    power = 10.0 ** math.floor(math.log10(least))
    step = next(one for one in (*(each * power for each in STEPS), 10.0 * power) if one >= least)
    return np.round(step * np.arange(math.floor(span / step * (1.0 + 1e-9)) + 1), 12)


def words(age: float, unit: str) -> str:
    """What stands beside a mark.

    >>> words(0.0, "s"), words(0.2, "s"), words(20.0, "ticks")
    ('now', '−0.2 s', '−20 ticks')
    """
    return "now" if age == 0.0 else f"−{age:g} {unit}"
