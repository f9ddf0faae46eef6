"""What a page does when its server is away, and what of viser's own cannot be reached in it."""

from __future__ import annotations

import numpy as np
import pytest

from app.front.server import admit_browsers, close_server, open_server
from app.viewer.panels.shell import set_look
from tests.browser.window import is_new
from tests.viewer.waiting import until

AWAY = (5.0, 30.0, 150.0)
"""Seconds for which servers are away, by the clocks of their pages, which the test moves."""
STEP = 2.5
"""Seconds of a page between two looks of the test."""
LOST = "Connection lost, trying again"


def opened(port: int = 0):
    """A server whose page is a button."""
    server = open_server(port=port)
    set_look(server.gui, "flockscope")
    server.gui.add_button("Here")
    admit_browsers(server)
    return server


def said(page) -> float:
    """For how many seconds a page says that its server is away."""
    return float(page.locator(".fs-lost span").inner_text().split()[1])


def test_a_page_says_that_its_server_is_away_and_is_loaded_again_however_long_that_was(chromium):
    servers = [opened() for _ in AWAY]
    ports = [server.get_port() for server in servers]
    pages = [chromium.new_page() for _ in AWAY]
    for page, port in zip(pages, ports, strict=True):
        page.clock.install()
        page.goto(f"http://127.0.0.1:{port}/")
        page.get_by_role("button", name="Here").wait_for(timeout=60_000)
        page.wait_for_timeout(500)
        assert page.get_by_text(LOST).count() == 0
    for server in servers:
        close_server(server)
    for page in pages:
        page.get_by_text(LOST).wait_for(timeout=60_000)
        page.evaluate("window.before = true")
    try:
        servers = []
        for page, port, away in zip(pages, ports, AWAY, strict=True):
            for _ in range(round(away / STEP)):
                page.clock.run_for(1000 * STEP)
            assert page.get_by_text(LOST).is_visible()
            until(lambda page=page, away=away: said(page) >= away, 60, "how long it was away")
            assert said(page) < away + 60.0
            servers.append(opened(port))
            until(lambda page=page: is_new(page), 60, "a new page")
            page.get_by_role("button", name="Here").wait_for(timeout=60_000)
            until(lambda page=page: page.get_by_text(LOST).count() == 0, 60)
            page.close()
    finally:
        for server in servers:
            close_server(server)


def test_the_settings_of_viser_are_out_of_reach(window):
    assert window.page.locator(".tabler-icon-adjustments").count() == 1
    assert not window.page.locator(".tabler-icon-adjustments").is_visible()
    fields = window.page.locator("input").all()
    assert not any("ws://" in field.input_value() for field in fields if field.is_visible())


def test_keys_act_again_after_a_choice_from_a_list(window, laboratory):
    window.tab("View")
    window.page.get_by_label("Colour by", exact=True).click()
    window.page.get_by_role("option", name="speed", exact=True).click()
    window.page.wait_for_timeout(300)
    window.page.keyboard.press("t")
    until(lambda: laboratory.simulation.frame.tick == 1, 10, "a tick by a key")
    window.page.get_by_label("Colour by", exact=True).click()
    window.page.keyboard.press("ArrowUp")
    window.page.keyboard.press("Enter")
    window.page.wait_for_timeout(300)
    window.page.keyboard.press("t")
    until(lambda: laboratory.simulation.frame.tick == 2, 10, "another")
    laboratory.view.form["colour"].value = "heading"
    window.tab("Rule")


@pytest.mark.parametrize("way", ["escape", "beside", "button"])
def test_the_guide_is_closed_by_escape_a_click_beside_it_and_its_button(window, way):
    window.page.keyboard.press("h")
    guide = window.page.locator(".fs-page").first
    guide.wait_for()
    if way == "escape":
        window.page.keyboard.press("Escape")
    elif way == "beside":
        window.page.mouse.click(20, 300)
    else:
        window.page.get_by_role("button", name="Close").click()
    until(lambda: window.page.locator(".fs-page").count() == 0, 10, "the guide to be closed")


def corners_in_view(laboratory, client) -> np.ndarray:
    """Where the corners of the world's box are in the picture, (K, 2), within [-1, 1] if seen."""
    stage, camera = laboratory.scene._sights[0].picture.stage, client.camera
    ahead = camera.look_at - camera.position
    ahead = ahead / np.linalg.norm(ahead)
    right = np.cross(ahead, camera.up_direction)
    right = right / np.linalg.norm(right)
    up = np.cross(right, ahead)
    seen = np.array([(x, y, 0.0) for x in (-1, 1) for y in (-1, 1)]) * stage.half - camera.position
    depth = np.tan(0.5 * camera.fov) * (seen @ ahead)
    aspect = camera.image_width / camera.image_height
    return np.stack([seen @ right / depth / aspect, seen @ up / depth], axis=1)


def test_the_camera_shows_the_whole_at_every_size_until_somebody_moves_it(chromium, laboratory):
    page = chromium.new_page(viewport={"width": 1440, "height": 900})
    known = set(laboratory.server.get_clients())
    page.goto(laboratory.address)
    page.locator(".fs-card").first.wait_for(timeout=60_000)
    until(lambda: set(laboratory.server.get_clients()) - known, 60)
    (number,) = set(laboratory.server.get_clients()) - known
    client = laboratory.server.get_clients()[number]

    def fits() -> bool:
        most = np.abs(corners_in_view(laboratory, client)).max(axis=0)
        return bool(0.7 < most.max() <= 1.0)

    for width, height in ((1440, 900), (1100, 700), (1920, 1080), (390, 844), (1100, 700)):
        page.set_viewport_size({"width": width, "height": height})
        page.wait_for_timeout(1500)
        until(fits, 20, f"the whole at {width} x {height}")
    page.wait_for_timeout(1500)
    page.mouse.move(550, 400)
    page.mouse.wheel(0, -400)
    page.wait_for_timeout(1500)
    place = client.camera.position.copy()
    page.set_viewport_size({"width": 1440, "height": 900})
    page.wait_for_timeout(2500)
    np.testing.assert_allclose(client.camera.position, place, atol=1e-3)
    page.close()
