"""Names beside the cars of a room with real ones, and what is to be known of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from viser import LabelHandle, SceneApi

from app.viewer.scene.draw.drawn_frame import Changes, Picture
from app.viewer.scene.marks.trails import INJECTED
from app.viewer.scene.shown.drawing_style import NUMBERED_UP_TO
from app.viewer.scene.shown.frame import LATE, LOST, SIMULATED, TRACKED

# Where words stand beside agents: on the side where they hide the fewest others; and which of
# numbers that would lie upon each other are written.

AFRESH = 0.5
"""Seconds for which names stay on their sides at least."""
LETTER, LINE, ENDS = 0.0085, 0.022, 0.014
"""Width of a letter, height of a line and width of both ends of a pill as multiples of the longest
side, as a room that fills a window of common size from above shows them."""
LEAVES, COMES = 0.7, 1.0
"""A number leaves when another is within this share of its size, and comes when none is within
that."""


def box(text: str) -> tuple[float, float]:
    """Width and height of words of common size, as multiples of the longest side."""
    return LETTER * len(text) + ENDS, LINE


class Sides:
    """Remembers the sides; forgotten when the run changes."""

    def __init__(self) -> None:
        self._decided: tuple[int, float] | None = None
        self._below: dict[int, bool] = {}

    def below(
        self,
        run: int,
        now: float,
        ids: Sequence[int],
        at: np.ndarray,
        size: np.ndarray,
        away: float,
        room: float,
    ) -> list[bool]:
        """Whether the names of M cars stand below and not above them.

        They are at `at` (M, 2), `away` from their names, which have widths and heights `size`
        (M, 2); each takes up `room` to every side. `now` is in seconds.
        """
        is_same_run = self._decided is not None and self._decided[0] == run
        if not is_same_run:
            self._below = {}
        due = not is_same_run or not 0.0 <= now - (self._decided or (0, 0.0))[1] < AFRESH
        if due or any(identity not in self._below for identity in ids):
            self._decided = run, now
            before = [self._below.get(identity, False) for identity in ids]
            sides = chosen_sides(before, at, size, away, room)
            self._below = dict(zip(ids, sides, strict=True))
        return [self._below[identity] for identity in ids]


def clear_labels(at: np.ndarray, size: np.ndarray, before: np.ndarray) -> np.ndarray:
    """Which of M numbers are written, (M,) bool: no two upon each other, first of all those that
    were, `before` (M,) bool.

    They stand at `at` (M, 2), with widths and heights `size` (M, 2).
    """
    written = np.zeros(len(at), bool)
    for row in np.argsort(~before, kind="stable"):
        share = LEAVES if before[row] else COMES
        near = np.abs(at[written] - at[row]) < share * 0.5 * (size[written] + size[row])
        written[row] = not near.all(axis=1).any()
    return written


def chosen_sides(
    before: Sequence[bool],
    at: np.ndarray,
    size: np.ndarray,
    away: float,
    room: float,
) -> list[bool]:
    """The sides by how much each hides, one car after the other; `before` where it is the same."""
    sides: list[bool] = []
    taken_boxes = np.empty((0, 4))
    for row, (was, place, box) in enumerate(zip(before, at, size, strict=True)):
        others = np.delete(at, row, axis=0)
        hidden, boxes = {}, {}
        for below in (was, not was):
            up = -1.0 if below else 1.0
            middle = place + np.array([0.0, up * (away + 0.5 * box[1])])
            boxes[below] = np.array([*middle, *box])
            near = np.abs(others - middle) < 0.5 * box + room
            clash = np.abs(taken_boxes[:, :2] - middle) < 0.5 * (taken_boxes[:, 2:] + box)
            hidden[below] = 2 * np.count_nonzero(near.all(1)) + np.count_nonzero(clash.all(1))
        side = was if hidden[was] <= hidden[not was] else not was
        sides.append(side)
        taken_boxes = np.concatenate([taken_boxes, boxes[side][None]])
    return sides


# Words beside agents: the information agent's name, and identities if asked for.

SMALL = 0.75
"""Size of a number."""
INFORMED = "information agent"
"""What it is called wherever a page tells of it, in the air or on wheels."""


LONGEST_NAME = 12
"""Letters of the name of an individual that are written beside it."""


class Labels:
    """A label for the first information agent and a pool of labels for identities."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        self._scene = scene
        self._root = root
        self._leader = scene.add_label(
            f"{root}/flock/leader",
            INFORMED,
            anchor="bottom-center",
            font_screen_scale=1.1,
            visible=False,
        )
        self._pool: list[LabelHandle] = []
        self._written = np.empty(0, int)
        """Identities whose numbers are written."""

    def draw(self, picture: Picture) -> Changes:
        changes: Changes = [(self._leader, "visible", picture.leader is not None)]
        if picture.leader is not None:
            changes.append((self._leader, "position", self._label_place(picture, picture.leader)))
            changes.append((self._leader, "anchor", anchor(picture, picture.leader)))
            informed = int(np.count_nonzero(picture.frame.informed))
            words = INFORMED if informed == 1 else f"{INFORMED} (1 of {informed})"
            changes.append((self._leader, "text", words))
        return changes + self._draw_identities(picture)

    def _draw_identities(self, picture: Picture) -> Changes:
        count = picture.count
        is_on = picture.look.labels and picture.live is None
        label_count = min(count, NUMBERED_UP_TO) if is_on else 0
        if is_on and count > NUMBERED_UP_TO and picture.frame.inspected is not None:
            rows = picture.frame.inspected.neighbours[:NUMBERED_UP_TO]
        else:
            rows = np.arange(label_count)
        while len(self._pool) < len(rows):
            self._pool.append(self._new(len(self._pool)))
        written = self._clear_rows(picture, rows)
        changes: Changes = []
        for label, row, is_shown in zip(self._pool, rows, written, strict=False):
            changes.append((label, "text", name(picture, int(row))))
            changes.append((label, "position", self._label_place(picture, int(row))))
            changes.append((label, "anchor", anchor(picture, int(row))))
            changes.append((label, "visible", bool(is_shown) and row != picture.leader))
        return changes + [(label, "visible", False) for label in self._pool[len(rows) :]]

    def _clear_rows(self, picture: Picture, rows: np.ndarray) -> np.ndarray:
        """Which of the numbers of these rows are written: in a flat world none upon another."""
        if picture.stage.dim == 3 or not len(rows):
            return picture.is_there[rows]
        ids = picture.frame.ids[rows]
        texts = [name(picture, int(row)) for row in rows]
        size = SMALL * picture.stage.side * np.array([box(text) for text in texts])
        before = np.isin(ids, self._written)
        written = np.zeros(len(rows), bool)
        there = picture.is_there[rows]
        written[there] = clear_labels(picture.at[rows[there], :2], size[there], before[there])
        self._written = ids[written]
        return written

    def _new(self, number: int) -> LabelHandle:
        return self._scene.add_label(
            f"{self._root}/flock/identities/{number}",
            "",
            anchor="bottom-center",
            font_screen_scale=SMALL,
            visible=False,
        )

    @staticmethod
    def _label_place(picture: Picture, row: int) -> np.ndarray:
        """A place clear of the agent and its halo: above it on the screen, or below."""
        clear = 1.05 * picture.length * float(picture.size[row])
        if picture.stage.dim == 3:
            return picture.at[row] + np.array([0.0, 0.0, clear])
        below = anchor(picture, row).startswith("top")
        return picture.at[row] + np.array([0.0, -clear if below else clear, 0.0])


