"""A picture of a flock for Python: shown by a notebook, saved as a file."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from agents.flock import Flock
from app.viewer.pictures.picture_camera import CAMERAS, FIXED, FOLLOW, ROUND, Camera, CameraRequest
from app.viewer.pictures.picture_sheet import Sheet
from app.viewer.pictures.shot import Shot, look_of, shot
from worlds.file_writer import writing
from worlds.input_error import InputError, unknown

ENDINGS = (".png", ".svg", ".pdf")
PLAIN, BROWSER = "plain", "browser"
RENDERERS = (PLAIN, BROWSER)
LEAST, MOST = 320, 8000
"""Pixels of a side."""


@dataclass(frozen=True)
class FlockPicture:
    """A flock as it was at a tick, drawn; a notebook shows it."""

    shot: Shot
    size: tuple[int, int]
    """Width and height, pixels."""
    camera: Camera
    renderer: str
    png: bytes
    """The picture as a PNG file holds it."""

    def save(self, path: str | Path) -> None:
        """Write it as the ending says, PNG, SVG or PDF; a file of that name is replaced.

        Raises InputError.
        """
        ending = Path(path).suffix.lower()
        if ending in ENDINGS[1:] and self.renderer == BROWSER:
            raise InputError(f"picture {str(path)!r} is not allowed: a browser draws no {ending}")
        with writing("picture", path, endings=ENDINGS) as file:
            file.write(self.png if ending == ENDINGS[0] else self.drawn(ending))

    def drawn(self, ending: str) -> bytes:
        """The file of it that has an ending."""
        return Sheet(self.shot, self.size, self.camera).as_bytes(ending)

    def _repr_png_(self) -> bytes:
        return self.png

    def __repr__(self) -> str:
        now = self.shot.now
        return f"<Picture of {now.model.name} at tick {now.tick}, {self.size[0]}x{self.size[1]}>"


def picture(
    flock: Flock,
    size: tuple[int, int] = (900, 560),
    *,
    colour: str | None = None,
    camera: str = FIXED,
    follow: int | None = None,
    renderer: str = PLAIN,
) -> FlockPicture:
    """Draw a flock as it is, see `Flock.picture`. Raises InputError."""
    demand_size(size)
    if renderer not in RENDERERS:
        raise unknown("renderer", renderer, RENDERERS)
    stands = tuple(name for name in CAMERAS if name != ROUND)
    if camera not in stands:
        raise unknown("camera", camera, stands)
    if follow is not None and camera not in (FIXED, FOLLOW):
        raise InputError(f"follow = {follow} is not allowed with camera = {camera!r}")
    aim = CameraRequest(FOLLOW if follow is not None else camera, follow)
    if renderer == PLAIN and flock.world.dim == 2 and not aim.is_from_above:
        raise InputError(
            f"camera = {camera!r} of a flat world takes renderer = {BROWSER!r}: the plain one "
            "looks straight down"
        )
    now = flock.snapshot(signals=True)
    one = shot(now, look_of(now, colour))
    seen_from = aim.camera(one)
    if renderer == BROWSER:
        png = by_browser(one, size, seen_from)
    else:
        png = Sheet(one, size, seen_from).as_bytes(ENDINGS[0])
    return FlockPicture(one, size, seen_from, renderer, png)


def by_browser(one: Shot, size: tuple[int, int], camera: Camera) -> bytes:
    """A shot as the page shows it, as PNG. Raises InputError where there is no browser for it."""
    from app.viewer.pictures.browser import NAMED, Browser, find_browser
    from app.viewer.pictures.film_writer import seen_picture

    program = find_browser()
    if program is None:
        raise InputError(
            f"renderer = {BROWSER!r}: there is no Chromium, Chrome or Edge; {NAMED} names one"
        )
    with Browser(program) as window:
        return seen_picture(one, window, size, camera)


def demand_size(size: tuple[int, int]) -> None:
    """Raise InputError for what is no width and height."""
    if len(size) != 2 or not all(isinstance(side, int) for side in size):
        raise InputError(f"size = {size} is not a width and a height in pixels")
    for side in size:
        if not LEAST <= side <= MOST:
            raise InputError(f"size = {size}: {side} is outside [{LEAST}, {MOST}]")
