"""Write files: never over a device, over a file only when asked, whole or not at all.

A file is made beside its place under another name and takes its place in one move, so that nobody
ever sees half of it and a full disk leaves the old one as it was. Links are followed to the file
that they lead to.
"""

from __future__ import annotations

import csv
import io
import os
import secrets
import stat
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, BinaryIO

from worlds.input_error import InputError

KINDS = {
    stat.S_ISDIR: "a folder",
    stat.S_ISCHR: "a device",
    stat.S_ISBLK: "a device",
    stat.S_ISFIFO: "a pipe",
    stat.S_ISSOCK: "a socket",
}
"""What a path may be that no file is written over."""
NEW = 0o666
"""Rights of a new file, before the process's umask."""


PAGES = (".html", ".htm")
"""Endings of web pages."""


def demand_writable(
    thing: str,
    path: str | Path,
    overwrite: bool = False,
    endings: Collection[str] = (),
) -> Path:
    """The place where a file can be written, links followed; nothing is written yet.

    `thing` is the option or the kind of file that a refusal names; `endings` are those allowed, if
    not all are. Raises InputError for what is there and no file, for a file unless `overwrite`, for
    a folder that is not there or not to be written to, and for another ending.
    """
    title = f"{thing} {str(path)!r}"
    place = place_of(title, Path(path))
    try:
        status = place.lstat()
    except (FileNotFoundError, NotADirectoryError):
        status = None
    except OSError as error:
        raise write_error(title, error) from None
    if status is not None and not stat.S_ISREG(status.st_mode):
        kind = next(
            (kind_name for test, kind_name in KINDS.items() if test(status.st_mode)), "no file"
        )
        raise InputError(f"{title} is {kind}, not a file to write")
    if endings and Path(path).suffix.lower() not in endings:
        allowed = " or ".join(endings)
        raise InputError(f"{title} is not allowed: a name that ends in {allowed} is needed")
    if status is not None and not overwrite:
        raise InputError(f"{title} exists already: name another, or --overwrite")
    if status is not None and not os.access(place, os.W_OK):
        raise InputError(f"{title} cannot be written: it may only be read")
    if not place.parent.is_dir():
        raise InputError(f"{title} cannot be written: there is no folder {str(place.parent)!r}")
    try:
        temporary = temporary_name(place)
        os.close(os.open(temporary, os.O_WRONLY | os.O_CREAT | os.O_EXCL, NEW))
        temporary.unlink()
    except OSError as error:
        raise write_error(title, error) from None
    return place


def place_of(title: str, path: Path) -> Path:
    """Where a path leads, links followed. Raises InputError."""
    try:
        if b"\0" in os.fsencode(path):
            raise ValueError
        return path.resolve() if path.is_symlink() else path
    except (OSError, RuntimeError) as error:
        raise InputError(
            f"{title} leads nowhere: {getattr(error, 'strerror', '') or error}"
        ) from None
    except ValueError:
        raise InputError(f"{title} is no name that a file can have") from None


def demand_distinct_files(paths: Mapping[str, str | Path | None]) -> None:
    """Refuse two outputs under one path; `paths` by option, None where none is asked for."""
    names_by_place: dict[Path, str] = {}
    for option, path in paths.items():
        if path is None:
            continue
        place = place_of(f"{option} {str(path)!r}", Path(path)).absolute()
        place = place.parent.resolve() / place.name
        if place in names_by_place:
            raise InputError(
                f"{names_by_place[place]} and {option} name the same file {str(path)!r}"
            )
        names_by_place[place] = option


@contextmanager
def writing(
    thing: str, path: str | Path, overwrite: bool = True, endings: Collection[str] = ()
) -> Iterator[BinaryIO]:
    """A new file to write bytes to, which takes the place of `path` once it is whole.

    A file that it replaces keeps its rights. Raises InputError as `demand_writable`, and if the
    disk is full; then nothing has changed.
    """
    place = demand_writable(thing, path, overwrite, endings)
    temporary = temporary_name(place)
    try:
        with open(os.open(temporary, os.O_RDWR | os.O_CREAT | os.O_EXCL, NEW), "w+b") as file:
            yield file
        replace_file(temporary, place)
    except OSError as error:
        raise write_error(f"{thing} {str(path)!r}", error) from None
    finally:
        temporary.unlink(missing_ok=True)


def write_text(
    thing: str, path: str | Path, text: str, overwrite: bool = True, endings: Collection[str] = ()
) -> None:
    """Write a text file in UTF-8, whole or not at all. Raises InputError as `writing`."""
    try:
        data = text.encode("utf-8")
    except UnicodeEncodeError as error:
        letter = error.object[error.start]
        raise InputError(
            f"{thing} {str(path)!r} cannot be written: {letter!r} is no character of UTF-8"
        ) from None
    write_bytes(thing, path, data, overwrite, endings)


def write_bytes(
    thing: str, path: str | Path, data: bytes, overwrite: bool = True, endings: Collection[str] = ()
) -> None:
    """Write a file, whole or not at all. Raises InputError as `writing`."""
    with writing(thing, path, overwrite, endings) as file:
        file.write(data)


def temporary_name(place: Path) -> Path:
    """A name beside a place that nothing has."""
    return place.with_name(f".flockscope-{secrets.token_hex(6)}.tmp")


def replace_file(temporary: Path, place: Path) -> None:
    """Move a finished file to its place, with the rights of the one that it replaces."""
    with suppress(FileNotFoundError):
        os.chmod(temporary, stat.S_IMODE(place.stat().st_mode))
    os.replace(temporary, place)


def write_error(title: str, error: OSError) -> InputError:
    """The refusal for what cannot be written."""
    return InputError(f"{title} cannot be written: {error.strerror or error}")


FORMULA = "=+-@\t\r"
"""With what a text begins that a spreadsheet takes for a formula."""


def csv_text(header: Iterable[str], rows: Iterable[Iterable[Any]]) -> str:
    """A table as CSV, in which no text is a formula: every table of ours is written by this.

    >>> csv_text(["a", "=b"], [[1.5, "-x"], [None, "-2"]])
    "a,'=b\\n1.5,'-x\\n,-2\\n"
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(map(guard_cell, header))
    writer.writerows(map(guard_cell, row) for row in rows)
    return text.getvalue()


def guard_cell(cell: Any) -> Any:
    """A cell with a mark before a text that a spreadsheet would calculate; numbers as they are."""
    if not isinstance(cell, str) or not cell.startswith((*FORMULA, "'")):
        return cell
    try:
        float(cell)
    except ValueError:
        return f"'{cell}"
    return cell


def unguard_cell(cell: str) -> str:
    """What `guard_cell` made a cell of."""
    return cell[1:] if cell.startswith("'") else cell
