"""Tracks from a browser: read aside, handed over without anything that could run."""

from __future__ import annotations

import io
from dataclasses import replace

import numpy as np
import pytest

from app.tracks import uploaded_tracks as limits
from app.tracks.readers.track_reader import ReadingOptions
from app.tracks.tracks import DroppedRows
from app.tracks.uploaded_tracks import packed, read_uploaded, unpacked
from tests.tracks.playing.ring_tracks import COUNT, RATE, ring_tracks
from worlds.input_error import InputError

OPTIONS = ReadingOptions(rate=RATE, unit="m", origin="bottom-left")


def table() -> bytes:
    tracks = ring_tracks()
    lines = ["frame,id,x,y"]
    for k in range(10):
        for row in np.flatnonzero(tracks.seen[k]):
            x, y = tracks.position[k, row]
            lines.append(f"{k},fish {row},{x:.6f},{y:.6f}")
    return "\n".join(lines).encode()


def test_what_is_read_aside_is_what_the_file_says():
    tracks = read_uploaded("ring.csv", table(), OPTIONS)
    assert (tracks.name, tracks.unit) == ("ring.csv", "m")
    assert sorted(tracks.ids) == sorted(f"fish {k}" for k in range(COUNT) if k != 5)
    order = [tracks.ids.index(f"fish {k}") for k in range(5)]
    assert np.allclose(tracks.position[:, order], ring_tracks().position[:10, :5], atol=1e-6)
    assert tracks.rate == pytest.approx(RATE)


@pytest.mark.parametrize("content", [b"", b"\x00" * 900, b"PK\x03\x04" + b"\xff" * 99, b"\x89HDF"])
def test_what_is_no_tracks_is_one_line(content):
    with pytest.raises(InputError) as refused:
        read_uploaded("sent.dat", content, ReadingOptions())
    assert "sent.dat" in str(refused.value)
    assert "\n" not in str(refused.value)


def test_everything_of_tracks_comes_back():
    tracks = ring_tracks()
    seen = tracks.seen
    tracks = replace(
        tracks,
        heading=np.ones_like(tracks.position),
        confidence=np.where(seen, 0.9, np.nan),
        filled=~seen,
        dropped=(DroppedRows(3, "twice"),),
        notes=("a note",),
        period=(0.0, 12.0),
        boundary="POLYGON ((0 0, 1 0, 1 1, 0 0))",
        format="table",
    )
    again = unpacked(packed(tracks))
    for name in (*limits.ARRAYS, *limits.WORDS, "dropped"):
        mine, other = getattr(tracks, name), getattr(again, name)
        same = np.array_equal(mine, other, equal_nan=name not in ("filled", "frame")) if isinstance(
            mine, np.ndarray
        ) else mine == other  # fmt: skip
        assert same, name


def test_an_archive_that_could_run_something_is_refused():
    file = io.BytesIO()
    words = np.frombuffer(b"{}", np.uint8)
    np.savez(file, words=words, position=np.array([{"a": 1}], dtype=object))
    with pytest.raises(InputError, match="cannot be taken over: ValueError"):
        unpacked(file.getvalue())


def test_an_archive_that_unpacks_to_too_much_is_refused(monkeypatch):
    monkeypatch.setattr(limits, "MOST_BYTES", 1000)
    with pytest.raises(InputError, match="the tracks hold 0 MiB"):
        unpacked(packed(ring_tracks()))
