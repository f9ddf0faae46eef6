"""The control loop: its deadlines by a clock of the test, its end, and a short run in real time."""

from __future__ import annotations

import math
import threading
import time

import pytest

from app.live.control.arm import OperatorRequest
from app.live.control.car_control import CarControl
from app.live.control.control_loop import MOST_REQUESTS, PARTING, STATUS_EVERY, Loop
from app.live.control.injected_target import InjectedTarget
from app.live.control.loop_status import DURATIONS_KEPT as SPANS
from app.live.control.loop_status import EVENTS_KEPT, Durations, Event, Events
from app.live.control.pose import MocapFrame, Pose, seen
from app.live.links.link import EMERGENCY, RUN, STOP
from live.rooms import LAB, Steady, lab

ARM = OperatorRequest("arm", "test")


class Clock:
    """A clock that goes on by what is waited, and by what the work takes."""

    def __init__(self):
        self.now = 50.0
        self.waited = []

    def __call__(self):
        return self.now

    def wait(self, seconds):
        self.waited.append(seconds)
        self.now += seconds


class Standing:
    """A feed of two cars that stand, with a frame for every tick until it is cut."""

    trouble = ""

    def __init__(self, clock):
        self.clock = clock
        self.number = 0
        self.cut = False

    def since(self, number):
        if self.cut:
            return []
        self.number += 1
        assert number < self.number
        cars = (seen("red", Pose(0.0, 0.0, 0.0)), seen("blue body", Pose(0.0, 1.0, 0.0)))
        return [MocapFrame(self.number, self.clock(), cars)]


class Radio:
    """A link that keeps what it is told; each frame takes it `takes` seconds of the clock."""

    name = "radio"
    dropped = 0

    def __init__(self, clock=None):
        self.clock = clock
        self.sent = []
        self.takes = 0.0
        self.fails = None
        self.closed = False
        self.then = {}

    def send(self, seq, mode, commands):
        if self.fails is not None:
            raise self.fails
        self.sent.append((seq, mode, dict(commands)))
        if self.clock is not None:
            self.clock.now += self.takes
        self.then.pop(len(self.sent), lambda: None)()

    def occupies(self, _cars):
        return 0.0

    def close(self):
        self.closed = True

    @property
    def modes(self):
        return [mode for _, mode, _ in self.sent]


def loop_of(driver=None, text=LAB, journal=None):
    """A loop with the clock of the test."""
    clock = Clock()
    one = lab(text)
    loop = Loop(
        CarControl(one.safety(), driver or Steady((0.5, 0.0))),
        Standing(clock),
        Radio(clock),
        one.addresses,
        InjectedTarget(one.injected, one.area),
        journal,
        one.rate,
        clock,
        clock.wait,
    )
    return loop, clock, loop.link


def run(loop, ticks):
    """Let it run for so many ticks and leave."""
    loop.link.then[ticks] = lambda: loop.end("test")
    loop.run()


def test_deadlines_are_absolute():
    loop, clock, radio = loop_of()
    radio.takes = 0.003
    run(loop, 100)
    assert clock.waited[:99] == pytest.approx([0.007] * 99)
    assert loop.periods.summary().worst == pytest.approx(0.01)
    assert loop.periods.count == 99
    assert loop.missed == 0


def test_missed_deadlines_are_left_out_and_never_caught_up():
    loop, clock, radio = loop_of()
    begun = clock.now
    ticks = []
    radio.then = {k: lambda: ticks.append(clock.now - begun) for k in range(1, 8)}
    radio.then[3] = lambda: (
        ticks.append(clock.now - begun),
        setattr(clock, "now", clock.now + 0.034),
    )
    run(loop, 8)
    # the third tick, begun at 20 ms, lasts until 54 ms: the deadlines of 30 and 40 ms are left out
    assert ticks == pytest.approx([0.0, 0.01, 0.02, 0.054, 0.06, 0.07, 0.08])
    assert loop.missed == 2


def test_a_tick_that_is_late_by_less_than_a_period_is_made_at_once():
    loop, clock, radio = loop_of()
    begun = clock.now
    radio.takes = 0.0005
    radio.then[1] = lambda: setattr(clock, "now", begun + 0.012)
    starts = []
    radio.then[2] = lambda: starts.append(clock.now - begun - radio.takes)
    radio.then[3] = lambda: starts.append(clock.now - begun - radio.takes)
    run(loop, 4)
    assert starts == pytest.approx([0.012, 0.02])
    assert loop.missed == 0


def test_every_tick_sends_whatever_the_mode():
    loop, _, radio = loop_of()
    radio.then[5] = lambda: loop.ask(ARM)
    radio.then[10] = lambda: loop.ask(OperatorRequest("emergency", "test"))
    run(loop, 20)
    assert radio.modes == [STOP] * 5 + [RUN] * 5 + [EMERGENCY] * 10 + [EMERGENCY] * PARTING
    assert [seq for seq, _, _ in radio.sent] == list(range(1, 20 + PARTING + 1))
    assert set(radio.sent[7][2]) == {1, 2}


