"""A written file of every format is told by what it holds, and read to the same walk."""

from __future__ import annotations

import shutil

import numpy as np
import pytest

from app.tracks.read_tracks import read
from app.tracks.readers.reader_catalogue import BUILT_IN, readers
from tests.tracks.written_formats import (
    COUNT,
    FORMATS,
    FRAMES,
    METRES,
    PLACES,
    SEEN,
    write_recording,
)
from worlds.input_error import InputError

IDS = [f"{one.name}-{one.file}" for one in FORMATS]


@pytest.fixture(params=FORMATS, ids=IDS)
def written(request, tmp_path):
    """A format and its file; what it needs may not be installed."""
    return request.param, request.param.written(tmp_path)


def test_it_is_read_to_the_same_walk(written):
    form, path = written
    tracks = read(path, **form.options)
    assert (tracks.format, tracks.unit, tracks.dim) == (form.name, form.unit, form.dim)
    assert tracks.ids == form.ids
    assert tracks.rate == pytest.approx(form.rate, rel=1e-3)
    assert tracks.is_even
    assert tracks.position.shape[:2] == (FRAMES, COUNT) or not form.keeps_gap
    if not form.keeps_gap:
        return
    expected = SEEN.copy()
    if form.name == "trex" and form.file == "trex":  # whose files begin at different frames
        expected &= np.arange(FRAMES)[:, None] >= np.arange(COUNT)
    assert np.array_equal(tracks.seen, expected)
    if form.tolerance == np.inf:  # degrees: the distances are those of the walk
        steps = np.diff(tracks.position, axis=0) / METRES
        truth = np.diff(PLACES, axis=0)
        assert np.allclose(steps[..., 1], truth[..., 1], rtol=0.002, atol=1e-4, equal_nan=True)
        assert np.allclose(
            steps[..., 0], truth[..., 0] * np.cos(np.radians(47.0)), rtol=0.004, atol=1e-4,
            equal_nan=True,
        )  # fmt: skip
        return
    places = tracks.position[..., :2] / form.scale
    assert np.allclose(places[expected], PLACES[expected], atol=form.tolerance)
    if form.dim == 3:
        assert np.allclose(tracks.position[expected][:, 2] / form.scale, 1.0, atol=1e-5)


def test_its_name_is_not_asked(written, tmp_path):
    form, path = written
    if path.is_dir():
        for file in sorted(path.iterdir()):
            file.rename(file.with_name(f"{file.stem}.{'npz' if file.suffix == '.npz' else 'dat'}"))
        other = path
    else:
        other = tmp_path / "renamed.dat"
        shutil.copy(path, other)
    assert read(other, **form.options).format == form.name


def test_what_it_does_not_say_is_asked_for_in_a_line(written):
    form, path = written
    for option in set(form.options) & {"rate", "unit", "origin", "node"}:
        with pytest.raises(InputError, match=f"--{option}") as refused:
            read(path, **{name: form.options[name] for name in form.options if name != option})
        assert "\n" not in str(refused.value)


def test_nothing_of_people_is_kept(written):
    form, path = written
    tracks = read(path, **form.options)
    told = repr((tracks.ids, tracks.notes, tracks.name, [str(one) for one in tracks.dropped]))
    for name in ("somebody", "Anna", str(path.parent)):
        assert name not in told


def test_some_frames_alone_can_be_read(written):
    form, path = written
    if not form.keeps_gap:
        pytest.skip("its frames are made")
    whole = read(path, **form.options)
    some = read(path, every=3, **form.options)
    assert np.array_equal(some.frame, whole.frame[::3])
    assert np.array_equal(some.position, whole.position[::3], equal_nan=True)
    end = int(whole.frame[4])
    first = read(path, frames=(int(whole.frame[0]), end), **form.options)
    assert first.frame.max() < end


def test_gaps_are_filled_only_if_asked_and_then_flagged(written):
    form, path = written
    if not form.keeps_gap:
        pytest.skip("it has no gap")
    tracks = read(path, fill=1, **form.options)
    assert not (tracks.filled is not None and tracks.filled[4:6, 1].any())
    tracks = read(path, fill=2, **form.options)
    assert tracks.filled[4:6, 1].all()
    assert np.isfinite(tracks.position[4:6, 1]).all()
    middle = 0.5 * (tracks.position[3, 1] + tracks.position[6, 1])
    assert np.allclose(0.5 * (tracks.position[4, 1] + tracks.position[5, 1]), middle, rtol=1e-3)


def test_there_is_a_written_file_for_every_format():
    others = {"recording", "tidy", "vsp"}
    assert {form.name for form in FORMATS} == set(BUILT_IN) - others
    assert [*readers()][-1] == "table"


def test_a_recording_of_a_run_is_read(tmp_path):
    pytest.importorskip("pyarrow")
    write_recording(tmp_path / "run.parquet")
    tracks = read(tmp_path / "run.parquet")
    assert tracks.position.shape == (FRAMES, COUNT, 2)
    assert tracks.period == (5.0, 5.0)
    assert tracks.heading is not None
    assert np.linalg.norm(tracks.heading, axis=2) == pytest.approx(1.0)
    assert tracks.ids == ("1", "2", "3")
