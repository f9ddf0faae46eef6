"""A browser window on the laboratory, in the words of who sits before it."""

from __future__ import annotations

import io
from contextlib import suppress
from typing import Any

import numpy as np
from PIL import Image

from app.viewer.lab.laboratory import Laboratory
from app.viewer.run.simulation import Simulation
from app.viewer.watching.watch_page import WatchPage
from tests.viewer.waiting import until


def is_compiled(simulation: Simulation) -> bool:
    """Whether what is shown is the run itself and no preview of it."""
    return not simulation.state.busy and simulation.state.compiling is None


def is_new(page: Any) -> bool:
    """Whether a page has been loaded since it was marked by `window.before = true`."""
    with suppress(Exception):  # it is being loaded
        return not page.evaluate("window.before === true")
    return False


class Window:
    """One page; waits until the laboratory is drawn in it."""

    def __init__(self, page: Any, laboratory: Laboratory | WatchPage):
        self.page = page
        page.goto(laboratory.address)
        page.locator(".fs-card").first.wait_for(timeout=90_000)
        until(self.shows_a_flock, 90, "a flock on the screen")

    def card(self, name: str) -> str:
        """What a monitor says."""
        return self.page.evaluate(
            """name => [...document.querySelectorAll('.fs-card')]
            .find(card => card.querySelector('span').textContent === name)
            ?.querySelector('b').textContent ?? ''""",
            name,
        )

    def text(self) -> str:
        """All text on the page."""
        return self.page.inner_text("body")

    def press(self, label: str) -> None:
        """Click a button."""
        self.page.get_by_role("button", name=label, exact=True).first.click()

    def tab(self, label: str) -> None:
        """Open a tab."""
        self.page.get_by_role("tab", name=label, exact=True).click()

    def number(self, control: Any) -> Any:
        """The box for the number of a slider."""
        return self.page.locator(f'[id="{control._impl.uuid}"] ~ div input')

    def box(self, control: Any) -> Any:
        """The field of a number that has no slider."""
        return self.page.locator(f'input[id="{control._impl.uuid}"]')

    def enter(self, control: Any, value: str) -> None:
        """Type a number beside a slider."""
        self.number(control).fill(value)

    def close_notices(self) -> None:
        """Close what lies over the picture and would catch the mouse."""
        notices = self.page.locator(".mantine-Notification-closeButton")
        while count := notices.count():
            notices.first.click()
            until(lambda count=count: notices.count() < count)

    def pixels(self) -> np.ndarray:
        """The picture between the panels, (height, width, 3)."""
        drawn = Image.open(io.BytesIO(self.page.screenshot())).convert("RGB")
        return np.asarray(drawn, int)[60:, 330 : drawn.width - 345]

    def shows_a_flock(self) -> bool:
        """Whether there are agents: some pixels are saturated, and most are not."""
        picture = self.pixels()
        vivid = np.mean(picture.max(axis=2) - picture.min(axis=2) > 90)
        return bool(0.003 < vivid < 0.4)


def on_page(window: Window, page: Any, side: int, row: int) -> tuple[float, float]:
    """Where in a window an agent of a laboratory or a watching page is, seen from above."""
    box = window.page.evaluate(
        """() => { const boxes = [...document.querySelectorAll('canvas')].map(
            canvas => canvas.getBoundingClientRect());
        const box = boxes.reduce((a, b) => b.width * b.height > a.width * a.height ? b : a);
        return [box.left, box.top, box.width, box.height]; }"""
    )
    clients = page.server.get_clients().values()
    camera = next(one.camera for one in clients if abs(one.camera.image_width - box[2]) < 3)
    shown, aside = page.scene._sights[side]
    away = shown.at[row] + aside - camera.look_at
    pixels = 0.5 * box[3] / (np.tan(0.5 * camera.fov) * camera.position[2])
    return box[0] + 0.5 * box[2] + pixels * away[0], box[1] + 0.5 * box[3] - pixels * away[1]
