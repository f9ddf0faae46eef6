"""A browser of one's own, without a window, that draws scenes as the page shows them.

It is the Chromium, Chrome or Edge of this machine, with a profile of its own in a temporary folder;
it reaches this process and nobody else, and ends with it.
"""

from __future__ import annotations

import io
import os
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import viser
from PIL import Image

from app.front.page_front import Front
from app.front.renders import LEAST, RenderCamera
from app.front.server import admit_browsers, close_server, open_server, renders_of
from app.viewer.pictures import key
from app.viewer.pictures.picture_sheet import Sheet
from app.viewer.pictures.plane import Plots
from app.viewer.pictures.shot import Shot
from app.viewer.scene.cameras.camera import UP, CameraView
from app.viewer.scene.draw.stage import Stage
from app.viewer.scene.scene import Scene
from app.viewer.scene.shown import palette
from app.viewer.scene.shown.drawing_style import DrawingStyle
from app.viewer.scene.shown.frame import Frame
from worlds.input_error import InputError

# What a browser shows, on a sheet with what its colours mean, a scale, and which run it is.

Render = Callable[[tuple[int, int]], np.ndarray]
"""Has a browser draw so many pixels, (width, height) -> (height, width, 3) uint8."""
STRAIGHT = 0.9986
"""Cosine of how far a camera may be from straight down, 3 deg, that lengths can be read off."""
TURN = np.array([[-0.574, 1.430, 0.144], [0.426, 0.430, 0.144], [0.426, 1.430, -0.856]])
"""`hue-rotate(180deg)` of CSS."""
INVERTED = 0.92
"""`invert` of the dark theme: what `static/page.css` has in `--fs-drawn`."""


def eye_of(view: CameraView) -> RenderCamera:
    """A point of view as a browser is told it."""
    back = view.position - view.target
    back = back / np.linalg.norm(back)
    right = np.cross(UP, back)
    right = right / np.linalg.norm(right)
    turn = quaternion(np.stack([right, np.cross(right, back), -back], 1))
    return RenderCamera(view.position, turn, view.fov)


def quaternion(axes: np.ndarray) -> np.ndarray:
    """The quaternion (w, x, y, z) of a rotation (3, 3).

    >>> quaternion(np.diag([1.0, -1.0, -1.0])).tolist()
    [0.0, 1.0, 0.0, 0.0]
    """
    (a, b, c), (d, e, f), (g, h, i) = axes
    form = np.array([
        [a + e + i, h - f, c - g, d - b],
        [h - f, a - e - i, b + d, c + g],
        [c - g, b + d, e - a - i, f + h],
        [d - b, c + g, f + h, i - a - e],
    ])  # fmt: skip
    largest = np.linalg.eigh(form)[1][:, -1]
    return np.where(abs(largest) < 1e-12, 0.0, largest * np.copysign(1.0, largest[np.argmax(
        abs(largest))]))  # fmt: skip


def lengths_across(stage: Stage, eye: RenderCamera) -> float | None:
    """How long the picture of a flat world is from its lower to its upper edge, length.

    None where it is not seen from straight above, or is no flat world.
    """
    w, x, y, z = eye.wxyz
    ahead = np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])
    if stage.dim == 3 or -ahead[2] < STRAIGHT:
        return None
    return float(2.0 * eye.position[2] * np.tan(0.5 * eye.fov) / stage.scale)


class BrowserScene:
    """The scene on its axes, where a browser's picture is put."""

    def __init__(self, axes: Any, first: Shot, aspect: float, eye: RenderCamera | None):
        self.axes = axes
        self.moving: list[Any] = []
        frame, stage = first.made.frame, first.made.stage
        self.signs = key.signs_of(
            frame.world,
            bool(frame.world.obstacles),
            palette.css(palette.LEADER),
            palette.css(palette.GOAL),
        )
        across = None if eye is None else lengths_across(stage, eye)
        self.has_scale = across is not None
        tall = across or 1.0
        axes.set(xlim=(0.0, tall * aspect), ylim=(0.0, tall), aspect="equal", xticks=[], yticks=[])
        axes.spines[:].set_visible(False)
        axes.set_facecolor("none")

    def begin(self, shot: Shot) -> None:
        """The browser draws it."""

    def show(self, shot: Shot) -> None:
        """The browser draws it."""

    def rule(self, figure: Any, shot: Shot, y: float) -> None:
        """The scale bar below the scene, where lengths can be read off."""
        if self.has_scale:
            key.draw_ruler(figure, self.axes, shot, y)


