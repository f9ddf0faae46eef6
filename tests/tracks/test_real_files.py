"""Files of trackers as others have written them, where FLOCKSCOPE_REAL_TRACKS names their folder.

None is kept here. They are found by name anywhere in the folder: the notebooks' data of PedPy
(`pathfinder.csv` ... `crowdit.csv`), `obsmat.txt` of ETH and UCY in folders called as their scenes,
CITR's `citr/p1.csv` ..., and the four files of the package trajectorytools. Counts are those that
the files themselves have, rows that are told as dropped left out.
"""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from app.tracks.read_tracks import read
from worlds.input_error import InputError

FOLDER = os.environ.get("FLOCKSCOPE_REAL_TRACKS", "")
FILES = {
    "pathfinder.json": ("pathfinder-json", {}, 11, 20, 141),
    "pathfinder.csv": ("pathfinder", {}, 150, 138, 11820),
    "vadere_postvis.traj": ("vadere", {"rate": 25}, 20, 595, 6640),
    "bi_corr_400_b_03.txt": ("petrack", {}, 480, 3247, 120790),
    "040_c_56_h-.txt": ("petrack", {}, 75, 1657, 63110),
    "uo-070-180-180.txt": ("petrack", {"unit": "cm", "rate": 16}, None, None, None),
    "00_01a.h5": ("pedestrian-archive", {}, 46, 943, 30701),
    "n56_cam1.csv": ("pedpy", {"rate": 25}, 53, 399, 2391),
    "trajectories.sqlite": ("jupedsim", {}, 30, 491, 8083),
    "crowdit.csv": ("crowdit", {}, 20, 69, 791),
    "eth/obsmat.txt": ("obsmat", {"rate": 15}, 360, 1448, 8908),
    "hotel/obsmat.txt": ("obsmat", {"rate": 25}, 390, 1807, 6544),
    "zara01/obsmat.txt": ("obsmat", {"rate": 25}, 148, 902, 5024),
    "students03/obsmat.txt": ("obsmat", {"rate": 25}, 428, 540, 21846),
    "citr": ("citr", {"rate": 29.97, "origin": "top-left"}, 10, 348, 3480),
    "trajectories_with_points.npy": ("idtracker-npy", {}, 15, 1000, 14993),
    "test_trajectories_idtrackerai.npy": ("idtracker-npy", {}, 8, 508, None),
    "test_trajectories_idtrackerai_with_border.npy": ("idtracker-npy", {}, 8, 508, 4021),
    "test_trajectories.npy": (
        "idtracker-npy", {"rate": 32, "unit": "px", "origin": "top-left"}, 100, 300, None
    ),
}  # fmt: skip
"""Name -> its format, what it does not say, individuals, frames and places."""


def real(name: str) -> Path:
    """A file or folder of that name; the test is skipped without."""
    found = sorted(Path(FOLDER).rglob(name)) if FOLDER else []
    if not found:
        pytest.skip(f"no {name} in FLOCKSCOPE_REAL_TRACKS")
    return found[0]


@pytest.mark.parametrize("name", FILES)
def test_a_real_file_is_told_by_what_it_holds_and_read(name):
    form, options, individuals, frames, places = FILES[name]
    tracks = read(real(name), **options)
    assert tracks.format == form
    assert individuals in (None, len(tracks.ids))
    assert frames in (None, len(tracks.frame))
    assert places in (None, int(tracks.seen.sum()))


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("n56_cam1.csv", "says no frames per second: give --rate"),
        ("uo-070-180-180.txt", "says no unit of length: give --unit"),
        ("test_trajectories.npy", "says no unit of length: give --unit"),
        ("annotation.vsp", "holds splines through points that were clicked"),
        ("bidirectional_data.pkl", "is in no format of tracks that is known"),
    ],
)
def test_what_a_real_file_does_not_say_is_asked_for(name, line):
    with pytest.raises(InputError, match=line):
        read(real(name))
