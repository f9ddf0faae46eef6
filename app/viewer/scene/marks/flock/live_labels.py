"""Names beside the cars of a room with real ones, and what is to be known of them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from viser import LabelHandle, SceneApi

from app.viewer.scene.draw.drawn_frame import Changes, Picture
from app.viewer.scene.marks.flock.placing import Sides, box
from app.viewer.scene.marks.paths.trail_history import INJECTED
from app.viewer.scene.shown.live_cars import LATE, LOST, SIMULATED, TRACKED

MOST = 40
"""Of more cars only those that are late or lost are named, and no more of them."""
BESIDE, OVER = 0.8, 0.5
"""How far from a car's middle its name is, on the floor and, behind it, in height, as multiples of
its length: clear of the car and of the outline around it, from above and from the side."""


class CarLabel(NamedTuple):
    """A car whose name is written."""

    identity: int
    text: str
    at: np.ndarray
    """Its middle on the floor of the display, (3,)."""


class LiveLabels:
    """A pool of labels."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        self._scene = scene
        self._name = f"{root}/flock/names"
        self._pool: list[LabelHandle] = []
        self._sides = Sides()

    def draw(self, picture: Picture) -> Changes:
        """Write the names, if there are real cars."""
        cars = named(picture)
        while len(self._pool) < len(cars):
            self._pool.append(self._new(len(self._pool)))
        hidden: Changes = [(label, "visible", False) for label in self._pool[len(cars) :]]
        if not cars:
            return hidden
        changes: Changes = []
        for label, car, below in zip(self._pool, cars, self._below(picture, cars), strict=False):
            aside = np.array([0.0, -BESIDE, 0.0]) if below else np.array([0.0, BESIDE, OVER])
            changes += [
                (label, "text", car.text),
                (label, "position", car.at + picture.length * aside),
                (label, "anchor", "top-center" if below else "bottom-center"),
                (label, "visible", True),
            ]
        return changes + hidden

    def _below(self, picture: Picture, cars: list[CarLabel]) -> list[bool]:
        """Whether the names stand below their cars."""
        frame, side = picture.frame, picture.stage.side
        return self._sides.below(
            frame.run,
            frame.tick * frame.dt,
            [car.identity for car in cars],
            np.array([car.at[:2] for car in cars]),
            side * np.array([box(car.text) for car in cars]),
            BESIDE * picture.length,
            0.5 * picture.length,
        )

    def _new(self, number: int) -> LabelHandle:
        return self._scene.add_label(
            f"{self._name}/{number}",
            "",
            anchor="bottom-center",
            font_screen_scale=1.0,
            visible=False,
        )


def named(picture: Picture) -> list[CarLabel]:
    """The cars whose names are written: those that are drawn as cars, and the injected one."""
    live, frame = picture.live, picture.frame
    if live is None:
        return []
    rows = np.arange(len(live.names))
    if len(rows) > MOST:
        rows = np.flatnonzero(live.are(LATE, LOST))[:MOST]
    cars = [
        CarLabel(
            int(frame.ids[row]),
            words(live.names[row], live.states[row], float(live.ages[row])),
            picture.at[row] * [1.0, 1.0, 0.0],
        )
        for row in rows
    ]
    if frame.progress.goal is not None and picture.look.mission:
        cars.append(CarLabel(INJECTED, "injected car", picture.stage.shown(frame.progress.goal)))
    return cars


def words(name: str, state: str, age: float) -> str:
    """What is written beside a car that was last seen `age` s ago.

    >>> words("red", "tracked", 0.01), words("blue", "late", 0.064), words("green", "lost", 1.38)
    ('red', 'blue · late 60 ms', 'green · lost 1.3 s')
    """
    if state in (TRACKED, SIMULATED):
        return name
    return f"{name} · {state} {age_text(age)}" if state in (LATE, LOST) else f"{name} · {state}"


def age_text(age: float) -> str:
    """An age (s) in steps that can be read: 10 ms, from 0.2 s on 0.1 s, from 10 s on 1 s.

    >>> age_text(0.199), age_text(0.2), age_text(9.99), age_text(83.0)
    ('190 ms', '0.2 s', '9.9 s', '83 s')
    """
    tiny = 1e-9
    if age < 0.2:
        return f"{10 * int(100.0 * age + tiny)} ms"
    return f"{int(10.0 * age + tiny) / 10:.1f} s" if age < 10.0 else f"{int(age + tiny)} s"
