"""A source in a child process: what is kept of it, and what becomes of one that hangs or dies."""

import errno
import multiprocessing
import os
import signal
import subprocess
import sys
import textwrap
import time
from itertools import islice

import pytest

from app.live.control.pose import MocapFrame, Pose
from app.live.sources import feed as feed_module
from app.live.sources import simulated_source
from app.live.sources.feed import KEPT, Feed
from app.live.sources.simulated_source import SimulatedSource
from tests.live.stub_sources import LateStub, Stub, StubSimulator, Undeclared
from tests.live.waiting import HandClock, until
from worlds.input_error import InputError

WITHIN = 60.0
"""Seconds in which what is waited for happens, on a machine that is very busy."""


def gone(process_id):
    """Whether there is no such process (any more)."""
    try:
        os.kill(process_id, 0)
    except ProcessLookupError:
        return True
    with open(f"/proc/{process_id}/stat") as stat:
        return stat.read().rpartition(")")[2].split()[0] == "Z"


def test_before_the_first_frame_there_is_none_and_nothing_waits():
    with Feed(Stub("hung before it connects")) as feed:
        began = time.monotonic()
        assert feed.latest() is None
        assert feed.since(-1) == []
        assert feed.last_seen() == {}
        assert time.monotonic() - began < 2.0  # it would be for ever
        assert (feed.state, feed.alive, feed.trouble) == ("connecting", True, "")


def test_frames_come_in_order_and_none_twice():
    with Feed(Stub(count=40)) as feed:
        until(lambda: not feed.alive)
        frames = feed.since(-1)
        assert feed.state == "ended"
        assert feed.trouble == ""
        assert [frame.number for frame in frames] == list(range(40))
        assert [frame.sent for frame in frames] == [0.01 * number for number in range(40)]
        assert feed.latest() == frames[-1]
        assert feed.since(36) == frames[37:]
        assert feed.since(39) == []
    assert feed.state == "closed"


def test_each_body_is_remembered_where_it_was_last_tracked():
    with Feed(Stub(count=10)) as feed:
        until(lambda: not feed.alive)
        frames = feed.since(-1)
        seen = feed.last_seen()
    assert (seen["car1"].pose, seen["car1"].received) == (Pose(9.0, 0.0, 0.0), frames[9].received)
    assert (seen["car2"].pose, seen["car2"].received) == (Pose(0.0, 1.0, 0.5), frames[1].received)
    assert seen["car2"].age(frames[1].received + 0.5) == pytest.approx(0.5)


def test_only_the_newest_frames_are_kept():
    count = KEPT + 500
    with Feed(Stub("fast", count=count)) as feed:
        until(lambda: not feed.alive, within=30.0)
        assert [frame.number for frame in feed.since(-1)] == list(range(500, count))


def test_a_source_that_hangs_as_it_connects_is_given_up_and_ended():
    with Feed(Stub("hung before it connects"), timeout=1.5) as feed:
        process = feed.process_id
        until(lambda: not feed.alive)
        assert feed.trouble == (
            "stub that is hung before it connects: no connection within 1.5 s, given up"
        )
        assert gone(process)
    assert feed.state == "failed"


def test_the_time_to_connect_counts_from_when_the_process_has_begun():
    with Feed(LateStub(), timeout=1.0) as feed:
        assert feed.first(WITHIN)
        assert feed.trouble == ""


def test_a_process_that_does_not_begin_is_told_and_begun_again(monkeypatch):
    monkeypatch.setattr(feed_module, "BEGINNING", 0.2)
    monkeypatch.setattr(feed_module, "PAUSE", 30.0)
    with Feed(LateStub()) as feed:
        until(lambda: feed.trouble)
        assert feed.state == "pausing"
        told = "its process has not begun within 0.2 s; it is opened again in 30 s"
        assert feed.trouble == f"stub that is steady: {told}"


def test_a_source_that_hangs_between_frames_only_grows_old_and_is_ended_on_closing():
    feed = Feed(Stub("hung between frames"))
    feed.first(WITHIN)
    until(lambda: feed.latest().age(time.monotonic()) > 0.3)
    assert (feed.state, feed.latest().number) == ("streaming", 2)
    began = time.monotonic()
    feed.close()
    assert time.monotonic() - began < 10.0  # it would be ten minutes
    assert gone(feed.process_id)


@pytest.mark.parametrize(
    ("how", "says"),
    [("refusing", "no such host as lab"), ("mistaken", "KeyError: 'car1'")],
)
def test_what_never_brought_a_frame_fails_for_good_in_one_line(how, says):
    with Feed(Stub(how)) as feed:
        until(lambda: not feed.alive)
        assert feed.trouble == f"stub that is {how}: {says}"
        assert feed.state == "failed"
        with pytest.raises(InputError, match=r"^stub that is"):
            feed.first(0.0)