class SeenSheet:
    """A sheet of `size` pixels for what a browser shows, one shot after the other.

    `eye`: from where it is seen as long as the sheet is used; None: from here and there.
    """

    def __init__(
        self,
        first: Shot,
        size: tuple[int, int],
        aspect: float,
        eye: RenderCamera | None,
        plots: Plots | None = None,
    ):
        scene = partial(BrowserScene, first=first, aspect=aspect, eye=eye)
        self.sheet = Sheet(first, size, plots=plots, scene=scene)

    def picture(self, shot: Shot, render: Render, dark: bool = False) -> np.ndarray:
        """A shot as the browser shows it now, (height, width, 3) uint8. Raises InputError."""
        left, top, wide, tall = self.sheet.box
        seen = render((wide, tall))
        self.sheet.show(shot)
        made = self.sheet.pixels().copy()
        made[top : top + tall, left : left + wide] = seen
        return darkened(made) if dark else made


def darkened(pixels: np.ndarray) -> np.ndarray:
    """What the dark theme makes of a light picture: lightness turned round, hues as they are.

    >>> darkened(np.full((1, 1, 3), 255, np.uint8)).tolist()
    [[[20, 20, 20]]]
    """
    inverted = np.column_stack([(1.0 - 2.0 * INVERTED) * TURN, np.full(3, 255.0 * INVERTED)])
    return np.asarray(Image.fromarray(pixels).convert("RGB", tuple(inverted.ravel().tolist())))


def as_png(pixels: np.ndarray) -> bytes:
    """A picture as PNG."""
    made = io.BytesIO()
    Image.fromarray(pixels).save(made, "png", optimize=False)
    return made.getvalue()


NAMED = "FLOCKSCOPE_CHROMIUM"
"""The environment's word for which browser it is."""
NAMES = (
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
    "chrome",
    "microsoft-edge",
    "microsoft-edge-stable",
    "msedge",
)
ELSEWHERE = (
    "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
    "/Applications/Chromium.app/Contents/MacOS/Chromium",
    "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
    "C:/Program Files/Google/Chrome/Application/chrome.exe",
    "C:/Program Files (x86)/Microsoft/Edge/Application/msedge.exe",
)
"""Where they are on systems that do not look for programs by name."""
ARGUMENTS = (
    "--headless=new",
    "--window-size=800,600",
    "--hide-scrollbars",
    "--mute-audio",
    "--ignore-gpu-blocklist",
    "--enable-unsafe-swiftshader",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-default-apps",
    "--disable-extensions",
    "--disable-quic",
    "--disable-sync",
    "--no-default-browser-check",
    "--no-first-run",
    "--no-proxy-server",
    "--password-store=basic",
    "--use-mock-keychain",
    "--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE 127.0.0.1",
)
STARTS, DRAWS = 45.0, 90.0
"""Seconds that it has until its page is there, and for a picture."""
SETTLES = 0.6
"""Seconds that a scene takes to be there whole when it is drawn first."""
ENDS = 10.0
"""Seconds that it has to end by itself."""


def find_browser() -> str | None:
    """The program of a browser that can draw; None if there is none. Raises InputError."""
    asked = os.environ.get(NAMED)
    if asked:
        found = shutil.which(asked)
        if found is None:
            raise InputError(f"{NAMED} = {asked!r} is no program")
        return found
    named = (shutil.which(name) for name in NAMES)
    there = (path for path in ELSEWHERE if Path(path).is_file())
    return next((one for one in (*named, *there) if one), None)


def is_far() -> bool:
    """Whether the folder for temporary files is too far down for the socket of a browser.

    Its path may have 107 bytes, of which the browser's own names take up to 46.
    """
    return os.name == "posix" and len(os.fsencode(tempfile.gettempdir())) > 60


