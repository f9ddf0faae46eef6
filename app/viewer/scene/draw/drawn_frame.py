"""What every part of the drawing needs of a frame, worked out once."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from app.viewer.scene.draw.attitude import attitude
from app.viewer.scene.draw.shapes import dart_length, spacing
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.shown import palette
from app.viewer.scene.shown.colouring import COLOURINGS
from app.viewer.scene.shown.drawing_style import (
    DARTS,
    DrawingStyle,
    agent_colours,
    drawn_form,
    shows_density,
)
from app.viewer.scene.shown.frame import LOST, Cars, Frame, Live

# Agents keep their identities while rows come and go.


def rows_of(before: np.ndarray, now: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rows in `before` of those identities in `now` that are there, and which they are, bool."""
    if not len(before):
        return np.empty(0, dtype=int), np.zeros(len(now), dtype=bool)
    order = np.argsort(before)
    place = np.minimum(np.searchsorted(before, now, sorter=order), len(before) - 1)
    row = order[place]
    same = before[row] == now
    return row[same], same


POINTS_BEYOND = 10_000
"""More agents than this are drawn as points."""

Changes = list[tuple[Any, str, Any]]
"""Node handle, property, new value: collected first, then assigned in one go."""


@dataclass(frozen=True)
class Picture:
    """One frame on the display."""

    frame: Frame
    look: DrawingStyle
    stage: Stage
    length: float
    """Length of a common agent."""
    size: np.ndarray
    """Length of each agent as a multiple of `length`, (N,)."""
    shows_density: bool = False
    """Whether the agents are drawn as a picture of their density, but for few that matter."""

    # Found when first asked for: of a picture of density hardly anything is.

    @cached_property
    def at(self) -> np.ndarray:
        """Where each agent is drawn, (N, 3)."""
        at, down = self.stage.to_display(self.frame.position), self.frame.is_down
        if self.stage.dim == 2:
            at[:, 2] = 0.22 * self.length * self.size
        else:
            at[down, 2] += LYING * self.length * self.size[down]
        return at

    @cached_property
    def wxyz(self) -> np.ndarray:
        """Attitude of each agent, (N, 4)."""
        return attitude(level_crashed(self.frame.heading, self.frame.is_down))

    @cached_property
    def colour(self) -> np.ndarray:
        """Colour of each agent, sRGB (N, 3)."""
        colour = agent_colours(self.frame, self.look)
        if self.live is not None:
            lost = self.live.is_in_state(LOST)
            colour[lost] = self.mix_with_backdrop(colour[lost], PALE)
        inspected = self.frame.inspected
        if self.inspected is not None and inspected is not None:
            others = ~np.asarray(self.frame.informed, bool)
            others[inspected.neighbours] = others[inspected.row] = False
            colour[others] = self.mix_with_backdrop(colour[others], DIMMED)
            if len(inspected.zone) and self.look.zones:
                colour[inspected.neighbours] = palette.zone_colours(inspected.zone)
        return colour

    def of_rows(self, rows: np.ndarray) -> Picture:
        """The picture of some agents alone; none is an animal, which would have to be followed."""
        look = replace(self.look, form=DARTS)
        part = Picture(self.frame.of_rows(rows), look, self.stage, self.length, self.size[rows])
        if self.look.measured or COLOURINGS[self.look.colour].labels:
            vars(part)["colour"] = self.colour[rows]  # which depends on the others
        return part

    @cached_property
    def is_there(self) -> np.ndarray:
        """Who is drawn at all, as a body or hollow, (N,) bool."""
        frame = self.frame
        if frame.seen is None:
            return np.ones(self.count, bool)
        return frame.seen if frame.hollow is None else frame.seen | frame.hollow

    @property
    def count(self) -> int:
        """Number of agents."""
        return len(self.frame.ids)

    @property
    def form(self) -> str:
        """What the agents are drawn as, unless as cars: darts, birds or fish."""
        return drawn_form(self.frame, self.look)

    @property
    def as_cars(self) -> bool:
        """Whether the agents are drawn as cars, true to scale: their size says what touches."""
        return as_cars(self.frame)

    @property
    def live(self) -> Live | None:
        """Of a room with real cars, drawn as such; None for a simulation."""
        return self.frame.live if self.as_cars else None

    @property
    def backdrop(self) -> np.ndarray:
        """What lies behind the agents: faint things are mixed with it."""
        return palette.FLOOR if self.stage.dim == 2 else palette.FOG

    @property
    def leader(self) -> int | None:
        """Row of the first information agent."""
        rows = np.flatnonzero(self.frame.informed)
        return int(rows[0]) if len(rows) else None

    def mix_with_backdrop(self, colour: np.ndarray, share: float | np.ndarray) -> np.ndarray:
        """`colour` with a `share` of the backdrop in it."""
        return colour + share * (self.backdrop - colour)

    @property
    def inspected(self) -> int | None:
        """Row of the inspected agent, if it is there."""
        inspected = self.frame.inspected
        if inspected is None or not 0 <= inspected.row < self.count:
            return None
        return int(inspected.row)


