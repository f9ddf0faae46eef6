"""Takes pictures of the page for its review: `python docs/make_looks.py FOLDER` (needs Chromium).

Each scene at four widths in the light and in the dark theme, and one sheet of them all. Names of
scenes after the folder take these alone.
"""

from __future__ import annotations

import shutil
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from make_screenshots import ARGUMENTS
from PIL import Image
from playwright.sync_api import sync_playwright

from agents.spec import Spec
from app.live.laboratory.lab_file import example
from app.live.operating.lab_choices import Choices
from app.viewer.lab.laboratory import Laboratory
from app.viewer.live.page import LivePage
from app.viewer.run.run_preset import preset_spec

SIZES = ((390, 844), (1100, 700), (1440, 900), (1920, 1080))
THEMES = ("light", "dark")
HIGH = 320
"""Height of a picture on the sheet, pixels."""


@contextmanager
def flock(spec: Spec, tick: int) -> Iterator[str]:
    """A flock that stands at a tick; the address of its page."""
    laboratory = Laboratory(spec, port=0, speed=1000.0, running=False)
    laboratory.simulation.ready.wait()
    laboratory.simulation.go()
    while laboratory.simulation.frame.tick < tick:
        time.sleep(0.01)
    laboratory.simulation.pause()
    yield laboratory.address
    laboratory.close()


@contextmanager
def room() -> Iterator[str]:
    """Emulated cars; the address of their page."""
    page = LivePage(Choices.of(example()).choosing(source="emulated cars"), port=0)
    yield page.address
    page.close()


def as_it_opens(_page: Any) -> None:
    """Nothing is chosen."""


def presenting(page: Any) -> None:
    """The panels are hidden and the text is large."""
    page.keyboard.press("x")
    page.keyboard.press("p")
    page.keyboard.press("p")
    page.wait_for_function(
        "() => document.querySelector('canvas[data-engine]').clientWidth === innerWidth"
    )


def large(page: Any) -> None:
    """The text is large."""
    page.keyboard.press("x")


def tab(name: str) -> Callable[[Any], None]:
    """A tab is open."""
    return lambda page: page.get_by_role("tab", name=name, exact=True).click()


PLANE = preset_spec("hwvem", agents=250, seed=7, parameters={"eta": 0.6})
SPACE = preset_spec("hwvem", agents=700, seed=3, dim=3, parameters={"eta": 0.7})
SCENES: dict[str, tuple[Callable[[], Any], Callable[[Any], None]]] = {
    "plane": (lambda: flock(PLANE, 45), as_it_opens),
    "setup": (lambda: flock(PLANE, 45), tab("Setup")),
    "view": (lambda: flock(PLANE, 45), tab("View")),
    "large": (lambda: flock(PLANE, 45), large),
    "presenting": (lambda: flock(SPACE, 40), presenting),
    "space": (lambda: flock(SPACE, 40), as_it_opens),
    "cars": (room, as_it_opens),
}
"""Name -> what is served, and what is done in the page."""


def take(browser: Any, address: str, arrange: Callable[[Any], None], stem: Path) -> list[Path]:
    """One scene at all sizes and in all themes."""
    made = []
    for theme in THEMES:
        for width, height in SIZES:
            page = browser.new_page(viewport={"width": width, "height": height}, color_scheme=theme)
            page.goto(address)
            page.locator(".fs-card").first.wait_for(state="attached", timeout=90_000)
            page.get_by_text("Software WebGL").wait_for(timeout=90_000)
            page.locator(".mantine-Notification-closeButton").first.click()
            arrange(page)
            page.wait_for_timeout(2500)
            made.append(stem.with_name(f"{stem.name}-{theme}-{width}.png"))
            page.screenshot(path=made[-1])
            page.close()
    return made


def sheet(pictures: list[Path], into: Path) -> None:
    """All pictures, small, a row for each theme of a scene."""
    small = []
    for path in pictures:
        with Image.open(path) as picture:
            wide = round(picture.width * HIGH / picture.height)
            small.append(picture.convert("RGB").resize((wide, HIGH)))
    rows = [small[at : at + len(SIZES)] for at in range(0, len(small), len(SIZES))]
    width = max(sum(one.width for one in row) for row in rows)
    made = Image.new("RGB", (width, HIGH * len(rows)), "#808080")
    for down, row in enumerate(rows):
        left = 0
        for one in row:
            made.paste(one, (left, HIGH * down))
            left += one.width
    made.save(into)


def main(folder: Path, only: tuple[str, ...] = ()) -> None:
    """All scenes, or `only` these, into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    pictures = []
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=ARGUMENTS
        )
        for name, (served, arrange) in SCENES.items():
            if not only or name in only:
                with served() as address:
                    pictures += take(browser, address, arrange, folder / name)
        browser.close()
    sheet(pictures, folder / "sheet.png")


if __name__ == "__main__":
    if len(sys.argv) < 2 or set(sys.argv[2:]) - set(SCENES):
        sys.exit(f"usage: python docs/make_looks.py FOLDER [{' | '.join(SCENES)} ...]")
    main(Path(sys.argv[1]), tuple(sys.argv[2:]))
