"""The watching page without a screen: what all see, and what each browser has alone."""

from __future__ import annotations

import threading
from dataclasses import replace

import numpy as np
import pytest

from agents.observables.catalogue import OBSERVABLES
from app.viewer.lab.laboratory import Laboratory
from app.viewer.lab.scene_requests import GALLERY, OPEN, TAKE
from app.viewer.measuring.observable_format import QUICK
from app.viewer.run.frame_builder import FrameBuilder, FrameRequest, WatchPageRequest
from app.viewer.run.run_preset import preset_spec
from app.viewer.watching.watch_page import LOOKED_AT, WatchPage, standing, values
from app.viewer.watching.watcher import ALWAYS, MOST, AgentSelection, measured_for_all
from tests.live.stand_in import StandIn
from tests.viewer.http_client import ask
from tests.viewer.stub_flock import StubFlock
from tests.viewer.waiting import until

START = preset_spec("hwvem", agents=30, seed=2)


@pytest.fixture(scope="module")
def laboratory():
    made = Laboratory(START, port=0, running=False)
    assert made.simulation.ready.wait(180)
    until(lambda: made.parameters.controls)
    yield made
    made.close()


@pytest.fixture(scope="module")
def page(laboratory):
    made = WatchPage(laboratory, "Ada <script>")
    yield made
    made.close()


@pytest.fixture
def browsers(page):
    """Two that watch, as the page knows them, in order."""
    with StandIn(page.port) as first:
        until(lambda: len(page.watchers) == 1)
        with StandIn(page.port) as second:
            until(lambda: len(page.watchers) == 2)
            until(lambda: all(plotted(one) not in ("", "nothing") for one in (first, second)))
            own = [page.watchers[number] for number in sorted(page.watchers)]
            yield (first, own[0]), (second, own[1])
    until(lambda: not page.watchers and page.drawing is None)


def plotted(browser: StandIn) -> str:
    """What a browser's first chart shows; empty if it is not there yet."""
    return browser.controls.get(browser.found("Plot 1"), {}).get("value", "")


def click(browser: StandIn, page: WatchPage, row: int) -> None:
    """Click on an agent, from straight above."""
    x, y, _ = until(lambda: page.scene.display_place(row))
    browser.say(
        type="ScenePointerMessage",
        event_type="click",
        ray_origin=[x, y, 30.0],
        ray_direction=[0.0, 0.0, -1.0],
        screen_pos=[[0.5, 0.5]],
        modifier=None,
    )


def card(browser: StandIn) -> str:
    """What a browser is told of an agent; empty if it sees no card."""
    panels = [one for one in browser.controls.values() if one["kind"] == "GuiPanelMessage"]
    if not any(list(one["_tab_labels"]) == ["Agent"] and one["visible"] for one in panels):
        return ""
    texts = [str(one.get("content")) for one in browser.controls.values()]
    return next((text for text in texts if "fs-agent" in text), "")


def test_what_all_see_has_no_control(page):
    assert page.server.gui._gui_input_handle_from_uuid == {}


def test_nothing_is_drawn_while_nobody_watches(page, laboratory):
    def drawing() -> int:
        return sum(one.name == "drawing" for one in threading.enumerate())

    assert page.drawing is None
    assert drawing() == 1  # the laboratory's own
    with StandIn(page.port):
        until(lambda: drawing() == 2)
    until(lambda: drawing() == 1)
    assert page.drawing is None
    until(lambda: laboratory.elsewhere == WatchPageRequest())


def test_it_serves_the_page_and_nothing_that_opens_or_takes(page):
    assert ask(page.port).status == 200
    for path in (OPEN, TAKE, GALLERY, "/sweep", "/sweeps.json"):
        assert ask(page.port, path).status == 404


@pytest.mark.usefixtures("browsers")
def test_who_watches_is_told_what_to_watch_and_not_what_to_try(page, laboratory):
    scene = replace(laboratory.now(), watch="Rings of <layers>", tries="Turn p2 up")
    laboratory.shown_scene = scene
    told = until(lambda: "layers" in page.story.content and page.story.content)
    assert "Rings of &lt;layers&gt;" in told
    assert "Turn" not in told
    assert until(lambda: "Turn p2 up" in laboratory.run.story.content)
    laboratory.shown_scene = None


def test_each_plots_what_it_likes_and_that_is_measured(laboratory, browsers):
    (first, _), (second, other) = browsers
    before = plotted(second)
    first.set("Plot 1", "nearest neighbour")
    until(lambda: "nearest-neighbour" in laboratory.simulation.watched)
    until(
        lambda: any(
            "nearest neighbour <b>" in str(one.get("content")) for one in first.controls.values()
        )
    )
    assert plotted(second) == before
    assert "nearest-neighbour" not in other.plots.names
    assert all(chart.choice.value != "nearest neighbour" for chart in laboratory.plots.charts)
    first.set("Plot 1", "nothing")
    until(lambda: "nearest-neighbour" not in laboratory.simulation.watched)


