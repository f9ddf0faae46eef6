"""What is measured of tracks with gaps: by frame, with the number seen, as of a flock."""

import importlib
import json
import math
import sys
from dataclasses import replace

import numpy as np
import pytest

from agents import Flock
from app.tracks.measure_report import (
    BOOK,
    NUMBERS,
    PAGE,
    SERIES,
    describe_report,
    measure_tracks,
    write_report,
)
from app.tracks.measures import measure_catalogue
from app.tracks.measures.order import random_polarisation
from app.tracks.measures.track_measure import MeasureInput, MeasureOptions, needs_plane
from app.tracks.motion import SmoothedMotion
from app.tracks.tracks import DroppedRows, Tracks
from worlds.input_error import InputError


def tracks_of(position, fps=10.0, unit="m", **others):
    frame = np.arange(len(position))
    ids = tuple(map(str, range(position.shape[1])))
    return Tracks(position, frame, frame / fps, ids, unit, **others)


def units(angle):
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def measured(tracks, name, options=None, **more):
    return measure_tracks(tracks, [name], options, **more).results[name]


def crowd(frames=40, n=12, seed=1, dim=2):
    """Individuals that wander."""
    rng = np.random.default_rng(seed)
    start = rng.uniform(0.0, 6.0, (n, dim))
    return start + np.cumsum(rng.normal(0.0, 0.05, (frames, n, dim)), axis=0)


# What is known.


def test_a_ring_of_which_30_per_cent_is_lost_mills():
    angle = np.arange(400) / 400 * math.tau + 0.05 * np.arange(20)[:, None]
    position = 10.0 * units(angle)
    position[np.random.default_rng(1).random((20, 400)) < 0.3] = np.nan
    ring = tracks_of(position, heading=units(angle + math.pi / 2.0))
    result = measured(ring, "angular-momentum", window=0.0, use_file_headings=True)
    assert result.tables[""]["angular_momentum"].min() > 0.999
    assert 240 < result.numbers["least number seen"] < 280


@pytest.mark.parametrize("kept", [1.0, 0.7, 0.4])
def test_a_wave_has_the_correlation_length_of_its_first_zero(kept):
    rng = np.random.default_rng(3)
    k, side = 2.4048 / 7.655, 60.0
    position = rng.uniform(0.0, side, (1, 3000, 2))
    velocity = np.stack([np.sin(k * position[..., 0]), np.zeros((1, 3000))], axis=-1)
    position[rng.random((1, 3000)) > kept] = np.nan
    tracks = tracks_of(position, period=(side, side))
    motion = SmoothedMotion(position, velocity, step=0.1, unit="m")
    given = MeasureInput(tracks, motion)
    lengths = measure_catalogue.track_measures()["correlation-length"].compute(
        given, lambda _: None
    )
    assert lengths.numbers["mean"] == pytest.approx(7.655, abs=0.15)
    curve = measure_catalogue.track_measures()["correlation"].compute(given, lambda _: None)
    assert curve.numbers["first zero (m)"] == pytest.approx(lengths.numbers["mean"], rel=1e-6)
    # J_0, the mean of a plane wave over all directions
    from scipy.special import j0

    r, c = curve.tables[""]["r"], curve.tables[""]["c"]
    near = r < 12.0
    assert np.abs(c[near] - j0(k * r[near])).max() < 0.12


def test_headings_at_random_have_the_level_that_is_drawn():
    rng = np.random.default_rng(2)
    for dim in (2, 3):
        heading = rng.normal(size=(4000, 30, dim))
        heading /= np.linalg.norm(heading, axis=2, keepdims=True)
        mean = np.linalg.norm(heading.mean(axis=1), axis=1).mean()
        assert mean == pytest.approx(random_polarisation(30, dim), rel=0.02)


def test_below_the_least_number_a_frame_has_no_value():
    position = crowd(30, 8)
    position[10:20, 4:] = np.nan
    result = measured(tracks_of(position), "polarisation", window=0.0)
    values, n = result.tables[""]["polarisation"], result.tables[""]["n"]
    assert np.flatnonzero(np.isfinite(values)).tolist() == [*range(1, 10), *range(21, 30)]
    assert n.tolist() == [0] + [8] * 9 + [4] * 11 + [8] * 9
    assert any("12 of 30 frames have no value" in note for note in result.notes)
    few = measured(tracks_of(position), "polarisation", MeasureOptions(least=4), window=0.0)
    assert np.isfinite(few.tables[""]["polarisation"]).sum() == 29
    assert any("between 4 and 8 individuals are seen" in note for note in few.notes)


