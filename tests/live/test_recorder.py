"""What begins and ends recordings of a loop that runs: what the disk does wrong is an event."""

from __future__ import annotations

import shutil
from types import SimpleNamespace

import pytest

from app.live.control.loop_status import Events
from app.live.laboratory.recording_parts import RecordingLimits
from app.live.operating.recorder import LoopRecorder, RecordRequest
from live.rooms import LAB
from tests.viewer.waiting import until


@pytest.fixture
def loop():
    """What a recorder needs of a loop."""
    return SimpleNamespace(
        journal=None, events=Events(), control=SimpleNamespace(tick=7), clock=lambda: 1.0
    )


@pytest.fixture
def recorder(loop):
    with LoopRecorder(LAB, RecordingLimits()) as made:
        made.loop = loop
        yield made


def words(loop, count=1):
    until(lambda: len(loop.events) >= count)
    return loop.events[count - 1].kind, loop.events[count - 1].words


def test_a_disk_without_room_is_told_and_nothing_begins(recorder, loop, tmp_path, monkeypatch):
    monkeypatch.setattr(shutil, "disk_usage", lambda _: SimpleNamespace(free=5e6))
    recorder.ask(RecordRequest(tmp_path / "one", "browser 1"))
    kind, told = words(loop)
    assert (kind, loop.journal) == ("recording", None)
    assert "nothing is recorded: 5 MB are free" in told
    assert not (tmp_path / "one").exists()


def test_a_folder_that_cannot_be_made_is_told(recorder, loop, tmp_path):
    (tmp_path / "file").write_text("")
    recorder.ask(RecordRequest(tmp_path / "file" / "one", "browser 1"))
    assert words(loop)[0] == "recording"
    assert loop.journal is None


def test_what_is_recorded_when_the_loop_ends_is_finished(loop, tmp_path):
    with LoopRecorder(LAB, RecordingLimits()) as recorder:
        recorder.loop = loop
        recorder.ask(RecordRequest(tmp_path / "one", "browser 1"))
        assert words(loop) == ("record", f"recording in {tmp_path / 'one'}")
        assert loop.journal is recorder.journal
    assert (tmp_path / "one" / "ticks.parquet").exists()
    assert not list((tmp_path / "one").glob("*.part"))


def test_what_is_not_recorded_cannot_end(recorder, loop):
    recorder.ask(RecordRequest(None, "browser 1"))
    assert words(loop) == ("recording", "nothing is recorded")
