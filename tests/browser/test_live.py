"""Emulated cars as a browser shows and drives them."""

from __future__ import annotations

import csv
import threading
from contextlib import suppress

import numpy as np
import pytest
from playwright.sync_api import TimeoutError as PlaywrightTimeout

from app.live.laboratory.lab_file import EXAMPLE_FILE, lab_from_toml
from app.live.operating.lab_choices import Choices
from app.viewer.live.page import LivePage
from tests.browser.accessibility import find_violations, find_violations_on_tabs
from tests.browser.conftest import obeyed
from tests.viewer.waiting import until

EMULATED = "emulated cars"
OPENS = 180.0
"""Seconds that the room may take to open: the rule may have to be compiled."""
SOON = 60.0
"""Seconds for what is done at once, on a busy machine."""


def patient() -> str:
    """The example with slow cars and one simulated one, which bears a machine that is busy."""
    text = (
        EXAMPLE_FILE.read_text()
        .replace("speed = 1.0", "speed = 0.5")
        .replace("fence = 0.5", "fence = 0.7")
    )
    limits = "stale = 0.25\nlong_gap = 10.0\nfrozen = 1.2\nunattended = 30.0\n"
    return f"{text}\n[limits]\n{limits}[simulated]\ncars = 1\n"


@pytest.fixture(scope="module")
def room_page(chromium):
    """A room with emulated cars and one simulated one."""
    assert chromium.is_connected()
    lab = lab_from_toml(patient(), "the test")
    page = LivePage(Choices.of(lab).choosing(source=EMULATED), port=0)
    yield page
    page.close()


class Operator:
    """A person at a browser."""

    def __init__(self, chromium, room_page):
        self.code = room_page.session.code.digits
        self.page = chromium.new_page(viewport={"width": 1000, "height": 600})
        self.page.goto(room_page.address)
        self.page.locator(".fs-banner").wait_for(timeout=1000 * OPENS)

    def sees(self, kind: str, seconds: float = SOON) -> None:
        """Wait until the banner is of a kind."""
        self.page.locator(f".fs-banner.fs-{kind}").wait_for(timeout=1000 * seconds)

    def press(self, label: str) -> None:
        """Click a button."""
        button = self.page.get_by_role("button", name=label, exact=True)
        button.click(timeout=1000 * SOON)

    def enter_code(self, code: str) -> None:
        """Type a code as a person does: viser's client sends at most 20 changes a second."""
        self.page.locator(".mantine-Modal-body input").first.fill(code, timeout=1000 * SOON)
        self.page.wait_for_timeout(100)

    def arm(self) -> None:
        """Arm, and say yes; again where something has come between, as a late second stop does."""
        for _ in range(3):
            with suppress(AssertionError, PlaywrightTimeout):
                if self.page.locator(".fs-banner.fs-emergency").is_visible():
                    self.press("Reset the emergency stop")
                self.press("Arm …")
                self.enter_code(self.code)
                self.press("Arm")
                return until(self.runs, SOON / 2, "running cars")
        return self.sees("running")

    def runs(self) -> bool:
        """Whether the banner says that the cars run."""
        return self.page.locator(".fs-banner.fs-running").is_visible()

    def table(self) -> dict[str, list[str]]:
        """The table of cars, name -> cells."""
        rows = self.page.evaluate(
            """() => [...document.querySelectorAll('.fs-cars tr')].map(
                row => [...row.querySelectorAll('td')].map(cell => cell.textContent))"""
        )
        return {row[0]: row[1:] for row in rows if row}


@pytest.fixture(scope="module")
def browser(chromium, room_page):
    """One browser at the room."""
    one = Operator(chromium, room_page)
    with obeyed(one.page):
        yield one
    one.page.close()


@pytest.fixture
def operator(browser, room_page):
    """Somebody at that browser, with the room safe and ready to be armed."""
    room = room_page.session
    until(lambda: room.status is not None or room.state.phase == "failed", OPENS)
    assert room.state.phase == "open", room.state.trouble
    room.emergency("test")
    until(lambda: room.status.arm == "emergency", SOON)

    def safe() -> bool:
        """Whether the page says so; a second stop that comes late is reset too."""
        if room.status.arm == "emergency":
            room.ask("reset", "test")
            until(lambda: room.status.arm != "emergency", SOON)
        return browser.page.locator(".fs-banner.fs-safe").is_visible()

    until(safe, 3 * SOON)
    until(lambda: not room_page.state.arm.disabled, OPENS)
    yield browser
    print("the room's events, shown where a test fails:", *room.events, sep="\n")


def places(room) -> np.ndarray:
    return np.array([(car.pose.x, car.pose.y) for car in room.status.cars])


