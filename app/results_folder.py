"""A folder of results: pictures and numbers that belong together, checked before they are made."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

from worlds.file_writer import demand_writable
from worlds.input_error import InputError

RESULTS = Path("results")
"""Where sweeps are kept that say no other folder, from where a command was called."""
PICTURES = ("png", "svg")
"""Endings of every picture that a command draws into a folder."""


RUNS = RESULTS / "runs.jsonl"
"""Where a laboratory keeps its runs that says no other file."""
RUNS_ENDING = ".jsonl"
RUNS_BEGIN = b'{"flockscope": "runs"'
"""How such a file begins."""


def demand_runs(path: Path) -> None:
    """Refuse what is no file of runs, by its name and how it begins. Raises InputError."""
    named = f"runs {str(path)!r}"
    if path.suffix.lower() != RUNS_ENDING:
        raise InputError(f"{named} is not allowed: a name that ends in {RUNS_ENDING} is needed")
    try:
        with open(path, "rb") as file:
            head = file.read(len(RUNS_BEGIN))
    except FileNotFoundError:
        return
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"{named} cannot be read: {reason}") from None
    if head not in (b"", RUNS_BEGIN):
        raise InputError(f"{named} is no file of runs: its first line says what it is")


def picture_files(name: str, pictures: bool = True) -> tuple[str, ...]:
    """The files that a picture of that name comes to, none if there are no pictures."""
    return tuple(f"{name}.{kind}" for kind in PICTURES) if pictures else ()


def demand_folder(option: str, folder: Path, files: Iterable[str], overwrite: bool) -> None:
    """Refuse a folder that cannot be made or written to, or has one of these files already.

    It is made when the first file is written. Raises InputError.
    """
    named = f"{option} {str(folder)!r}"
    try:
        existing = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or "it is no name that a folder can have"
        raise InputError(f"{named} cannot be written: {reason}") from None
    if not existing.is_dir() or not os.access(existing, os.W_OK):
        raise InputError(f"{named} cannot be written: {str(existing)!r} is no folder to write to")
    if folder.is_dir():
        for file in files:
            demand_writable("result", folder / file, overwrite)


def make_folder(folder: Path) -> None:
    """Make the folder. Raises InputError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{str(folder)!r} cannot be made: {error.strerror or error}") from None
