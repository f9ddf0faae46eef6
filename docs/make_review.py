"""Takes the page where faults of it were seen: `python docs/make_review.py` (needs Chromium).

`docs/review/` has a picture of each fault, `-before.webp`; beside it comes the page as it is now,
`-after.webp`. Names as arguments take these alone.
"""

from __future__ import annotations

import io
import math
import shutil
import sys
import time
from pathlib import Path
from typing import Any

from make_screenshots import ARGUMENTS, arm
from PIL import Image
from playwright.sync_api import sync_playwright

from agents.spec import Spec
from app.live.laboratory.lab_file import example
from app.live.operating.lab_choices import Choices
from app.viewer.gallery.scene_collection import find_scene
from app.viewer.lab.laboratory import Laboratory
from app.viewer.live.page import LivePage
from app.viewer.run.run_preset import preset_spec
from worlds.generators import generate

HERE = Path(__file__).parent / "review"
DESK, PHONE = (1440, 900), (390, 844)
SMALLER = 0.75
"""How large a picture is stored, as a share of the page."""
TIMEOUT = 180_000
"""Milliseconds for what may have to be compiled."""


class Sight:
    """A page in a browser, and the laboratory behind it."""

    def __init__(self, browser: Any, served: Any, theme: str = "light", size: Any = DESK):
        self.served = served
        self.page = browser.new_page(
            viewport={"width": size[0], "height": size[1]}, color_scheme=theme
        )
        self.page.set_default_timeout(TIMEOUT)
        self.page.goto(served.address)
        self.page.get_by_text("Software WebGL").wait_for()
        self.page.locator(".mantine-Notification-closeButton").first.click()
        self.page.locator(".fs-card").first.wait_for(state="attached")

    def keep(self, name: str) -> None:
        """Store the page as it is now."""
        self.page.wait_for_timeout(2500)
        seen = Image.open(io.BytesIO(self.page.screenshot())).convert("RGB")
        small = seen.resize((round(SMALLER * seen.width), round(SMALLER * seen.height)))
        small.save(HERE / f"{name}-after.webp", quality=82, method=6)
        print(name)
        self.page.close()


def run_to(laboratory: Laboratory, tick: int) -> None:
    """Run to a tick, and stand there."""
    laboratory.simulation.ready.wait()
    laboratory.simulation.go()
    while laboratory.simulation.frame.tick < tick:
        time.sleep(0.01)
    laboratory.simulation.pause()


def agent_card(browser: Any) -> None:
    """An agent is clicked among blocks in space."""
    laboratory = Laboratory(preset_spec("guarded", seed=1), port=0, speed=math.inf, running=False)
    run_to(laboratory, 2000)
    sight = Sight(browser, laboratory)
    sight.page.keyboard.press("f")
    sight.page.wait_for_timeout(2500)
    canvas = sight.page.locator("canvas[data-engine]").bounding_box()
    sight.page.mouse.click(canvas["x"] + canvas["width"] / 2, canvas["y"] + canvas["height"] / 2)
    sight.keep("agent-card")
    laboratory.close()


def beside(browser: Any) -> None:
    """Two models, for long."""
    spec, second = preset_spec("boundary-points", seed=3), Spec("olfati-saber")
    laboratory = Laboratory(spec, port=0, speed=math.inf, running=False, beside=second)
    run_to(laboratory, 20_000)
    Sight(browser, laboratory).keep("beside")
    Sight(browser, laboratory, size=PHONE).keep("phone")
    laboratory.close()


def dark(browser: Any) -> None:
    """A browser that asks for dark pages; then a server that goes away."""
    spec = preset_spec("hwvem", agents=100, seed=7, parameters={"eta": 0.3})
    laboratory = Laboratory(spec, port=0, running=False)
    run_to(laboratory, 140)
    Sight(browser, laboratory, "dark").keep("dark")
    sight = Sight(browser, laboratory)
    laboratory.close()
    sight.page.get_by_text("Connection lost").wait_for()
    sight.keep("dead-server")


def first_view(browser: Any) -> None:
    """A mission as it opens."""
    laboratory = Laboratory(preset_spec("hwvem-nav", seed=3), port=0, running=False)
    Sight(browser, laboratory).keep("first-view")
    laboratory.close()


def vicsek(browser: Any) -> None:
    """Five thousand agents."""
    laboratory = Laboratory(port=0, running=False, opened=find_scene("order"))
    run_to(laboratory, 800)
    Sight(browser, laboratory).keep("vicsek")
    laboratory.close()


def maze(browser: Any) -> None:
    """Boids in a maze."""
    world = generate("maze", 5, (60.0, 40.0), "solid")
    laboratory = Laboratory(preset_spec("reynolds", world=world), port=0, running=False)
    run_to(laboratory, 300)
    Sight(browser, laboratory).keep("maze")
    laboratory.close()


def room(browser: Any) -> None:
    """Emulated cars that drive, then stand by an emergency stop."""
    page = LivePage(Choices.of(example()).choosing(source="emulated cars"), port=0)
    sight = Sight(browser, page)
    arm(sight.page, page)
    sight.page.wait_for_timeout(8000)
    sight.keep("armed")
    sight = Sight(browser, page)
    sight.page.keyboard.press("Escape")
    sight.keep("stopped")
    page.close()


ROOMS = {
    "agent-card": agent_card,
    "beside": beside,
    "dark": dark,
    "first-view": first_view,
    "vicsek": vicsek,
    "maze": maze,
    "room": room,
}
"""Where faults were seen; some take two pictures."""


def main(names: tuple[str, ...]) -> None:
    """All of them, or those of these names."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=ARGUMENTS
        )
        for name in names or tuple(ROOMS):
            ROOMS[name](browser)
        browser.close()


if __name__ == "__main__":
    if set(sys.argv[1:]) - set(ROOMS):
        sys.exit(f"usage: python docs/make_review.py [{' | '.join(ROOMS)} ...]")
    main(tuple(sys.argv[1:]))
