"""Whatever a browser sends to the page: nothing is armed, no limit is exceeded, the page lives on.

The page of the example laboratory with emulated cars, an injected car in the hand, and browsers
that say what no browser of viser's would.
"""

from __future__ import annotations

import math
from contextlib import suppress

import pytest
import viser
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from msgspec.msgpack import encode
from viser import _messages as messages
from viser.infra._messages import wire_field_names
from websockets.exceptions import ConnectionClosed

from agents.models.declare import declared
from app.front.server import UNWANTED
from app.live.laboratory.lab_file import example
from app.viewer.live.page import KEYS
from tests.live.opened_page import arm, opened
from tests.live.stand_in import CAMERA, StandIn
from tests.live.waiting import until

SOON = 60.0
"""Seconds within which the page has taken in what it was sent."""
BUTTONS = (viser.GuiButtonHandle, viser.GuiButtonGroupHandle)
NUMBERS = (viser.GuiSliderHandle, viser.GuiNumberHandle)
HEARD = (
    messages.CommandTriggerMessage,
    messages.GetRenderResponseMessage,
    messages.GuiButtonHoldMessage,
    messages.GuiUpdateMessage,
    messages.SceneNodeClickMessage,
    messages.SceneNodeDragMessage,
    messages.ScenePointerMessage,
    messages.TransformControlsDragEndMessage,
    messages.TransformControlsDragStartMessage,
    messages.TransformControlsUpdateMessage,
    messages.ViewerCameraMessage,
    *UNWANTED,
)
"""What a viser server hears, and what this one does not."""
NODES = st.sampled_from(["/injected_hand", "/leader_gizmo", "/flock/cars/hulls", "/world", "/none"])
WORDS = st.sampled_from(["", "dry run", "emulated cars", "squashing", "armed", "simulated"])
NUMBER = st.one_of(
    st.floats(),
    st.integers(-(2**63), 2**63 - 1),
    st.sampled_from([0, -1, 1e308, -1e308, math.nan, math.inf, -math.inf]),
)
TEXT = st.one_of(WORDS, st.text(max_size=20), st.binary(max_size=9))
PLAIN = st.one_of(st.none(), st.booleans(), NUMBER, TEXT)
JUNK = st.one_of(
    PLAIN,
    st.lists(PLAIN, max_size=5),
    st.dictionaries(st.text(max_size=8), PLAIN, max_size=3),
)
USUAL = {
    "name": NODES,
    "owner": st.just(""),
    "wxyz": st.lists(NUMBER, min_size=4, max_size=4),
    "phase": st.sampled_from(["start", "update", "end"]),
    "event_type": st.sampled_from(["click", "rect-select"]),
    "modifier": st.none(),
    "frequency": st.just(5.0),
    "screen_pos": st.just([[0.5, 0.5], [0.6, 0.6]]),
} | dict.fromkeys(("fov", "near", "far", "image_height", "image_width"), NUMBER)
"""What is usual in some fields of messages; in others there are three numbers."""


def message(kind):
    """A message of a kind: most fields are as usual, some are junk."""
    fields = {
        name: st.one_of(*[USUAL.get(name, st.lists(NUMBER, min_size=3, max_size=3))] * 5, JUNK)
        for name in wire_field_names(kind)
    }
    return st.fixed_dictionaries(fields).map(lambda made: {"type": kind.__name__} | made)


PLENTY = settings(
    max_examples=10,
    deadline=None,
    derandomize=True,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.too_slow],
)
pytestmark = pytest.mark.filterwarnings("ignore:.*does not match annotation")


@pytest.fixture(scope="module")
def page():
    lab = example().with_values("the test", injected={"path": "hand", "speed": 1.0})
    with opened(lab) as one:
        yield one


@pytest.fixture
def witness(page):
    """A browser that behaves; the cars are safe before and after."""
    page.session.place(0.0, 0.0)
    with StandIn(page.server.get_port()) as browser:
        until(lambda: len(browser.commands) == len(KEYS), SOON)  # the page has sent these last
        yield browser
        make_safe(page, browser)


