"""The wake of birds: the lines that their wing tips leave behind.

The vortices that come off the tips turn against each other, up on the outside: so the left line
is cool and the right one warm. They are drawn where the tips of level wings have been; what the
flock's model knows of upwash is not read from them.
"""

from __future__ import annotations

import numpy as np
from viser import SceneApi

from app.viewer.scene.draw.agent_meshes import TIP
from app.viewer.scene.draw.agent_shapes import BIRD
from app.viewer.scene.draw.attitude import left_directions
from app.viewer.scene.draw.drawn_frame import Changes, Picture, rows_of
from app.viewer.scene.draw.line_segments import add_lines, jumps, segments
from app.viewer.scene.marks.agents import FlockMotion
from app.viewer.scene.shown import palette
from app.viewer.scene.shown.drawing_style import BIRDS, LINE
from app.viewer.scene.shown.frame import Frame

# Where moving points have been: their places at some ticks, the knots of the lines they leave.

INJECTED = -1
"""Identity of the injected car, which leaves a band too."""


class TrailHistory:
    """The knots of one run; forgotten when the run changes."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget where the points have been."""
        self._run: tuple[int, int] | None = None
        self._ids = np.empty(0, dtype=int)
        self.began = 0
        """Tick of the first knot of the run, which may be forgotten by now."""
        self.ticks: list[int] = []
        self.knots: list[np.ndarray] = []
        """The places (M, 3) at each of these ticks, NaN for points that were not there."""

    def remember(
        self,
        frame: Frame,
        ids: np.ndarray,
        positions: np.ndarray,
        length: int,
        knots: int,
        window: int = 0,
    ) -> bool:
        """Add a knot when the last is old enough for `knots` of them in `length` ticks, and forget
        what is older than that and than `window` ticks; True if anything changed.

        The points `positions` (M, 3) have identities (M,), which may be others than before.
        """
        run = (frame.run, frame.dim)
        if self._run != run or (self.ticks and frame.tick < self.ticks[-1]):
            self.clear()
            self._run, self.began = run, frame.tick
        if not np.array_equal(ids, self._ids):
            self.knots = [match_rows(knot, self._ids, ids) for knot in self.knots]
            self._ids = ids.copy()
        elif self.ticks and frame.tick - self.ticks[-1] < length / knots:
            return False
        if self.ticks and self.ticks[-1] == frame.tick:
            self.knots[-1] = positions
        else:
            self.ticks.append(frame.tick)
            self.knots.append(positions)
        while self.ticks[0] < frame.tick - max(length, window):
            del self.ticks[0], self.knots[0]
        return True


def thin_knots(ticks: np.ndarray, now: int, length: int, knots: int) -> np.ndarray:
    """Which of the knots at ticks (K,) show `length` ticks up to `now` with `knots` pieces or so.

    A knot stays as long as it is shown: nothing flickers.

    >>> thin_knots(np.arange(10), 10, 8, 4).tolist()
    [2, 4, 6, 8]
    """
    indices = np.flatnonzero(ticks >= now - length)
    cell = ticks[indices] // max(1, length // knots)
    return indices[np.diff(cell, prepend=-1) > 0]


def match_rows(knot: np.ndarray, before: np.ndarray, now: np.ndarray) -> np.ndarray:
    """Places (M, 3) of the identities `before` for the identities `now`; NaN for new ones."""
    rows, known_rows = rows_of(before, now)
    result = np.full((len(now), 3), np.nan)
    result[known_rows] = knot[rows]
    return result


# Lines that moving points leave behind them; they fade with age and break at the seams.
#
# Past places are kept, about `KNOTS` a line. The older part is sent only when a knot is added; each
# frame sends no more than the stretch from the last knot.

KNOTS = 16
FAINTEST, STRONGEST = 0.80, 0.20
"""Share of the backdrop in the colour of a line at its old and at its new end."""


