"""The panels of a room with real cars: what they say, and the hand that drags the injected car."""

from __future__ import annotations

import csv
import io
import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from agents.catalogue import cars_for_rule
from app.front.server import admit_browsers, close_server, open_server
from app.live.control.loop_status import Event
from app.live.control.pose import Pose
from app.live.control.safety import StopReason
from app.live.laboratory.lab_file import example
from app.live.links.link import RUN
from app.viewer.live.loop_connection import notice_of
from app.viewer.live.panels.live_plots import WINDOW, LivePlots, colours
from app.viewer.live.panels.log_panel import COLUMNS, as_csv, event_list
from app.viewer.live.panels.room_monitors import cars, numbers
from app.viewer.live.panels.room_panel import describe_injected, describe_limits
from app.viewer.live.panels.state_panel import (
    EMULATED_CARS,
    MOVES,
    arming_question,
    banner_html,
    banner_of,
)
from app.viewer.live.room_frame import RoomReadings, Setting, frame_of
from app.viewer.live.session_requests import DragHandle, SessionState
from app.viewer.scene.shown import palette
from tests.viewer.stub_operator import car_status, companion, status_at

OPEN = SessionState("emulated cars", "dry run", "squashing", phase="open")
UNSEEN = StopReason("unseen", "blue was last seen 0.40 s ago", "blue", holds=False)


@pytest.fixture
def server():
    made = open_server(port=0)
    admit_browsers(made)
    yield made
    close_server(made)


@pytest.mark.parametrize(
    ("state", "status", "kind", "words"),
    [
        (replace(OPEN, phase="opening"), None, "opening", "Waiting"),
        (replace(OPEN, phase="opening", compiling="compiling x"), None, "opening", "Compiling x"),
        (replace(OPEN, phase="opening", latched=True), None, "emergency", "begins stopped"),
        (replace(OPEN, phase="failed", trouble="no frame within 5 s"), None, "failed", "no frame"),
        (OPEN, None, "opening", "Waiting"),
        (OPEN, status_at(), "safe", "Ready"),
        (OPEN, replace(status_at(), reasons=(UNSEEN,)), "safe", "Cannot be armed"),
        (OPEN, status_at(arm="armed"), "running", "run"),
        (OPEN, replace(status_at(arm="armed"), mode=0, reasons=(UNSEEN,)), "held up", "0.40 s"),
        (OPEN, status_at(arm="emergency"), "emergency", "stop"),
        (OPEN, replace(status_at(arm="armed"), troubles={"link": "gone"}), "running", "link: gone"),
    ],
)
def test_the_banner_says_how_the_room_stands(state, status, kind, words):
    now = banner_of(state, status)
    assert now.kind == kind
    assert words in banner_html(now)
    assert f"fs-{kind.replace(' ', '-')}" in banner_html(now)
    assert now.can_be_armed == (kind == "safe" and not now.reasons)


@pytest.mark.parametrize("arm", ["safe", "armed", "emergency"])
def test_a_car_that_moves_though_told_to_stand_is_a_large_banner_in_every_state(arm):
    words = "blue moves though it is told to stand: is it pushed?"
    more = (StopReason("moves", words, "blue"), *[replace(UNSEEN, words=str(k)) for k in range(9)])
    now = banner_of(OPEN, replace(status_at(arm=arm), mode=0, reasons=more))
    assert now.alarm == MOVES
    assert now.reasons[0] == words
    assert not now.can_be_armed
    assert f'<div class="fs-alarm">{MOVES}</div>' in banner_html(now)
    assert "fs-alarm" not in banner_html(banner_of(OPEN, status_at(arm=arm)))
    told = Event(7, 0.07, "moves", words, "blue")
    assert notice_of(told) == words


def test_the_banner_says_that_cars_are_emulated_and_why_they_stand():
    why = "stopped until armed again: blue was last seen 0.40 s ago (safety)"
    state = replace(OPEN, emulated=True, disarmed=why)
    assert f"SAFE · {EMULATED_CARS}" in banner_html(banner_of(state, status_at()))
    assert why in banner_html(banner_of(state, status_at()))
    assert why in banner_html(banner_of(state, status_at(arm="emergency")))
    running = banner_html(banner_of(state, status_at(arm="armed")))
    assert EMULATED_CARS in running
    assert why not in running
    replay = banner_html(banner_of(replace(state, phase="replay"), status_at()))
    assert EMULATED_CARS not in replay
    assert why not in replay
    assert EMULATED_CARS not in banner_html(banner_of(OPEN, status_at()))


def test_the_question_before_arming_tells_emulated_cars_from_real_ones():
    assert "1 car will drive" in arming_question(["red"])
    assert "Is the area clear?" in arming_question(["red"])
    assert "2 emulated cars will drive" in arming_question(["red", "blue"], True)
    assert "No real car moves." in arming_question(["red", "blue"], True)


def test_trouble_of_the_tracking_is_shown_beside_the_cars_that_are_not_seen():
    status = replace(status_at(), reasons=(UNSEEN,), troubles={"source": "it is opened again"})
    assert banner_of(OPEN, status).reasons == (UNSEEN.words, "source: it is opened again")


def test_what_a_tracking_or_a_link_says_is_no_html():
    status = replace(status_at(), reasons=(replace(UNSEEN, words="<img src=x>"),))
    assert "<img" not in banner_html(banner_of(OPEN, status))
    assert "<img" not in event_list([Event(1, 0.0, "rule", "<img src=x>", cause="<img>")])


