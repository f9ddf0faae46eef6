"""A room that runs for days: its recording and its events stay bounded, and say what is missing."""

from __future__ import annotations

from contextlib import suppress

import pytest

from app.live.control.loop_status import Event, Events
from app.live.laboratory.lab_file import lab_from_toml
from app.live.laboratory.recording_parts import MB, RESERVE, RecordingLimits, parts_of
from app.live.recording.recording_replay import read, replay
from app.live.recording.recording_writer import TABLES, RecordingWriter
from app.live.recording.recovery import read_end, recover
from live.rooms import LAB
from live.test_live_record import make, record
from worlds.input_error import InputError

SMALL = LAB + "\n[recording]\npart = 1.0\nmost = 4.0\n"


@pytest.fixture
def small(monkeypatch):
    """Parts of some hundred ticks, which the file does not allow: a day of them is soon over."""

    def kept(part, most):
        def begin(self, folder, laboratory, _kept=None):
            begun(self, folder, laboratory, RecordingLimits.model_construct(part=part, most=most))

        begun = RecordingWriter.__init__
        monkeypatch.setattr(RecordingWriter, "__init__", begin)
        return RecordingLimits.model_construct(part=part, most=most)

    return kept


def size(folder):
    """Bytes of the files in a folder; a stream goes as soon as its table is made."""
    found = 0
    for file in folder.rglob("*"):
        with suppress(FileNotFoundError):
            found += file.stat().st_size if file.is_file() else 0
    return found


def test_what_goes_on_in_parts_replays_to_the_bit(tmp_path, small):
    small(0.1, 100.0)
    loop = record(tmp_path / "run", 1500)
    parts = parts_of(tmp_path / "run")
    assert [part.number for part in parts] == list(range(1, len(parts) + 1))
    assert len(parts) > 3
    for part in parts:
        tables = {file.name for file in part.folder.iterdir() if file.is_file()}
        assert tables == {f"{name}.parquet" for name in TABLES}
    recorded = read(tmp_path / "run")
    assert recorded.removed == ""
    assert [tick.number for tick in recorded.ticks()] == list(range(1500))
    replayed = replay(tmp_path / "run", make)
    assert (replayed.differs, replayed.ticks) == ("", 1500)
    told = [event.words for event in loop.events if event.kind == "part"]
    assert set(told) <= {f"the recording goes on in part {part.number}" for part in parts}


def test_the_oldest_parts_are_removed_and_a_replay_says_what_is_missing(tmp_path, small):
    kept = small(0.1, 0.6)
    folder = tmp_path / "run"
    sizes = []
    turn_over = RecordingWriter.begin_next_part

    def watched(self):
        turn_over(self)
        sizes.append(size(folder))

    RecordingWriter.begin_next_part = watched
    try:
        loop = record(folder, 6000)
    finally:
        RecordingWriter.begin_next_part = turn_over
    parts = parts_of(folder)
    assert parts[0].number > 1
    assert not list(folder.glob("*.parquet"))
    assert max(*sizes, size(folder)) <= MB * kept.most
    assert sum(part.size() for part in parts[:-2]) <= MB * (kept.most - RESERVE * kept.part)
    recorded = read(folder)
    numbers = [tick.number for tick in recorded.ticks()]
    assert numbers == list(range(numbers[0], 6000))
    assert numbers[0] > 0
    gone = f"parts 1 to {parts[0].number - 1}" if parts[0].number > 2 else "part 1"
    assert recorded.removed == gone
    with pytest.raises(InputError, match=f"cannot be replayed: {gone} of it were removed"):
        replay(folder, make)
    with pytest.raises(InputError, match="holds nothing to recover"):
        recover(folder)
    last = read_end(folder)
    assert last is not None
    assert last.tick == 5999
    words = {event.words for event in loop.events if event.kind == "part"}
    assert words <= {
        *(f"part {k} of the recording was removed: it keeps 0.6 MB" for k in range(1, 1000)),
        *(f"the recording goes on in part {k}" for k in range(2, 1000)),
    }


def test_a_kill_amid_many_parts_is_recovered(tmp_path, small):
    small(0.1, 100.0)
    folder = tmp_path / "run"
    exits = RecordingWriter.__exit__

    def killed(self, *_):
        """As a kill would: nothing is finished."""
        self.ending.set()
        self.thread.join()
        self.filer.shutdown()

    RecordingWriter.__exit__ = killed
    try:
        record(folder, 1500)
    finally:
        RecordingWriter.__exit__ = exits
    number = parts_of(folder)[-1].number
    (folder / f"{number + 1:04d}").mkdir()  # and a part had just been begun
    (folder / f"{number + 1:04d}" / "frames.parquet.part").write_bytes(b"")
    with pytest.raises(InputError, match="was killed: recover it first"):
        read(folder)
    assert recover(folder).keys() == set(TABLES)
    assert not list(folder.rglob("*.part"))
    assert replay(folder, make).differs == ""
    assert read_end(folder).tick == len(list(read(folder).ticks())) - 1


def test_a_part_that_is_missing_in_the_middle_is_named(tmp_path, small):
    small(0.1, 100.0)
    record(tmp_path / "run", 1500)
    parts_of(tmp_path / "run")[1].remove()
    with pytest.raises(InputError, match="has no part 2, but part 3"):
        read(tmp_path / "run")


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ("part = 0.5", r"recording.part = 0.5 is not allowed: .* line \d+"),
        ("part = 1e6", r"recording.part = 1e\+06 is not allowed"),
        ("most = 1e9", r"recording.most = 1e\+09 is not allowed"),
        ("part = 100.0\nmost = 300.0", "most must be at least four parts, 400"),
        ("parts = 3", "unknown key 'parts'"),
    ],
)
def test_what_is_kept_is_checked_as_all_else_in_the_file(values, words):
    with pytest.raises(InputError, match=words):
        lab_from_toml(f"{LAB}\n[recording]\n{values}\n", "room.toml")


def test_the_file_says_how_much_is_kept():
    assert lab_from_toml(SMALL, "room.toml").recording == RecordingLimits(part=1.0, most=4.0)
    assert lab_from_toml(LAB, "room.toml").recording == RecordingLimits(part=200.0, most=20_000.0)


def test_a_disk_that_takes_nothing_is_given_up(tmp_path):
    journal = RecordingWriter(tmp_path / "run", LAB)
    for _ in range(7000):
        journal.write(None)
    assert "the disk has taken nothing for 6000 ticks" in journal.trouble
    assert journal.waiting.qsize() == 6000


def test_events_are_read_as_a_list_that_forgets_its_oldest():
    log = Events(limit=100)
    every = [Event(k, 0.01 * k, "tune", str(k)) for k in range(1000)]
    for event in every:
        log.add(event)
    assert len(log) == log.count == 1000
    assert log.dropped == 900
    assert list(log) == log[:] == every[900:]
    assert log[-5:] == every[-5:]
    assert log[950:960] == every[950:960]
    assert log[850:905] == every[900:905]
    assert log[-1] == every[-1]
    assert log.since(990) == (1000, every[990:])
    assert log.since(10) == (1000, every[900:])
    assert log.since(1000) == (1000, [])
    with pytest.raises(IndexError, match="no longer kept"):
        log[5]
