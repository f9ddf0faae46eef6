"""Recordings as sources: trials in C3D, how they are played, and the texts that name them."""

import math
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from app.live.control.pose import Pose, seen, unseen
from app.live.sources import recorded_source
from app.live.sources.axes import Axes
from app.live.sources.c3d_trial import MarkedBody
from app.live.sources.feed import Feed
from app.live.sources.recorded_source import RecordedSource
from app.live.sources.source_catalogue import open_source
from tests.live.recordings import ROWS, csv_of, write_trial
from tests.live.waiting import HandClock, until
from worlds.input_error import InputError


def test_a_trial_of_markers_is_read_back_and_gaps_stay_gaps(tmp_path):
    path = tmp_path / "trial.c3d"
    points = np.zeros((3, 3, 4))
    points[:, 0] = np.array([1000.0, 2000.0, 50.0])[:, None] + [[0, 10, 20, 30], [0] * 4, [0] * 4]
    points[:, 1] = points[:, 0] + np.array([0.0, 200.0, 5.0])[:, None]
    points[:, 2] = 77.0
    points[:, 1, 2] = np.nan  # the front marker is hidden in frame 2
    points[:, 0, 3] = points[:, 1, 3]  # in frame 3 the two are one
    write_trial(path, ("car1_rear", "car1_front", "else"), points)
    source = RecordedSource(path, bodies=(MarkedBody("car1", "car1_rear", "car1_front"),))
    frames = source.recording()
    assert [(frame.time, frame.number) for frame in frames] == [
        (0.0, 0), (0.01, 1), (0.02, 2), (0.03, 3)
    ]  # fmt: skip
    first, second, hidden, one = (frame.sightings[0] for frame in frames)
    for sighting, x in ((first, 1.0), (second, 1.01)):
        pose = sighting.pose
        assert (pose.x, pose.y, pose.yaw) == pytest.approx((x, 2.0, math.pi / 2), abs=1e-6)
    assert hidden == one == unseen("car1")


def test_a_trial_of_rotations_is_read_back_and_gaps_stay_gaps(tmp_path):
    path = tmp_path / "trial.c3d"
    matrices = np.zeros((4, 4, 2, 3))
    matrices[:] = np.eye(4)[:, :, None, None]
    matrices[:3, 3, 0] = np.array([1.0, 0.5, -2.0])[:, None]
    turn = math.radians(30.0)  # about y, which is up
    matrices[:3, :3, 1] = np.array(
        [[math.cos(turn), 0, math.sin(turn)], [0, 1, 0], [-math.sin(turn), 0, math.cos(turn)]]
    )[:, :, None]
    matrices[:, :, 1, 1] = np.nan
    write_trial(path, ("m",), np.ones((3, 1, 3)), matrices, ("car1", "car2"), units="m", rate=50.0)
    frames = RecordedSource(path, Axes(up="y")).recording()
    assert [frame.time for frame in frames] == [0.0, 0.02, 0.04]
    assert frames[0].sightings[0] == seen("car1", Pose(1.0, 2.0, 0.0))
    assert frames[0].sightings[1].pose.yaw == pytest.approx(turn, abs=1e-6)
    assert frames[1].sightings[1] == unseen("car2")
    assert frames[2].sightings[1].pose is not None


def test_what_a_trial_does_not_hold_is_refused(tmp_path):
    path = tmp_path / "trial.c3d"
    write_trial(path, ("rear", "front"), np.ones((3, 2, 3)))
    with pytest.raises(InputError, match=r"no rotations: say which markers .*markers: rear, front"):
        RecordedSource(path).recording()
    with pytest.raises(InputError, match="unknown marker 'frnt': did you mean 'front'"):
        RecordedSource(path, bodies=(MarkedBody("car1", "rear", "frnt"),)).recording()
    write_trial(path, ("rear", "front"), np.ones((3, 2, 3)), units="inch")
    with pytest.raises(InputError, match=r"unknown unit of length 'inch'.*POINT:UNITS"):
        RecordedSource(path, bodies=(MarkedBody("car1", "rear", "front"),)).recording()


