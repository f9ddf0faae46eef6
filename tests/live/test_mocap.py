"""Motion capture end to end: an emulated NatNet server, the real `motioncapture`, a feed."""

import math
import sys
import threading
import time
from itertools import islice
from types import SimpleNamespace

import pytest

from app.live.control.pose import Pose, seen, unseen
from app.live.sources import mocap
from app.live.sources.axes import Axes
from app.live.sources.feed import Feed
from app.live.sources.mocap import MotionCapture
from app.live.sources.source_catalogue import open_source
from tests.live.natnet_emulator import Body, NatNetEmulator
from tests.live.waiting import until
from worlds.input_error import InputError

pytest.importorskip("motioncapture")

HALF = math.sqrt(0.5)
Y_UP = Axes(up="y")


def standing(_seconds):
    """Two cars at rest; y is up. car2 is turned by 90 degrees to the left seen from above."""
    return {
        "car1": Body((1.0, 0.05, -2.0), (0.0, 0.0, 0.0, 1.0)),
        "car2": Body((-0.5, 0.05, 0.25), (0.0, HALF, 0.0, HALF)),
    }


def circling(seconds):
    """One car on a circle of 2 m at 1 rad/s, anticlockwise from above, its nose along its way."""
    yaw = seconds + math.pi / 2
    point = (2.0 * math.cos(seconds), 0.05, -2.0 * math.sin(seconds))
    return {"car1": Body(point, (0.0, math.sin(yaw / 2), 0.0, math.cos(yaw / 2)))}


def optitrack(server, axes=Y_UP):
    return MotionCapture("optitrack", "127.0.0.1", axes, server.options)


@pytest.mark.parametrize("version", [(3, 1), (4, 0)])
@pytest.mark.parametrize("multicast", [False, True])
def test_poses_come_through_the_real_library(version, multicast):
    with (
        NatNetEmulator(standing, version=version, multicast=multicast) as server,
        Feed(optitrack(server)) as feed,
    ):
        frame = feed.first(60.0)
        assert 0.0 < frame.age(time.monotonic()) < 10.0
        assert frame.pose("car1") == Pose(1.0, 2.0, 0.0)
        assert frame.pose("car2") == Pose(-0.5, -0.25, pytest.approx(math.pi / 2, abs=1e-6))
        assert server.requests == [0, 4]
        assert feed.state == "streaming"
    assert feed.state == "closed"


def test_frames_are_counted_and_stamped_by_one_clock():
    began = time.monotonic()
    with NatNetEmulator(circling) as server, Feed(optitrack(server)) as feed:
        feed.first(60.0)
        until(lambda: feed.latest().number >= 30)
        frames = feed.since(9)
    assert [frame.number for frame in frames] == list(range(10, 10 + len(frames)))
    stamps = [frame.received for frame in frames]
    assert stamps == sorted(stamps)
    assert began < stamps[0]
    assert stamps[-1] < time.monotonic()
    for frame in frames:
        pose = frame.pose("car1")
        angle = math.atan2(pose.y, pose.x)
        assert math.hypot(pose.x, pose.y) == pytest.approx(2.0, abs=1e-5)
        off = math.remainder(pose.yaw - angle - math.pi / 2, math.tau)
        assert off == pytest.approx(0.0, abs=1e-5)


def test_a_body_that_is_not_tracked_is_missing_and_its_last_sight_grows_old():
    with NatNetEmulator(standing) as server, Feed(optitrack(server)) as feed:
        feed.first(60.0)
        server.drop("car2")
        until(lambda: feed.latest().pose("car2") is None)
        lost = feed.last_seen()["car2"]
        number = feed.latest().number
        until(lambda: feed.latest().number > number + 5)
        assert all(frame.pose("car2") is None for frame in feed.since(number))
        assert all(frame.pose("car1") is not None for frame in feed.since(number))
        assert feed.last_seen()["car2"] == lost
        assert feed.last_seen()["car1"].received > lost.received
        server.find("car2")
        until(lambda: feed.latest().pose("car2") is not None)


def test_a_stream_that_stops_grows_old_and_comes_back():
    with NatNetEmulator(standing) as server, Feed(optitrack(server)) as feed:
        feed.first(60.0)
        server.stop()
        until(lambda: feed.latest().age(time.monotonic()) > 0.3)
        assert feed.alive
        assert feed.trouble == ""
        number = feed.latest().number
        server.go()
        until(lambda: feed.latest().number > number)


def test_a_frozen_stream_is_fresh_but_stands_still_within_its_noise():
    with NatNetEmulator(circling, seed=3) as server, Feed(optitrack(server)) as feed:
        feed.first(60.0)
        server.freeze(noise=0.0005)
        number = feed.latest().number + 5
        until(lambda: feed.latest().number > number + 30)
        poses = [frame.pose("car1") for frame in feed.since(number)]
    assert len({(pose.x, pose.y) for pose in poses}) == len(poses)
    assert max(math.dist((p.x, p.y), (poses[0].x, poses[0].y)) for p in poses) < 0.005


