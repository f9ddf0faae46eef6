"""Films of what one browser sees, from when it says so until it says stop: its own pictures, in its
own time, encoded in a process of its own; or the frames themselves, for a page that plays them."""

from __future__ import annotations

import tempfile
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from app.viewer.pictures import key
from app.viewer.pictures.browser_scene import SeenSheet
from app.viewer.pictures.film_writer import Encoder
from app.viewer.pictures.player import LIGHT, Player
from app.viewer.pictures.shot import Shot
from worlds.input_error import InputError

FPS = 20.0
"""Pictures a second: as many are drawn as the browser can, the rest are the last again."""
LONGEST = 180.0
"""Seconds of a film at most."""
LARGEST = 48_000_000
"""Bytes of a film at most: it is sent through the line that the page has."""
GAP = 5.0
"""Seconds at most that a picture stays where the browser draws no other."""
PAGE = ".html"


class FilmSource(Protocol):
    """What a film is made of."""

    def shot(self) -> Shot: ...
    def aspect(self) -> float: ...
    def where(self) -> Any: ...
    def picture(self, sheet: SeenSheet, shot: Shot) -> np.ndarray: ...


class FilmRecorder(threading.Thread):
    """One film in the making; `done` is given its kind and bytes, or `failed` why there is none."""

    def __init__(
        self,
        eyes: FilmSource,
        kind: str,
        size: tuple[int, int],
        done: Callable[[bytes], None],
        failed: Callable[[str], None],
    ):
        super().__init__(name="filming", daemon=True)
        self.eyes, self.kind, self.size = eyes, kind, size
        self.done, self.failed = done, failed
        self.ending = threading.Event()
        self.is_wanted = True
        self.begun = time.monotonic()
        self.bytes = 0

    @property
    def seconds(self) -> float:
        """How long it is by now."""
        return time.monotonic() - self.begun

    def stop(self, is_wanted: bool = True) -> None:
        """End it; unless it is wanted nothing comes of it."""
        self.is_wanted = self.is_wanted and is_wanted
        self.ending.set()

    def run(self) -> None:
        try:
            made = self.frames() if self.kind == PAGE else self.film()
            if self.is_wanted:
                self.done(made)
        except InputError as refusal:
            self.failed(str(refusal))
        except Exception as error:
            self.failed(f"the film cannot be made: {type(error).__name__}")

    def goes_on(self, due: float) -> bool:
        """Wait for the next picture; whether there is to be one."""
        late = self.seconds > LONGEST or self.bytes > LARGEST
        return not late and not self.ending.wait(max(0.0, due - time.monotonic()))

    def film(self) -> bytes:
        """Pictures until the end, as a film. Raises InputError."""
        with tempfile.TemporaryDirectory(prefix="flockscope-page-film-") as folder:
            path = Path(folder) / f"film{self.kind}"
            with Encoder(path, self.size, FPS) as encoder:
                self.pictures(encoder)
                if not self.is_wanted:
                    raise InputError("the film is discarded")
            return path.read_bytes()

    def pictures(self, encoder: Encoder) -> None:
        """Have pictures drawn and written. Raises InputError."""
        sheet: SeenSheet | None = None
        picture: np.ndarray | None = None
        laid_out: Any = None
        shot, where, written = self.eyes.shot(), None, 0
        self.begun = time.monotonic()
        while self.goes_on(self.begun + written / FPS):
            before, shot = (shot.made.frame, where), self.eyes.shot()
            where, wanted = self.eyes.where(), layout(shot, self.eyes.aspect())
            is_new = sheet is None or wanted != laid_out or sheet.sheet.is_outgrown_by(shot)
            if sheet is None or is_new:
                sheet, laid_out = SeenSheet(shot, self.size, wanted[-1], None), wanted
            if picture is None or is_new or before[0] is not shot.made.frame or before[1] != where:
                picture = self.eyes.picture(sheet, shot)
            due = int(self.seconds * FPS) + 1
            for _ in range(min(max(due - written, 1), round(GAP * FPS))):
                encoder.add(picture)
            written = max(due, written + 1)
            self.bytes = encoder.made.stat().st_size if encoder.made.exists() else 0

    def frames(self) -> bytes:
        """Frames until the end, as a page that plays them. Raises InputError."""
        shot = self.eyes.shot()
        begun, first, last, taken, then = time.monotonic(), shot, None, 0, 0.0
        with Player(LIGHT) as player:
            due = begun
            while self.goes_on(due) and taken * len(shot.now.ids) < LIGHT:
                due = time.monotonic() + 1.0 / FPS
                shot = self.eyes.shot()
                if last is not None and shot.made.frame is last.made.frame:
                    continue
                now = self.seconds
                player.add(shot.made.frame, shot.made.look, now - then)
                last, then, taken = shot, now, taken + 1
            last = last or first
            words = [key.caption(first), key.changes(first)]
            words.append(f"ticks {first.now.tick} to {last.now.tick}")
            told = " · ".join(word for word in words if word)
            return player.page(key.title(first), told, max(self.seconds - then, 0.5))


def layout(shot: Shot, aspect: float) -> tuple[Any, ...]:
    """What a sheet is laid out for: another needs a new one."""
    look, frame = shot.made.look, shot.made.frame
    return frame.run, look.colour, look.measured, key.changes(shot), round(aspect, 1)