def make_safe(page, browser):
    """No emergency stop, not armed."""
    page.session.ask("disarm", "test")
    if page.session.status.arm == "emergency" or page.session.latch:
        browser.press("Reset the emergency stop")
    until(lambda: page.session.status.arm == "safe" and not page.session.latch, SOON)


def throw(page, said):
    """Say all of it, from a new browser whenever the page has had enough of one; wait until the
    page has taken it in and brought its panels up."""
    handles = page.server.gui._gui_input_handle_from_uuid
    uuid, length = next((u, one) for u, one in handles.items() if one.label == "Trail length")
    last = length.min if length.value > length.min else length.max
    browsers = []

    def say(message):
        if not browsers or browsers[-1].gone:
            browsers.append(StandIn(page.server.get_port()))
        with suppress(ConnectionClosed):
            browsers[-1].socket.send(message)

    def taken_in():
        say(encode({"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": last}}))
        return length.value == last

    for message in said:
        say(message if isinstance(message, bytes | str) else encode(message))
    until(taken_in, SOON)
    for browser in browsers:
        browser.socket.close()
    due, status = page.panels_due, page.session.status
    until(lambda: page.panels_due > due and page.session.status is not status, SOON)


def everything_is_within_its_limits(page):
    state, status, lab = page.session.state, page.session.status, page.lab
    assert state.phase == "open"
    assert state.source in page.session.chosen.sources
    assert state.link in page.session.chosen.links
    assert state.rule in page.session.chosen.rules
    for one in declared(state.model.parameters):
        value = state.values[one.name]
        if one.kind == "number":
            assert one.low <= value <= one.high, one.name
        else:
            assert value in (one.choices or (True, False)), one.name
    for car in status.cars:
        steer, throttle = car.sent
        limits = lab.cars[car.name]
        assert abs(steer) <= limits.steer
        assert -limits.reverse <= throttle <= limits.throttle
        assert car.runs or throttle == 0.0
    assert lab.area.distance_inside(status.injected.x, status.injected.y) >= -1e-9
    assert 0 <= len(status.companions) <= lab.simulated.most
    for control in page.server.gui._gui_input_handle_from_uuid.values():
        if isinstance(control, NUMBERS):
            assert control.min <= control.value <= control.max
        elif isinstance(control, viser.GuiDropdownHandle):
            assert control.value in control.options


def controls(page, *but):
    """The uuids of what can be set on the page, buttons left out."""
    found = page.server.gui._gui_input_handle_from_uuid
    return [uuid for uuid, one in found.items() if not isinstance(one, but or BUTTONS)]


def never_armed_since(page, number):
    return all(event.kind not in ("arm", "run") for event in page.session.events[number:])


@pytest.mark.usefixtures("witness")
@PLENTY
@given(junk=st.lists(JUNK, min_size=1, max_size=4))
def test_junk_for_every_control_changes_nothing_that_counts(page, junk):
    events = len(page.session.events)
    throw(
        page,
        (
            {"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": value}}
            for uuid in controls(page)
            for value in junk
        ),
    )
    everything_is_within_its_limits(page)
    assert page.session.status.arm == "safe"
    assert never_armed_since(page, events)


@pytest.mark.usefixtures("witness")
@PLENTY
@given(
    said=st.lists(st.sampled_from(HEARD).flatmap(message), min_size=5, max_size=20),
    raw=st.lists(st.one_of(st.binary(max_size=30), st.text(max_size=30)), max_size=2),
)
def test_messages_of_any_kind_arm_nothing_and_the_page_goes_on(page, said, raw):
    events = len(page.session.events)
    throw(page, [*said, *raw, {"type": "Nonsense"}, CAMERA])
    everything_is_within_its_limits(page)
    assert page.session.status.arm == "safe"
    assert never_armed_since(page, events)