def name(picture: Picture, row: int) -> str:
    """What is written beside an agent: its number, or its name in a file of tracks; and of a car
    that hunts the others also that."""
    names, cars = picture.frame.names, picture.frame.cars
    number = names[row][:LONGEST_NAME] if names else str(picture.frame.ids[row])
    return f"{number} predator" if cars is not None and cars.predator[row] else number


def anchor(picture: Picture, row: int) -> str:
    """Which point of the words is fixed: chosen so that they stay within a flat world's picture.

    Agents that have left the box of an open world have theirs above them, as in space.
    """
    if picture.stage.dim == 3:
        return "bottom-center"
    across, along = picture.at[row, :2] / picture.stage.half[:2]
    upright = "top" if 0.87 < along < 1.02 else "bottom"
    sideways = "right" if 0.85 < across < 1.02 else "left" if -1.02 < across < -0.85 else "center"
    return f"{upright}-{sideways}"


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
        cars = named_cars(picture)
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


def named_cars(picture: Picture) -> list[CarLabel]:
    """The cars whose names are written: those that are drawn as cars, and the injected one."""
    live, frame = picture.live, picture.frame
    if live is None:
        return []
    rows = np.arange(len(live.names))
    if len(rows) > MOST:
        rows = np.flatnonzero(live.is_in_state(LATE, LOST))[:MOST]
    cars = [
        CarLabel(
            int(frame.ids[row]),
            label_text(live.names[row], live.states[row], float(live.ages[row])),
            picture.at[row] * [1.0, 1.0, 0.0],
        )
        for row in rows
    ]
    if frame.progress.goal is not None and picture.look.mission:
        cars.append(
            CarLabel(INJECTED, "injected car", picture.stage.to_display(frame.progress.goal))
        )
    return cars


def label_text(name: str, state: str, age: float) -> str:
    """What is written beside a car that was last seen `age` s ago.

    >>> cars = ("red", "tracked", 0.01), ("blue", "late", 0.064), ("green", "lost", 1.38)
    >>> tuple(label_text(*car) for car in cars)
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