@pytest.mark.parametrize("factor", [0.5, 1.0, 4.0])
def test_a_recording_is_played_at_its_times_by_the_factor(tmp_path, monkeypatch, factor):
    clock = HandClock()
    monkeypatch.setattr(recorded_source, "time", clock)
    times = [7.0, 7.02, 7.04, 7.5, 7.51]
    rows = [f"{t},{k},car1,{k},0,0,0,0,0,1,1" for k, t in enumerate(times)]
    frames = list(RecordedSource(csv_of(tmp_path, rows), factor=factor).frames(clock))
    assert [frame.number for frame in frames] == [0, 1, 2, 3, 4]
    assert [frame.pose("car1").x for frame in frames] == [0, 1, 2, 3, 4]
    assert [frame.sent for frame in frames] == pytest.approx(times)
    at = [(t - 7.0) / factor for t in times]
    assert [frame.received for frame in frames] == pytest.approx(at)


def test_a_recording_that_is_late_catches_up(tmp_path, monkeypatch):
    clock = HandClock()
    monkeypatch.setattr(recorded_source, "time", clock)
    rows = [f"{0.01 * k},{k},car1,0,0,0,0,0,0,1,1" for k in range(5)]
    received = []
    for frame in RecordedSource(csv_of(tmp_path, rows)).frames(clock):
        received.append(frame.received)
        clock.now += 0.025 if frame.number == 0 else 0.0
    assert received == pytest.approx([0.0, 0.025, 0.025, 0.03, 0.04])


def test_a_recording_that_begins_anew_goes_on_in_time_and_number(tmp_path):
    source = RecordedSource(csv_of(tmp_path, ROWS), factor=20.0, again=True)
    stop = threading.Event()
    frames = []
    for frame in source.frames(stop):
        frames.append(frame)
        if len(frames) == 7:
            stop.set()
    assert [frame.number for frame in frames] == [10, 11, 14, 15, 16, 19, 20]
    assert [frame.sent for frame in frames] == pytest.approx(
        [0.0, 0.01, 0.04, 0.06, 0.07, 0.10, 0.12]
    )


def test_a_recording_comes_through_a_feed(tmp_path):
    path = csv_of(tmp_path, ROWS)
    source = open_source(f"recorded:{path}?factor=0.1")
    assert source == RecordedSource(Path(path), factor=0.1)
    with Feed(source) as feed:
        feed.first(10.0)
        until(lambda: not feed.alive)
        frames = feed.since(-1)
        assert (feed.state, feed.trouble) == ("ended", "")
    assert [frame.sightings for frame in frames] == [m.sightings for m in source.recording()]
    assert frames[-1].received - frames[0].received >= 0.38
    assert frames[-1].age(time.monotonic()) < 10.0


def test_texts_that_name_recordings(tmp_path):
    path = tmp_path / "trial.c3d"
    write_trial(path, ("rear", "front"), np.ones((3, 2, 3)))
    source = open_source(f"recorded:{path}?body=car1,rear,front&body=car2,front,rear&again=yes")
    assert source.bodies == (
        MarkedBody("car1", "rear", "front"),
        MarkedBody("car2", "front", "rear"),
    )
    assert source.again
    table = csv_of(tmp_path, ROWS)
    for text, says in (
        (f"recorded:{path}?body=car1,rear", "body = car1,rear is not of the form NAME,REAR,FRONT"),
        (f"recorded:{table}?body=car1,rear,front", "holds poses, not markers"),
        (f"recorded:{table}?factor=0", "factor = 0 is outside [0.001, 1000]"),
        (f"recorded:{table}?factor=fast", "factor = fast is outside [0.001, 1000]"),
        (f"recorded:{table}?again=1", "again = 1 is neither yes nor no"),
        (f"recorded:{table}?speed=2", "unknown option 'speed'"),
        (f"recorded:{tmp_path / 'none.csv'}", "cannot be read"),
    ):
        with pytest.raises(InputError) as refused:
            open_source(text)
        assert says in str(refused.value)
        assert "\n" not in str(refused.value)
