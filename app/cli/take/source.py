"""What a picture or a film is made of: a recording, a saved state, or a run that is made for it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeGuard

from app.cli.options.run_arguments import GivenOptions, option_name
from app.cli.options.tracks_options import demand_tracks, played_tracks
from app.cli.run import build_flock
from app.cli.terminal.outcome_table import print_stderr
from app.cli.terminal.usage import first_of, model_name
from app.studies.workers.kernels import compile_loop
from worlds.input_error import InputError

if TYPE_CHECKING:
    from agents import Flock
    from agents.recordings.recording import Recording
    from app.tracks.playing.played_tracks import PlayedTracks

STATES = (".parquet", ".pq")
"""Endings of recordings and saved states."""


def is_recording(what: str | None) -> TypeGuard[str]:
    """Whether it names a recording or a saved state."""
    return what is not None and Path(what).suffix.lower() in STATES


def recording_of(what: str, options: GivenOptions, settings: list[str], rule: Any) -> Recording:
    """The recording that is named; what a run takes beside it is refused. Raises InputError."""
    for name, value in {**options, "set": settings or None, "rule": rule or None}.items():
        if value is not None:
            raise InputError(
                f"{option_name(name)} {value} is not allowed: "
                f"{what} is a recording, its run is done"
            )
    from agents.recordings.recording import Recording

    return Recording(what)


def recorded_source(
    what: str | None,
    tracks: str | None,
    reading: dict[str, Any],
    options: GivenOptions,
    settings: list[str],
    rule: Any,
) -> Recording | PlayedTracks | None:
    """What holds snapshots of a run or of tracks at ticks; None for a run that is to be made.

    Raises InputError.
    """
    demand_tracks(tracks, **reading)
    if tracks is None:
        return recording_of(what, options, settings, rule) if is_recording(what) else None
    for name, value in {**options, "set": settings or None, "rule": rule or None}.items():
        if value is not None:
            raise InputError(
                f"{option_name(name)} {value} is not allowed: {tracks} is a file of tracks"
            )
    if what is not None:
        raise InputError(f"{what} is not allowed with --tracks {tracks}: one source at a time")
    return played_tracks(tracks, **reading)


def flock_of(
    what: str | None, options: GivenOptions, settings: list[str], rule: Any, quiet: bool
) -> Flock:
    """The flock of a model's name, of a FILE.py or of a spec (TOML), compiled. Raises
    InputError."""
    spec = Path(what) if what is not None and Path(what).suffix.lower() == ".toml" else None
    model = None if spec else first_of(model_name(what), rule)
    if spec is not None and not spec.exists():
        raise InputError(f"spec {str(spec)!r} cannot be read: there is no such file")
    flock = build_flock(spec, model, options, settings, {}, quiet)
    if flock.warning and not quiet:
        print_stderr(f"flockscope: {flock.warning}")
    compile_loop(flock, None if quiet else print_stderr)
    return flock


def pixels(text: str) -> tuple[int, int]:
    """Width and height of a text WIDTHxHEIGHT. Raises InputError."""
    wide, times, tall = text.lower().partition("x")
    if not (times and wide.isdigit() and tall.isdigit()):
        raise InputError(f"--pixels {text!r} is not a size: WIDTHxHEIGHT, as 1600x1000")
    for side in (wide, tall):
        if not LEAST <= int(side[:9]) <= MOST:
            raise InputError(f"--pixels {text}: {side} is outside [{LEAST}, {MOST}]")
    return int(wide), int(tall)


LEAST, MOST = 320, 8000
"""Pixels of a side."""
