"""A run as one HTML file that plays it without a server: viser's page with the scene in it."""

from __future__ import annotations

import html
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from dataclasses import replace
from typing import Any

import numpy as np
import viser

from agents.snapshot import Snapshot
from app.front.server import close_server, open_server
from app.front.viser_internals import change_updates
from app.package_files import STATIC
from app.viewer.pictures import key
from app.viewer.pictures.picture_camera import PRESETS, USUAL, CameraRequest
from app.viewer.pictures.shot import Shot, frame_of, look_of, shot
from app.viewer.scene.scene import Scene
from app.viewer.scene.shown import drawing_style
from app.viewer.scene.shown.drawing_style import DARTS, DrawingStyle
from app.viewer.scene.shown.frame import Frame
from worlds.input_error import InputError

GRIDS = {"batched_positions": 256.0, "position": 256.0, "batched_wxyzs": 128.0,
         "batched_scales": 64.0}  # fmt: skip
"""Steps to a unit that what moves is rounded to: less than a dot of the screen, and what is round
packs well."""
SHADES = 4
"""Steps between two values of a colour."""
FEW = 60_000
"""Agents times pictures up to which birds and fish are such: each takes three times what a dart
takes."""
MOST = 2_000_000
"""Agents times pictures of a file at most: some 30 MB."""
HOLDS = 1.0
"""Seconds that the last picture stays."""
CLOSED = (
    "default-src 'none'; script-src 'unsafe-inline' 'unsafe-eval'; worker-src blob:; "
    "connect-src data: blob:; style-src 'unsafe-inline'; img-src data: blob:; font-src data:"
)
"""The page's own policy: it runs what it holds, and asks nobody for anything."""
STYLE = """
.told { position: fixed; top: 12px; left: 16px; right: 16px; z-index: 5; pointer-events: none;
  font: 14px/1.4 -apple-system, "Segoe UI", Roboto, "Helvetica Neue", sans-serif; color: #3a4553;
  text-shadow: 0 0 4px #fff, 0 0 8px #fff; }
.told h1 { margin: 0; font-size: 18px; line-height: inherit; color: #1b2330; }
"""
ACCESSIBLE = (STATIC / "accessible.js").read_text("utf-8")
"""The script that gives names to what viser's client leaves without."""


LIGHT = 250_000
"""Agents times pictures up to which a file is some 5 MB at most."""
DENSITY_WORTH = 5_000
"""As many agents take what a picture of density takes."""


class Player:
    """Takes frames and makes them a page; a context manager.

    `count`: agents times frames that there will be at most, which says how they are drawn.
    `camera`: a preset on which it opens, unless on the usual one.
    """

    def __init__(self, count: int, camera: str = ""):
        self.count, self.camera = count, camera
        self.recorded: Any = None
        self.taken = 0

    def __enter__(self) -> Player:
        self.server = open_server(port=0)
        self.scene = Scene(self.server, is_recorded=True)
        self.scene.open_on(self.camera)
        return self

    def __exit__(self, *_: object) -> None:
        close_server(self.server)

    def add(self, frame: Frame, look: DrawingStyle, seconds: float) -> None:
        """The next frame, so many seconds after the last; of very many agents in space some."""
        frame = thinned_frame(frame)
        if self.count > FEW:
            look = replace(look, form=DARTS)
        if self.recorded is None:
            self.scene.show(frame, look)
            self.recorded = self.server.get_scene_serializer()
            self.recorded._filter = rounding(self.recorded._filter)
        else:
            self.recorded.insert_sleep(seconds)
            self.scene.show(frame, look)
        self.taken += 1

    def page(self, title: str, caption: str, last: float) -> bytes:
        """The page; its last picture stays for so many seconds before it begins again."""
        self.recorded.insert_sleep(last)
        text = self.recorded.as_html()
        named = f"<title>{html.escape(title)}</title>"
        head = f'<meta http-equiv="Content-Security-Policy" content="{CLOSED}">{named}'
        told = (
            f"<style>{STYLE}</style><header class='told'><h1>{html.escape(title)}</h1>"
            f"{html.escape(caption)}</header><script>{ACCESSIBLE}</script>"
        )
        before, found, after = text.partition("<head>")
        body, ends, rest = after.rpartition("</body>")
        if not (found and ends):
            raise InputError(f"the page of viser {viser.__version__} is not built as it was")
        return (before + found + head + body + told + ends + rest).encode()


