"""From where a picture or a film is seen: from one place, after an agent, or round the world."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from app.viewer.pictures.shot import Shot
from app.viewer.scene.cameras.camera import CameraView, view
from app.viewer.scene.cameras.viewpoints import extent
from worlds.input_error import InputError

FIXED, FOLLOW, ROUND = "fixed", "follow", "round"
PRESETS = ("top-down", "perspective", "side")
CAMERAS = (FIXED, *PRESETS, FOLLOW, ROUND)
"""What a camera may do; fixed is the place that is usual in a plane, or in space."""
CLOSE_UP = 1.6
"""Half of what is shown around a followed agent, display units."""
ASPECT, SHAPES = 1.3, (0.8, 2.0)
"""Width over height of a picture, as it is usual; and of one of a flat world, at least and most."""
CORNERS = 1.1
"""How much larger the floor is taken for a camera that goes round it: its corners come nearer."""


@dataclass(frozen=True)
class Camera:
    """A camera on one run. Places are of the display."""

    preset: str
    low: np.ndarray
    high: np.ndarray
    """Corners (3,) of what is to be seen."""
    follow: int | None = None
    """Identity of the agent that it follows."""
    per_tick: float = 0.0
    """How far it goes round in a tick, rad."""
    begin: int = 0
    """The tick from which on it goes round."""

    @staticmethod
    def of(first: Shot, follow: int | None = None) -> Camera:
        """The usual one for a run that begins with a shot."""
        low, high = extent(first.made)
        flat = first.made.stage.dim == 2
        return Camera("top-down" if flat else "perspective", low, high, follow)

    @property
    def moves(self) -> bool:
        """Whether it does not stay where it is."""
        return self.follow is not None or self.per_tick != 0.0

    @property
    def aspect(self) -> float:
        """Width over height of a picture that suits what is to be seen."""
        across, deep, _ = self.high - self.low
        if self.preset != "top-down" or self.follow is not None or not deep > 0.0:
            return ASPECT
        return float(np.clip(across / deep, *SHAPES))

    def view(self, shot: Shot, aspect: float) -> CameraView:
        """Where it is at a shot, in a picture of this aspect. Raises InputError."""
        dim = shot.made.stage.dim
        if self.follow is not None:
            at = shot.made.at[shot.row_of(self.follow)]
            return view(FOLLOW, dim, at - CLOSE_UP, at + CLOSE_UP, aspect)
        made = view(self.preset, dim, self.low, self.high, aspect)
        if not self.per_tick:
            return made
        angle = self.per_tick * (shot.now.tick - self.begin)
        middle = 0.5 * (self.low + self.high)
        return replace(
            made,
            position=middle + rotate_about_upright(made.position - middle, angle),
            target=middle + rotate_about_upright(made.target - middle, angle),
        )


def rotate_about_upright(place: np.ndarray, angle: float) -> np.ndarray:
    """A place (3,) turned about the upright axis by an angle, rad."""
    c, s = np.cos(angle), np.sin(angle)
    x, y, z = place
    return np.array([c * x - s * y, s * x + c * y, z])


@dataclass(frozen=True)
class CameraRequest:
    """What is asked of a camera before the run is known."""

    kind: str = FIXED
    follow: int | None = None
    per_tick: float = 0.0
    """How far a camera that goes round goes in a tick, rad."""

    def camera(self, first: Shot) -> Camera:
        """The camera for a run that begins with a shot. Raises InputError."""
        follow = self.follow
        if self.kind == FOLLOW and follow is None:
            follow = worth_following(first)
        if follow is not None:
            first.row_of(follow)
        made = Camera.of(first, follow)
        if self.kind in PRESETS:
            return replace(made, preset=self.kind)
        if self.kind != ROUND:
            return made
        middle, half = 0.5 * (made.low + made.high), 0.5 * (made.high - made.low)
        half[:2] *= CORNERS
        return replace(made, preset="perspective", low=middle - half, high=middle + half,
                       per_tick=self.per_tick, begin=first.now.tick)  # fmt: skip

    @property
    def is_from_above(self) -> bool:
        """Whether it looks straight down in a flat world."""
        return self.kind in (FIXED, "top-down", FOLLOW)

    def demand_plain(self, dim: int) -> None:
        """Refuse what only a browser can show. Raises InputError."""
        if dim == 2 and not self.is_from_above:
            raise InputError(
                f"--camera {self.kind} of a flat world takes --renderer browser: the plain one "
                "looks straight down"
            )


USUAL = CameraRequest()


def worth_following(first: Shot) -> int:
    """The identity of the agent that leads, else of the first. Raises InputError if there is
    none."""
    if not len(first.now.ids):
        raise InputError("there is no agent to follow")
    return int(first.now.ids[np.argmax(first.now.informed)])
