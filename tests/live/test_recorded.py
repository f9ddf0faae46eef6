"""Recordings as sources: C3D trials and tables of poses, their gaps and their errors."""

import math
import threading
import time
from pathlib import Path

import numpy as np
import pyarrow
import pyarrow.parquet
import pytest

from app.live.pose import Pose, seen, unseen
from app.live.sources import recorded
from app.live.sources.axes import Axes
from app.live.sources.feed import Feed
from app.live.sources.opening import open_source
from app.live.sources.recorded import Recorded
from app.live.sources.recording import RecordedFrame
from app.live.sources.trial import MarkedBody
from tests.live.waiting import HandClock, until
from worlds.refusal import Refusal

HEADER = "t,frame,name,x,y,z,qx,qy,qz,qw,valid"
ROWS = [
    "0.00,10,car1,1.0,2.0,0.05,0,0,0,1,1",
    "0.00,10,car2,3.0,4.0,0.05,0,0,0.7071067811865476,0.7071067811865476,true",
    "0.01,11,car1,1.1,2.0,0.05,0,0,0,1,1",
    "0.01,11,car2,,,,,,,,0",
    "0.04,14,car2,3.2,4.0,0.05,0,0,1,0,1",
]
RECORDING = [
    RecordedFrame(
        0.0, 10, (seen("car1", Pose(1.0, 2.0, 0.0)), seen("car2", Pose(3.0, 4.0, math.pi / 2)))
    ),
    RecordedFrame(0.01, 11, (seen("car1", Pose(1.1, 2.0, 0.0)), unseen("car2"))),
    RecordedFrame(0.04, 14, (seen("car2", Pose(3.2, 4.0, math.pi)),)),
]


def csv_of(folder, rows, header=HEADER):
    path = folder / "trial.csv"
    path.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    return path


def parquet_of(folder, **changed):
    columns = {
        "t": [0.0, 0.0, 0.01, 0.01, 0.04],
        "frame": [10, 10, 11, 11, 14],
        "name": ["car1", "car2", "car1", "car2", "car2"],
        "x": [1.0, 3.0, 1.1, None, 3.2],
        "y": [2.0, 4.0, 2.0, None, 4.0],
        "z": [0.05, 0.05, 0.05, None, 0.05],
        "qx": [0.0, 0.0, 0.0, None, 0.0],
        "qy": [0.0, 0.0, 0.0, None, 0.0],
        "qz": [0.0, math.sqrt(0.5), 0.0, None, 1.0],
        "qw": [1.0, math.sqrt(0.5), 1.0, None, 0.0],
        "valid": [True, True, True, False, True],
    } | changed
    path = folder / "trial.parquet"
    kept = {name: values for name, values in columns.items() if values is not None}
    pyarrow.parquet.write_table(pyarrow.table(kept), path)
    return path


def nearly(frames):
    """The frames with yaw to 12 digits."""
    return [
        RecordedFrame(
            m.time,
            m.number,
            tuple(
                seen(s.name, Pose(s.pose.x, s.pose.y, round(s.pose.yaw, 12))) if s.pose else s
                for s in m.sightings
            ),
        )
        for m in frames
    ]


def test_a_csv_table_is_read_and_its_gaps_stay_gaps(tmp_path):
    assert nearly(Recorded(csv_of(tmp_path, ROWS)).recording()) == nearly(RECORDING)


def test_a_parquet_table_is_read_as_the_csv(tmp_path):
    assert nearly(Recorded(parquet_of(tmp_path)).recording()) == nearly(RECORDING)


def test_columns_may_stand_in_any_order_and_others_are_left_alone(tmp_path):
    header = HEADER.split(",")
    order = [*reversed(header), "remark"]
    rows = [
        ",".join(dict(zip(header, row.split(","), strict=True)).get(c, "hm") for c in order)
        for row in ROWS
    ]
    source = Recorded(csv_of(tmp_path, rows, ",".join(order)))
    assert nearly(source.recording()) == nearly(RECORDING)


def test_the_axes_of_a_table_are_declared(tmp_path):
    row = "0,1,car1,1000,50,-2000,0,0.7071067811865476,0,0.7071067811865476,1"
    [frame] = Recorded(csv_of(tmp_path, [row]), Axes("y", "mm")).recording()
    pose = frame.sightings[0].pose
    assert (pose.x, pose.y, pose.yaw) == pytest.approx((1.0, 2.0, math.pi / 2), abs=1e-12)


def test_a_car_on_its_nose_is_not_tracked(tmp_path):
    row = "0,1,car1,1,2,0,0,0.7071067811865476,0,0.7071067811865476,1"
    [frame] = Recorded(csv_of(tmp_path, [row])).recording()
    assert frame.sightings == (unseen("car1"),)