class Streaks:
    """The lines of one run; forgotten when the run changes."""

    def __init__(self, scene: SceneApi, name: str, thick: float = 1.0) -> None:
        self._old = add_lines(scene, f"{name}/old", thick, many_coloured=True)
        self._young = add_lines(scene, f"{name}/young", 1.8 * thick, many_coloured=True)
        self._tip = add_lines(scene, f"{name}/tip", 2.2 * thick, many_coloured=True)
        self._past = TrailHistory()

    def hide(self) -> Changes:
        """Forget them, and draw nothing."""
        self._past.clear()
        return [(lines, "visible", False) for lines in (self._old, self._young, self._tip)]

    def follow(
        self, picture: Picture, ids: np.ndarray, positions: np.ndarray, colour: np.ndarray
    ) -> Changes:
        """Draw lines through `positions` (M, 3), NaN for none, with identities (M,) and colours
        (M, 3); they reach back as far as the look wants trails to."""
        length = picture.look.trail_length
        added = self._past.remember(picture.frame, ids, positions, length, KNOTS)
        changes = self._draw_tip(picture, positions, colour)
        return changes + self._draw_history(picture, colour) if added else changes

    def _draw_history(self, picture: Picture, colour: np.ndarray) -> Changes:
        knots = np.stack(self._past.knots)
        points = np.stack([knots[:-1], knots[1:]], axis=2)
        is_drawn = ~jumps(points[:, :, 0], points[:, :, 1], picture.stage.period)
        is_drawn &= np.isfinite(points).all(axis=(2, 3))
        age = (picture.frame.tick - np.array(self._past.ticks)) / picture.look.trail_length
        share = STRONGEST + (FAINTEST - STRONGEST) * np.clip(age, 0.0, 1.0)
        faded = picture.mix_with_backdrop(colour, share[:, None, None])
        colours = palette.unlit_bytes(np.stack([faded[:-1], faded[1:]], axis=2))
        half = len(points) // 2
        old, young = slice(None, half), slice(half, None)
        return segments(
            self._old, points[old][is_drawn[old]], colours[old][is_drawn[old]]
        ) + segments(self._young, points[young][is_drawn[young]], colours[young][is_drawn[young]])

    def _draw_tip(self, picture: Picture, positions: np.ndarray, colour: np.ndarray) -> Changes:
        points = np.stack([self._past.knots[-1], positions], axis=1)
        is_drawn = ~jumps(points[:, 0], points[:, 1], picture.stage.period)
        is_drawn &= np.isfinite(points).all(axis=(1, 2))
        colours = palette.unlit_bytes(picture.mix_with_backdrop(colour, STRONGEST))
        return segments(
            self._tip, points[is_drawn], np.repeat(colours[is_drawn][:, None], 2, axis=1)
        )


def trailed_rows(informed: np.ndarray, most: int) -> np.ndarray:
    """Rows whose lines are drawn: all, or evenly spaced ones and the first information agents."""
    count = len(informed)
    if count <= most:
        return np.arange(count)
    even = np.linspace(0, count - 1, most).astype(int)
    return np.union1d(even, np.flatnonzero(informed)[: most // 4])


# Where the agents have been.

MOST_AGENTS = 800


class Trails(Streaks):
    """A line behind each agent, or of very many agents behind some."""

    def __init__(self, scene: SceneApi, root: str = "") -> None:
        super().__init__(scene, f"{root}/flock/trails")

    def draw(self, picture: Picture) -> Changes:
        if picture.look.trails != LINE or picture.look.trail_length < 1:
            return self.hide()
        rows = trailed_rows(picture.frame.informed, MOST_AGENTS)
        at = picture.at[rows]
        if picture.frame.seen is not None:
            at[~picture.frame.seen[rows]] = np.nan
        return self.follow(picture, picture.frame.ids[rows], at, picture.colour[rows])


MOST_BIRDS = 300


class Wake(Streaks):
    """Two thin lines behind each bird, or of very many birds behind some."""

    def __init__(self, scene: SceneApi, root: str, flight: FlockMotion) -> None:
        super().__init__(scene, f"{root}/flock/wake", thick=0.7)
        self._flight = flight

    def draw(self, picture: Picture) -> Changes:
        look = picture.look
        if not (look.wake and picture.form == BIRDS and look.trail_length >= 1):
            return self.hide()
        rows = trailed_rows(picture.frame.informed, MOST_BIRDS)
        aside = span(picture, rows) * left_directions(self._flight.poses.wxyz[rows])
        at, ids = picture.at[rows], picture.frame.ids[rows]
        tips = np.concatenate([at + aside, at - aside])
        tips[np.tile(picture.frame.is_down[rows], 2)] = np.nan
        colour = np.repeat([palette.COOL, palette.WARM], len(rows), axis=0)
        return self.follow(picture, np.concatenate([2 * ids, 2 * ids + 1]), tips, colour)


def span(picture: Picture, rows: np.ndarray) -> np.ndarray:
    """Distance of the wing tips from the middle of the birds in `rows`, (M, 1)."""
    return TIP * BIRD.scale * picture.length * picture.size[rows, None]