def test_the_end_is_a_stop():
    loop, _, radio = loop_of(Steady((0.5, 1.0)))
    radio.then[2] = lambda: loop.ask(ARM)
    run(loop, 10)
    assert (
        radio.modes == [STOP, *[STOP] * 1, *[RUN] * 8, *[STOP] * PARTING]
        or radio.modes[-PARTING:] == [STOP] * PARTING
    )
    assert all(throttle == 0.0 for _, throttle in radio.sent[-1][2].values())
    assert radio.closed


@pytest.mark.parametrize("error", [RuntimeError("a bug"), KeyboardInterrupt()])
def test_the_end_is_a_stop_when_the_loop_itself_fails(error):
    loop, _, radio = loop_of(Steady((0.0, 1.0)))
    radio.then[2] = lambda: loop.ask(ARM)

    def fail(_number):
        raise error

    radio.then[6] = lambda: setattr(loop.feed, "since", fail)
    with pytest.raises(type(error)):
        loop.run()
    assert radio.modes == [STOP, STOP, RUN, RUN, RUN, RUN, *[STOP] * PARTING]
    assert radio.closed


def test_an_emergency_stop_asked_for_in_the_last_tick_is_sent():
    loop, _, radio = loop_of()
    radio.then[3] = lambda: (loop.ask(OperatorRequest("emergency", "test")), loop.end("test"))
    loop.run()
    assert radio.modes == [STOP] * 3 + [EMERGENCY] * PARTING


def test_an_emergency_stop_overtakes_every_other_request():
    loop, _, radio = loop_of()
    radio.then[2] = lambda: [loop.ask(ARM) for _ in range(5 * MOST_REQUESTS)]
    radio.then[3] = lambda: loop.ask(OperatorRequest("emergency", "browser"))
    run(loop, 6)
    assert radio.modes[:6] == [STOP, STOP, RUN, EMERGENCY, EMERGENCY, EMERGENCY]


@pytest.mark.parametrize("before", [0, 3, 60])
def test_what_was_asked_before_an_emergency_stop_does_not_undo_it(before):
    loop, _, _ = loop_of()
    loop.tick()
    loop.ask(OperatorRequest("emergency", "browser 1"))
    loop.tick()
    for _ in range(before):
        loop.ask(OperatorRequest("disarm", "browser 2"))
    loop.ask(OperatorRequest("reset", "browser 2"))
    loop.ask(ARM)
    loop.ask(OperatorRequest("emergency", "browser 1"))
    for _ in range(40):
        loop.tick()
    assert loop.control.safety.arm.state == "emergency"
    refused = [one.words for one in loop.events.since(0)[1] if one.kind == "refused"]
    assert refused == [f"{action}: overtaken by an emergency stop" for action in ("reset", "arm")]
    loop.ask(OperatorRequest("emergency", "browser 1"))
    loop.ask(OperatorRequest("reset", "browser 2"))
    loop.tick()
    assert loop.control.safety.arm.state == "safe"


def test_a_source_that_falls_silent_stops_the_cars():
    loop, _, radio = loop_of()
    radio.then[1] = lambda: loop.ask(ARM)
    radio.then[5] = lambda: setattr(loop.feed, "cut", True)
    run(loop, 30)
    assert radio.modes[1:15] == [RUN] * 14
    assert STOP in radio.modes[14:17]
    assert radio.modes[17:30] == [STOP] * 13


def test_a_link_that_fails_takes_the_arming_away_once_more_if_armed_again():
    loop, _, radio = loop_of()
    loop.tick()
    loop.ask(ARM)
    loop.tick()
    radio.fails = OSError("the radio is unplugged")
    loop.tick()
    loop.tick()
    assert loop.control.safety.arm.state == "safe"
    loop.ask(ARM)
    loop.tick()
    loop.tick()
    assert loop.control.safety.arm.state == "safe"
    radio.fails = None
    loop.ask(ARM)
    loop.tick()
    loop.tick()
    assert loop.control.safety.arm.state == "armed"
    log = [(event.kind, event.words) for event in loop.events.since(0)[1]]
    assert log.count(("link", "the radio is unplugged")) == 1
    assert log.count(("hold", "held: the radio is unplugged")) == 2
    assert log.count(("link", "the link works again")) == 1


def test_an_operator_that_has_long_been_silent_takes_the_arming_away():
    loop, clock, _ = loop_of()
    loop.tick()
    loop.ask(ARM)
    loop.tick()
    for silent in (1.9, 0.0, 1.9):
        loop.attended = clock.now - silent
        loop.tick()
        assert loop.control.safety.arm.state == "armed"
    loop.attended = clock.now - 2.1
    loop.tick()
    assert loop.control.safety.arm.state == "safe"
    assert loop.events.since(0)[1][-1].words == "the cars stop"
    held = [event for event in loop.events.since(0)[1] if event.kind == "hold"]
    assert [(one.words, one.cause) for one in held] == [
        ("held: the operator has been silent for 2 s", "operator")
    ]


