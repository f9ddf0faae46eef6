"""What is wrong with tracks is found, and tracks that are sound are left in peace."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from app.tracks.read_tracks import read
from app.tracks.track_checks import check_tracks, describe_tracks, gap_lengths
from app.tracks.tracks import DroppedRows, Tracks
from app.tracks.written_tracks import write_tracks
from tests.tracks.written_formats import FORMATS, write_recording
from worlds.input_error import InputError

RATE, FRAMES, COUNT = 25.0, 200, 10


def walks(**more):
    """Individuals who walk smoothly, each its own way, a metre apart."""
    rng = np.random.default_rng(5)
    turn = np.cumsum(rng.normal(0.0, 0.1, (FRAMES, COUNT)), axis=0)
    steps = 0.04 * np.stack([np.cos(turn), np.sin(turn)], axis=2)
    start = np.stack([np.arange(COUNT) % 5, np.arange(COUNT) // 5], axis=1) * 20.0
    frame = np.arange(FRAMES)
    made = Tracks(
        start + np.cumsum(steps, axis=0), frame, frame / RATE,
        tuple(f"fish {k}" for k in range(COUNT)), "m", format="table",
    )  # fmt: skip
    return replace(made, **more)


def kinds(tracks):
    return {flag.kind: flag for flag in check_tracks(tracks).flags}


def test_sound_tracks_are_left_in_peace():
    report = check_tracks(walks())
    assert report.is_sound
    assert report.flags == ()


def test_a_jump_is_found_where_it_is():
    position = walks().position.copy()
    position[80, 3] += 15.0
    flag = kinds(walks(position=position))["jump"]
    assert flag.count == 2  # there and back
    assert {case["frame"] for case in flag.cases} == {80, 81}
    assert flag.cases[0]["ids"] == ["fish 3"]


def test_two_who_change_places_are_a_swap():
    position = walks().position.copy()
    position[120:, [2, 7]] = position[120:, [7, 2]]
    flag = kinds(walks(position=position))["swap"]
    assert (flag.count, flag.cases[0]["frame"]) == (1, 120)
    assert flag.cases[0]["ids"] == ["fish 2", "fish 7"]


def test_a_step_over_the_edge_of_a_box_is_no_jump():
    tracks = walks()
    wrapped = replace(tracks, position=tracks.position % 7.0, period=(7.0, 7.0))
    assert not {"jump", "swap"} & set(kinds(wrapped))
    assert "jump" in kinds(replace(wrapped, period=()))


def test_two_names_on_one_body_are_found():
    position = walks().position.copy()
    position[50:90, 4] = position[50:90, 5] + 0.001
    flag = kinds(walks(position=position))["one-body"]
    assert flag.cases[0]["ids"] == ["fish 4", "fish 5"]
    assert (flag.cases[0]["frame"], flag.cases[0]["frames"]) == (50, 40)
    position[50:90, 4] = position[50:90, 5] + 3.0
    assert "one-body" not in kinds(walks(position=position))


def test_who_rests_exactly_is_told():
    position = walks().position.copy()
    position[60:, 1] = position[60, 1]
    flag = kinds(walks(position=position))["rest"]
    assert flag.cases == ({"ids": ["fish 1"], "share": 0.698},)


def test_uneven_times_and_short_tracks_and_what_was_dropped_are_told():
    time = walks().time.copy()
    time[100:] += 3.0
    position = walks().position.copy()
    position[4:, 9] = np.nan
    dropped = (DroppedRows(7, "the place is blank or no number"),)
    found = kinds(walks(time=time, position=position, dropped=dropped))
    assert found["uneven"].cases[0]["frame"] == 100
    assert found["short"].cases == ({"ids": ["fish 9"], "frames": 4},)
    assert found["dropped"].count == 7


def test_gaps_are_counted_between_frames_in_which_one_is_seen():
    seen = np.array([[0, 1, 1, 0, 0, 1, 0, 1, 0], [1] * 9], bool).T
    assert sorted(gap_lengths(seen).tolist()) == [1, 2]
    told = describe_tracks(walks())
    assert (told["individuals"], told["frames"], told["gaps"], told["seen"]) == (10, 200, 0, 1.0)
    assert told["rate"] == pytest.approx(RATE)


def test_one_individual_in_one_frame_can_be_checked():
    alone = Tracks(np.zeros((1, 1, 2)), np.arange(1), np.zeros(1), ("a",), "m")
    report = check_tracks(alone)
    assert {flag.kind for flag in report.flags} <= {"short"}


# What is written is read back.


@pytest.mark.parametrize("ending", ["csv", "parquet"])
@pytest.mark.parametrize("form", FORMATS, ids=lambda form: f"{form.name}-{form.file}")
def test_what_convert_writes_needs_no_option(tmp_path, form, ending):
    tracks = read(form.written(tmp_path), **form.options)
    write_tracks(tracks, tmp_path / f"out.{ending}")
    again = read(tmp_path / f"out.{ending}")
    assert (again.format, again.unit, again.ids) == ("tidy", tracks.unit, tracks.ids)
    shared = np.isin(tracks.frame, again.frame)
    assert np.allclose(again.position, tracks.position[shared], equal_nan=True, atol=1e-9)
    assert np.allclose(again.time, tracks.time[shared], atol=1e-6)
    assert np.isfinite(again.position).sum() == np.isfinite(tracks.position).sum()
    if tracks.heading is not None:
        assert np.allclose(again.heading, tracks.heading[shared], equal_nan=True, atol=1e-9)
    if tracks.confidence is not None:
        there = again.seen
        assert np.allclose(again.confidence[there], tracks.confidence[shared][there])


def test_a_box_that_wraps_and_a_boundary_are_kept(tmp_path):
    pytest.importorskip("pyarrow")
    write_recording(tmp_path / "run.parquet")
    tracks = read(tmp_path / "run.parquet")
    write_tracks(tracks, tmp_path / "out.csv")
    assert read(tmp_path / "out.csv").period == tracks.period
    area = "POLYGON ((0 0, 9 0, 9 9, 0 9, 0 0))"
    write_tracks(walks(boundary=area), tmp_path / "area.csv")
    assert read(tmp_path / "area.csv").boundary == area


def test_a_name_that_a_spreadsheet_would_calculate_is_read_back(tmp_path):
    ids = ("=1+1", "@x", *(str(k) for k in range(2, COUNT)))
    write_tracks(walks(ids=ids), tmp_path / "out.csv")
    assert ",'=1+1," in (tmp_path / "out.csv").read_text()
    assert set(read(tmp_path / "out.csv").ids) == set(ids)


def test_a_database_for_jupedsim_is_read_back(tmp_path):
    numbered = walks(ids=tuple(str(3 * k + 1) for k in range(COUNT)))
    write_tracks(numbered, tmp_path / "out.sqlite")
    again = read(tmp_path / "out.sqlite")
    assert (again.format, again.unit, again.rate) == ("jupedsim", "m", pytest.approx(RATE))
    order = [again.ids.index(name) for name in numbered.ids]
    assert np.allclose(again.position[:, order], numbered.position)
    assert again.boundary.startswith("POLYGON")
    for wrong, says in ((walks(unit="px"), "--scale"), (in_space(), "--flat")):
        with pytest.raises(InputError, match=says):
            write_tracks(wrong, tmp_path / "wrong.sqlite")
    assert not (tmp_path / "wrong.sqlite").exists()


def in_space():
    flat = walks().position
    return walks(position=np.concatenate([flat, np.ones((*flat.shape[:2], 1))], axis=2))


def test_pedpy_reads_what_is_written_for_jupedsim(tmp_path):
    pedpy = pytest.importorskip("pedpy")
    tracks = walks()
    write_tracks(tracks, tmp_path / "out.sqlite")
    read_there = pedpy.load_trajectory_from_jupedsim_sqlite(trajectory_file=tmp_path / "out.sqlite")
    assert read_there.frame_rate == RATE
    first = read_there.data.query("id == 1").sort_values("frame")[["x", "y"]].to_numpy()
    assert np.allclose(first, tracks.position[:, 0])
