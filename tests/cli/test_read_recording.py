"""`flockscope recording` and `Recording`: what a file holds, as it was, to the bit."""

import json
from itertools import pairwise

import numpy as np
import pandas as pd
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from pyarrow.csv import read_csv

from agents import Flock
from agents.catalogue import MODELS
from agents.columns import columns_of
from agents.record import KEY, Recorder, batch_of
from agents.recording import Recording
from cli.calling import call, refusal
from worlds.input_error import InputError

TICKS = (0, 2, 5)
QUICKLY_COMPILED = ("vem", "boundary-points", "olfati-saber", "squashing-cars", "thesis")
"""Models that other tests compile too: what others write is looked at by `.ci/run` only."""


def record(path, flock, ticks=TICKS):
    """Record a flock at some ticks; its snapshots."""
    taken = []
    with Recorder(path, flock) as recorder:
        for tick in ticks:
            flock.run(tick - flock.tick)
            recorder.write()
            taken.append(flock.snapshot(signals=True))
    return taken


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """A recording of a model with units, a memory and a world of its own, and its snapshots."""
    path = tmp_path_factory.mktemp("recorded") / "points.parquet"
    flock = Flock("boundary-points", agents=12, rng=3)
    return path, flock, record(path, flock)


def test_a_data_frame_has_the_arrays_to_the_bit(recorded):
    path, flock, taken = recorded
    frame = Recording(path).to_dataframe()
    assert isinstance(frame, pd.DataFrame)
    assert len(frame) == 12 * len(TICKS)
    for snapshot in taken:
        rows = frame[frame.tick == snapshot.tick]
        assert np.array_equal(rows["id"], snapshot.ids)
        assert rows[["x", "y"]].to_numpy().tobytes() == snapshot.position.tobytes()
        assert rows[["ux", "uy"]].to_numpy().tobytes() == snapshot.heading.tobytes()
        assert rows["speed"].to_numpy().tobytes() == snapshot.speed.tobytes()
        assert rows["informed"].dtype == bool
        for name in flock.model.columns:
            assert np.array_equal(rows[name], snapshot.signal(name), equal_nan=True), name


def test_it_says_units_time_and_world_without_its_model(recorded):
    path, flock, _ = recorded
    found = Recording(path)
    attrs = found.to_dataframe(["tick", "x", "speed", "phase", "aim_y"]).attrs
    assert attrs["units"] == {"tick": "ticks", "x": "m", "speed": "m/s", "phase": "rad",
                              "aim_y": "m"}  # fmt: skip
    assert (attrs["time_per_tick"], attrs["time_unit"]) == (flock.dt, "s")
    assert attrs["length_unit"] == "m"
    assert found.world == flock.world
    assert len(found.world.obstacles) > 0
    assert found.spec == flock.spec
    assert found.ticks.tolist() == list(TICKS)


def test_some_columns_and_some_ticks(recorded):
    path, _, taken = recorded
    found = Recording(path)
    frame = found.to_dataframe(["y", "tick"], ticks=(2, 5))
    assert list(frame.columns) == ["y", "tick"]
    assert sorted(set(frame.tick)) == [2, 5]
    assert np.array_equal(found.at(2).position, taken[1].position)
    with pytest.raises(InputError, match=r"unknown column 'z'.*points.parquet"):
        found.to_dataframe(["z"])
    with pytest.raises(InputError, match="tick = 3 is not in"):
        found.to_dataframe(ticks=3)


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.exhaustive] * (name not in QUICKLY_COMPILED))
        for name in MODELS
    ],
)
def test_every_column_that_is_written_is_described(name):
    flock = Flock(name, agents=3, rng=1)
    snapshot = flock.snapshot(signals=True)
    names = [one.name for one in columns_of(flock.model, flock.world)]
    assert names == batch_of(snapshot).schema.names
    assert all(one.unit and one.meaning for one in columns_of(flock.model, flock.world))


def test_units_name_only_columns_that_there_are():
    for one in MODELS.values():
        for part in (one.rule, one.body):
            for name in part.units:
                assert {name, f"{name}_x"} & set(one.columns), (one.name, name)


