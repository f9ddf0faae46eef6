"""The formats of tracks, in the order in which they are tried; others bring their own.

A new one is a file beside this with its `READERS`, and its name here; or, in a package of its own,
a `TrackReader` under the entry point `flockscope.tracks`. What a plug-in reads is tried first.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

from app.tracks.readers import (
    body_parts,
    crowd_databases,
    crowd_simulators,
    crowd_texts,
    gps_fixes,
    idtracker,
    own_files,
    room_files,
    trex,
)
from app.tracks.readers.file_beginning import FileBeginning
from app.tracks.readers.track_reader import TrackReader
from worlds.input_error import InputError, unknown
from worlds.plug_ins import plug_ins

MODULES = (
    own_files, room_files, idtracker, trex, body_parts, gps_fixes, crowd_databases,
    crowd_simulators, crowd_texts,
)  # fmt: skip
BUILT_IN: Mapping[str, TrackReader] = {
    reader.name: reader
    for reader in (*(one for module in MODULES for one in module.READERS), *own_files.TABLES)
}
MOST_FILES = 10_000
"""Files of a folder."""


def reader_of_entry(name: str, thing: object) -> tuple[str, TrackReader]:
    """The reader that an entry point brings. Raises TypeError if it brings none."""
    if not isinstance(thing, TrackReader):
        raise TypeError(f"{name} is a {type(thing).__name__}, not a TrackReader")
    return thing.name, thing


@cache
def readers() -> Mapping[str, TrackReader]:
    """All readers by name: those of plug-ins, then the built-in ones, the plain table last."""
    return plug_ins("flockscope.tracks", reader_of_entry, BUILT_IN) | dict(BUILT_IN)


def find_reader(beginning: FileBeginning) -> TrackReader | None:
    """The first reader that recognises a file, None if none does."""
    return next((one for one in readers().values() if one.recognises(beginning)), None)


def named_reader(name: str) -> TrackReader:
    """The reader of a name. Raises InputError."""
    if name not in readers():
        raise unknown("format", name, readers(), "--format")
    return readers()[name]


def choose_reader(
    paths: Sequence[Path], name: str | None, wants_table: bool
) -> tuple[TrackReader, list[Path], list[str]]:
    """Who reads these files, or the files of this folder; which ones; and what is left out.

    name: a format that is asked for. wants_table: whether columns of a plain table are named.
    Raises InputError if nobody reads them, or several do.
    """
    files, left_out = [], []
    wanted = "table" if wants_table else name
    asked = named_reader(wanted) if wanted else None
    is_folder = len(paths) == 1 and paths[0].is_dir()
    for path in files_of(paths[0]) if is_folder else paths:
        if path.is_dir():
            raise InputError(f"{path} is a folder: give one folder, or files")
        if is_folder and not path.stat().st_size:
            left_out.append(path.name)
            continue
        beginning = FileBeginning(path)
        reader = asked or find_reader(beginning)
        if is_folder and (reader is None or (asked and not asked.recognises(beginning))):
            left_out.append(path.name)
        elif reader is None:
            raise unrecognised(beginning)
        else:
            files.append((path, reader))
    own = [pair for pair in files if pair[1].name != "table"]
    if is_folder and own and len(own) < len(files):  # a table of something else lies beside
        left_out += [path.name for path, reader in files if reader.name == "table"]
        files = own
    chosen = {reader.name: reader for _, reader in files}
    if not files:
        raise InputError(f"{paths[0]} has no file of tracks in it")
    if len(chosen) > 1:
        raise InputError(
            f"{paths[0]} and others are of several formats ({', '.join(chosen)}): choose one with "
            "--format, or name the files"
        )
    reader = next(iter(chosen.values()))
    if len(files) > 1 and not reader.takes_several:
        raise InputError(
            f"{len(files)} files of {reader.title} are not one set of tracks: give one of them "
            f"({', '.join(path.name for path, _ in files[:5])})"
        )
    return reader, [path for path, _ in files], left_out


def files_of(folder: Path) -> list[Path]:
    """The files of a folder by name, hidden ones not. Raises InputError for too many."""
    paths = []
    try:
        for path in folder.iterdir():
            if path.is_file() and not path.name.startswith("."):
                paths.append(path)
            if len(paths) > MOST_FILES:
                raise InputError(f"{folder} holds more than {MOST_FILES} files")
    except OSError as error:
        raise InputError(f"{folder} cannot be read: {error.strerror or error}") from None
    return sorted(paths, key=natural_order)


def natural_order(path: Path) -> list[tuple[int, str]]:
    """What files are sorted by: p2 comes before p10."""
    words, digits = [], ""
    for letter in f"{path.name}/":
        if letter.isdigit():
            digits += letter
            continue
        if digits:
            words.append((int(digits[:18]), ""))
            digits = ""
        words.append((-1, letter))
    return words


def unrecognised(beginning: FileBeginning) -> InputError:
    """The refusal of a file that nobody reads."""
    kinds = {
        "hdf5": "an HDF5 file with " + (", ".join(sorted(beginning.parts)[:8]) or "nothing in it"),
        "zip": "a zip file with " + (", ".join(sorted(beginning.parts)[:8]) or "nothing in it"),
        "gzip": "packed by gzip: unpack it",
        "sqlite": "a database of something else",
        "text": f"a text that begins with {beginning.first[:60]!r}",
    } if beginning.kind else {}  # fmt: skip
    return InputError(
        f"{beginning.name} is in no format of tracks that is known: it is "
        f"{kinds.get(beginning.kind, 'no text and no known kind of file')} "
        "(`flockscope tracks formats` lists those that are)"
    )
