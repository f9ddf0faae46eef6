"""Films: pictures one after the other through a packaged ffmpeg, whole or not at all."""

from __future__ import annotations

import shutil
import signal
import subprocess
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path

import numpy as np

from agents.snapshot import Snapshot
from app.viewer.pictures.browser import (
    Browser,
    SeenSheet,
    as_png,
    begin_guard,
    eye_of,
    guard_program,
)
from app.viewer.pictures.picture_camera import USUAL, Camera, CameraRequest
from app.viewer.pictures.picture_sheet import Sheet
from app.viewer.pictures.plane import Plots
from app.viewer.pictures.shot import Shot, look_of, shot
from worlds.file_writer import writing
from worlds.input_error import InputError
from worlds.plug_ins import demand

EVEN = "pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white"
"""These codecs take an even number of pixels only."""
CODECS = {
    ".mp4": ["-vf", EVEN, "-c:v", "libx264", "-preset", "veryfast", "-crf", "18",
             "-pix_fmt", "yuv420p", "-movflags", "+faststart"],
    ".webm": ["-vf", EVEN, "-c:v", "libvpx-vp9", "-crf", "30", "-b:v", "0", "-deadline",
              "realtime", "-cpu-used", "5", "-row-mt", "1", "-pix_fmt", "yuv420p"],
    ".gif": ["-vf", "split[a][b];[a]palettegen=stats_mode=single[p];[b][p]paletteuse=new=1"],
}  # fmt: skip
"""How each kind of film is made, by its ending."""

ENDS = 5.0
"""Seconds that ffmpeg has to end once it takes no more."""
SIGNALS = {
    getattr(signal, "SIGXFSZ", 0): "it is larger than the limit of this session for a file "
    "(`ulimit -f`)",
    getattr(signal, "SIGKILL", 0): "ffmpeg was killed, as where memory is short",
}
"""What it means that ffmpeg ended by a signal."""


def demand_film(purpose: str) -> None:
    """Refuse with one line where films cannot be made."""
    demand("imageio_ffmpeg", purpose, "film")


class Encoder:
    """Takes pictures and writes them as a film; a context manager.

    The film is made in a folder of its own and takes its place at the end; leaving by an exception
    leaves nothing. Raises InputError if it cannot be made or written.
    """

    def __init__(self, path: Path, size: tuple[int, int], fps: float, overwrite: bool = False):
        demand_film(f"the film {str(path)!r}")
        self.path, self.size, self.fps, self.overwrite = path, size, fps, overwrite

    def __enter__(self) -> Encoder:
        import imageio_ffmpeg

        self.folder = tempfile.TemporaryDirectory(prefix="flockscope-film-")
        self.guard = begin_guard(self.folder.name)
        self.made = Path(self.folder.name) / f"film{self.path.suffix.lower()}"
        self.errors = tempfile.TemporaryFile()
        wide, tall = self.size
        words = [
            imageio_ffmpeg.get_ffmpeg_exe(), "-loglevel", "error", "-y", "-f", "rawvideo",
            "-pix_fmt", "rgb24", "-s", f"{wide}x{tall}", "-r", f"{self.fps:.6f}", "-i", "-", "-an",
            *CODECS[self.path.suffix.lower()], str(self.made),
        ]  # fmt: skip
        self.process = subprocess.Popen(  # not to be stopped by a Ctrl-C that is for us
            words, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=self.errors,
            start_new_session=True,
        )  # fmt: skip
        guard_program(self.guard, self.process.pid)
        return self

    def add(self, pixels: np.ndarray) -> None:
        """The next picture, (height, width, 3) uint8. Raises InputError."""
        assert self.process.stdin is not None
        try:
            self.process.stdin.write(np.ascontiguousarray(pixels).tobytes())
        except OSError:
            raise self.failed() from None

    def failed(self) -> InputError:
        """What ffmpeg says is wrong, in one line."""
        with suppress(subprocess.TimeoutExpired):  # it ends by itself where its own end broke
            self.process.wait(ENDS)
        self.process.kill()
        code = self.process.wait()
        self.errors.seek(0)
        said = self.errors.read().decode(errors="replace").strip().splitlines()
        why = said[-1] if said else f"ffmpeg ended with code {code}"
        if code < 0:
            why = SIGNALS.get(-code, f"ffmpeg was ended by signal {-code}")
        return InputError(f"the film {str(self.path)!r} cannot be made: {why}")

    def __exit__(self, kind: object, *_: object) -> None:
        assert self.process.stdin is not None
        try:
            if kind is not None:
                self.process.kill()
                self.process.wait()
                return
            try:
                self.process.stdin.close()
            except OSError:
                raise self.failed() from None
            if self.process.wait() != 0:
                raise self.failed()
            endings = tuple(CODECS)
            with (
                writing("--out", self.path, self.overwrite, endings) as out,
                open(self.made, "rb") as made,
            ):
                shutil.copyfileobj(made, out)
        finally:
            self.guard.communicate(b"ended")
            self.errors.close()
            self.folder.cleanup()