@pytest.mark.parametrize("model", ["vem", "couzin"])
def test_a_simulated_recording_has_the_observables_of_its_flock(model):
    flock = Flock(model, agents=40, size=5.0, dim=2, rng=4)
    names = ("polarisation", "angular-momentum", "correlation-length", "gyration-radius",
             "mean-neighbours", "velocity-spread")  # fmt: skip
    position, expected = [], []
    for _ in range(25):
        flock.run(1)
        position.append(flock.position.copy())
        expected.append([flock.observe(name) for name in names])
    world, tick = flock.world, flock.dt
    period = tuple(np.where(world.images, world.size, 0.0).tolist())
    tracks = tracks_of(np.array(position), 1.0 / tick, period=period)
    report = measure_tracks(
        tracks, list(names), MeasureOptions(reach=flock.reach), window=0.0
    )  # fmt: skip
    for k, name in enumerate(names):
        found = report.results[name].tables[""][name.replace("-", "_")]
        ours = np.array(expected)[:, k]
        first = 1 if np.isnan(found[0]) else 0
        np.testing.assert_allclose(found[first:], ours[first:], rtol=1e-6, atol=1e-9, err_msg=name)


def test_sizes_of_groups_and_neighbours_follow_the_reach():
    line = np.zeros((4, 6, 2))
    line[..., 0] = [0.0, 1.0, 2.0, 10.0, 11.0, 30.0]
    tracks = tracks_of(line + 0.001 * np.arange(4)[:, None, None])
    result = measured(tracks, "group-sizes", MeasureOptions(reach=1.5), window=0.0)
    assert result.tables[""]["largest_group"].tolist() == [3.0] * 4
    assert result.tables[""]["groups"].tolist() == [3.0] * 4
    assert result.tables["distribution"]["size"].tolist() == [1, 2, 3]
    share = result.tables["distribution"]["share_of_individuals"]
    np.testing.assert_allclose(share, [1 / 6, 2 / 6, 3 / 6])
    chosen = measured(tracks, "group-sizes", window=0.0)
    assert "3 times the median distance to the nearest neighbour: --reach" in chosen.notes[0]
    near = measured(tracks, "spacing", window=0.0)
    assert near.tables[""]["spacing"].tolist() == pytest.approx([1.0] * 4)
    assert near.numbers["least of all"] == pytest.approx(1.0)


def test_speeds_below_the_least_are_counted():
    speed = np.array([0.1, 0.2, 1.0, 2.0, 3.0, 4.0])
    place = np.arange(40)[:, None, None] / 10.0 * speed[:, None] * np.array([1.0, 0.0])
    place[..., 1] = np.arange(6)
    result = measured(tracks_of(place), "speed", least_speed=0.5)
    assert result.numbers["of all individuals, mean"] == pytest.approx(speed.mean())
    assert any(note.startswith("33% of the speeds are below") for note in result.notes)
    order = measured(tracks_of(place), "polarisation", MeasureOptions(least=4), least_speed=0.5)
    assert order.numbers["largest number seen"] == 4


def test_leaders_are_named_in_the_order_of_their_leads():
    rng = np.random.default_rng(5)
    angle = rng.normal(0.0, 0.15, 1240).cumsum()
    delays = (8, 0, 4, 2, 6)
    heading = units(np.stack([angle[40 - d :][:1200] for d in delays], axis=1))
    place = np.cumsum(heading * 0.1, axis=0) + np.arange(5)[:, None]
    result = measured(tracks_of(place), "leadership", window=0.0)
    assert result.tables[""]["id"].tolist() == ["1", "3", "2", "4", "0"]
    assert result.numbers["resolved"] >= 4
    assert result.numbers["largest lead (s)"] == pytest.approx(0.5, abs=0.02)
    pairs = result.tables["pairs"]
    among = {(a, b): d for a, b, d in zip(pairs["leader"], pairs["follower"], pairs["delay"],
                                          strict=True)}  # fmt: skip
    assert among["0", "1"] == pytest.approx(-0.8, abs=0.01)