LEADER_SIZE = {2: 1.75, 3: 2.2}
"""Length of an information agent as a multiple of a common one, by dimension."""
LEADER_LEAST = 0.045
"""Length of an information agent as a multiple of the world's longest side, at least."""
LEADER_LEAST_CLOSE = 0.02
"""The same among agents that start close together."""
FEW_LEADERS = 12
"""More information agents than this keep a common size and wear no halo."""
CLOSE = {2: 0.35, 3: 0.8}
"""Length of an agent of a flock that starts close together, as a multiple of its mean spacing."""
LEAST_LENGTH = 0.012
"""Length of an agent of a close flock as a multiple of the world's longest side, at least."""
LEAST_CAR = 0.022
"""Length of a car as a multiple of the world's longest side, at least."""
TRACKED = 1.3
"""Length of an individual of tracks as a multiple of their median distance, at most; but not less
than LEAST_LENGTH."""
LYING = 0.09
"""How high the middle of one that lies on the floor is, as a multiple of its length."""
KEPT = 1.15
"""Length of an agent in space as a multiple of the distance that they keep, at most; but not less
than half of what it would be without."""
INSPECTED_SIZE = 1.45
DIMMED = 0.72
PALE = 0.6
"""Share of the floor in the colour of a car that is lost."""


def as_cars(frame: Frame) -> bool:
    """Whether a flock is drawn as cars: in a flat world, if it is one."""
    return frame.cars is not None and frame.dim == 2


def agent_length(frame: Frame, stage: Stage) -> float:
    """Length of a common agent: as suits the box they fill, or the region in which they start.

    A flock that starts close together stays so: its darts are small enough to be told apart, and
    not too small to be seen.
    """
    count = frame.usual or len(frame.position)
    if frame.room is None:
        common = dart_length(count, stage.half)
        fraction = KEPT * frame.kept * stage.scale if stage.dim == 3 else np.inf
        if np.isfinite(frame.apart):
            least = LEAST_LENGTH * stage.side
            return float(min(common, max(least, TRACKED * frame.apart * stage.scale)))
        return float(np.clip(fraction, 0.5 * common, common))
    half = np.zeros(3)
    half[: stage.dim] = 0.5 * stage.scale * (frame.room[1] - frame.room[0])
    packed = min(CLOSE[stage.dim] * spacing(count, half), frame.reach * stage.scale)
    return float(np.clip(packed, LEAST_LENGTH * stage.side, dart_length(count, stage.half)))


def car_length(cars: Cars, stage: Stage) -> float:
    """Length of a car: true to scale, unless it would be too small to see."""
    return max(cars.length * stage.scale, LEAST_CAR * stage.side)


def picture(frame: Frame, look: DrawingStyle, stage: Stage) -> Picture:
    """Work out lengths and sizes, and the rest when it is asked for; agents hover just above a flat
    floor."""
    cars = frame.cars if as_cars(frame) else None
    common = agent_length(frame, stage) if cars is None else car_length(cars, stage)
    length = common * float(np.clip(look.agent_size, 0.1, 10.0))
    size = np.ones(len(frame.position), dtype=np.float32)
    result = Picture(frame, look, stage, length, size, shows_density(frame))
    if cars is not None:
        return result
    if np.count_nonzero(frame.informed) <= FEW_LEADERS:
        least = LEADER_LEAST if frame.room is None else LEADER_LEAST_CLOSE
        size[frame.informed] = max(LEADER_SIZE[stage.dim], least * stage.side / length)
    if result.inspected is not None and frame.inspected is not None:
        size[frame.inspected.neighbours] *= 1.0 + 0.35 * shares(frame.inspected.weights)
        size[frame.inspected.row] *= INSPECTED_SIZE
    return result


def level_crashed(heading: np.ndarray, down: np.ndarray) -> np.ndarray:
    """Headings (N, dim) with those level that have crashed, `down` (N,) bool."""
    if heading.shape[1] == 2 or not down.any():
        return heading
    level = heading.copy()
    level[down, 2] = 0.0
    return level


def shares(weights: np.ndarray) -> np.ndarray:
    """Weights (M,) as shares of the largest, in [0, 1]; all 1 when they are all alike or zero."""
    largest = float(np.max(weights, initial=0.0))
    return np.asarray(weights) / largest if largest > 0.0 else np.ones(len(weights))
