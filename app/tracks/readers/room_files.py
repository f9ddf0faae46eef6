"""Recordings of rooms: C3D, Motive, Vicon, TRC, QTM, ROS bags as CSV, TUM.

They are the sources of `recorded:` too, so what reads them is in `app.live.sources`.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from app.tracks.readers.file_beginning import FileBeginning
from app.tracks.readers.track_reader import FileTracks, ReadingOptions, TrackReader
from worlds.input_error import InputError

TITLES = {
    "motive": ("Motive, CSV", (".csv",)),
    "nexus": ("Vicon Nexus, CSV", (".csv",)),
    "tracker": ("Vicon Tracker, CSV", (".csv",)),
    "trc": ("TRC, markers", (".trc",)),
    "qtm": ("QTM, TSV", (".tsv",)),
}
"""Formats with many bodies in a file."""
SINGLE = {
    "rosbag": ("ROS bag as CSV, a file for each body", (".csv",)),
    "tum": ("TUM trajectory, a file for each body", (".txt",)),
}


def read_room(files: Sequence[Path], _: ReadingOptions) -> FileTracks:
    """The bodies or markers of a room, in space. Raises InputError."""
    from app.live.sources.c3d_trial import read_marker_trial
    from app.live.sources.room_tables import read_room_table

    is_c3d = FileBeginning(files[0]).kind == "c3d"
    trial = read_marker_trial(files[0]) if is_c3d else read_room_table(files[0])
    return FileTracks(
        trial.position,
        trial.names,
        trial.frame,
        trial.time,
        unit=trial.unit if trial.unit in ("m", "cm", "mm", "in", "ft") else "",
    )


def read_bodies(files: Sequence[Path], _: ReadingOptions) -> FileTracks:
    """Files of one body each, by the clock of the first. Raises InputError."""
    from app.live.sources.room_tables import read_room_table

    trials = [read_room_table(path) for path in files]
    first = min(trial.start for trial in trials)
    time = [trial.time + (trial.start - first) for trial in trials]
    names = [trial.names[0] for trial in trials]
    if len(set(names)) < len(names):
        raise InputError(f"{files[0].name} and others have the same name: a file for each body")
    return FileTracks(
        np.concatenate([trial.position[:, 0] for trial in trials]),
        np.repeat(np.array(names, object), [len(trial.time) for trial in trials]),
        time=np.concatenate(time),
        unit="m",
    )


def recogniser(kind: str) -> object:
    """What tells files of a kind from others."""

    def recognises(beginning: FileBeginning) -> bool:
        from app.live.sources.room_tables import first_lines, kind_of_room

        if beginning.kind != "text":
            return False
        is_late = beginning.first.startswith("Devices")  # a block of Vicon's before the places
        return kind_of_room(first_lines(beginning.path) if is_late else beginning.lines) == kind

    return recognises


READERS = (
    TrackReader(
        "c3d",
        "C3D, markers",
        (".c3d",),
        lambda beginning: beginning.kind == "c3d",
        read_room,
    ),
    *(
        TrackReader(name, title, endings, recogniser(name), read_room)  # type: ignore[arg-type]
        for name, (title, endings) in TITLES.items()
    ),
    *(
        TrackReader(name, title, endings, recogniser(name), read_bodies, takes_several=True)  # type: ignore[arg-type]
        for name, (title, endings) in SINGLE.items()
    ),
)