def test_who_do_not_follow_are_not_resolved():
    result = measured(tracks_of(crowd(400, 6)), "leadership", window=0.2)
    assert result.notes[0].startswith("not resolved")


# The folder.


@pytest.fixture(scope="module")
def report():
    position = crowd(60, 9)
    position[20:24, 3] = np.nan
    tracks = tracks_of(position, name="wanderers.csv", dropped=(DroppedRows(7, "no place"),))
    return measure_tracks(replace(tracks, notes=("z is left out",)), window=0.4, least_speed=0.01)


def test_all_that_these_tracks_have_is_measured_and_the_rest_named(report):
    every = set(measure_catalogue.track_measures())
    assert set(report.results) | {one.name for one in report.skipped} == every
    reasons = {one.name: one.reason for one in report.skipped}
    assert reasons == dict.fromkeys(
        ("crowd-density", "flow", "fundamental-diagram", "neighbour-distance", "time-headway"),
        "where people can walk is needed: --walkable WKT",
    )


@pytest.fixture(scope="module")
def written(report, tmp_path_factory):
    """The folder, and the files that are said to be in it."""
    folder = tmp_path_factory.mktemp("measured") / "new" / "folder"
    return folder, write_report(report, folder)


def test_the_folder_has_page_pdf_and_tables(report, written):
    folder, files = written
    names = {path.name for path in files}
    assert {PAGE, BOOK, NUMBERS, SERIES, "polarisation.csv", "turning-map.csv"} <= names
    assert sorted(path.name for path in folder.iterdir()) == sorted(names)
    page = (folder / PAGE).read_text(encoding="utf-8")
    assert page.count("window 5 frames (0.4 s); noise of places") == 1 + 0
    assert page.count("Window 5 frames (0.4 s); noise of places") == len(report.results)
    assert "7 rows dropped: no place." in page
    assert "z is left out" in page
    assert "no heading below 0.01 m/s" in page
    charts = sum(len(result.charts) for result in report.results.values())
    assert page.count("<svg") == charts
    outside = [part[:8] for part in page.split('href="')[1:] if not part.startswith("#")]
    assert set(outside) <= {"data:ima"}
    assert "<script" not in page
    assert "src=" not in page
    ids = [part.partition('"')[0] for part in page.split(' id="')[1:]]
    assert len(ids) == len(set(ids))
    assert (folder / BOOK).read_bytes().startswith(b"%PDF")


def test_tables_hold_what_was_measured(report, written):
    import pandas as pd

    folder, _ = written
    table = pd.read_csv(folder / "polarisation.csv")
    expected = report.results["polarisation"].tables[""]
    np.testing.assert_allclose(table["polarisation"], expected["polarisation"])
    series = pd.read_parquet(folder / SERIES)
    np.testing.assert_array_equal(series["polarisation_n"], expected["n"])
    assert {"time", "spacing", "largest_group", "correlation_length"} <= set(series)
    numbers = json.loads((folder / NUMBERS).read_text(encoding="utf-8"))
    assert numbers["window_frames"] == 5
    assert numbers["dropped"] == [{"rows": 7, "reason": "no place"}]
    assert numbers["measures"]["speed"]["numbers"]["mean"] == pytest.approx(
        report.results["speed"].numbers["mean"]
    )


def test_what_is_there_is_kept_unless_asked(report, tmp_path):
    one = replace(report, results={"speed": report.results["speed"]})
    write_report(one, tmp_path)
    (tmp_path / "speed.csv").write_text("mine", encoding="utf-8")
    with pytest.raises(InputError, match="exists already"):
        write_report(one, tmp_path)
    assert (tmp_path / "speed.csv").read_text(encoding="utf-8") == "mine"
    write_report(one, tmp_path, overwrite=True)
    assert (tmp_path / "speed.csv").read_text(encoding="utf-8").startswith("frame,time,n,speed")
    assert not list(tmp_path.glob(".*"))


