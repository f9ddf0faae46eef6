"""Vicsek's rule on the real fish of trajectorytools, where FLOCKSCOPE_REAL_TRACKS has its files.

It explains nothing of any of the three at any horizon: the mean heading of all within r loses to
keeping the heading, or is best where nobody is within r.
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


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("every", [1, 2, 5, 10, 20])
def test_vicseks_rule_explains_nothing_of_fish(name, every):
    paths = sorted(Path(FOLDER).rglob(name))
    if not paths:
        pytest.skip(f"no {name} in FLOCKSCOPE_REAL_TRACKS")
    tracks = read(paths[0], **FILES[name])
    # 300 px are one length, so that r is looked for from 15 to 1500 px.
    (found,) = fit(tracks, "vem", "r=0.05:5:34", every=every, length=300.0, workers=1).fits
    assert not found.explains
    assert found.cost >= found.null_cost * (1.0 - 1e-9)
    assert found.sentences()[0].startswith("vem explains nothing: on frames it has not seen")