def test_a_server_that_does_not_answer_is_given_up_in_one_line():
    with NatNetEmulator(standing, mute=True) as server:
        began = time.monotonic()
        with Feed(optitrack(server), timeout=4.0) as feed:
            assert feed.latest() is None
            with pytest.raises(InputError) as refused:
                feed.first(60.0)
            assert 4.0 <= time.monotonic() - began < 60.0
            assert server.requests == [0]
            assert not feed.alive
    assert str(refused.value) == (
        "optitrack at 127.0.0.1 (y up, m): no connection within 4 s, given up"
    )
    assert feed.state == "failed"


def test_a_system_that_refuses_says_so_before_the_timeout():
    with Feed(MotionCapture("qualisys", "127.0.0.1"), timeout=60.0) as feed:
        until(lambda: not feed.alive)
    assert feed.trouble.startswith("qualisys at 127.0.0.1 (z up, m): Error connecting QTM")


class HidingVicon:
    """A library whose second frame has a hidden subject, and whose fourth is broken."""

    def __init__(self):
        self.frame = 0

    def connect(self, _system, _options):
        return self

    def waitForNextFrame(self):  # noqa: N802
        self.frame += 1

    @property
    def rigidBodies(self):  # noqa: N802
        if self.frame in (2, 4):
            raise RuntimeError("Unknown rigid body!" if self.frame == 2 else "no more")
        turn = SimpleNamespace(x=0.0, y=0.0, z=0.0, w=1.0)
        return {"car1": SimpleNamespace(position=(1.0, 2.0, 0.0), rotation=turn)}


def test_a_hidden_subject_makes_a_frame_without_bodies_and_no_end(monkeypatch):
    monkeypatch.setitem(sys.modules, "motioncapture", HidingVicon())
    monkeypatch.setattr(mocap, "demand", lambda *_: None)
    frames = MotionCapture("vicon", "lab").frames(threading.Event())
    told = (seen("car1", Pose(1.0, 2.0, 0.0)),)
    assert [(f.number, f.sightings) for f in islice(frames, 3)] == [(0, told), (1, ()), (2, told)]
    with pytest.raises(RuntimeError, match="no more"):
        next(frames)


def test_the_mock_of_the_library_gives_its_bodies():
    bodies = "car1(1,2,3,1,0,0,0);car2(4,5,6,0,0,0,1);tipped(0,0,0,0.7071068,0,0.7071068,0)"
    source = open_source(f"mock:?rigid_bodies={bodies}&frequency=50")
    with Feed(source) as feed:
        frame = feed.first(60.0)
    assert frame.pose("car1") == Pose(1.0, 2.0, 0.0)
    assert frame.pose("car2") == Pose(4.0, 5.0, pytest.approx(math.pi, abs=1e-6))
    assert unseen("tipped") in frame.sightings


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("optitrack:motive", "host = motive is not a numeric address such as 192.168.1.5"),
        ("optitrack:", "optitrack has no host: write optitrack:HOST"),
        ("optitrack:10.0.0.1?up=x", "unknown up axis 'x'"),
        ("optitrack:10.0.0.1?unit=inch", "unknown unit 'inch'"),
        ("optitrack:10.0.0.1?nose=front", "unknown nose axis 'front'"),
        ("optitrack:10.0.0.1?port=1510", "unknown option 'port': did you mean 'port_command'?"),
        ("optitrack:10.0.0.1?port_command=70000", "port_command = 70000 is no whole number"),
        ("optitrack:10.0.0.1?up=y&up=z", "up is given twice"),
        ("vicon:lab?up=y", "vicon is given in metres with z up, not with y up, m"),
        ("vikon:lab", "unknown kind of source 'vikon': did you mean 'vicon'?"),
        ("optitrack", "source 'optitrack' is not of the form kind:place"),
        ("optitrack:10.0.0.1?up", "'up' is not of the form option=value"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line_with_the_text(text, says):
    with pytest.raises(InputError) as refused:
        open_source(text)
    assert str(refused.value).startswith(says)
    assert text in str(refused.value)
    assert "\n" not in str(refused.value)


def test_the_usual_axes_of_a_system_are_taken_and_can_be_declared():
    assert open_source("optitrack:10.0.0.1").axes == Axes("y", "m", "x")
    assert open_source("vicon:lab").axes == Axes("z", "m", "x")
    assert open_source("vrpn:lab?unit=mm&nose=-y").axes == Axes("z", "mm", "-y")
    assert open_source("optitrack:10.0.0.1?port_command=1510").options == {"port_command": "1510"}
