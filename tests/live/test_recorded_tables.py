"""Tables of poses, in CSV and Parquet: their gaps and their errors."""

import math

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from agents.recordings import parquet_table
from app.live.control.pose import Pose, seen, unseen
from app.live.sources.axes import Axes
from app.live.sources.pose_source import RecordedFrame
from app.live.sources.recorded_source import RecordedSource
from tests.live.recordings import HEADER, ROWS, csv_of
from worlds.input_error import InputError

RECORDING = [
    RecordedFrame(
        0.0,
        10,
        (seen("car1", Pose(1.0, 2.0, 0.0)), seen("car2", Pose(3.0, 4.0, math.pi / 2))),
    ),
    RecordedFrame(0.01, 11, (seen("car1", Pose(1.1, 2.0, 0.0)), unseen("car2"))),
    RecordedFrame(0.04, 14, (seen("car2", Pose(3.2, 4.0, math.pi)),)),
]


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
    pq.write_table(pa.table(kept), path)
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
    assert nearly(RecordedSource(csv_of(tmp_path, ROWS)).recording()) == nearly(RECORDING)


def test_a_parquet_table_is_read_as_the_csv(tmp_path):
    assert nearly(RecordedSource(parquet_of(tmp_path)).recording()) == nearly(RECORDING)


def test_columns_may_stand_in_any_order_and_others_are_left_alone(tmp_path):
    header = HEADER.split(",")
    order = [*reversed(header), "remark"]
    rows = [
        ",".join(dict(zip(header, row.split(","), strict=True)).get(c, "hm") for c in order)
        for row in ROWS
    ]
    source = RecordedSource(csv_of(tmp_path, rows, ",".join(order)))
    assert nearly(source.recording()) == nearly(RECORDING)


def test_the_axes_of_a_table_are_declared(tmp_path):
    row = "0,1,car1,1000,50,-2000,0,0.7071067811865476,0,0.7071067811865476,1"
    [frame] = RecordedSource(csv_of(tmp_path, [row]), Axes("y", "mm")).recording()
    pose = frame.sightings[0].pose
    assert (pose.x, pose.y, pose.yaw) == pytest.approx((1.0, 2.0, math.pi / 2), abs=1e-12)


def test_a_car_on_its_nose_is_not_tracked(tmp_path):
    row = "0,1,car1,1,2,0,0,0.7071067811865476,0,0.7071067811865476,1"
    [frame] = RecordedSource(csv_of(tmp_path, [row])).recording()
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
    with pytest.raises(InputError) as refused:
        RecordedSource(path).recording()
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
    with pytest.raises(InputError) as refused:
        RecordedSource(path).recording()
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
        "wrong.parquet": "wrong.parquet' is not a Parquet file",
        "wrong.c3d": "wrong.c3d is not a C3D file",
        "none.csv": "none.csv cannot be read: No such file",
        "none.parquet": "none.parquet' cannot be read: No such file",
        "none.c3d": "none.c3d cannot be read: there is no such file",
        "trial.doc": "unknown kind of recording '.doc'",
        "none.trc": "none.trc cannot be read: there is no such file",
    }
    for name, content in wrong.items():
        (tmp_path / name).write_bytes(content)
    for name, said in says.items():
        with pytest.raises(InputError) as refused:
            RecordedSource(tmp_path / name).recording()
        assert said in str(refused.value)
        assert "\n" not in str(refused.value)


def test_a_small_table_of_endless_rows_is_refused_before_it_is_unpacked(tmp_path, monkeypatch):
    monkeypatch.setattr(parquet_table, "MOST_NUMBERS", 1000)
    rows = 5000
    columns = {name: pa.array(np.zeros(rows)) for name in ("t", "x", "y", "z")}
    columns |= {name: pa.array(np.zeros(rows)) for name in ("qx", "qy", "qz", "qw")}
    columns |= {"frame": pa.array(np.zeros(rows, int)), "name": pa.array(["red"] * rows)}
    table = pa.table(columns | {"valid": pa.array(["1"] * rows)})
    pq.write_table(table, tmp_path / "many.parquet")
    with pytest.raises(InputError, match=r"many\.parquet' holds .* numbers in a row group"):
        RecordedSource(tmp_path / "many.parquet").recording()
