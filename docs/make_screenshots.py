"""Takes the pictures of the laboratory: `python docs/make_screenshots.py` (needs Chromium)."""

from __future__ import annotations

import shutil
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from playwright.sync_api import sync_playwright

from app.viewer.laboratory import Laboratory
from app.viewer.start import Start

HERE = Path(__file__).parent
ARGUMENTS = [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--ignore-gpu-blocklist",
]


def main() -> None:
    """The plane, an agent from close, and space."""
    plane = Start("hwvem", agents=250, seed=7, parameters={"eta": 0.6})
    take("laboratory.png", plane, 15.0, 45, in_layers)
    take("laboratory-agent.png", plane, 15.0, 45, from_close)
    space = Start("hwvem", agents=700, seed=3, dim=3, parameters={"eta": 0.7})
    take("laboratory-3d.png", space, 5.0, 6, in_space)


def in_layers(laboratory: Laboratory, _page: Any) -> None:
    """Colours are layers, and there are trails."""
    laboratory.view.colour.value = "layer"
    laboratory.view.trails.value = True
    laboratory.view.length.value = 30


def from_close(laboratory: Laboratory, page: Any) -> None:
    """An agent is inspected; the View tab is open."""
    laboratory.view.colour.value = "layer"
    laboratory.select(200)
    page.get_by_role("tab", name="View").click()


def in_space(_laboratory: Laboratory, page: Any) -> None:
    """Colours are headings; the Setup tab is open."""
    page.get_by_role("tab", name="Setup").click()


def take(
    name: str, start: Start, speed: float, tick: int, arrange: Callable[[Laboratory, Any], None]
) -> None:
    """Run a flock to a tick and take its picture, 1440 x 900."""
    laboratory = Laboratory(start, port=0, speed=speed, running=False)
    laboratory.simulation.ready.wait()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=ARGUMENTS
        )
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        page.goto(laboratory.address)
        page.locator(".fs-card").first.wait_for()
        page.get_by_text("Software WebGL").wait_for()
        page.locator(".mantine-Notification-closeButton").first.click()
        arrange(laboratory, page)
        laboratory.simulation.go()
        while laboratory.simulation.frame.tick < tick:
            time.sleep(0.01)
        time.sleep(1.0)
        page.screenshot(path=HERE / name)
        browser.close()
    laboratory.close()


if __name__ == "__main__":
    main()