GUARD = """
import os, shutil, signal, sys, time
folder, words = sys.argv[1], sys.stdin.read().split()  # to the end: until its parent is gone
program = int(words[0]) if words and words[-1] != "ended" else 0  # 0: none began, or it has ended
for _ in range(50 if program else 0):
    try:
        os.kill(program, signal.SIGKILL if os.name == "posix" else signal.SIGTERM)
    except OSError:
        break
    time.sleep(0.1)
for _ in range(50):
    shutil.rmtree(folder, ignore_errors=True)
    if not os.path.exists(folder):
        break
    time.sleep(0.1)
"""
"""Waits until the process that began it is gone, however it ended, and tidies up after it."""


def begin_guard(folder: str) -> subprocess.Popen:
    """A small process that removes a folder once our end of its pipe closes.

    It begins before the program whose folder it is: `guard_program` names that, to be ended too.
    Not even SIGKILL keeps the system from closing a pipe; in a session of its own no Ctrl-C or
    SIGTERM for a whole group ends it.
    """
    return subprocess.Popen(
        [sys.executable, "-I", "-S", "-c", GUARD, folder],
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )


def guard_program(guard: subprocess.Popen, program: int) -> None:
    """Have a guard end a program, by its number, before it removes the folder."""
    assert guard.stdin is not None
    guard.stdin.write(f"{program}\n".encode())
    guard.stdin.flush()


class Browser:
    """Draws frames; a context manager. Raises InputError where the browser does not start."""

    def __init__(self, program: str):
        self.program = program
        self.is_new = True

    def __enter__(self) -> Browser:
        self.server = open_server(port=0, front=Front(("sharp.js",)))
        self.profile = tempfile.mkdtemp(prefix="flockscope-browser-")
        self.process: Any = None
        self.guard = begin_guard(self.profile)
        try:
            self.scene = Scene(self.server)
            admit_browsers(self.server)
            self.start()
        except BaseException:
            self.close()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def start(self) -> None:
        """Have it open the page of our server. Raises InputError."""
        is_root = hasattr(os, "geteuid") and os.geteuid() == 0  # it runs in no sandbox for root
        self.process = subprocess.Popen(
            [
                self.program,
                *ARGUMENTS,
                *(["--no-sandbox"] if is_root else []),
                f"--user-data-dir={self.profile}",
                f"http://127.0.0.1:{self.server.get_port()}/",
            ],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            env=os.environ | ({"TMPDIR": "/tmp"} if is_far() else {}),
        )
        guard_program(self.guard, self.process.pid)
        until = time.monotonic() + STARTS
        while not self.server.get_clients():
            if self.process.poll() is not None:
                raise InputError(f"the browser {self.program!r} ends at once: it cannot run here")
            if time.monotonic() > until:
                raise InputError(f"the browser {self.program!r} opens no page within {STARTS:g} s")
            time.sleep(0.05)

    @property
    def client(self) -> viser.ClientHandle:
        """Its page. Raises InputError if it is gone."""
        clients = self.server.get_clients()
        if not clients:
            raise InputError(f"the browser {self.program!r} has ended")
        return next(iter(clients.values()))

    def show(self, frame: Frame, look: DrawingStyle) -> None:
        """Have a frame on its page."""
        self.scene.show(frame, look)

    def draw(self, size: tuple[int, int], view: CameraView) -> np.ndarray:
        """The frame as it draws it, (height, width, 3) uint8. Raises InputError."""
        client, renders = self.client, renders_of(self.server)
        with client.atomic():  # what is written in the scene has its size by the page's own camera
            client.camera.up_direction = UP
            client.camera.fov, client.camera.near = view.fov, view.near
            client.camera.position, client.camera.look_at = view.position, view.target
        if self.is_new:
            self.is_new = False
            self.server.flush()
            time.sleep(SETTLES)
            renders.ask(client, (LEAST, LEAST), RenderCamera.of(client.camera), timeout=DRAWS)
        return renders.ask(client, size, eye_of(view), exact=True, timeout=DRAWS)

    def close(self) -> None:
        """End it, and take its profile away."""
        if self.process is not None and self.process.poll() is None:
            self.process.terminate()
            try:
                self.process.wait(ENDS)
            except subprocess.TimeoutExpired:
                self.process.kill()
                self.process.wait()
        self.guard.communicate(b"ended")  # so that it kills no other that has its number now
        close_server(self.server)
        for _ in range(10):  # what it has begun to write may come late
            shutil.rmtree(self.profile, ignore_errors=True)
            if not Path(self.profile).exists():
                return
            time.sleep(0.1)
