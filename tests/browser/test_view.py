"""The buttons that turn the camera, and the card of an agent beside it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from tests.browser.conftest import obeyed
from tests.browser.window import Window
from tests.viewer.waiting import until

FRAMES = """() => new Promise((done) => {
  let left = 20;
  const next = () => left-- ? requestAnimationFrame(next) : done();
  next();
})"""
"""Waits until a page has drawn some pictures, however long it takes for one."""
CARD = "[data-floating-window]:has(.fs-agent)"


def client_of(laboratory, known):
    """The browser that has come since."""
    (number,) = until(lambda: set(laboratory.server.get_clients()) - known, 60)
    return laboratory.server.get_clients()[number]


def on_page(page, laboratory, client, row) -> tuple[float, float]:
    """Where a browser shows an agent, pixels."""
    camera, canvas = client.camera, page.locator("canvas[data-engine]").bounding_box()
    away = np.array(laboratory.scene.display_place(row)) - camera.position
    ahead = camera.look_at - camera.position
    ahead = ahead / np.linalg.norm(ahead)
    right = np.cross(ahead, camera.up_direction)
    right = right / np.linalg.norm(right)
    down = np.cross(ahead, right)
    scale = 0.5 * canvas["height"] / np.tan(0.5 * camera.fov) / (away @ ahead)
    return (
        canvas["x"] + 0.5 * canvas["width"] + scale * (away @ right),
        canvas["y"] + 0.5 * canvas["height"] + scale * (away @ down),
    )


def in_sight(page, place) -> bool:
    """Whether nothing lies over the picture there; notices, which may come late, are closed."""
    Window.close_notices(SimpleNamespace(page=page))
    return page.evaluate("([x, y]) => document.elementFromPoint(x, y)?.matches('canvas')", place)


def settle(page, client) -> None:
    """Wait until the picture has its shape and its camera stands: a page is laid out in steps.

    Its size in pixels is no sign: a page that draws too slowly draws fewer of them.
    """
    canvas = page.locator("canvas[data-engine]")

    def state():
        box, camera = canvas.bounding_box(), client.camera
        shape = camera.image_width / camera.image_height
        return box["width"] / box["height"], shape, *camera.position, *camera.look_at

    def stands() -> bool:
        before = state()
        page.evaluate(FRAMES)
        after = state()
        return after[0] == pytest.approx(after[1], rel=0.01) and after == pytest.approx(before)

    until(stands, 60, "a picture that stands")


@pytest.fixture(params=[(1100, 700), (390, 844)], ids=["wide", "phone"])
def own(request, chromium, laboratory, window):
    """A page beside the window, and its browser as the laboratory knows it."""
    assert window.page.is_visible("canvas")
    width, height = request.param
    known = set(laboratory.server.get_clients())
    page = chromium.new_page(viewport={"width": width, "height": height})
    try:
        with obeyed(page):
            page.goto(laboratory.address)
            page.locator(".fs-card").first.wait_for(state="attached", timeout=90_000)
            client = client_of(laboratory, known)
            until(lambda: client.camera.image_width > 0, 60)
            settle(page, client)
            Window.close_notices(SimpleNamespace(page=page))
            yield page, client
        laboratory.select(None)
    finally:
        page.close()
    until(lambda: client.client_id not in laboratory.server.get_clients(), 60)


def tilt(client) -> float:
    """How steeply a camera looks down, rad."""
    away = client.camera.position - client.camera.look_at
    return float(np.arcsin(away[2] / np.linalg.norm(away)))


def test_the_buttons_on_the_picture_turn_this_browser_s_camera(own, laboratory):
    page, client = own
    other = next(one for one in laboratory.server.get_clients().values() if one != client)
    until(lambda: tilt(other) > 1.5, 30, "the other, seen from above")
    before = tilt(other)
    for label, low, high in (
        ("Camera: side (key 3)", 0.1, 0.4),
        ("Camera: perspective (key 2)", 0.6, 0.9),
        ("Camera: top-down (key 1)", 1.5, 1.6),
    ):
        button = page.get_by_role("button", name=label, exact=True)
        assert button.get_attribute("title") == label
        button.click()
        until(lambda low=low, high=high: low < tilt(client) < high, 30, label)
    page.get_by_label("Camera: side (key 3)").focus()
    page.keyboard.press("Enter")
    until(lambda: tilt(client) < 0.4, 30, "the side by the keyboard")
    page.keyboard.press("p")
    page.keyboard.press("p")
    page.get_by_label("Camera: perspective (key 2)").click()
    until(lambda: tilt(client) > 0.6, 30, "while the panels are hidden")
    page.keyboard.press("p")
    assert tilt(other) == pytest.approx(before)


def test_the_buttons_turn_it_after_a_list_had_the_focus(window, laboratory):
    page = window.page
    client = list(laboratory.server.get_clients().values())[-1]
    window.tab("View")
    page.get_by_label("Trail", exact=True).focus()
    page.get_by_label("Camera: perspective (key 2)").click()
    until(lambda: tilt(client) < 1.2, 60, "perspective")
    page.get_by_label("Camera: top-down (key 1)").click()
    until(lambda: tilt(client) > 1.5, 60, "top-down")
    window.tab("Rule")


def test_the_card_opens_beside_the_clicked_agent_and_never_over_it(own, laboratory):
    page, client = own
    frame = laboratory.simulation.frame
    middle = int(np.argmin(np.linalg.norm(frame.position - frame.size / 2, axis=1)))
    edge = int(np.argmax(frame.position[:, 0]))
    for row in (middle, edge):
        laboratory.select(None)
        page.locator(".fs-agent").wait_for(state="detached")
        settle(page, client)
        until(lambda row=row: in_sight(page, on_page(page, laboratory, client, row)))
        page.mouse.click(*on_page(page, laboratory, client, row))
        until(lambda: laboratory.selected is not None, 60, "an agent that is clicked")
        page.get_by_text(f"Agent {frame.ids[laboratory.selected]}").wait_for(timeout=60_000)
        page.wait_for_timeout(1000)
        assert in_sight(page, on_page(page, laboratory, client, laboratory.selected))
        card = page.locator(".fs-agent").bounding_box()
        canvas = page.locator("canvas[data-engine]").bounding_box()
        assert card["width"] > 200
        if page.viewport_size["width"] > 600:
            window = page.locator(CARD).bounding_box()
            assert canvas["x"] <= window["x"]
            assert window["x"] + window["width"] <= canvas["x"] + canvas["width"]
            assert window["y"] + window["height"] <= canvas["y"] + canvas["height"]
        else:
            assert card["y"] >= canvas["y"] + canvas["height"]
            assert card["y"] + card["height"] <= page.viewport_size["height"]


def test_the_card_moves_aside_for_its_agent_but_not_for_the_hand_that_put_it_there(own, laboratory):
    page, client = own
    if page.viewport_size["width"] < 600:
        pytest.skip("a sheet below the picture needs not move")
    laboratory.select(5)
    window = page.locator(CARD)
    window.wait_for()
    page.wait_for_timeout(2000)

    def covered() -> bool:
        box = window.bounding_box()
        x, y = on_page(page, laboratory, client, 5)
        across, along = x - box["x"], y - box["y"]
        return 0 < across < box["width"] and 0 < along < box["height"]

    box = window.bounding_box()
    x, y = on_page(page, laboratory, client, 5)
    shift = (box["x"] + 0.5 * box["width"] - x, box["y"] + 0.5 * box["height"] - y)
    away = np.linalg.norm(client.camera.position - client.camera.look_at)
    canvas = page.locator("canvas[data-engine]").bounding_box()
    unit = 2.0 * away * np.tan(0.5 * client.camera.fov) / canvas["height"]
    step = np.array([-shift[0] * unit, shift[1] * unit, 0.0])
    client.camera.position, client.camera.look_at = (
        client.camera.position + step,
        client.camera.look_at + step,
    )
    until(lambda: not covered() and window.bounding_box() != box, 10, "a card that moves aside")

    page.wait_for_timeout(500)
    box = window.bounding_box()
    x, y = on_page(page, laboratory, client, 5)
    grip = (box["x"] + 0.5 * box["width"], box["y"] + 6)
    page.mouse.move(*grip)
    page.mouse.down()
    page.mouse.move(x, y - 40, steps=8)
    page.mouse.up()
    page.wait_for_timeout(2500)
    assert covered()


def test_what_is_unfolded_stays_so_while_the_flock_runs(window, laboratory):
    page = window.page
    laboratory.select(5)
    page.get_by_text("Listens to").wait_for(timeout=60_000)
    shares = page.get_by_text(" %", exact=False).locator("visible=true")
    assert shares.count() == 0
    page.get_by_text("Listens to").click()
    until(lambda: shares.count() > 0, 10, "whom it listens to")
    words = page.locator(".fs-agent").inner_text()
    laboratory.simulation.go()
    until(lambda: page.locator(".fs-agent").inner_text() != words, 20, "a row that changes")
    page.wait_for_timeout(2000)
    assert shares.count() > 0
    laboratory.simulation.pause()
    window.press("Close")