@pytest.mark.parametrize(
    ("how", "says"),
    [
        ("broken", "the camera is gone"),
        ("killed", "its process was killed (SIGKILL)"),
        ("leaving", "its process ended by itself (exit code 3)"),
        ("greedy", "it asked for more memory than it gets (4 GiB)"),
    ],
)
def test_what_goes_wrong_later_is_told_in_one_line_and_it_is_opened_again(how, says, monkeypatch):
    monkeypatch.setattr(feed_module, "PAUSE", 0.2)
    told = []
    with Feed(Stub(how)) as feed:
        until(lambda: bool(feed.trouble) and not told.append(feed.trouble), WITHIN)
        until(lambda: feed.latest().number >= 8, WITHIN)  # of the third child, three each
        assert told[0] == f"stub that is {how}: {says}; it is opened again in 0.2 s"
        numbers = [frame.number for frame in feed.since(-1)]
        assert numbers == list(range(len(numbers)))
        stamps = [frame.received for frame in feed.since(-1)]
        assert stamps == sorted(stamps)
    assert feed.state == "closed"


def test_who_is_killed_again_and_again_is_opened_ever_more_rarely(monkeypatch):
    monkeypatch.setattr(feed_module, "PAUSE", 0.1)
    monkeypatch.setattr(feed_module, "LONGEST_PAUSE", 0.4)
    told = []
    with Feed(Stub("killed")) as feed:

        def pauses():
            if feed.trouble and feed.trouble not in told:
                told.append(feed.trouble)
            return len(told) == 3 and feed.latest().number >= 15

        until(pauses, WITHIN)
        assert [one.rpartition(" again in ")[2] for one in told] == ["0.1 s", "0.2 s", "0.4 s"]


def test_it_is_opened_again_though_at_first_no_process_can_be_started(monkeypatch):
    monkeypatch.setattr(feed_module, "PAUSE", 0.1)
    begin, begun, told = Feed._open, [], []

    def scarce(feed):
        begun.append(feed)
        if len(begun) == 2:
            raise BlockingIOError(errno.EAGAIN, os.strerror(errno.EAGAIN))
        begin(feed)

    fail = Feed._fail

    def noted(feed, *how, **more):
        fail(feed, *how, **more)
        told.append(feed.trouble)

    monkeypatch.setattr(Feed, "_open", scarce)
    monkeypatch.setattr(Feed, "_fail", noted)
    with Feed(Stub("killed")) as feed:
        until(lambda: len(feed.since(-1)) >= 6, WITHIN)
    assert told[1] == (
        "stub that is killed: no process can be started: Resource temporarily unavailable; "
        "it is opened again in 0.2 s"
    )


@pytest.mark.parametrize("number", [signal.SIGSEGV, signal.SIGKILL, signal.SIGABRT])
def test_a_child_that_is_killed_from_outside_is_reported_and_comes_back(number):
    with Feed(Stub()) as feed:
        feed.first(WITHIN)
        killed = feed.process_id
        os.kill(killed, number)
        until(lambda: bool(feed.trouble), WITHIN)
        assert feed.trouble == (
            f"stub that is steady: its process was killed ({number.name}); "
            "it is opened again in 1 s"
        )
        last = feed.latest()
        assert feed.alive
        until(lambda: not feed.trouble, WITHIN)
        assert feed.process_id != killed
        first = feed.since(last.number)[0]
        assert first.number == last.number + 1
        assert feed.state == "streaming"
        after = feed.process_id
    assert gone(after)


def test_a_library_that_hangs_on_a_frame_is_ended_and_opened_again(monkeypatch):
    monkeypatch.setattr(feed_module, "SILENT", 3.0)
    monkeypatch.setattr(feed_module, "PAUSE", 0.1)
    with Feed(Stub("holding the interpreter between frames")) as feed:
        hung = feed.process_id
        until(lambda: bool(feed.trouble), WITHIN)
        assert feed.trouble == (
            "stub that is holding the interpreter between frames: no frame and no sign of life for "
            "3 s, ended; it is opened again in 0.1 s"
        )
        assert gone(hung)
        until(lambda: feed.latest().number >= 5, WITHIN)


def test_a_source_that_is_silent_for_long_is_left_alone(monkeypatch):
    monkeypatch.setattr(feed_module, "SILENT", 4.0)
    with Feed(Stub("hung between frames")) as feed:
        feed.first(WITHIN)
        until(lambda: feed.latest().age(time.monotonic()) > 6.0, WITHIN)
        assert (feed.state, feed.trouble) == ("streaming", "")


def test_a_source_that_declares_no_longest_gap_is_left_alone():
    with Feed(Undeclared()) as feed:
        feed.first(WITHIN)
        until(lambda: feed.latest().age(time.monotonic()) > 2.5, WITHIN)  # signs of life came
        assert (feed.state, feed.trouble) == ("streaming", "")


