"""A ZIP from a stranger: what may be in it, how much, and its texts, read within bounds."""

from __future__ import annotations

import io
import os
import re
import stat
import zipfile
import zlib
from collections import Counter
from pathlib import Path

from worlds.input_error import InputError, shortened

LARGEST = 32 * 2**20
"""Bytes of a class's file."""
OPENED = 128 * 2**20
"""Bytes of all that is in it."""
MOST_ENTRIES = 12_000
TEXT, TABLE, PICTURE = 2 * 2**20, 8 * 2**20, 32 * 2**20
"""Bytes of what is in it, by kind."""
ENTRY = b"PK\x01\x02"
"""Stands before each entry in a ZIP's list of them."""
NAME = r"[^/\\:\0]{1,100}"
KINDS = {
    r"(class|scene)\.toml": TEXT,
    rf"(students|questions)/{NAME}\.toml": TEXT,
    rf"results/{NAME}\.csv": TABLE,
    rf"results/{NAME}/[0-9]{{4}}\.toml": TEXT,
    rf"plots/{NAME}\.(svg|png)": PICTURE,
}
"""What a class's file has, and how large it may be."""
PACKED = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
LOCKED = 0x1
"""The flag of an entry that needs a password."""
BROKEN = (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError, OSError,
          ValueError, OverflowError)  # fmt: skip
"""What the library raises for ZIPs that are none."""


class ClassArchive:
    """The texts of a ZIP by their names. Raises InputError for what is no class's file."""

    def __init__(self, name: str, data: bytes):
        self.name = name
        if len(data) > LARGEST:
            raise InputError(
                f"{name} has {len(data):,} bytes: a class's file has {LARGEST:,} at most"
            )
        listed = data.count(ENTRY)
        if listed > MOST_ENTRIES:
            raise InputError(f"{name} has {listed:,} entries: a class's file has {MOST_ENTRIES:,}")
        try:
            self.pack = zipfile.ZipFile(io.BytesIO(data))
        except BROKEN:
            raise InputError(f"{name} is not a class's file, which is a ZIP") from None
        demand_sound(name, self.pack.infolist())
        self.names = frozenset(one.filename for one in self.pack.infolist())

    def text(self, entry: str) -> str:
        """A text in UTF-8. Raises InputError."""
        if entry not in self.names:
            raise InputError(f"{self.name} has no {shortened(entry)}")
        try:
            data = self.pack.read(entry)
        except BROKEN:
            raise InputError(f"{self.name}: {entry} is damaged") from None
        try:
            return data.decode("utf-8")
        except UnicodeDecodeError:
            raise InputError(f"{self.name}: {entry} is not a text") from None


def demand_sound(name: str, entries: list[zipfile.ZipInfo]) -> None:
    """Refuse entries that no class's file has, before any is read. Raises InputError."""
    twice = [one for one, count in Counter(one.filename for one in entries).items() if count > 1]
    if twice:
        raise InputError(f"{name} has {shortened(twice[0])} twice")
    for one in entries:
        where = shortened(one.filename)
        if one.is_dir() and one.filename.count("/") <= 2 and ".." not in one.filename:
            continue
        largest = allowed(one.filename)
        if largest is None:
            raise InputError(f"{name}: {where} is nothing that a class's file has")
        mode = one.external_attr >> 16
        if stat.S_IFMT(mode) not in (0, stat.S_IFREG):
            raise InputError(f"{name}: {where} is a link or a device, not a file")
        if one.flag_bits & LOCKED or one.compress_type not in PACKED:
            raise InputError(f"{name}: {where} is packed in a way that is not read here")
        if one.file_size > largest:
            raise InputError(f"{name}: {where} has {one.file_size:,} bytes: at most {largest:,}")
    if (total := sum(one.file_size for one in entries)) > OPENED:
        raise InputError(f"{name} holds {total:,} bytes: a class's file holds {OPENED:,} at most")


def allowed(entry: str) -> int | None:
    """The most bytes of an entry of that name; None where there is none in a class's file."""
    if entry != entry.strip() or any(part.startswith(".") for part in entry.split("/")):
        return None
    if not entry.isprintable():
        return None
    return next((most for kind, most in KINDS.items() if re.fullmatch(kind, entry)), None)


def content_of(path: Path) -> bytes:
    """The bytes of a plain file, not without end. Raises InputError."""
    named = f"class {str(path)!r}"
    try:
        if not stat.S_ISREG(os.stat(path).st_mode):
            raise InputError(f"{named} cannot be read: it is no file")
        with open(path, "rb") as file:
            return file.read(LARGEST + 1)
    except OSError as error:
        raise InputError(f"{named} cannot be read: {error.strerror or error}") from None
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{named} is no name that a file can have") from None