def page_of(
    snapshots: Iterable[Snapshot],
    count: int,
    fps: float,
    colour: str | None = None,
    aim: CameraRequest = USUAL,
    went_on: Callable[[int], None] = lambda _: None,
) -> bytes:
    """A page that plays `count` snapshots, `fps` a second. Raises InputError.

    `went_on` is told how many are done.
    """
    look, fastest, first, last = None, 0.0, None, None
    player: Player | None = None
    preset = aim.kind if aim.kind in PRESETS else ""
    with ExitStack() as held:
        for done, now in enumerate(snapshots, start=1):
            look = look or look_of(now, colour)
            frame = frame_of(now, look, fastest)
            fastest = frame.speed_scale
            if player is None:
                worth = count * agents_worth(len(now.ids), now.world.dim)
                player = held.enter_context(Player(worth, preset))
            player.add(frame, look, 1.0 / fps)
            first, last = first or shot(now, look), now
            went_on(done)
        if player is None or first is None or last is None:
            raise InputError("no picture was taken: there is nothing to play")
        words = describe_recorded_run(first, last, fps * apart(first, last, count))
        return player.page(key.title(first), words, HOLDS)


def apart(first: Shot, last: Snapshot, count: int) -> float:
    """Ticks between two of so many pictures."""
    return (last.tick - first.now.tick) / max(count - 1, 1)


def describe_recorded_run(first: Shot, last: Snapshot, pace: float) -> str:
    """What the page says of the run."""
    changes = key.changes(first)
    apart = one_of(len(last.ids), last.world.dim)
    drawn = [f"one of {apart} agents is drawn"] if apart > 1 else []
    ticks = f"ticks {first.now.tick} to {last.tick}, {pace:.3g} a second"
    return " · ".join([key.caption(first), *([changes] if changes else []), *drawn, ticks])


def one_of(agents: int, dim: int) -> int:
    """Of how many agents one is drawn: of very many in space, since a picture of their density
    would be another from every place.

    >>> one_of(1_000_000, 3), one_of(1_000_000, 2), one_of(150_000, 3)
    (50, 1, 1)
    """
    is_many = dim == 3 and agents > drawing_style.DENSITY_BEYOND
    return -(-agents // drawing_style.SINGLES_UP_TO) if is_many else 1


def thinned_frame(frame: Frame) -> Frame:
    """A frame with as many agents as are drawn, always the same ones."""
    beside = None if frame.beside is None else thinned_frame(frame.beside)
    frame = replace(frame, beside=beside)
    apart = one_of(len(frame.ids), frame.dim)
    if apart == 1:
        return frame
    is_drawn = (frame.ids % apart == frame.ids[0] % apart) | frame.informed
    return replace(frame.of_rows(np.flatnonzero(is_drawn)), beside=beside)


def agents_worth(agents: int, dim: int) -> int:
    """As many agents as take what a picture of so many takes."""
    if agents <= drawing_style.DENSITY_BEYOND:
        return max(agents, 1)
    return DENSITY_WORTH if dim == 2 else drawing_style.SINGLES_UP_TO


def rounding(wanted: Callable[[Any], bool]) -> Callable[[Any], bool]:
    """What rounds the numbers of a message that is wanted, as it is recorded."""

    def rounded(message: Any) -> bool:
        if not wanted(message):
            return False
        change_updates(message, coarse)
        return True

    return rounded


def coarse(name: str, value: Any) -> Any:
    """A property of a node that changes, as coarse as nobody sees.

    >>> coarse("batched_positions", np.array([0.1, 2.0], np.float32)).tolist()
    [0.1015625, 2.0]
    """
    if not isinstance(value, np.ndarray):
        return value
    if value.dtype == np.uint8:
        return np.minimum((value.astype(np.uint16) + SHADES // 2) // SHADES * SHADES, 255).astype(
            np.uint8
        )
    grid = GRIDS.get(name)
    return value if grid is None else np.round(value * grid) / value.dtype.type(grid)


def demand_playable(agents: int, dim: int, pictures: int) -> None:
    """Refuse what would be too large a file with one line. Raises InputError."""
    most = MOST // agents_worth(agents, dim)
    if pictures > most:
        apart = -(-pictures // most)
        raise InputError(
            f"{pictures} pictures of {agents} agents are too many for an HTML file, which takes "
            f"{most}: take one of {apart}, by --every {apart}, or fewer by --from and --to"
        )
