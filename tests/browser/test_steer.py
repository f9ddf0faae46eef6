"""A person steers an agent in a real browser, by keys and by touch."""

from __future__ import annotations

import numpy as np
import pytest

from agents.kinds import Kind
from app.steering.hand_pilot import SILENCE
from app.viewer.lab.laboratory import Laboratory
from app.viewer.run.run_preset import preset_spec
from tests.browser.accessibility import find_violations
from tests.browser.window import Window, is_compiled
from tests.viewer.waiting import COMPILED, until


@pytest.fixture(scope="module")
def served():
    kinds = [Kind("robot", 1, steered=True, colour="#e03131")]
    spec = preset_spec("vem", agents=40, seed=3, parameters={"eta": 0.0}).but(kinds=kinds)
    laboratory = Laboratory(spec, port=0)
    until(lambda: is_compiled(laboratory.simulation), COMPILED)
    until(lambda: laboratory.simulation.frame is not None)
    yield laboratory
    laboratory.close()


@pytest.fixture
def hands(served):
    """The people who steer, nobody yet. A page of a busy machine is not late: the clock stands."""
    hands = served.simulation.hands
    hands.begin()
    hands.clock = lambda: 5.0
    served.select(int(np.flatnonzero(served.simulation.frame.kind == 1)[0]))
    return hands


def steer(window: Window) -> None:
    """Begin to steer the agent whose card is there."""
    window.page.locator(".fs-agent[data-steer]").wait_for(state="attached")
    window.close_notices()
    window.press("Steer this agent")
    window.page.get_by_text("You steer agent 41").wait_for()


def heading_of_robot(served) -> np.ndarray:
    """Where the one robot heads now."""
    frame = served.simulation.frame
    return frame.heading[np.flatnonzero(frame.kind == 1)[0]].copy()


def motion(hands):
    """What the one hand does."""
    return next((hand.motion for hand in list(hands.hands.values())), None)


def test_keys_steer_and_do_nothing_else(served, hands, chromium):
    window = Window(chromium.new_page(viewport={"width": 1200, "height": 700}), served)
    other = Window(chromium.new_page(viewport={"width": 1100, "height": 600}), served)
    page = window.page
    steer(window)
    until(lambda: other.page.get_by_text("Steered by hand: agent 41").count() == 1)
    assert find_violations(page) == []
    camera = next(iter(served.server.get_clients().values())).camera
    before = tuple(camera.position)
    run = served.simulation.state.run
    for key, turn in (("ArrowLeft", 1.0), ("d", -1.0), ("A", 1.0)):
        page.keyboard.down(key)
        until(lambda turn=turn: motion(hands).turn == turn)
        page.keyboard.up(key)
        until(lambda: motion(hands).turn == 0.0)
    page.keyboard.press("w")
    page.keyboard.press("s")
    assert tuple(camera.position) == before
    assert served.simulation.state.run == run
    page.keyboard.down("ArrowRight")
    until(lambda: motion(hands).turn == -1.0)
    heading = heading_of_robot(served)
    until(lambda: heading_of_robot(served) @ heading < 0.0)
    page.keyboard.press("Escape")
    until(lambda: not hands.steered)
    until(lambda: other.page.get_by_text("Steered by hand: agent").count() == 0)
    for one in (window, other):
        one.page.close()


def test_a_window_that_is_left_lets_go_and_takes_up_again(served, hands, chromium):
    window = Window(chromium.new_page(viewport={"width": 1200, "height": 700}), served)
    steer(window)
    window.page.keyboard.down("ArrowLeft")
    until(lambda: motion(hands) is not None and motion(hands).turn == 1.0)
    window.page.evaluate("window.dispatchEvent(new Event('blur'))")
    until(lambda: not hands.steered)
    window.page.get_by_text("You let go of agent 41: this window was left.").wait_for()
    window.press("Steer again")
    until(lambda: motion(hands) is not None and motion(hands).turn == 0.0)
    window.page.close()  # it cannot say that it goes
    hands.clock = lambda: 5.1 + SILENCE
    until(lambda: not hands.steered)


def test_only_one_person_steers_an_agent(served, hands, chromium):
    windows = [
        Window(chromium.new_page(viewport={"width": 1200, "height": 700}), served) for _ in "ab"
    ]
    steer(windows[0])
    windows[1].press("Steer this agent")
    words = "You let go of agent 41: somebody else steers agent 41."
    windows[1].page.get_by_text(words).wait_for()
    windows[0].press("Let go")
    until(lambda: not hands.steered)
    for window in windows:
        window.page.close()


@pytest.mark.parametrize("size", [(390, 844), (844, 390)])
def test_a_finger_on_the_stick_steers(served, hands, chromium, size):
    context = chromium.new_context(viewport={"width": size[0], "height": size[1]}, has_touch=True)
    page = context.new_page()
    page.goto(served.address)
    page.locator(".fs-agent[data-steer]").wait_for(state="attached")
    page.get_by_role("button", name="Steer this agent").tap()
    stick = page.get_by_role("img", name="Stick: drag it to steer")
    stick.wait_for()
    until(lambda: motion(hands) is not None)
    box = stick.bounding_box()
    assert find_violations(page) == []
    assert box["x"] >= 0
    assert box["x"] + box["width"] <= size[0]
    assert box["y"] + box["height"] <= size[1]
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    session = context.new_cdp_session(page)

    def touch(kind, *points):
        found = [{"x": px, "y": py} for px, py in points]
        session.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": found})

    touch("touchStart", (x, y))
    touch("touchMove", (x - 16, y))
    until(lambda: motion(hands).turn == pytest.approx(0.5, abs=0.05))
    touch("touchMove", (x + 90, y))
    until(lambda: motion(hands).turn == -1.0)
    touch("touchEnd")
    until(lambda: motion(hands).turn == 0.0)
    page.get_by_role("button", name="Let go").tap()
    until(lambda: not hands.steered)
    context.close()
