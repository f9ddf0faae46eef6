"""Who draws pictures and films: a browser of this machine, as the page shows it, or ourselves."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from app.cli.terminal.outcome_table import print_stderr
from worlds.input_error import InputError, unknown

if TYPE_CHECKING:
    from app.viewer.pictures.browser import Browser
    from app.viewer.pictures.picture_camera import CameraRequest

AUTO, BROWSER, PLAIN = "auto", "browser", "plain"
RENDERERS = (AUTO, BROWSER, PLAIN)


def demand_renderer(name: str) -> None:
    """Refuse what is no renderer. Raises InputError."""
    if name not in RENDERERS:
        raise unknown("renderer", name, RENDERERS)


@contextmanager
def browser(name: str, quiet: bool) -> Iterator[Browser | None]:
    """A browser that draws; None where it is to be drawn plainly. Raises InputError."""
    if name == PLAIN:
        yield None
        return
    from app.viewer.pictures.browser import NAMED, Browser, find_browser

    program = find_browser()
    if program is None and name == BROWSER:
        raise InputError(
            f"--renderer browser: there is no Chromium, Chrome or Edge; {NAMED} names one"
        )
    words = "no browser is found: drawn by the plain renderer"
    window: Browser | None = None
    if program is not None:
        try:
            window = Browser(program).__enter__()
            words = f"drawn by {program}; --renderer plain takes less time"
        except InputError as refusal:
            if name == BROWSER:
                raise
            words = f"{refusal}: drawn by the plain renderer"
    if name == AUTO and not quiet:
        print_stderr(f"flockscope: {words}")
    try:
        yield window
    finally:
        if window is not None:
            window.close()


def camera_request(
    camera: str, follow: int | None, turn: float | None, ticks_a_second: float, ticks: int
) -> CameraRequest:
    """Where a camera is to look; going round it does so once in `ticks` unless `turn` (deg/s) says.

    Raises InputError.
    """
    from app.viewer.pictures.picture_camera import CAMERAS, FIXED, FOLLOW, ROUND, CameraRequest

    if camera not in CAMERAS:
        raise unknown("camera", camera, CAMERAS)
    if follow is not None and camera not in (FIXED, FOLLOW):
        raise InputError(f"--follow {follow} is not allowed with --camera {camera}")
    if turn is not None and camera != ROUND:
        raise InputError(f"--turn {turn:g} is not allowed: it is of --camera {ROUND}")
    if turn is not None and not 0.1 <= abs(turn) <= 360.0:
        raise InputError(f"--turn {turn:g} is outside [0.1, 360] degrees a second, or [-360, -0.1]")
    kind = FOLLOW if follow is not None else camera
    if kind != ROUND:
        return CameraRequest(kind, follow)
    turn_per_tick = 2.0 * math.pi / max(ticks, 1)
    return CameraRequest(
        kind, per_tick=turn_per_tick if turn is None else math.radians(turn) / ticks_a_second
    )
