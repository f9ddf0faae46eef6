"""Two browsers that watch what a third one leads."""

from __future__ import annotations

import numpy as np
import pytest

from app.viewer.watching.watch_page import WatchPage
from tests.browser.conftest import obeyed
from tests.browser.window import Window, on_page
from tests.viewer.waiting import until

LEADS = ("Setup", "Step", "Reset", "Pause", "Go", "Undo", "Go on from here")


@pytest.fixture
def watching(laboratory):
    made = WatchPage(laboratory, "Ada")
    yield made
    made.close()


@pytest.fixture
def windows(chromium, watching):
    """A wide and a narrow one, closed again: a picture costs a core."""
    pages = [
        chromium.new_page(viewport={"width": wide, "height": tall})
        for wide, tall in ((1100, 640), (1000, 600))
    ]
    with obeyed(pages[0]), obeyed(pages[1]):
        yield [Window(page, watching) for page in pages]
    for page in pages:
        page.close()


def test_two_watch_what_a_third_leads_and_each_sees_its_own_agent(
    windows, watching, laboratory, window
):
    first, second = windows
    for one in windows:
        assert "Watching Ada's run" in one.text()
        for label in LEADS:
            assert one.page.get_by_role("button", name=label, exact=True).count() == 0
        assert one.page.locator("input[type=file]").count() == 0

    until(lambda: watching.scene.display_place(17), 60)
    first.close_notices()
    first.page.wait_for_timeout(1000)
    first.page.mouse.click(*on_page(first, watching, 0, 17))
    head = first.page.locator(".fs-agent .fs-head")
    head.wait_for(timeout=90_000)
    frame = laboratory.simulation.frame
    assert head.inner_text().startswith(f"Agent {frame.ids[17]}")
    assert second.page.locator(".fs-agent .fs-head").count() == 0
    assert window.page.locator(".fs-agent .fs-head").count() == 0

    cameras = {
        round(client.camera.image_width): client.camera
        for client in watching.server.get_clients().values()
    }
    assert len(cameras) == 2
    wide, narrow = (cameras[width] for width in sorted(cameras, reverse=True))
    before = [np.array(one.position) for one in (wide, narrow)]
    second.press("side")
    until(lambda: not np.allclose(narrow.position, before[1]), 60)
    assert np.allclose(wide.position, before[0])

    window.press("Step")
    for one in (*windows, window):
        until(lambda one=one: one.card("tick") == "1", 30, "the tick that was led")
    assert head.is_visible()