def test_trouble_of_the_source_is_an_event():
    loop, _, _ = loop_of()
    loop.tick()
    loop.feed.trouble = "mock: its process was killed (SIGKILL)"
    loop.tick()
    loop.tick()
    _, log = loop.events.since(0)
    assert [(e.kind, e.words) for e in log] == [
        ("source", "mock: its process was killed (SIGKILL)")
    ]


def test_trouble_of_the_source_takes_the_arming_away_though_its_frames_go_on():
    loop, _, radio = loop_of()
    loop.tick()
    loop.ask(ARM)
    loop.tick()
    assert loop.control.safety.arm.state == "armed"
    loop.feed.trouble = "mock: its process was killed (SIGSEGV); it is opened again in 1 s"
    loop.tick()
    loop.feed.trouble = ""
    run(loop, 5)
    assert loop.control.safety.arm.state == "safe"
    assert radio.modes[-4:] == [STOP] * 4
    log = loop.events.since(0)[1]
    assert [one.words for one in log if one.kind == "hold"] == [
        "held: mock: its process was killed (SIGSEGV); it is opened again in 1 s"
    ]
    assert log[-1].words == "the source works again" or log[-2].words == "the source works again"


def test_who_arms_after_the_source_has_failed_is_held_though_its_last_poses_are_fresh():
    loop, _, radio = loop_of()
    loop.tick()
    loop.feed.trouble = "mock: its process was killed (SIGSEGV); it is opened again in 1 s"
    loop.tick()
    loop.ask(ARM)
    loop.tick()
    loop.tick()
    loop.feed.trouble = ""
    run(loop, 10)
    assert loop.control.safety.arm.state == "safe"
    assert radio.modes[-7:] == [STOP] * 7
    holds = [one for one in loop.events.since(0)[1] if one.kind == "hold"]
    assert len(holds) == 1


def test_the_latency_is_from_the_frame_to_the_command():
    loop, _, radio = loop_of()
    radio.takes = 0.002
    run(loop, 5)
    assert loop.latencies.summary().median == pytest.approx(0.002)


def test_a_look_shows_the_cars():
    loop, clock, _ = loop_of()
    loop.tick()
    assert [car.state for car in loop.latest.cars] == ["stopped", "stopped"]
    loop.ask(ARM)
    loop.tick()
    assert [car.state for car in loop.latest.cars] == ["tracked", "tracked"]
    assert loop.latest.arm == "armed"
    loop.feed.cut = True
    for state, later in (("late", 0.05), ("lost", 0.1)):
        clock.now += later
        for _ in range(STATUS_EVERY):
            loop.tick()
        assert [car.state for car in loop.latest.cars] == [state, state]
    assert loop.latest.cars[0].age == pytest.approx(0.15)
    assert loop.latest.cars[0].pose == Pose(0.0, 0.0, 0.0)


def test_the_hand_moves_the_injected_car_of_the_loop():
    loop, _, _ = loop_of(text=LAB.replace('path = "circle"', 'path = "hand"'))
    loop.place(1.0, 0.5)
    loop.tick()
    assert (loop.latest.injected.x, loop.latest.injected.y) == (1.0, 0.5)


def test_events_are_kept_up_to_a_number():
    log = Events()
    log.add(*(Event(k, 0.0, "run", "") for k in range(EVENTS_KEPT + 10)))
    count, kept = log.since(0)
    assert (count, len(kept), kept[0].tick) == (EVENTS_KEPT + 10, EVENTS_KEPT, 10)
    assert log.since(EVENTS_KEPT + 10) == (EVENTS_KEPT + 10, [])


def test_a_summary_is_of_the_last_spans():
    spans = Durations()
    assert math.isnan(spans.summary().median)
    for k in range(SPANS + 100):
        spans.add(float(k))
    summary = spans.summary()
    assert summary.worst == SPANS + 99
    assert summary.median == 100 + (SPANS - 1) / 2
    assert summary.late == 100 + 0.99 * SPANS


def test_in_real_time_it_keeps_to_its_deadlines():
    one = lab()
    clock = time.monotonic
    loop = Loop(
        CarControl(one.safety(), Steady((0.5, 0.0))),
        Standing(clock),
        Radio(),
        one.addresses,
        InjectedTarget(one.injected, one.area),
    )
    ends = threading.Timer(1.0, lambda: loop.end("test"))
    ends.start()
    begun = clock()
    loop.run()
    assert loop.before is not None
    # ticks never bunch: there are no more of them than there were deadlines
    deadlines = (loop.before - begun) * 100.0
    assert 0.5 * deadlines < loop.periods.count + loop.missed <= deadlines + 1.0
    assert len(loop.link.sent) == loop.periods.count + 1 + PARTING