@pytest.mark.parametrize(
    ("line", "row", "says"),
    [
        (3, "0.00,10,car2,3.0,abc,0,0,0,0,1,1", ", line 3, column y: 'abc' is not a number"),
        (3, "0.00,10,car2,3.0,,0,0,0,0,1,1", ", line 3, column y: it is empty"),
        (3, "0.00,10,car2,3.0,nan,0,0,0,0,1,1", ", line 3, column y: 'nan' is not a number"),
        (3, "0.00,10,car2,3,4,0,0,0,0,2,1", ", line 3, columns qx to qw: a quaternion of length 2"),
        (3, "0.00,10,car2,3,4,0,0,0,0,1,maybe", ", line 3, column valid: 'maybe' is none of 1, "),
        (3, "0.00,10,,3,4,0,0,0,0,1,1", ", line 3, column name: it is empty"),
        (3, "0.00,10.5,car2,3,4,0,0,0,0,1,1", ", line 3, column frame: '10.5' is not a whole"),
        (3, "soon,10,car2,3,4,0,0,0,0,1,1", ", line 3, column t: 'soon' is not a number"),
        (3, "0.005,10,car2,3,4,0,0,0,0,1,1", ", line 3: t = 0.005, but frame 10 began with t = 0"),
        (3, "0.00,10,car1,3,4,0,0,0,0,1,1", ", line 3: 'car1' is twice in frame 10"),
        (4, "0.00,11,car1,3,4,0,0,0,0,1,1", ", line 4: t = 0 does not come after 0, that of"),
        (4, "0.01,9,car1,3,4,0,0,0,0,1,1", ", line 4: frame = 9 comes after frame 10: frames"),
        (5, "0.01,11,car2,3,4,0,0,0,1,1", ", line 5: it does not have 11 columns, as the first"),
        (5, "0.01,11,car2,3,4,0,0,0,0,1,1,1", ", line 5: it does not have 11 columns, as the"),
        (6, '0.04,14,"car2,3,4,0,0,0,0,1,1', ", line 6: unexpected end of data"),
    ],
)
def test_what_is_wrong_in_a_table_is_named_by_line_and_column(tmp_path, line, row, says):
    rows = list(ROWS)
    rows[line - 2] = row
    path = csv_of(tmp_path, rows)
    with pytest.raises(Refusal) as refused:
        Recorded(path).recording()
    assert str(refused.value).startswith(f"{path}{says}")


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"x": [1.0, math.nan, 1.1, None, 3.2]}, ", row 2, column x: nan is not a number"),
        ({"x": [1.0, 3.0, None, None, 3.2]}, ", row 3, column x: it is empty"),
        ({"x": [True, True, True, None, True]}, ", row 1, column x: True is not a number"),
        ({"qx": None, "valid": None}, " has no column qx, valid: a table of poses needs t, frame"),
    ],
)
def test_what_is_wrong_in_a_parquet_table_is_named_by_row_and_column(tmp_path, changed, says):
    path = parquet_of(tmp_path, **changed)
    with pytest.raises(Refusal) as refused:
        Recorded(path).recording()
    assert str(refused.value).startswith(f"{path}{says}")


def test_files_that_are_none_are_refused_in_one_line(tmp_path):
    wrong = {
        "empty.csv": b"",
        "no-rows.csv": HEADER.encode() + b"\n",
        "twice.csv": f"{HEADER},x\n".encode(),
        "binary.csv": b"\xff\xfe\x00t",
        "wrong.parquet": b"PAR2",
        "wrong.c3d": b"not a trial",
    }
    says = {
        "empty.csv": "empty.csv has no column t, frame",
        "no-rows.csv": "no-rows.csv has no rows",
        "twice.csv": "twice.csv has the column x twice",
        "binary.csv": "binary.csv is not a CSV file in UTF-8",
        "wrong.parquet": "wrong.parquet is not a Parquet file: ",
        "wrong.c3d": "wrong.c3d is not a C3D file",
        "none.csv": "none.csv cannot be read: No such file",
        "none.parquet": "none.parquet cannot be read: ",
        "none.c3d": "none.c3d cannot be read: there is no such file",
        "trial.txt": "unknown kind of recording '.txt'",
    }
    for name, content in wrong.items():
        (tmp_path / name).write_bytes(content)
    for name, said in says.items():
        with pytest.raises(Refusal) as refused:
            Recorded(tmp_path / name).recording()
        assert said in str(refused.value)
        assert "\n" not in str(refused.value)


