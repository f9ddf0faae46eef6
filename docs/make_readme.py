"""Makes the film and the picture of README.md: `uv run python docs/make_readme.py`.

The film (needs Chromium, takes some minutes) follows 50 flapping-wing aircraft among blocks. The
picture is what README's Python example saves. `film` or `example` as an argument makes one alone.
"""

from __future__ import annotations

import os
import re
import sys
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

from agents.flock import Flock
from app.viewer.pictures.browser import Browser, find_browser
from app.viewer.pictures.shot import Shot, look_of, shot
from app.viewer.scene.cameras.camera import CameraView

HERE = Path(__file__).parent
README = HERE.parent / "README.md"
FILM, EXAMPLE = HERE / "flock.webp", HERE / "flock.png"
MODEL, SEED = "guarded", 1
FIRST, LAST = 1600, 1712
"""Ticks of the film: here no block hides the flock from the camera."""
FPS = 20
SIZE = (800, 450)
QUALITY = 55
"""Of each WebP picture, 0 to 100: the whole film stays below 3 MB."""
BLENDED = 6
"""Pictures at the end that fade into those before the first, so that the loop has no cut."""
AZIMUTH, ELEVATION = (95.0, 115.0), 24.0
"""Direction from the flock to the camera, deg: the azimuth turns during the film."""
DISTANCE, FOV = 5.3, 0.62
"""From the middle of the flock to the camera, display units; vertical field of view, rad."""


def view_of(one: Shot, share: float) -> CameraView:
    """The camera's view of a flock when a share of the film (0 to 1) is over."""
    middle = one.made.at.mean(axis=0)
    azimuth = np.deg2rad(AZIMUTH[0] + share * (AZIMUTH[1] - AZIMUTH[0]))
    elevation = np.deg2rad(ELEVATION)
    level = np.cos(elevation)
    back = np.array([np.cos(azimuth) * level, np.sin(azimuth) * level, np.sin(elevation)])
    return CameraView(middle + DISTANCE * back, middle, FOV)


def draw_film() -> list[np.ndarray]:
    """The pictures of the run, one a tick, (height, width, 3) uint8."""
    program = find_browser()
    if program is None:
        raise SystemExit("the film needs Chromium, Chrome or Edge")
    flock = Flock(MODEL, rng=SEED)
    flock.run(FIRST)
    drawn: list[np.ndarray] = []
    fastest = 0.0
    with Browser(program) as browser:
        while flock.tick < LAST:
            now = flock.snapshot(signals=True)
            one = shot(now, look_of(now, None), fastest)
            fastest = one.made.frame.speed_scale
            browser.show(one.made.frame, one.made.look)
            drawn.append(browser.draw(SIZE, view_of(one, len(drawn) / (LAST - FIRST))))
            flock.run(1)
    return drawn


def blend_ends(pictures: list[np.ndarray]) -> list[np.ndarray]:
    """The pictures without the first `BLENDED`, into which the last ones fade."""
    body = pictures[BLENDED:]
    for k in range(BLENDED):
        weight = (k + 1) / (BLENDED + 1)
        last, first = body[k - BLENDED], pictures[k]
        body[k - BLENDED] = np.rint((1.0 - weight) * last + weight * first).astype(np.uint8)
    return body


def write_film() -> None:
    """Write `docs/flock.webp`, which plays for ever.

    Every picture is whole (`kmax`): pictures of differences alone leave squares while ends fade.
    """
    first, *others = map(Image.fromarray, blend_ends(draw_film()))
    first.save(
        FILM, save_all=True, append_images=others, duration=1000 // FPS, loop=0,
        quality=QUALITY, method=6, kmin=0, kmax=1,
    )  # fmt: skip


def write_example() -> None:
    """Run README's Python in a folder of its own, and keep the picture that it saves."""
    (code,) = re.findall(r"^```python\n(.*?)^```$", README.read_text("utf-8"), re.M | re.S)
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        exec(compile(code, str(README), "exec"), {"__name__": "__main__"})
        EXAMPLE.write_bytes(Path(EXAMPLE.name).read_bytes())
        os.chdir(HERE)


def main(only: tuple[str, ...] = ()) -> None:
    """Make `only` these, or both."""
    for name, write in (("film", write_film), ("example", write_example)):
        if not only or name in only:
            write()


if __name__ == "__main__":
    main(tuple(sys.argv[1:]))