def pictures(
    snapshots: Iterable[Snapshot],
    size: tuple[int, int],
    colour: str | None = None,
    aim: CameraRequest = USUAL,
    plots: Plots | None = None,
) -> Iterator[np.ndarray]:
    """The pictures of a film, (height, width, 3) uint8, one for each snapshot. Raises
    InputError."""
    sheet: Sheet | None = None
    look, fastest, camera = None, 0.0, None
    for now in snapshots:
        look = look or look_of(now, colour)
        one = shot(now, look, fastest)
        fastest = one.made.frame.speed_scale
        grown = plots is not None and plots.look(now)
        if sheet is None or sheet.is_outgrown_by(one):
            aim.demand_plain(now.world.dim)
            camera = camera or aim.camera(one)
            sheet = Sheet(one, size, camera, plots)
        else:
            sheet.show(one)
        if grown:
            sheet.background = None
        yield sheet.pixels()


def seen_pictures(
    snapshots: Iterable[Snapshot],
    browser: Browser,
    size: tuple[int, int],
    colour: str | None = None,
    aim: CameraRequest = USUAL,
    plots: Plots | None = None,
) -> Iterator[np.ndarray]:
    """The same as a browser draws them. Raises InputError."""
    sheet: SeenSheet | None = None
    look, camera, fastest = None, None, 0.0
    for now in snapshots:
        look = look or look_of(now, colour)
        one = shot(now, look, fastest)
        demand_single_agents(one)
        fastest = one.made.frame.speed_scale
        camera = camera or aim.camera(one)
        view = camera.view(one, camera.aspect)
        grown = plots is not None and plots.look(now)
        if sheet is None or sheet.sheet.is_outgrown_by(one):
            sheet = SeenSheet(
                one, size, camera.aspect, None if camera.moves else eye_of(view), plots
            )
        if grown:
            sheet.sheet.background = None
        browser.show(one.made.frame, look)
        yield sheet.picture(one, partial(browser.draw, view=view))


def demand_single_agents(one: Shot) -> None:
    """Refuse a flock that a browser would be sent pictures of. Raises InputError."""
    if one.made.shows_density:
        raise InputError(
            f"{one.made.count} agents are drawn as a picture of their density, by the plain "
            f"renderer{'' if one.made.stage.dim == 3 else ' and from above'}: renderer = 'plain'"
        )


def seen_picture(one: Shot, browser: Browser, size: tuple[int, int], camera: Camera) -> bytes:
    """A shot as a browser draws it, as PNG. Raises InputError."""
    demand_single_agents(one)
    view = camera.view(one, camera.aspect)
    browser.show(one.made.frame, one.made.look)
    sheet = SeenSheet(one, size, camera.aspect, eye_of(view))
    return as_png(sheet.picture(one, partial(browser.draw, view=view)))
