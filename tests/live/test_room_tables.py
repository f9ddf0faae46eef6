"""What tracking systems export is played as a recording: its bodies, its markers, its unit."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.live.control.pose import Pose, seen, unseen
from app.live.sources.axes import Axes
from app.live.sources.recorded_source import RecordedSource
from app.live.sources.room_tables import READERS, MarkedBody, kind_of_room, read_room_table
from app.live.sources.source_catalogue import open_source
from tests.live.recordings import write_trial
from tests.tracks.written_formats import (
    FORMATS,
    FRAMES,
    PLACES,
    RATE,
    SEEN,
    write_motive,
    write_nexus,
    write_rosbag,
    write_tracker,
    write_trc,
)
from worlds.input_error import InputError

HALF = math.sqrt(0.5)


def test_every_format_of_a_room_is_told_by_its_lines(tmp_path):
    rooms = [form for form in FORMATS if form.name in READERS]
    assert {form.name for form in rooms} == set(READERS)
    for form in rooms:
        path = form.written(tmp_path)
        file = sorted(path.iterdir())[0] if path.is_dir() else path
        assert kind_of_room(file.read_text().splitlines()) == form.name


def test_rigid_bodies_of_motive_are_poses_on_the_floor(tmp_path):
    write_motive(tmp_path / "take.csv")
    frames = RecordedSource(tmp_path / "take.csv", Axes(up="y")).recording()
    assert [frame.number for frame in frames] == list(range(FRAMES))
    assert [frame.time for frame in frames] == pytest.approx(np.arange(FRAMES) / RATE, abs=1e-6)
    for t, frame in enumerate(frames):
        for n, sighting in enumerate(frame.sightings):
            if not SEEN[t, n]:
                assert sighting == unseen(str(n + 1))
                continue
            x, y = PLACES[t, n]
            assert (sighting.pose.x, sighting.pose.y) == pytest.approx((x, y), abs=1e-6)
            assert sighting.pose.yaw == pytest.approx(0.0, abs=1e-9)


def test_objects_of_tracker_turn_about_the_vector_that_is_written(tmp_path):
    write_tracker(tmp_path / "tracker.csv")
    frames = RecordedSource(tmp_path / "tracker.csv").recording()
    assert frames[0].sightings[0].pose.yaw == pytest.approx(0.5)
    trial = read_room_table(tmp_path / "tracker.csv")
    assert trial.names == ("1", "2", "3")
    lengths = np.linalg.norm(trial.quaternion, axis=2)
    assert np.allclose(lengths[SEEN], 1.0)


def test_markers_make_a_body_that_is_declared(tmp_path):
    for write, file in ((write_nexus, "nexus.csv"), (write_trc, "walk.trc")):
        write(tmp_path / file)
        source = RecordedSource(tmp_path / file, bodies=(MarkedBody("car", "1", "3"),))
        first, gap = source.recording()[0], source.recording()[4]
        assert first.sightings == (seen("car", Pose(1.0, 2.0, 0.0)),)
        assert gap.sightings[0].valid  # only the marker 2 is hidden there
        hidden = RecordedSource(tmp_path / file, bodies=(MarkedBody("car", "1", "2"),))
        assert hidden.recording()[4].sightings == (unseen("car"),)
        with pytest.raises(InputError, match=r"no rotations: say which markers .*markers: 1, 2, 3"):
            RecordedSource(tmp_path / file).recording()
        with pytest.raises(InputError, match="unknown marker '9'"):
            RecordedSource(tmp_path / file, bodies=(MarkedBody("car", "1", "9"),)).recording()


def test_a_bag_is_a_source_by_its_address(tmp_path):
    (tmp_path / "bags").mkdir()
    write_rosbag(tmp_path / "bags")
    source = open_source(f"recorded:{tmp_path / 'bags' / '1.csv'}")
    assert source.recording()[0].sightings == (seen("1", Pose(1.0, 2.0, 0.0)),)


def test_the_unit_is_that_of_the_file_or_declared(tmp_path):
    path = tmp_path / "take.csv"
    write_motive(path)
    with pytest.raises(InputError, match=r"unit = m is declared, but .* is in mm"):
        open_source(f"recorded:{path}?up=y&unit=m")
    bare = path.read_text().replace("Length Units,Millimeters,", "")
    path.write_text(bare)
    with pytest.raises(InputError, match=r"has no unit: declare that of its numbers, \?unit="):
        open_source(f"recorded:{path}?up=y")
    pose = open_source(f"recorded:{path}?up=y&unit=mm").recording()[0].sightings[0].pose
    assert (pose.x, pose.y) == pytest.approx((1.0, 2.0), abs=1e-6)


@pytest.mark.parametrize("units", ["in", "", "inch"])
def test_a_trial_in_inches_or_without_a_unit_can_be_read(tmp_path, units):
    path = tmp_path / "trial.c3d"
    points = np.ones((3, 2, 2)) * [[[100.0]], [[0.0]], [[0.0]]]
    points[0, 1] = 120.0
    write_trial(path, ("rear", "front"), points, units=units)
    text = f"recorded:{path}?body=car,rear,front&unit=in"
    pose = open_source(text).recording()[0].sightings[0].pose
    assert (pose.x, pose.y) == pytest.approx((2.54, 0.0))


def test_a_marker_whose_residual_is_below_0_is_not_seen(tmp_path):
    ezc3d = pytest.importorskip("ezc3d")
    path = tmp_path / "trial.c3d"
    points = np.ones((3, 2, 3))
    points[0, 1] = 500.0
    write_trial(path, ("rear", "front"), points)
    trial = ezc3d.c3d(str(path))
    residuals = np.zeros((1, 2, 3))
    residuals[0, 1, 1] = -1.0
    trial["data"]["meta_points"]["residuals"] = residuals
    trial.write(str(path))
    source = RecordedSource(path, bodies=(MarkedBody("car", "rear", "front"),))
    assert [frame.sightings[0].valid for frame in source.recording()] == [True, False, True]


def qtm_bodies(path):
    """Two bodies of QTM, one turned by 90 degrees about z, by columns of the matrix."""
    one = "10 20 30 0 0 90 0.5 0 1 0 -1 0 0 0 0 1"
    none = "0 0 0 0 0 0 0 0 0 0 0 0 0 0 0 0"
    rows = [f"{one} {none}", f"{one} {one}"]
    header = "NO_OF_FRAMES 2\nNO_OF_BODIES 2\nFREQUENCY 100\nDATA_INCLUDED 6D\nBODY_NAMES a b\n"
    names = " ".join(
        ["X Y Z Roll Pitch Yaw Residual " + " ".join(f"Rot[{k}]" for k in range(9))] * 2
    )
    path.write_text((header + names + "\n" + "\n".join(rows) + "\n").replace(" ", "\t"))


def test_bodies_of_qtm_are_turned_as_their_matrix(tmp_path):
    qtm_bodies(tmp_path / "six.tsv")
    trial = read_room_table(tmp_path / "six.tsv")
    assert trial.quaternion[0, 0] == pytest.approx([0.0, 0.0, HALF, HALF])
    assert np.isnan(trial.position[0, 1]).all()
    pose = RecordedSource(tmp_path / "six.tsv").recording()[1].sightings[1].pose
    assert (pose.x, pose.y, pose.yaw) == pytest.approx((0.01, 0.02, math.pi / 2))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("Format Version,1.23\n", "no row of columns"),
        ("Trajectories\nfast\n", "in no format of a room"),
        ("Trajectories\n100\n", "ends before its first frame"),
        ("PathFileType\t4\nDataRate\n", "ends before its first frame"),
        ("NO_OF_FRAMES\t2\nFREQUENCY\t100\n1\t2\t3\n", "neither MARKER_NAMES nor BODY_NAMES"),
        ("%time,field.x\n1,2\n", "no column field.pose.position.x"),
        ("0 1 2 3 0 0 0 1\n0 1 2 3 0 0 x 1\n0 1 2 3 0 0 0 1\n", "in no format of a room"),
    ],
)
def test_what_is_no_recording_of_a_room_is_refused_in_a_line(tmp_path, text, says):
    (tmp_path / "none.txt").write_text(text)
    with pytest.raises(InputError) as refused:
        RecordedSource(tmp_path / "none.txt").recording()
    assert says in str(refused.value)
    assert "\n" not in str(refused.value)
