"""The page of a room with real cars, without a screen and without a loop."""

from __future__ import annotations

import socket
import threading
from dataclasses import replace
from typing import Any

import msgspec
import pytest
import viser
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

from agents.catalogue import cars_for_rule
from app.live.control.safety import StopReason
from app.live.laboratory.lab_file import example
from app.live.operating.flock_driver import NOT_SIMULATED
from app.live.operating.lab_choices import Choices, laboratory
from app.viewer.live.page import KEYS, LivePage
from app.viewer.live.session import Session
from tests.viewer.stub_operator import Operators, driver
from tests.viewer.test_laboratory import CAMERA
from tests.viewer.waiting import until
from worlds.input_error import InputError

UNSEEN = StopReason("unseen", "blue was last seen 0.40 s ago", "blue", holds=False)


@pytest.fixture
def operators():
    one = Operators()
    yield one
    one.gate.set()


@pytest.fixture
def serve(operators):
    """Makes pages with stub operators and closes them."""
    made = []

    def make(lab=None, ready=True) -> LivePage:
        def make_session(choices, recording) -> Session:
            return Session(choices, recording, operator=operators, driver=driver)

        page = LivePage(Choices.of(lab or example()), port=0, make_session=make_session)
        made.append(page)
        if ready:
            until(lambda: page.drawing.drawn and page.rule.controls)
        return page

    yield make
    operators.gate.set()
    for page in made:
        page.close()


class Browser:
    """A client that speaks viser's language."""

    def __init__(self, page: LivePage):
        self.page = page
        before = set(page.server.get_clients())
        self.client = connect(
            page.address.replace("http", "ws"),
            subprotocols=[f"viser-v{viser.__version__}"],
            max_size=None,
        )
        threading.Thread(target=self.read, daemon=True).start()
        self.say(**CAMERA)
        (self.number,) = until(lambda: set(page.server.get_clients()) - before)

    def read(self) -> None:
        try:
            for _ in self.client:
                pass
        except ConnectionClosed:
            pass

    def say(self, **message: Any) -> None:
        self.client.send(msgspec.msgpack.encode(message))

    def turn(self, control: Any, value: Any) -> None:
        self.say(type="GuiUpdateMessage", uuid=control._impl.uuid, updates={"value": value})

    def press(self, key: str) -> None:
        (found,) = (
            uuid
            for uuid, command in self.page.server.gui._command_handle_from_uuid.items()
            if command.hotkey == key
        )
        self.say(type="CommandTriggerMessage", uuid=found)

    def own(self, label: str) -> Any:
        """A button that only this browser has."""
        gui = self.page.server.get_clients()[self.number].gui
        return next(
            (
                one
                for one in gui._gui_input_handle_from_uuid.values()
                if getattr(one, "label", "") == label
            ),
            None,
        )

    def arm(self) -> None:
        self.turn(self.page.state.arm, True)
        arm = until(lambda: self.own("Arm"))
        self.turn(self.own("Code"), self.page.session.code.digits)
        self.turn(arm, True)
        until(lambda: self.page.session.status.arm == "armed")

    def leave(self) -> None:
        self.client.close()
        until(lambda: self.number not in self.page.server.get_clients())


def test_the_emergency_stop_is_there_before_the_room_is_open(serve, operators):
    operators.gate.clear()
    page = serve(ready=False)
    until(lambda: "Opening" in page.state.banner.content)
    browser = Browser(page)
    browser.turn(page.state.stop, True)
    until(lambda: page.session.state.latched)
    operators.gate.set()
    until(lambda: page.session.status is not None and page.session.status.arm == "emergency")
    assert operators.last.asked[0].cause == f"browser {browser.number}"
    until(lambda: page.state.reset.visible)


def test_the_stop_button_stops_when_it_goes_down(serve, operators):
    page = serve()
    browser = Browser(page)
    (rate,) = page.state.stop._hold_callback_freqs
    browser.say(type="GuiButtonHoldMessage", uuid=page.state.stop._impl.uuid, frequency=rate)
    until(lambda: operators.last.arm == "emergency")


@pytest.mark.parametrize("key", ["space", "escape"])
def test_two_keys_stop_in_every_browser(serve, operators, key):
    page = serve()
    first, second = Browser(page), Browser(page)
    first.arm()
    second.press(key)
    until(lambda: operators.last.arm == "emergency")
    assert operators.last.asked[-1].cause == f"browser {second.number}"


def test_no_other_key_reaches_the_cars(serve, operators):
    page = serve()
    browser = Browser(page)
    for key in set(KEYS) - {"space", "escape"}:
        browser.press(key)
    until(lambda: page.view.form["colour"].value == "heading")
    assert operators.last.asked == []


def test_arming_is_asked_once_more_and_only_in_that_browser(serve, operators):
    page = serve()
    first, second = Browser(page), Browser(page)
    first.turn(page.state.arm, True)
    until(lambda: first.own("Arm"))
    assert second.own("Arm") is None
    assert operators.last.asked == []
    first.turn(first.own("Cancel"), True)
    until(lambda: first.own("Arm") is None)
    first.arm()
    assert [(one.action, one.cause) for one in operators.last.asked] == [
        ("arm", f"browser {first.number}")
    ]
    until(lambda: page.state.disarm.visible and not page.state.arm.visible)