def test_names_of_people_and_files_are_no_mark_up(tmp_path):
    position = crowd(30, 6)
    frame = np.arange(30)
    ids = ("<b>", "=1+1", "c", "d", "e", "f")
    tracks = Tracks(position, frame, frame / 10.0, ids, "m", name="<script>alert(1)</script>")
    write_report(measure_tracks(tracks, ["leadership", "speed"], MeasureOptions(longest_delay=0.5)),
                 tmp_path)  # fmt: skip
    assert "<script" not in (tmp_path / PAGE).read_text(encoding="utf-8")
    assert "\n=1+1" not in (tmp_path / "leadership.csv").read_text(encoding="utf-8")


def test_lines_for_a_terminal_say_how_and_what_is_missing(report):
    lines = describe_report(report)
    assert any(
        line.startswith("Velocities and headings: window 5 frames (0.4 s)") for line in lines
    )
    assert any(line.startswith("polarisation: mean 0.") for line in lines)
    assert any(line.startswith("not measured: flow: ") for line in lines)


def test_the_share_that_is_done_rises_to_the_end():
    told = []
    measure_tracks(tracks_of(crowd(200, 6)), ["polarisation", "neighbour-map", "leadership"],
                   window=0.2, tell=lambda *now: told.append(now))  # fmt: skip
    shares = [share for share, _, _ in told]
    assert shares == sorted(shares)
    assert shares[0] == 0.0
    assert shares[-1] == pytest.approx(1.0)
    assert {name for _, _, name in told} == {"polarisation", "neighbour-map", "leadership"}


# A new measure, and bad input.

NEW = """
from app.tracks.measures.track_measure import TrackMeasure, frame_series

def count(given, progress):
    values, count = given.by_frame(len, given.tracks.position)
    return frame_series(given, "heads", "individuals", values, count)

MEASURES = (TrackMeasure("heads", "How many there are", "", count, by_frame="individuals"),)
"""


def test_a_new_measure_is_one_file(tmp_path, monkeypatch):
    (tmp_path / "heads.py").write_text(NEW, encoding="utf-8")
    monkeypatch.setattr(measure_catalogue.package, "__path__",
                        [*measure_catalogue.package.__path__, str(tmp_path)])  # fmt: skip
    measure_catalogue.track_measures.cache_clear()
    try:
        importlib.invalidate_caches()
        result = measured(tracks_of(crowd(20, 7)), "heads")
        assert result.numbers["mean"] == 7.0
    finally:
        measure_catalogue.track_measures.cache_clear()
        sys.modules.pop("app.tracks.measures.heads", None)


def test_each_measure_is_declared_in_full():
    for name, measure in measure_catalogue.track_measures().items():
        assert name == name.lower().replace(" ", "-")
        assert measure.title[0].isupper()
        assert (measure.compute.__doc__ or "").strip()
        assert measure.cost(1000, 50) > 0.0


@pytest.mark.parametrize(
    ("name", "options", "words"),
    [
        ("polarisaton", {}, "unknown measure 'polarisaton': did you mean 'polarisation'?"),
        ("polarisation", {"least": 0}, "least = 0"),
        ("group-sizes", {"reach": -1.0}, "reach = -1 m"),
        ("group-sizes", {"reach": math.nan}, "reach = nan m"),
        ("neighbour-map", {"map_reach": 0.0}, "map reach = 0 m"),
        ("leadership", {"longest_delay": 60.0}, "frames are too few for delays up to 60 s"),
        ("leadership", {"longest_delay": -1.0}, "longest delay = -1 s"),
        ("structure", {"neighbours": 0}, "neighbours = 0"),
        ("flow", {"walkable": "POLYGON ((0 0, 9 0, 9 9, 0 9, 0 0))"}, "needed: --line WKT"),
        ("crowd-density", {"walkable": "a room"}, "--walkable = 'a room' is no WKT"),
        ("crowd-density", {"walkable": "POINT (1 1)"}, "is no Polygon"),
        (
            "crowd-density",
            {"walkable": "POLYGON ((0 0, 9 0, 9 9, 5 4, 0 0))"},
            "not convex, so a part of it must be chosen: --area",
        ),
        (
            "crowd-density",
            {"walkable": "POLYGON ((90 90, 99 90, 99 99, 90 90))"},
            "nobody is ever inside",
        ),
        (
            "flow",
            {
                "walkable": "POLYGON ((0 0, 9 0, 9 9, 0 9, 0 0))",
                "line": "LINESTRING (0 0, 1 1, 2 0)",
            },
            "--line = .* has more than two ends",
        ),
    ],
)
def test_what_cannot_be_measured_is_refused_in_one_line(name, options, words):
    with pytest.raises(InputError, match=words) as caught:
        measured(tracks_of(crowd(60, 8)), name, MeasureOptions(**options))
    assert "\n" not in str(caught.value)