@pytest.mark.usefixtures("witness")
@PLENTY
@given(place=st.one_of(JUNK, st.tuples(NUMBER, NUMBER, NUMBER), st.lists(NUMBER, max_size=4)))
def test_the_injected_car_is_dragged_no_further_than_the_fence(page, place):
    pose = {"name": "/injected_hand", "owner": ""}
    update = {"type": "TransformControlsUpdateMessage", **pose, "wxyz": [1.0, 0.0, 0.0, 0.0]}
    throw(
        page,
        [
            {"type": "TransformControlsDragStartMessage", **pose},
            update | {"position": place},
            update | {"position": [1e9, -1e9, 0.0]},
            {"type": "TransformControlsDragEndMessage", **pose},
        ],
    )
    everything_is_within_its_limits(page)
    assert page.session.status.arm == "safe"


def test_nobody_else_can_say_yes_to_the_question_of_one_browser(page, witness):
    witness.press("Arm …")
    until(lambda: witness.found("Arm"))
    events = len(page.session.events)
    throw(
        page,
        [{"type": "GuiUpdateMessage", "uuid": witness.found("Arm"), "updates": {"value": True}}],
    )
    assert never_armed_since(page, events)
    witness.press("Cancel")


def test_no_key_and_no_button_but_the_two_arms(page, witness):
    events = len(page.session.events)
    left_out = {"Open", "Open again", "Arm …"}
    for uuid, one in tuple(witness.controls.items()):
        if one["kind"] == "GuiButtonMessage" and one["label"] not in left_out:
            witness.say(type="GuiUpdateMessage", uuid=uuid, updates={"value": True})
            witness.say(type="GuiButtonHoldMessage", uuid=uuid, frequency=5.0)
    for uuid in witness.commands.values():
        witness.say(type="CommandTriggerMessage", uuid=uuid)
    until(lambda: page.session.latch and page.session.status.arm == "emergency", SOON)
    throw(page, [])
    assert never_armed_since(page, events)


@pytest.mark.parametrize("junk", [None, [1.0, 2.0]])
def test_the_cars_stop_when_the_browser_that_armed_them_is_gone(page, junk):
    page.session.place(0.0, 0.0)
    with StandIn(page.server.get_port()) as browser:
        arm(page, browser, lambda: page.session.status.arm == "armed", SOON)
        if junk:
            browser.say(
                type="TransformControlsUpdateMessage",
                name="/injected_hand",
                owner="",
                position=junk,
                wxyz=CAMERA["wxyz"],
            )
        until(lambda: page.browsers() == 1, SOON)
    until(lambda: page.session.status.arm == "safe", SOON)
    assert any(event.cause == "the last browser is gone" for event in page.session.events[-6:])


def test_a_drag_does_reach_the_injected_car(page, witness):
    pose = {"name": "/injected_hand", "owner": ""}
    witness.say(type="TransformControlsDragStartMessage", **pose)
    witness.say(
        type="TransformControlsUpdateMessage", position=[9.0, 0.1, 0.0], wxyz=CAMERA["wxyz"], **pose
    )
    witness.say(type="TransformControlsDragEndMessage", **pose)
    edge = page.lab.area.high[0] - page.lab.area.fence
    until(lambda: page.session.status.injected.x == pytest.approx(edge), SOON)


def test_junk_while_the_cars_run_keeps_them_within_their_limits(page, witness):
    seen = []
    arm(page, witness, lambda: page.session.status.arm == "armed", SOON)
    for value in (1e308, -1e308, math.nan, True, "9", None, [1.0], 0):
        said = [
            {"type": "GuiUpdateMessage", "uuid": uuid, "updates": {"value": value}}
            for uuid in controls(page)
        ]
        throw(page, said)
        everything_is_within_its_limits(page)
        seen.append(page.session.status.arm)
    assert seen[0] == "armed"
    assert set(seen) <= {"armed", "safe"}
    assert page.session.state.rule == page.lab.rule
    witness.stop()
    until(lambda: page.session.status.arm == "emergency", SOON)