def test_the_question_is_withdrawn_by_an_emergency_stop(serve, operators):
    page = serve()
    browser = Browser(page)
    browser.turn(page.state.arm, True)
    until(lambda: browser.own("Arm"))
    yes = browser.own("Arm")
    browser.press("space")
    until(lambda: not page.state.confirming.open)
    browser.turn(yes, True)
    browser.turn(page.state.arm, True)
    browser.turn(page.view.form["fence"], False)
    until(lambda: not page.view.form["fence"].value)
    assert operators.last.actions() == ["emergency"]


def test_what_speaks_against_arming_keeps_the_button_off(serve, operators):
    page = serve()
    until(lambda: not page.state.arm.disabled)
    status = operators.last.status
    operators.last.status = lambda: replace(status(), reasons=(UNSEEN,))
    until(lambda: page.state.arm.disabled)
    browser = Browser(page)
    browser.turn(page.state.arm, True)
    browser.turn(page.view.form["fence"], False)
    until(lambda: not page.view.form["fence"].value)
    assert not page.state.confirming.open
    assert "0.40 s ago" in page.state.banner.content


def test_the_cars_stop_when_the_last_browser_that_could_stop_them_is_gone(serve, operators):
    page = serve()
    browser = Browser(page)
    browser.arm()
    browser.leave()
    until(lambda: operators.last.arm == "safe")
    assert operators.last.actions() == ["arm", "hold"]


def test_sliders_are_those_that_a_real_room_may_change(serve, operators):
    page = serve()
    offered = set(page.rule.controls)
    assert offered == set(cars_for_rule("squashing").parameters.model_fields) - set(NOT_SIMULATED)
    browser = Browser(page)
    browser.turn(page.rule.controls["beta"], 3.5)
    until(lambda: page.session.state.values["beta"] == 3.5)
    assert operators.last.tuned() == [{"beta": 3.5}]
    browser.turn(page.rule.controls["beta"], 1e9)
    until(lambda: page.session.state.values["beta"] == page.rule.controls["beta"].max)


def test_a_slider_goes_back_to_what_the_loop_has(serve, operators):
    page = serve()
    operators.last.refuses = "not now"
    Browser(page).turn(page.rule.controls["beta"], 3.5)
    until(lambda: operators.last.tuned())
    until(lambda: page.rule.controls["beta"].value == 2.0)


def test_another_rule_brings_its_own_sliders_unless_armed(serve):
    page = serve()
    browser = Browser(page)
    browser.turn(page.rule.rule, "squashing-best")
    until(lambda: page.session.state.run == 2 and page.rule.shown[0] == 2)
    assert page.session.state.model.name == "squashing-best"
    browser.arm()
    until(lambda: page.rule.rule.disabled and page.place.open.disabled)
    browser.turn(page.rule.rule, "squashing")
    browser.turn(page.view.form["fence"], False)
    until(lambda: not page.view.form["fence"].value)
    assert (page.rule.rule.value, page.session.state.run) == ("squashing-best", 2)


def test_a_source_is_chosen_and_then_opened(serve, operators):
    page = serve()
    browser = Browser(page)
    browser.turn(page.place.source, "emulated cars")
    until(lambda: page.place.changed.visible)
    assert page.session.state.run == 1
    browser.turn(page.place.open, True)
    until(lambda: page.session.state.run == 2 and page.session.state.phase == "open")
    assert page.session.state.source == "emulated cars"
    assert operators.last.lab.source == "simulated"
    until(lambda: not page.place.changed.visible)


def test_what_failed_can_be_opened_again(serve, operators):
    operators.refuses = "no frame within 5 s"
    page = serve(ready=False)
    until(lambda: page.state.again.visible)
    assert "no frame within 5 s" in page.state.banner.content
    operators.refuses = ""
    Browser(page).turn(page.state.again, True)
    until(lambda: page.state.arm.visible)


def test_simulated_cars_are_asked_for_and_clamped(serve, operators):
    page = serve()
    browser = Browser(page)
    browser.turn(page.place.companions, 3)
    until(lambda: operators.last.asked)
    browser.turn(page.place.companions, 4000)
    until(lambda: len(operators.last.asked) == 2)
    most = example().simulated.most
    assert [(one.action, one.words) for one in operators.last.asked] == [
        ("accompany", "3"),
        ("accompany", str(most)),
    ]


def test_a_busy_port_is_refused_before_anything_is_opened(serve):
    page = serve()
    with pytest.raises(InputError, match="port"):
        LivePage(laboratory(), port=page.server.get_port(), make_session=pytest.fail)


def test_a_room_that_cannot_be_made_frees_the_port():
    def make_session(_choices, _recording):
        raise InputError("it cannot be made")

    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    for _ in range(2):
        with pytest.raises(InputError, match="it cannot be made"):
            LivePage(laboratory(), port=port, make_session=make_session)
    names = {thread.name for thread in threading.enumerate()}
    assert "room" not in names


def test_closing_the_page_closes_the_operator(serve, operators):
    page = serve()
    page.close()
    assert operators.last.closed == 1