def write_trial(path, labels=(), points=None, matrices=None, names=(), units="mm", rate=100.0):
    """A C3D file with markers (3, M, F) and rotations (4, 4, B, F)."""
    ezc3d = pytest.importorskip("ezc3d")
    trial = ezc3d.c3d()
    frames = points.shape[2] if points is not None else matrices.shape[3]
    trial["parameters"]["POINT"]["RATE"]["value"] = [rate]
    trial["parameters"]["POINT"]["UNITS"]["value"] = [units]
    trial["parameters"]["POINT"]["LABELS"]["value"] = tuple(labels)
    if points is not None:
        trial["data"]["points"] = np.concatenate([points, np.ones((1, len(labels), frames))])
    if matrices is not None:
        trial.add_parameter("ROTATION", "LABELS", list(names))
        trial.add_parameter("ROTATION", "RATE", [rate])
        trial["data"]["rotations"] = matrices
    trial.write(str(path))


def test_a_trial_of_markers_is_read_back_and_gaps_stay_gaps(tmp_path):
    path = tmp_path / "trial.c3d"
    points = np.zeros((3, 3, 4))
    points[:, 0] = np.array([1000.0, 2000.0, 50.0])[:, None] + [[0, 10, 20, 30], [0] * 4, [0] * 4]
    points[:, 1] = points[:, 0] + np.array([0.0, 200.0, 5.0])[:, None]
    points[:, 2] = 77.0
    points[:, 1, 2] = np.nan  # the front marker is hidden in frame 2
    points[:, 0, 3] = points[:, 1, 3]  # in frame 3 the two are one
    write_trial(path, ("car1_rear", "car1_front", "else"), points)
    source = Recorded(path, bodies=(MarkedBody("car1", "car1_rear", "car1_front"),))
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
    frames = Recorded(path, Axes(up="y")).recording()
    assert [frame.time for frame in frames] == [0.0, 0.02, 0.04]
    assert frames[0].sightings[0] == seen("car1", Pose(1.0, 2.0, 0.0))
    assert frames[0].sightings[1].pose.yaw == pytest.approx(turn, abs=1e-6)
    assert frames[1].sightings[1] == unseen("car2")
    assert frames[2].sightings[1].pose is not None


def test_what_a_trial_does_not_hold_is_refused(tmp_path):
    path = tmp_path / "trial.c3d"
    write_trial(path, ("rear", "front"), np.ones((3, 2, 3)))
    with pytest.raises(Refusal, match=r"no rotations: say which markers .*markers: rear, front"):
        Recorded(path).recording()
    with pytest.raises(Refusal, match="unknown marker 'frnt': did you mean 'front'"):
        Recorded(path, bodies=(MarkedBody("car1", "rear", "frnt"),)).recording()
    write_trial(path, ("rear", "front"), np.ones((3, 2, 3)), units="inch")
    with pytest.raises(Refusal, match=r"unknown unit of length 'inch'.*POINT:UNITS"):
        Recorded(path, bodies=(MarkedBody("car1", "rear", "front"),)).recording()


@pytest.mark.parametrize("factor", [0.5, 1.0, 4.0])
def test_a_recording_is_played_at_its_times_by_the_factor(tmp_path, monkeypatch, factor):
    clock = HandClock()
    monkeypatch.setattr(recorded, "time", clock)
    times = [7.0, 7.02, 7.04, 7.5, 7.51]
    rows = [f"{t},{k},car1,{k},0,0,0,0,0,1,1" for k, t in enumerate(times)]
    frames = list(Recorded(csv_of(tmp_path, rows), factor=factor).frames(clock))
    assert [frame.number for frame in frames] == [0, 1, 2, 3, 4]
    assert [frame.pose("car1").x for frame in frames] == [0, 1, 2, 3, 4]
    assert [frame.sent for frame in frames] == pytest.approx(times)
    at = [(t - 7.0) / factor for t in times]
    assert [frame.received for frame in frames] == pytest.approx(at)


def test_a_recording_that_is_late_catches_up(tmp_path, monkeypatch):
    clock = HandClock()
    monkeypatch.setattr(recorded, "time", clock)
    rows = [f"{0.01 * k},{k},car1,0,0,0,0,0,0,1,1" for k in range(5)]
    received = []
    for frame in Recorded(csv_of(tmp_path, rows)).frames(clock):
        received.append(frame.received)
        clock.now += 0.025 if frame.number == 0 else 0.0
    assert received == pytest.approx([0.0, 0.025, 0.025, 0.03, 0.04])


def test_a_recording_that_begins_anew_goes_on_in_time_and_number(tmp_path):
    source = Recorded(csv_of(tmp_path, ROWS), factor=20.0, again=True)
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
    assert source == Recorded(Path(path), factor=0.1)
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
        with pytest.raises(Refusal) as refused:
            open_source(text)
        assert says in str(refused.value)
        assert "\n" not in str(refused.value)
