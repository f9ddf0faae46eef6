"""Values of real tracks that others have computed, where FLOCKSCOPE_REAL_TRACKS names their folder.

Three files, found by name anywhere in it: a tank of eight fish (trajectorytools), a bottleneck
(PedPy's notebooks), a street (UCY). None is kept here. Headings are from the frames before and
after, so a window of three frames; the xi of others ends a curve that is below 0 in its first bin
in another way, which is in its mean alone.
"""

import os
from pathlib import Path

import numpy as np
import pytest

from agents.observables.neighbours import nearest_neighbour
from app.tracks.measure_report import measure_tracks
from app.tracks.measures.track_measure import MeasureOptions
from app.tracks.motion import smoothed_motion
from app.tracks.tracks import Tracks, tracks_of_rows

FOLDER = os.environ.get("FLOCKSCOPE_REAL_TRACKS", "")
NAMES = ["polarisation", "angular-momentum", "correlation-length"]


def file_of(pattern):
    """The file of that name in the folder; the test is skipped without."""
    found = sorted(Path(FOLDER).rglob(pattern)) if FOLDER else []
    if not found:
        pytest.skip(f"no {pattern} in FLOCKSCOPE_REAL_TRACKS")
    return found[0]


def fish():
    held = np.load(file_of("test_trajectories_idtrackerai.npy"), allow_pickle=True).item()
    position = held["trajectories"] * [1.0, -1.0]
    frame = np.arange(len(position))
    ids = tuple(map(str, range(position.shape[1])))
    return Tracks(position, frame, frame / held["frames_per_second"], ids, "px")


def rows(pattern, columns):
    table = np.loadtxt(file_of(pattern))
    return tracks_of_rows(
        table[:, columns[0]].astype(int),
        table[:, columns[1]].astype(int),
        table[:, columns[2:]],
        name=pattern,
        unit="m",
        rate=25.0,
    )


def series(tracks):
    """What is measured by frame, and the distances to the nearest of those with a heading."""
    report = measure_tracks(tracks, NAMES, window=2.0 * tracks.step)
    tables = {name: report.results[name].tables[""] for name in NAMES}
    values = {name: table[name.replace("-", "_")] for name, table in tables.items()}
    return report.motion, values, tables["polarisation"]["n"]


def spacings(tracks, motion, frames):
    open_box = np.ones(2), np.zeros(2, bool)
    heads = np.isfinite(motion.heading).all(axis=2)
    return [nearest_neighbour(tracks.position[t][heads[t]], *open_box) for t in frames]


def test_eight_fish():
    tracks = fish()
    motion, values, n = series(tracks)
    frames = np.flatnonzero(np.isfinite(values["polarisation"]))
    assert len(frames) == 506
    assert np.nanmean(values["polarisation"]) == pytest.approx(0.350095, abs=1e-6)
    assert np.nanstd(values["polarisation"]) == pytest.approx(0.163500, abs=1e-6)
    assert np.nanmean(values["angular-momentum"]) == pytest.approx(0.189632, abs=1e-6)
    assert np.nanmean(values["correlation-length"]) == pytest.approx(61.018344, rel=0.003)
    near = spacings(tracks, motion, frames)
    assert np.mean([np.median(one) for one in near]) == pytest.approx(70.681695, abs=1e-6)
    assert min(one.min() for one in near) == pytest.approx(2.557975, abs=1e-6)
    speeds = np.nanquantile(motion.speed, [0.05, 0.5, 0.95])
    np.testing.assert_allclose(speeds, [30.696, 115.677, 353.567], atol=5e-4)
    assert n[254] == 6
    assert values["polarisation"][254] == pytest.approx(0.271616, abs=1e-6)
    assert values["angular-momentum"][254] == pytest.approx(0.169157, abs=1e-6)
    assert np.median(near[254 - frames[0]]) == pytest.approx(55.892978, abs=1e-6)
    assert values["correlation-length"][254] == pytest.approx(33.308255, abs=1e-6)


def test_a_bottleneck():
    tracks = rows("040_c_56_h-.txt", [1, 0, 2, 3])
    motion, values, n = series(tracks)
    tenth = np.arange(0, len(tracks.frame), 10)
    frames = tenth[np.isfinite(values["polarisation"][tenth])]
    assert len(frames) == 156
    assert values["polarisation"][frames].mean() == pytest.approx(0.545996, abs=1e-6)
    assert values["angular-momentum"][frames].mean() == pytest.approx(0.103948, abs=1e-6)
    assert values["correlation-length"][frames].mean() == pytest.approx(1.224785, rel=0.011)
    near = spacings(tracks, motion, frames)
    assert np.mean([np.median(one) for one in near]) == pytest.approx(0.369483, abs=1e-6)
    assert min(one.min() for one in near) == pytest.approx(0.086812, abs=1e-6)
    assert np.nanmean(motion.speed) == pytest.approx(0.207216, abs=1e-6)
    (at,) = np.flatnonzero(tracks.frame == 790)
    assert n[at] == 39
    assert values["polarisation"][at] == pytest.approx(0.361578, abs=1e-6)
    assert values["angular-momentum"][at] == pytest.approx(0.213455, abs=1e-6)
    assert values["correlation-length"][at] == pytest.approx(1.474665, abs=1e-6)


def test_a_street():
    tracks = rows("zara01/obsmat.txt", [0, 1, 2, 4])  # the third column is y, the second height
    motion, values, _ = series(tracks)
    frames = np.flatnonzero(np.isfinite(values["polarisation"]))
    assert len(frames) == 504
    assert np.nanmean(values["polarisation"]) == pytest.approx(0.425549, abs=1e-6)
    assert np.nanmean(values["angular-momentum"]) == pytest.approx(0.221818, abs=1e-6)
    assert np.nanmean(values["correlation-length"]) == pytest.approx(2.217643, rel=0.006)
    near = spacings(tracks, motion, frames)
    assert np.mean([np.median(one) for one in near]) == pytest.approx(1.158253, abs=1e-6)
    speeds = np.nanquantile(motion.speed, [0.05, 0.5, 0.95])
    np.testing.assert_allclose(speeds, [0.259783, 1.181479, 1.577245], atol=5e-7)


def test_the_flow_through_a_bottleneck_is_pedpys():
    tracks = rows("040_c_56_h-.txt", [1, 0, 2, 3])
    walkable = "POLYGON ((3.5 -2, 3.5 8, -3.5 8, -3.5 -2, 3.5 -2))"
    options = MeasureOptions(walkable=walkable, line="LINESTRING (0.4 0, -0.4 0)")
    report = measure_tracks(tracks, ["flow", "time-headway"], options)
    import pedpy

    data = pedpy.load_trajectory_from_txt(trajectory_file=file_of("040_c_56_h-.txt"))
    line = pedpy.MeasurementLine([(0.4, 0.0), (-0.4, 0.0)])
    table, crossing = pedpy.compute_n_t(traj_data=data, measurement_line=line)
    found = report.results["flow"].tables[""]
    np.testing.assert_array_equal(found["across"], table.cumulative_pedestrians)
    assert report.results["flow"].numbers["people across"] == len(crossing) == 75
    headway = report.results["time-headway"].tables[""]["headway"]
    np.testing.assert_allclose(headway, np.diff(np.sort(crossing.frame)) / 25.0)


@pytest.mark.parametrize("window", [2, 6, 10])
def test_the_velocity_noise_of_a_file_is_told(window):
    tracks = rows("040_c_56_h-.txt", [1, 0, 2, 3])
    motion = smoothed_motion(tracks, window * tracks.step)
    assert ("noise of places" in motion.describe()) == (window > 2)
