"""Density as a browser shows it, in both themes, and single agents from near."""

from __future__ import annotations

import colorsys

import numpy as np
import pytest

from agents.flock import Flock
from app.viewer.lab.laboratory import Laboratory
from app.viewer.run.stored_flock import InMemoryFlock
from app.viewer.scene.shown import drawing_style, palette
from tests.browser.accessibility import find_violations
from tests.browser.conftest import obeyed
from tests.browser.window import Window
from tests.viewer.waiting import until

NORTH, WEST = np.array([0.0, 1.0]), np.array([-1.0, 0.0])


@pytest.fixture
def laboratory(monkeypatch):
    """Two thousand agents, of which the lower left quarter goes north, and the upper right west."""
    monkeypatch.setattr(drawing_style, "DENSITY_BEYOND", 500)
    monkeypatch.setattr(drawing_style, "SINGLES_UP_TO", 300)
    flock = Flock("vem", agents=2_000, rng=1)
    half = 0.5 * np.array(flock.world.size)
    flock.position[:] %= half
    flock.position[1_000:] += half
    flock.heading[:1_000], flock.heading[1_000:] = NORTH, WEST
    stored = InMemoryFlock(flock.spec, flock.snapshot())
    made = Laboratory(opened=stored, port=0, running=False)
    assert made.simulation.ready.wait(180)
    yield made
    made.close()


@pytest.fixture(params=["light", "dark"])
def window(request, chromium, laboratory):
    page = chromium.new_page(viewport={"width": 1000, "height": 640}, color_scheme=request.param)
    with obeyed(page):
        yield Window(page, laboratory)
    page.close()


def hue(colours: np.ndarray) -> float:
    """The middle hue of the vivid ones of some colours (N, 3), turns; nan if few are."""
    vivid = colours[np.ptp(colours, axis=1) > 50]
    if len(vivid) < 0.3 * len(colours):
        return float("nan")
    return colorsys.rgb_to_hsv(*(np.median(vivid, axis=0) / 255.0))[0]


def quarters(window: Window) -> list[float]:
    """The hues of the quarters of the world: lower left, lower right, upper left, upper right."""
    pixels = window.pixels()
    tall, wide, _ = pixels.shape
    side = int(0.7 * min(tall, wide)) // 2
    x, y = wide // 2, tall // 2
    gap = side // 4
    near, far = slice(-side, -gap), slice(gap, side)
    rows = {
        "lower": slice(y + far.start, y + far.stop),
        "upper": slice(y + near.start, y + near.stop),
    }
    columns = [slice(x + part.start, x + part.stop) for part in (near, far)]
    return [
        hue(pixels[rows[row], column].reshape(-1, 3))
        for row in ("lower", "upper")
        for column in columns
    ]


def is_hue(found: float, heading: np.ndarray) -> bool:
    """Whether a hue is that of a heading."""
    expected = colorsys.rgb_to_hsv(*palette.heading_colours(heading[None])[0])[0]
    return abs((found - expected + 0.5) % 1.0 - 0.5) < 0.09


def shows_the_quarters(window: Window) -> bool:
    lower_left, lower_right, upper_left, upper_right = quarters(window)
    nobody = np.isnan(lower_right) and np.isnan(upper_left)
    return bool(nobody and is_hue(lower_left, NORTH) and is_hue(upper_right, WEST))


def test_density_lies_where_the_agents_are_and_single_ones_appear_from_near(window, laboratory):
    window.close_notices()
    until(lambda: shows_the_quarters(window), 60, "two quarters in the hues of their headings")
    until(lambda: "Density of 2\u202f000 agents in sight" in window.text(), 60)
    until(lambda: find_violations(window.page) == [], 60, "all words to be readable")

    canvas = window.page.locator("canvas[data-engine]").bounding_box()
    x, y = canvas["x"] + 0.5 * canvas["width"], canvas["y"] + 0.5 * canvas["height"]
    window.page.mouse.move(x, y)

    def is_near() -> bool:
        window.page.mouse.wheel(0, -300)
        return "drawn one by one" in window.text()

    until(is_near, 60, "agents one by one")
    (client,) = laboratory.server.get_clients().values()
    (flock,) = laboratory.scene.in_sight(client)
    assert flock.agents is not None
    assert len(flock.agents._darts.batched_positions) < 1_000