def test_cars_are_armed_run_and_are_stopped_by_a_key_in_every_browser(
    chromium, operator, room_page
):
    first, second = operator, Operator(chromium, room_page)
    room = room_page.session
    before = places(room)
    until(lambda: {"red", "blue", "sim 1"} <= set(first.table()), SOON)

    def drives() -> bool:
        """Whether both browsers show cars that drive; armed again where a pause stopped them."""
        if not first.runs():
            first.arm()
        moved = np.linalg.norm(places(room) - before, axis=1) > 0.2
        speeds = [float(second.table()[name][1]) for name in ("red", "blue")]
        return moved.any() and second.runs() and max(speeds) > 0.2

    until(drives, 3 * SOON)

    second.page.keyboard.press("Space")
    first.sees("emergency")
    second.sees("emergency")
    stopped = room.events[-1]
    assert any(one.kind == "emergency" and "browser" in one.cause for one in room.events), stopped
    until(lambda: max(float(row[1]) for row in first.table().values()) < 0.05, SOON)

    first.press("Reset the emergency stop")
    second.sees("safe")
    assert room.status.arm == "safe"
    second.page.close()


def test_everybody_can_use_the_page_in_both_themes_and_the_stop_is_never_hidden(operator):
    page = operator.page
    until(lambda: "red" in operator.table(), SOON)
    for theme in ("light", "dark"):
        assert page.locator("html").get_attribute("data-theme") == theme
        assert find_violations_on_tabs(page) == []
        operator.press("Arm …")
        page.locator(".mantine-Modal-body input").first.wait_for()
        assert find_violations(page) == []
        page.get_by_role("button", name="Cancel", exact=True).click()
        page.locator(".mantine-Modal-body input").first.wait_for(state="detached")
        page.keyboard.press("m")
    for _ in ("the plots alone", "nothing"):
        page.keyboard.press("p")
        assert not page.locator(".fs-banner").is_visible()
        assert page.locator(".fs-stop").is_visible()
    page.locator(".fs-stop").click()
    page.keyboard.press("p")
    operator.sees("emergency")
    page.get_by_role("alert").get_by_text("EMERGENCY STOP ·").wait_for()
    assert find_violations(page) == []


@pytest.mark.parametrize("key", ["Space", "Escape", "Shift+Space"])
def test_the_keys_stop_even_while_a_number_is_being_typed(operator, room_page, key):
    first = operator
    first.arm()
    box = first.page.locator(f'[id="{room_page.rule.controls["C"]._impl.uuid}"] ~ div input')
    box.click()
    first.page.keyboard.press(key)
    first.sees("emergency")
    assert room_page.session.state.values["C"] == 0.7


@pytest.fixture
def standing(room_page, browser):
    """Has viser's thread stand still, when called, until the test is over.

    Then comes what the page has sent meanwhile: the stop's other way, which may not meet a reset.
    """
    go_on = threading.Event()

    def stand() -> None:
        stands = threading.Event()
        loop = room_page.server._event_loop
        loop.call_soon_threadsafe(lambda: (stands.set(), go_on.wait(3 * SOON)))
        assert stands.wait(SOON)

    yield stand
    go_on.set()
    browser.page.wait_for_timeout(3000)


@pytest.mark.parametrize("way", ["key", "button"])
def test_key_and_button_stop_the_cars_while_visers_thread_stands_still(
    operator, room_page, standing, way
):
    first, room = operator, room_page.session
    first.arm()
    standing()
    if way == "key":
        first.page.keyboard.press("Space")
    else:
        first.press("EMERGENCY STOP")
    until(lambda: room.status.arm == "emergency", SOON)
    causes = [one.cause for one in room.events if one.kind == "emergency"]
    assert causes[-1] == "browser at 127.0.0.1"


def test_the_key_does_not_press_the_button_that_was_pressed_last(operator, room_page):
    first = operator
    first.press("Arm …")
    first.page.get_by_role("button", name="Arm", exact=True).focus()
    first.page.keyboard.press("Space")
    first.sees("emergency")
    first.page.wait_for_timeout(500)
    assert first.page.locator(".fs-question").count() == 0
    assert room_page.session.status.arm == "emergency"
    assert not [one for one in room_page.session.events[-3:] if one.asked == "arm"]


def test_the_stop_stays_in_view_however_far_one_scrolls(operator):
    first = operator
    stop = first.page.get_by_role("button", name="EMERGENCY STOP", exact=True)
    first.page.get_by_text("Body: Car").wait_for(timeout=1000 * SOON)
    top = stop.bounding_box()["y"]
    stop.hover()
    first.page.mouse.wheel(0, 4000)
    until(lambda: not in_view(first.page.get_by_label("Rule", exact=True).first), SOON)
    box = stop.bounding_box()
    assert box["y"] == pytest.approx(top, abs=20)
    stop.click()
    first.sees("emergency")


def in_view(thing) -> bool:
    box = thing.bounding_box()
    return box is not None and box["y"] > 0


def test_the_log_is_shown_and_downloaded(operator, tmp_path):
    first = operator
    first.page.get_by_role("tab", name="Log", exact=True).click()
    first.page.locator(".fs-log").wait_for(timeout=1000 * SOON)
    with first.page.expect_download() as download:
        first.press("Download all (CSV)")
    file = tmp_path / "events.csv"
    download.value.save_as(file)
    rows = list(csv.DictReader(file.open()))
    assert {"room", "emergency"} <= {row["kind"] for row in rows}
