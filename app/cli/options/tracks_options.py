"""A file of tracks, and what it does not say itself, as options of every command that plays it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from worlds.input_error import InputError

if TYPE_CHECKING:
    from app.tracks.playing.played_tracks import PlayedTracks

TracksFile = Annotated[
    str | None,
    typer.Option(
        "--tracks",
        metavar="FILE",
        help="Tracks of real animals, people or robots, of any format of `flockscope tracks`.",
    ),
]
Rate = Annotated[
    float | None, typer.Option(help="Of tracks: frames per second, if the file does not say.")
]
Unit = Annotated[
    str | None,
    typer.Option(help="Of tracks: unit of the file's numbers, m, cm, mm, ... or px."),
]
Scale = Annotated[float | None, typer.Option(help="Of tracks in pixels: metres in a pixel.")]
Origin = Annotated[
    str | None,
    typer.Option(help="Of tracks: top-left where y points down, as in a picture, or bottom-left."),
]


def played_tracks(path: str, **reading: Any) -> PlayedTracks:
    """Tracks of a file, to be played. Raises InputError."""
    from app.tracks.playing.played_tracks import PlayedTracks
    from app.tracks.read_tracks import read

    return PlayedTracks(read(Path(path), **reading))


def demand_tracks(tracks: str | None, **reading: Any) -> None:
    """Refuse what says how tracks are read where there are none. Raises InputError."""
    for name, value in reading.items():
        if tracks is None and value is not None:
            raise InputError(f"--{name} {value} is not allowed: it says how --tracks FILE is read")
