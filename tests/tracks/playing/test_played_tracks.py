"""Tracks as snapshots: who is where, who is seen, and in what world."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely

from agents.catalogue import MODELS, PLAYED
from agents.catalogue import model as find_model
from agents.observables.catalogue import OBSERVABLES
from app.tracks.playing import played_tracks as limits
from app.tracks.playing.played_tracks import PlayedTracks, ticks_of
from app.tracks.playing.tracks_world import world_of_tracks
from app.tracks.tracks import Tracks
from tests.tracks.playing.ring_tracks import COUNT, GAP, GONE, LATE, RADIUS, RATE, TURN, ring_tracks
from worlds.input_error import InputError

SQUARE = "POLYGON ((-6 -6, 6 -6, 6 6, -6 6, -6 -6), (-1 -1, 1 -1, 1 1, -1 1, -1 -1))"


def shown(played: PlayedTracks, name: str, tick: int) -> float:
    return float(OBSERVABLES[name].measure(played.at(tick).measurable()))


def test_headings_and_speeds_are_those_of_the_motion():
    played = PlayedTracks(ring_tracks())
    now = played.at(20)
    angle = np.arctan2(now.position[:, 1], now.position[:, 0])
    along = np.column_stack([-np.sin(angle), np.cos(angle)])
    seen = now.seen
    assert (now.heading[seen] * along[seen]).sum(axis=1).min() > 0.9999
    # Five frames of a circle: what the smoothing takes from its speed is known.
    k = np.arange(1, 3)
    step = TURN / RATE
    share = (k * np.sin(k * step)).sum() / (step * (k * k).sum())
    assert now.speed[seen] == pytest.approx(RADIUS * TURN * share, rel=1e-6)
    assert played.median_speed == pytest.approx(RADIUS * TURN, rel=0.01)


def test_whoever_is_not_seen_has_the_last_place_and_is_hollow_only_in_a_gap():
    tracks = ring_tracks()
    played = PlayedTracks(tracks)
    before, within, after = (played.at(k) for k in (LATE - 1, GAP.stop - 1, GONE + 5))
    assert np.flatnonzero(~within.seen).tolist() == [3]
    assert np.array_equal(within.position[3], tracks.position[GAP.start - 1, 3])
    assert np.flatnonzero(within.hollow).tolist() == [3]
    assert np.flatnonzero(~before.seen).tolist() == [5]
    assert not before.hollow.any()  # not there yet
    assert np.flatnonzero(~after.seen).tolist() == [4]
    assert not after.hollow.any()  # gone for good
    assert played.gaps_of(3) == 1
    assert played.gaps_of(4) == 0
    assert played.since[GAP.stop - 1, 3] == pytest.approx(20 / RATE)


def test_a_long_gap_is_hollow_for_a_while_only(monkeypatch):
    monkeypatch.setattr(limits, "LONGEST_GAP", (0.2, 1))
    played = PlayedTracks(ring_tracks())
    hollow = [played.is_hollow(k)[3] for k in range(GAP.start, GAP.stop)]
    assert hollow == [True] * 5 + [False] * 15


def test_observables_are_of_those_who_are_seen():
    tracks = ring_tracks()
    played = PlayedTracks(tracks)
    now = played.at(GAP.start + 3)
    assert shown(played, "number-seen", GAP.start + 3) == COUNT - 1
    heading = now.heading[now.seen]
    assert shown(played, "polarisation", GAP.start + 3) == pytest.approx(
        float(np.linalg.norm(heading.mean(axis=0)))
    )
    assert shown(played, "angular-momentum", LATE - 1) == pytest.approx(1.0, abs=0.01)
    assert math.isnan(shown(played, "divergence", 0))


def test_links_and_groups_keep_the_rows_of_individuals():
    played = PlayedTracks(ring_tracks())
    now = played.at(GAP.start + 3)
    pairs = now.links()
    assert len(pairs) == 2 * COUNT - 4  # two to each side, but those of the one who is missing
    assert 3 not in pairs
    assert set(np.unique(pairs)) <= set(range(COUNT))
    assert len(now.group_labels()) == COUNT


def test_a_flock_of_tracks_is_put_where_they_are_and_says_nothing_of_walls():
    played = PlayedTracks(ring_tracks(boundary=SQUARE))
    flock = played.flock()
    assert flock.warning == ""
    assert flock.stray() is None
    flock.return_to(played.at(50))
    assert flock.observe("number-seen") == COUNT - 1
    assert flock.tick == 50


def test_models_of_tracks_answer_to_their_names_and_are_offered_nowhere():
    assert find_model("tracks-px").in_units("length/time") == "px/s"
    assert MODELS["tracks"].in_units("length") == "m"
    assert not PLAYED.keys() & MODELS.keys()
    assert not PLAYED.keys() & set(MODELS)
    with pytest.raises(KeyError):
        MODELS["no such model"]


def test_pixels_stay_pixels_unless_somebody_says_what_a_length_is():
    plain, scaled = PlayedTracks(ring_tracks("px")), PlayedTracks(ring_tracks("px"), length=2.5)
    assert (plain.length_unit, scaled.length_unit) == ("px", "length")
    assert np.allclose(scaled.place * 2.5, plain.place)
    assert scaled.spacing * 2.5 == pytest.approx(plain.spacing)
    centimetres = PlayedTracks(ring_tracks("cm"))
    assert centimetres.length_unit == "m"
    assert np.allclose(centimetres.place[0, 0], [0.05, 0.0])


@pytest.mark.parametrize(
    ("time", "ticks", "lasts"),
    [
        ([0.0, 0.04, 0.08, 0.2], [0, 1, 2, 5], 0.04),
        ([10.0, 10.1, 10.2], [100, 101, 102], 0.1),
        ([-1.0, 0.0, 1.0], [0, 1, 2], 1.0),
        ([0.0, 10.0, 11.0, 21.0, 31.0], [0, 10, 11, 21, 31], 1.0),
        ([3.0], [0], 1.0),
    ],
)
def test_ticks_are_frames_and_never_two_frames_at_once(time, ticks, lasts):
    got, step = ticks_of(np.array(time))
    assert got.tolist() == ticks
    assert step == pytest.approx(lasts)


def test_times_without_any_grid_still_have_a_tick_each():
    time = np.cumsum(np.r_[0.0, 1e-9, 5e5, 7e5, 3e9])
    ticks, step = ticks_of(time)
    assert ticks.tolist() == [0, 1, 2, 3, 4]
    assert step == pytest.approx(time[-1] / 4)


def test_the_world_is_around_all_places_and_walls_are_outside_of_the_boundary():
    tracks = ring_tracks()
    world = world_of_tracks(tracks)
    low, high = tracks.extent
    assert (np.array(world.low) < low).all()
    assert (np.array(world.low) + world.size > high).all()
    assert world.edges == ("open", "open")
    walled = world_of_tracks(ring_tracks(boundary=SQUARE), scale=2.0)
    solid = shapely.union_all([obstacle.footprint() for obstacle in walled.obstacles])
    assert solid.contains(shapely.Point(0.0, 0.0))
    assert not solid.intersects(shapely.Point(2.5, 2.5))
    assert solid.area == pytest.approx(16.0)
    assert walled.size == (24.0, 24.0)


def test_tracks_that_wrap_have_a_world_that_wraps():
    tracks = ring_tracks()
    tracks.position[..., 0] %= 8.0
    tracks = ring_tracks(position=tracks.position, period=(8.0, 0.0))
    world = world_of_tracks(tracks)
    assert world.edges == ("wrap", "open")
    assert (world.low[0], world.size[0]) == (0.0, 8.0)
    assert np.nanmax(PlayedTracks(tracks).speed) < 1.01 * RADIUS * TURN  # not across the box


@pytest.mark.parametrize(
    ("boundary", "says"),
    [
        ("POLYGON ((0 0, 1", "is no WKT"),
        ("POINT (1 1)", "nobody can walk on"),
        ("POLYGON ((0 0, 2 2, 2 0, 0 2, 0 0))", "nobody can walk on"),
        ("POLYGON EMPTY", "nobody can walk on"),
        ("x" * 1_000_001, "1000000 at most"),
    ],
)
def test_a_boundary_that_is_none_is_refused_in_one_line(boundary, says):
    with pytest.raises(InputError) as refused:
        PlayedTracks(ring_tracks(boundary=boundary))
    assert says in str(refused.value)
    assert "\n" not in str(refused.value)
    assert "ring.csv" in str(refused.value)


def test_too_much_is_refused_before_it_is_kept(monkeypatch):
    monkeypatch.setattr(limits, "MOST_NUMBERS", 100)
    with pytest.raises(InputError, match="12 individuals in 120 frames are too many"):
        PlayedTracks(ring_tracks())
    monkeypatch.undo()
    with pytest.raises(InputError, match="length = 0 is not allowed"):
        PlayedTracks(ring_tracks(), length=0.0)


@pytest.mark.parametrize("dim", [2, 3])
def test_one_individual_and_one_frame_are_enough(dim):
    tracks = Tracks(np.ones((1, 1, dim)), np.arange(1), np.zeros(1), ("a",), "m")
    played = PlayedTracks(tracks)
    now = played.at()
    assert np.isfinite(now.heading).all()
    assert now.seen.all()
    assert min(played.world.size) > 0.0
    assert played.flock().observe("number-seen") == 1.0