def test_pixels_and_space_have_no_crowd_and_space_no_map():
    pixels = measure_tracks(tracks_of(crowd(30, 6), unit="px"), window=0.2)
    assert "metres are needed, these are pixels: --scale" in {one.reason for one in pixels.skipped}
    space = tracks_of(crowd(40, 30, dim=3))
    found = measure_tracks(space, window=0.2)
    assert "neighbour-map" not in found.results
    assert found.results["structure"].numbers["the same all round"] == pytest.approx(1 / 3)
    assert needs_plane(MeasureInput(space, found.motion)).startswith("tracks in the plane")


@pytest.mark.parametrize("n", [1, 2, 3])
def test_few_individuals_are_measured_as_far_as_it_goes(n, tmp_path):
    report = measure_tracks(tracks_of(crowd(60, n)), window=0.2)
    assert report.results["polarisation"].numbers == {"values": 0, "frames": 0}
    assert ("spacing" in report.results) == (n > 1)
    with_least = measure_tracks(tracks_of(crowd(60, n)), None, MeasureOptions(least=1), window=0.2)
    assert with_least.results["speed"].numbers["frames"] == 58
    write_report(with_least, tmp_path)


# Crowds.

ROOM = "POLYGON ((0 0, 10 0, 10 4, 0 4, 0 0))"


def test_a_crowd_that_walks_in_step_has_its_density_flow_and_headway():
    # a column of pairs, 1 m apart, that walks at 1 m/s through a line
    lead = np.arange(120) / 10.0
    rank = np.repeat(np.arange(8), 2)
    place = np.stack([lead[:, None] - rank * 1.0, np.tile([1.0, 3.0], 8) + 0.0 * lead[:, None]], 2)
    place[(place[..., 0] < 0.05) | (place[..., 0] > 9.95)] = np.nan
    options = MeasureOptions(
        walkable=ROOM,
        line="LINESTRING (5.03 0, 5.03 4)",
        area="POLYGON ((3 0, 5 0, 5 4, 3 4, 3 0))",
    )
    report = measure_tracks(
        tracks_of(place),
        ["crowd-density", "fundamental-diagram", "flow", "time-headway", "neighbour-distance"],
        options,
        window=0.2,
    )
    flow = report.results["flow"].numbers
    assert flow["people across"] == 14
    assert flow["mean flow (1/s)"] == pytest.approx(13 / 6.0, rel=1e-6)
    headway = report.results["time-headway"].tables[""]["headway"]
    assert sorted(set(np.round(headway, 9).tolist())) == [0.0, 1.0]
    density = report.results["crowd-density"].tables[""]
    middle = (density["time"] > 6.0) & (density["time"] < 8.0)
    assert density["density_counted"][middle].mean() == pytest.approx(4 / 8.0, rel=0.15)
    assert density["density"][middle].mean() == pytest.approx(1.0 / 2.0, rel=0.2)
    diagram = report.results["fundamental-diagram"].tables[""]
    np.testing.assert_allclose(diagram["speed"], 1.0, atol=1e-9)
    assert report.results["neighbour-distance"].numbers["5 %"] == pytest.approx(1.0, abs=0.01)


def test_centimetres_are_metres_to_a_crowd():
    place = crowd(30, 10) * 0.3 + 3.0
    options = MeasureOptions(walkable=ROOM)
    in_m = measured(tracks_of(place), "fundamental-diagram", options, window=0.2)
    in_cm = measured(
        tracks_of(place * 100.0, unit="cm"), "fundamental-diagram", options, window=0.2
    )
    for column in ("density", "speed"):
        np.testing.assert_allclose(in_cm.tables[""][column], in_m.tables[""][column], rtol=1e-9)