def drag(x: float, y: float, client: int = 1, phase: str = "update") -> Any:
    """What viser tells of a drag on the display."""
    target = SimpleNamespace(position=np.array([x, y, 0.0]))
    return SimpleNamespace(phase=phase, client_id=client, target=target)


@pytest.fixture
def hand(server):
    placed = []
    made = DragHandle(server.scene, example().area, lambda x, y: placed.append((x, y)))
    made.draw(whole_frame())
    return made, placed


def whole_look(arm="armed"):
    return replace(
        status_at(7, 1.0, arm, [car_status("blue"), car_status("red", Pose(0.0, -2.0, 0.0), 0.06)],
                Pose(2.0, 0.0, 0.0), [companion(1, -2.0, 0.0, -0.4)]),
        mode=RUN,
    )  # fmt: skip


def whole_frame(status=None):
    lab = example()
    setting = Setting.of(1, lab, cars_for_rule(lab.rule))
    return frame_of(setting, status or whole_look(), {"length": 0.22})


def moved(hand: DragHandle, event: Any) -> None:
    """Give it a drag, as viser's event loop does."""
    with pytest.raises(StopIteration):
        hand.handle_drag(event).send(None)


def test_the_hand_stays_within_the_fence(hand):
    made, placed = hand
    assert made.handle.visible
    moved(made, drag(0.0, 0.0, phase="start"))
    moved(made, drag(500.0, 0.1))
    moved(made, drag(math.nan, 0.0))
    area = example().area
    (x, _), (far, _) = placed
    assert x == pytest.approx(0.0)
    assert far == pytest.approx(area.high[0] - area.fence)


def test_only_who_holds_the_hand_moves_it(hand):
    made, placed = hand
    moved(made, drag(0.0, 0.0, client=1, phase="start"))
    moved(made, drag(1.0, 0.0, client=2))
    assert len(placed) == 1
    before = np.array(made.handle.position)
    made.draw(whole_frame())
    np.testing.assert_array_equal(made.handle.position, before)
    moved(made, drag(1.0, 0.0, client=1, phase="end"))
    moved(made, drag(2.0, 0.0, client=1))
    assert len(placed) == 2


def test_the_table_has_every_car_with_its_state():
    status = whole_look()
    readings = RoomReadings(example().injected)
    readings.note(status)
    shown = cars(status, whole_frame(status), readings, chosen=1)
    assert [f">{name}</td>" in shown for name in ("blue", "red", "sim 1")] == [True] * 3
    assert "0 ms" in shown
    assert "60 ms" in shown
    assert "−0.40" in shown
    assert shown.count("fs-chosen") == 1
    for car in status.cars:
        own, outline = palette.css(palette.OWN[car.name]), palette.css(palette.STATES[car.state])
        dot = f'<i class="fs-dot fs-small fs-car" style="background:{own};color:{outline}"></i>'
        assert f'<td title="{car.state}">{dot}{car.name}</td>' in shown
    assert 'title="simulated"' in shown
    told = numbers(status, readings, 3)
    assert (told["loop"], told["browsers"], told["ticks missed"]) == ("10.0 ms", "3", "0")
    assert told["least distance"] == "2.69 m"


def test_a_car_that_was_never_seen_is_in_the_table():
    status = status_at(0, 0.0, "safe", [car_status("blue", None), car_status("red")])
    shown = cars(status, whole_frame(status), RoomReadings(example().injected), None)
    assert "never" in shown
    assert 'title="lost"' in shown


def test_plots_reach_back_a_minute(server):
    plots = LivePlots(server, 100.0)
    readings = RoomReadings(example().injected)
    status = whole_look()
    for second in range(90):
        readings.note(replace(status, time=float(second)))
    names = ["blue", "red", "sim 1"]
    plots.refresh(readings, names, 0.22)
    at, median, *_ = plots.times.plot.chart.plot.data
    assert (at[0], at[-1], median[-1]) == (89.0 - WINDOW, 89.0, 10.0)
    assert len(plots.lags.plot.chart.plot.data) == len(plots.lags.plot.chart.plot.series) == 4
    assert plots.lags.plot.chart.plot.data[2][-1] == pytest.approx(90.0)
    plots.refresh(readings, ["red"], 0.22)
    assert len(plots.lags.plot.chart.plot.data) == len(plots.lags.plot.chart.plot.series) == 2
    drawn = [one["stroke"] for one in plots.lags.plot.chart.plot.series[1:]]
    assert drawn == [colours(names)["red"]] == [palette.css(palette.OWN["red"])]
    assert len(set(colours(names).values())) == 3


def test_the_log_has_the_newest_on_top_and_the_file_has_all():
    events = [Event(k, float(k), "tune", f"beta = {k}", cause="browser 1") for k in (1, 2)]
    shown = event_list(events)
    assert shown.index("beta = 2") < shown.index("beta = 1")
    header, first, second = csv.reader(io.StringIO(as_csv(events)))
    assert tuple(header) == COLUMNS
    assert (first[1], second[4]) == ("1", "beta = 2")


def test_the_room_says_its_limits_and_what_the_injected_car_does():
    lab = example()
    assert "6.10 × 6.71 m" in describe_limits(lab)
    assert "red" in describe_limits(lab)
    plan = lab.injected.model_copy(update={"path": "hand"})
    assert "drag" in describe_injected(plan)