def test_each_inspects_its_own_agent_and_the_laboratory_none(page, laboratory, browsers):
    (first, own), (second, other) = browsers
    before = laboratory.simulation.wanted.first
    click(first, page, 5)
    until(lambda: own.choice is not None)
    row = own.choice.row
    until(lambda: row in laboratory.simulation.frame.others, 60)
    until(lambda: f"Agent {laboratory.simulation.frame.ids[row]}" in card(first))
    until(lambda: "/own/inspected/ring" in first.nodes)
    assert card(second) == ""
    assert not any("own" in name for name in second.nodes)
    assert other.choice is None
    assert laboratory.selected is None
    assert laboratory.simulation.frame.inspected is None
    assert laboratory.simulation.wanted.first == before

    click(second, page, 9)
    until(lambda: other.choice is not None and other.choice != own.choice)
    until(lambda: {row, other.choice.row} <= set(laboratory.simulation.frame.others))
    laboratory.select(12)
    until(lambda: laboratory.simulation.frame.inspected is not None)
    assert own.choice.row == row
    assert {row, other.choice.row} <= set(laboratory.simulation.frame.others)
    laboratory.select(None)
    first.press("Close")
    until(lambda: own.choice is None and card(first) == "")
    until(lambda: set(laboratory.simulation.frame.others) == {other.choice.row})
    assert other.choice is not None


def test_another_run_has_other_agents(page, laboratory, browsers):
    (_, own), _ = browsers
    frame = laboratory.simulation.frame
    own.choose(AgentSelection(3, run=frame.run))
    until(lambda: page.scene.own)
    laboratory.simulation.reset()
    until(lambda: laboratory.simulation.frame.run > frame.run)
    until(lambda: own.choice is None and not page.scene.own)
    until(lambda: laboratory.elsewhere.rows == frozenset())


def test_a_key_turns_the_camera_of_one_browser(browsers):
    (first, own), (_, other) = browsers
    flat = np.array(other.client.camera.position)
    until(lambda: first.commands.get("Camera: side"))
    before = np.array(own.client.camera.position)
    first.say(type="CommandTriggerMessage", uuid=first.commands["Camera: side"])
    until(lambda: not np.allclose(own.client.camera.position, before))
    assert np.allclose(other.client.camera.position, flat)


def test_what_is_told_of_the_run_is_text(laboratory):
    state = laboratory.simulation.state
    told = standing(state, "<b>Ada</b>")
    assert "&lt;b&gt;Ada" in told
    assert "<b>Ada" not in told
    assert "Press Setup" not in standing(replace(state, error="x < y"), "Ada")
    changed = replace(state, values=state.values | {"eta": 0.3, "neighbours": True})
    assert "<b>0.3 rad</b>" in values(changed)
    assert "<input" not in values(changed)
    assert "on</td>" in values(changed)


def test_what_is_measured_for_those_who_watch_is_bounded_and_what_most_want_goes_first():
    assert measured_for_all([QUICK]) == frozenset()
    assert measured_for_all([["connectivity"], [], ["connectivity", QUICK[0]]]) == {"connectivity"}
    last = [name for name in OBSERVABLES if name not in ALWAYS][-2:]
    chosen = measured_for_all([list(OBSERVABLES), last, last])
    assert len(chosen) == MOST
    assert chosen > set(last)


def test_agents_that_are_looked_at_are_bounded_and_the_latest_go_first(page):
    class One:
        def __init__(self, row: int, beside: bool):
            self.choice = AgentSelection(row, beside)
            self.plots = type("Plots", (), {"names": frozenset()})

    asked = page.asked([One(k, k % 2 == 0) for k in range(LOOKED_AT + 20)])
    assert len(asked.rows) + len(asked.rows_beside) == LOOKED_AT
    assert asked.rows | asked.rows_beside == frozenset(range(LOOKED_AT))


def test_agents_of_other_pages_are_looked_at_a_few_times_a_second_and_the_own_in_every_frame():
    looked: list[int] = []

    class Seen(StubFlock):
        def inspect(self, row):
            looked.append(row)
            return super().inspect(row)

    camera = FrameBuilder(
        Seen(preset_spec(agents=5)), 1, FrameRequest(row=1, others=frozenset({2, 3, 99}))
    )
    until(camera.is_warm)
    for _ in range(10):
        camera.inspect()
        camera.inspect_others()
    assert looked.count(1) == 10
    assert looked.count(2) == looked.count(3) == 1
    assert 99 not in looked
    assert set(camera.build().others) == {2, 3}
    camera.inspect_others(at_once=True)
    assert looked.count(2) == 2
    camera.set_request(FrameRequest(row=1))
    camera.inspect_others()
    assert camera.build().others == {}


def test_what_other_pages_inspect_does_not_have_layers_found_anew():
    camera = FrameBuilder(StubFlock(preset_spec(agents=5)), 1, FrameRequest(layers=True))
    camera.rate_limit.next = 1e12
    camera.set_request(FrameRequest(layers=True, others=frozenset({2})))
    assert camera.rate_limit.next == 1e12
    camera.set_request(FrameRequest(layers=True, groups=True, others=frozenset({2})))
    assert camera.rate_limit.next == 0.0


def test_browsers_that_come_and_go_hold_up_nobody(page, laboratory, capfd):
    def tick(browser: StandIn) -> bool:
        card = f"<span>tick</span><b>{laboratory.simulation.frame.tick}</b>"
        return any(card in str(one.get("content")) for one in browser.controls.values())

    with StandIn(page.port) as stays:
        for _ in range(30):
            StandIn(page.port).socket.close()
        laboratory.simulation.step()
        until(lambda: tick(stays), 60)
        until(lambda: len(page.watchers) == 1)
    assert "Traceback" not in capfd.readouterr().err
