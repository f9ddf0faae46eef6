"""Vicsek's rule on the real fish of trajectorytools, where FLOCKSCOPE_REAL_TRACKS has its files.

It explains nothing of any of the three up to 10 frames: the mean heading of all within r loses to
keeping the heading, or is best where nobody is within r. Of a hundred fish it explains a little
over 20 frames, 0.7 s: they turn round the tank together.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from app.tracks.fit.fit_api import fit
from app.tracks.read_tracks import read

FOLDER = os.environ.get("FLOCKSCOPE_REAL_TRACKS", "")
pytestmark = pytest.mark.skipif(not FOLDER, reason="no FLOCKSCOPE_REAL_TRACKS")
FILES = {
    "test_trajectories.npy": {"rate": 28.0, "unit": "px", "origin": "top-left"},
    "test_trajectories_idtrackerai.npy": {"unit": "px"},
    "trajectories_with_points.npy": {"unit": "px"},
}


def fit_of_fish(name, every):
    """The fit of r, the test is skipped without the file."""
    paths = sorted(Path(FOLDER).rglob(name))
    if not paths:
        pytest.skip(f"no {name} in FLOCKSCOPE_REAL_TRACKS")
    tracks = read(paths[0], **FILES[name])
    # 300 px are one length, so that r is looked for from 15 to 1500 px.
    (found,) = fit(tracks, "vem", "r=0.05:5:34", every=every, length=300.0, workers=1).fits
    return found


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("every", [1, 2, 5, 10])
def test_vicseks_rule_explains_nothing_of_fish(name, every):
    found = fit_of_fish(name, every)
    assert not found.explains
    assert found.cost >= found.null_cost * (1.0 - 1e-9)
    assert found.sentences()[0].startswith("vem explains nothing: on frames it has not seen")


def test_of_a_hundred_fish_it_explains_a_little_over_a_longer_time():
    found = fit_of_fish("test_trajectories.npy", 20)
    assert found.explains
    assert 0.05 < found.skill < 0.15
    assert max(found.shuffled_skills) < 0.01