def test_a_source_whose_frames_have_stopped_for_too_long_is_opened_again():
    with Feed(Stub("hung between frames", longest_gap=0.5)) as feed:
        hung = feed.process_id
        until(lambda: bool(feed.trouble), WITHIN)
        assert feed.trouble == (
            "stub that is hung between frames: no frame for 0.5 s; it is opened again in 1 s"
        )
        until(lambda: feed.latest().number >= 5, WITHIN)
        assert gone(hung)


def test_a_source_that_waits_to_be_opened_again_is_closed_at_once(monkeypatch):
    monkeypatch.setattr(feed_module, "PAUSE", 600.0)
    feed = Feed(Stub("killed"))
    until(lambda: feed.state == "pausing", WITHIN)
    feed.close()  # it would take ten minutes
    assert gone(feed.process_id)
    assert feed.state == "closed"


def test_a_child_that_stands_still_does_not_hold_up_who_looks():
    with Feed(Stub()) as feed:
        feed.first(WITHIN)
        os.kill(feed.process_id, signal.SIGSTOP)
        until(lambda: feed.latest().age(time.monotonic()) > 0.2)
        slowest = 0.0
        for _ in range(100):
            began = time.monotonic()
            feed.latest(), feed.since(0), feed.last_seen()
            slowest = max(slowest, time.monotonic() - began)
        assert slowest < 2.0  # it would be for ever
    assert gone(feed.process_id)  # SIGTERM waits for a stopped process: it takes SIGKILL


def test_a_source_without_a_frame_says_so():
    with Feed(Stub(count=0)) as feed:
        until(lambda: not feed.alive)
        with pytest.raises(InputError) as refused:
            feed.first(1.0)
    assert str(refused.value) == "stub that is steady: it ended without a frame"


def test_what_a_library_prints_does_not_reach_the_terminal(capfd):
    with Feed(Stub("printing")) as feed:
        feed.first(WITHIN)
    assert tuple(capfd.readouterr()) == ("", "")


@pytest.mark.parametrize("timeout", [0.0, -1.0, 601.0, float("nan")])
def test_a_timeout_that_is_none_is_refused(timeout):
    with pytest.raises(InputError, match=r"timeout = .* is outside"):
        Feed(Stub(), timeout)


def test_closing_twice_is_no_matter_and_leaves_no_process():
    feed = Feed(Stub())
    feed.close()
    feed.close()
    assert gone(feed.process_id)
    assert not any(child.pid == feed.process_id for child in multiprocessing.active_children())


@pytest.mark.parametrize("how", ["steady", "hung between frames", "holding the interpreter"])
def test_a_child_whose_parent_is_killed_leaves(how):
    script = textwrap.dedent(
        f"""
        import sys, time
        sys.path[:0] = {sys.path!r}
        from app.live.sources.feed import Feed
        from tests.live.stub_sources import Stub
        if __name__ == "__main__":
            if {how!r} == "holding the interpreter":
                feed = Feed(Stub({how!r}), timeout=4.0)
                time.sleep(1.5)
            else:
                feed = Feed(Stub({how!r}))
                feed.first({WITHIN})
            print(feed.process_id, flush=True)
            sys.stdin.read()
        """
    )
    parent = subprocess.Popen(
        [sys.executable, "-c", script], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    with parent:
        child = int(parent.stdout.readline())
        assert not gone(child)
        parent.kill()
    until(lambda: gone(child))


def test_a_simulator_comes_through_a_feed_and_keeps_to_the_wall_clock():
    with Feed(SimulatedSource(StubSimulator, rate=100.0)) as feed:
        until(lambda: feed.latest() is not None and feed.latest().number >= 30)
        frames = feed.since(-1)
    assert frames[0].number == 0
    for frame in frames:
        assert isinstance(frame, MocapFrame)
        assert frame.sent == frame.number / 100.0
        assert frame.pose("car1") == Pose(frame.sent, 0.0, 0.0)
        assert frame.received - frames[0].received >= frame.sent - 0.005


def test_a_simulator_that_is_late_loses_frames_and_no_time(monkeypatch):
    clock = HandClock()
    monkeypatch.setattr(simulated_source, "time", clock)

    def work(seconds):
        clock.now += 0.305 if seconds == 0.02 else 0.001

    room = StubSimulator(work)
    played = SimulatedSource(lambda: room, rate=100.0).frames(clock)
    frames = list(islice(played, 5))
    assert [frame.number for frame in frames] == [0, 1, 2, 33, 34]
    assert [frame.received for frame in frames] == pytest.approx(
        [0.001, 0.011, 0.325, 0.331, 0.341]
    )
    assert [frame.pose("car1").x for frame in frames] == [0.0, 0.01, 0.02, 0.33, 0.34]
    played.close()
    assert room.closed


def test_a_simulator_at_no_rate_is_refused():
    with pytest.raises(InputError, match="rate = 0 Hz"):
        SimulatedSource(StubSimulator, rate=0.0)
