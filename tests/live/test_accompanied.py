"""Simulated cars behind the whole of control: asked for, stopped, recorded and replayed."""

from __future__ import annotations

import json
import math

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from app.live.control.arm import OperatorRequest
from app.live.operating.flock_driver import FlockDriver
from app.live.recording.recording_replay import read, replay
from live.rooms import Room, Steady, lab
from live.test_companions import beside
from live.test_flock_driver import SQUASHING
from live.test_live_record import ARM, record
from worlds.input_error import InputError


class Accompanying(Room):
    """The room with a driver that has simulated cars."""

    def __init__(self, text):
        super().__init__(FlockDriver(lab(text)), text)

    def ask(self, words):
        """What comes of asking for so many simulated cars."""
        before = len(self.events)
        self.tick(OperatorRequest("accompany", "browser 1", words))
        return [(event.kind, event.words, event.note) for event in self.events[before:]]


ALONE = SQUASHING.replace('path = "circle"\nradius = 2.0', 'path = "none"')


def test_asking_for_them_is_an_event():
    one = Accompanying(beside(ALONE, cars=0))
    one.tick()
    assert one.ask("3") == [("accompany", "3 simulated cars", "3")]
    assert [c.name for c in one.control.companions] == ["sim 1", "sim 2", "sim 3"]
    assert one.step.companions == one.control.companions
    assert one.ask("1") == [("accompany", "1 simulated car", "1")]
    assert one.ask("0") == [("accompany", "no simulated cars", "0")]
    for words in ("9", "-1", "1.0", "two", "", " 1", "1_0", "١", "9" * 5000):
        assert [kind for kind, _, _ in one.ask(words)] == ["refused"]
    assert one.ask("two")[0][1] == "simulated cars = 'two' is not allowed: not a whole number"
    assert one.control.companions == ()


def test_a_driver_without_them_refuses():
    one = Room(Steady())
    one.tick(OperatorRequest("accompany", "browser 1", "1"))
    assert [(event.kind, event.words) for event in one.events] == [
        ("refused", "this driver has no simulated cars beside the real ones")
    ]
    assert one.step.companions == ()


@pytest.mark.parametrize("action", ["emergency", "disarm"])
def test_a_stop_stands_them_still(action):
    one = Accompanying(beside(ALONE, cars=2))
    one.arm()
    begins = one.control.companions
    one.ticks(0.2)
    assert one.control.companions != begins
    one.tick(OperatorRequest(action, "test"))
    stands = one.control.companions
    one.ticks(0.5)
    assert one.control.companions == stands


def actions(seed, ticks):
    """Requests at random ticks, some of which are refused."""
    rng = np.random.default_rng(seed)
    found = {5: ARM}
    for tick in rng.choice(np.arange(6, ticks), 25, replace=False):
        found[int(tick)] = [
            ARM,
            OperatorRequest("accompany", "browser 1", str(rng.integers(-1, 11))),
            OperatorRequest("accompany", "browser 2", str(rng.integers(0, 9))),
            OperatorRequest("accompany", "browser 2", "many"),
            OperatorRequest("tune", "browser 1", json.dumps({"beta": rng.uniform(0.5, 2.0)})),
            OperatorRequest("emergency", "browser 1"),
            OperatorRequest("reset", "browser 2"),
        ][rng.integers(7)]
    return found


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("rule", ["squashing", "squashing-best"])
def test_a_replay_is_the_same_to_the_bit(tmp_path, rule, seed):
    text = beside(SQUASHING.replace('"squashing"', f'"{rule}"'), cars=seed % 3, seed=seed)
    record(tmp_path / "run", 500, seed, actions(seed, 500), text, FlockDriver)
    replayed = replay(tmp_path / "run", FlockDriver)
    assert replayed.differs == ""
    assert replayed.ticks == 500
    ticks = list(read(tmp_path / "run").ticks())
    assert len({len(tick.companions) for tick in ticks}) > 2
    assert len({pose_of(tick) for tick in ticks}) > 50


def pose_of(tick):
    return tick.companions[0].pose if tick.companions else None


def test_a_changed_simulated_car_is_found(tmp_path):
    record(tmp_path / "run", 60, text=beside(cars=2), make=FlockDriver)
    path = tmp_path / "run" / "companions.parquet"
    table = pq.read_table(path)
    assert table.num_rows == 2 * 60
    steer = table["steer"].to_numpy().copy()
    steer[101] = math.nextafter(steer[101], 9.0)
    column = table.column_names.index("steer")
    pq.write_table(table.set_column(column, "steer", pa.array(steer)), path)
    assert replay(tmp_path / "run", FlockDriver).differs.startswith("tick 50: Companion")
    pq.write_table(table.slice(0, 100), path)
    differs = replay(tmp_path / "run", FlockDriver).differs
    assert differs == "tick 50: 2 simulated cars instead of 0"


def test_a_recording_from_before_there_were_any_is_read(tmp_path):
    record(tmp_path / "run", 60, text=SQUASHING, make=FlockDriver)
    (tmp_path / "run" / "companions.parquet").unlink()
    with pytest.raises(InputError, match=r"companions\.parquet' cannot be read"):
        read(tmp_path / "run")
    for path in (tmp_path / "run").iterdir():
        table = pq.read_table(path)
        meta = json.loads(table.schema.metadata[b"flockscope"]) | {"format": 1}
        pq.write_table(table.replace_schema_metadata({b"flockscope": json.dumps(meta)}), path)
    assert replay(tmp_path / "run", FlockDriver).differs == ""
    assert {tick.companions for tick in read(tmp_path / "run").ticks()} == {()}
