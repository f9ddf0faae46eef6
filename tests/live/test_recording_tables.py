"""The tables of a live recording say what their columns are, and come out as frames and as CSV."""

import json

import pyarrow.parquet as pq
import pytest
from cli.calling import call, refusal
from pyarrow.csv import read_csv

from agents.recordings.recorder import KEY
from app.live.recording.recording_replay import read
from app.live.recording.recording_writer import COLUMNS, TABLES
from live.test_live_record import record
from worlds.input_error import InputError
from worlds.layout import world_from_layout


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    made = tmp_path_factory.mktemp("live") / "run"
    record(made, 40)
    return made


def test_every_column_is_described():
    assert {name: list(columns) for name, columns in COLUMNS.items()} == {
        name: list(columns) for name, columns in TABLES.items()
    }


def test_the_metadata_has_units_time_and_room(folder):
    meta = json.loads(pq.read_schema(folder / "poses.parquet").metadata[KEY])
    assert meta["format"] == 4
    assert meta["units"] == {"received": "s", "x": "m", "y": "m", "yaw": "rad"}
    assert (meta["time_per_tick"], meta["time_unit"], meta["length_unit"]) == (0.01, "s", "m")
    room = world_from_layout(meta["world"], meta["world_name"])
    assert (room.low, room.size, room.edges) == ((-3.0, -3.0), (6.0, 6.0), ("open", "open"))


def test_a_table_as_a_data_frame(folder):
    recorded = read(folder)
    frame = recorded.to_dataframe("ticks")
    assert [tick.now for tick in recorded.ticks()] == frame["now"].tolist()
    assert frame.attrs["units"]["latency"] == "s"
    assert frame.attrs["time_per_tick"] == 0.01
    with pytest.raises(InputError, match="unknown table 'pose'"):
        recorded.to_dataframe("pose")


def test_the_command(folder, tmp_path):
    made = json.loads(call("recording", folder, "--json").stdout)
    assert made["tables"]["ticks"]["rows"] == 40
    assert made["cars"] == ["red", "blue"]
    shown = call("recording", folder, "--table", "poses", "--csv", tmp_path / "poses.csv")
    assert "a room: 2 cars, rule none, 6 x 6 m, 0.01 s a tick" in shown.stdout
    assert "  yaw       rad  heading" in shown.stdout
    rows = read_csv(tmp_path / "poses.csv").to_pandas()
    kept = read(folder).to_dataframe("poses")
    assert rows["x"].to_numpy().tobytes() == kept["x"].to_numpy().tobytes()
    line = refusal("recording", folder, "--csv", tmp_path / "other.csv")
    assert "which --table? One of frames, poses" in line