def test_csv_is_what_a_run_records_as_csv(recorded, tmp_path):
    path, _, taken = recorded
    record(tmp_path / "run.csv", Flock("boundary-points", agents=12, rng=3))
    result = call("recording", path, "--csv", tmp_path / "out.csv")
    assert result.stderr == f"written: {tmp_path / 'out.csv'}\n"
    assert (tmp_path / "out.csv").read_bytes() == (tmp_path / "run.csv").read_bytes()
    again = read_csv(tmp_path / "out.csv").to_pandas()
    kept = again[again.tick == 5][["x", "y"]].to_numpy()
    assert kept.tobytes() == taken[-1].position.tobytes()
    assert "exists already" in refusal("recording", path, "--csv", tmp_path / "out.csv")


def test_a_saved_state_is_one_frame_and_its_messages_stay_out_of_csv(tmp_path):
    flock = Flock("vem", agents=5, rng=2, delay=2.0)
    flock.run(4)
    flock.save(tmp_path / "late.parquet")
    found = Recording(tmp_path / "late.parquet")
    assert found.ticks.tolist() == [4]
    assert "past" in found.columns
    assert found.to_csv(tmp_path / "late.csv") == 5
    assert "past" not in (tmp_path / "late.csv").read_text().splitlines()[0]


def test_a_recording_of_before_still_opens(recorded, tmp_path):
    path, flock, _ = recorded
    table = pq.read_table(path)
    meta = json.loads(table.schema.metadata[KEY])
    assert meta["format"] == 2
    old = {"format": 1, "spec": meta["spec"], "next_id": meta["next_id"]}
    pq.write_table(table.replace_schema_metadata({KEY: json.dumps(old)}), tmp_path / "old.parquet")
    found, now = Recording(tmp_path / "old.parquet"), Recording(path)
    assert found.world == flock.world
    made, wanted = found.described(), now.described()
    assert {**made, "recording": ""} == {**wanted, "recording": ""}
    assert np.array_equal(Flock.load(tmp_path / "old.parquet").position, flock.position)


def test_the_command_says_what_it_holds(recorded):
    path, flock, _ = recorded
    shown = call("recording", path).stdout
    assert "Boundary-point flocking (boundary-points): 12 agents in wu2023-multi 90 x 90 m" in shown
    assert "3 frames of ticks 0 to 5 = 0.1 s, 0.02 s a tick; 36 rows" in shown
    ticks = Recording(path).ticks.tolist()
    apart = {later - tick for tick, later in pairwise(ticks)}
    line = (
        f"frames are {min(apart)} to {max(apart)} ticks apart; the end of a run is always recorded"
    )
    assert (line in shown) == (len(apart) > 1)
    assert "  speed      m/s    speed along the heading" in shown
    made = json.loads(call("recording", path, "--json").stdout)
    assert made["columns"]["split_x"]["unit"] == "m"
    assert made["agents"] == 12
    assert made["layout"]["size"] == list(flock.world.size)


def test_what_cannot_be_read_is_one_line(recorded, tmp_path):
    path, _, _ = recorded
    assert "No such file" in refusal("recording", tmp_path / "no.parquet")
    (tmp_path / "text.parquet").write_text("no parquet")
    assert "is not a state or a recording" in refusal("recording", tmp_path / "text.parquet")
    pq.write_table(pa.table({"a": [1]}), tmp_path / "other.parquet")
    assert "is not a state or a recording" in refusal("recording", tmp_path / "other.parquet")
    assert "ends in .csv" in refusal("recording", path, "--csv", tmp_path / "a.txt")
    assert "--table poses is not allowed" in refusal("recording", path, "--table", "poses")
    table = pq.read_table(path)
    meta = json.loads(table.schema.metadata[KEY])
    del meta["columns"]["x"]
    pq.write_table(table.replace_schema_metadata({KEY: json.dumps(meta)}), tmp_path / "cut.parquet")
    assert "the metadata of" in refusal("recording", tmp_path / "cut.parquet")
