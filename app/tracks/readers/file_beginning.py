"""The first bytes of a file, by which its format is told; its name is never asked."""

from __future__ import annotations

import os
import stat
from functools import cached_property
from pathlib import Path

from worlds.input_error import InputError

BEGINNING = 1 << 16
"""Bytes that are looked at."""
LARGEST = 4 << 30
"""Bytes of a file of tracks at most."""
SEPARATORS = (",", ";", "\t")
"""What may stand between the columns of a text; blanks otherwise."""
MAGIC = {
    b"\x89HDF\r\n\x1a\n": "hdf5",
    b"SQLite format 3\x00": "sqlite",
    b"\x93NUMPY": "npy",
    b"PK\x03\x04": "zip",
    b"PAR1": "parquet",
    b"\x1f\x8b": "gzip",
}
"""How files that are not text begin."""


class FileBeginning:
    """What a file begins with. Raises InputError if it cannot be opened, or is too large."""

    def __init__(self, path: Path):
        self.path = path
        try:
            with open(path, "rb") as file:
                status = os.fstat(file.fileno())
                if not stat.S_ISREG(status.st_mode):
                    raise InputError(f"{path} cannot be read: it is no file")
                self.size = status.st_size
                self.data = file.read(BEGINNING)
        except OSError as error:
            raise InputError(f"{path} cannot be read: {error.strerror or error}") from None
        except ValueError as error:
            if isinstance(error, InputError):
                raise
            raise InputError(f"{str(path)!r} is no name that a file can have") from None
        if self.size > LARGEST:
            raise InputError(f"{path} has {self.size >> 20} MiB: at most {LARGEST >> 20} are read")
        if not self.size:
            raise InputError(f"{path} is empty")

    @property
    def name(self) -> str:
        """Its own name, without its folders."""
        return self.path.name

    @cached_property
    def kind(self) -> str:
        """One of the values of MAGIC, "c3d", "text", or "" for none of these."""
        for magic, kind in MAGIC.items():
            if self.data.startswith(magic):
                return kind
        if len(self.data) >= 512 and self.data[1] == 0x50 and 2 <= self.data[0] <= 127:
            return "c3d"  # the place of its parameters, then the key byte that all of them have
        return "text" if self.is_text else ""

    @cached_property
    def is_text(self) -> bool:
        """Whether it is UTF-8 with no control characters but those of lines."""
        if b"\x00" in self.data:
            return False
        try:  # the last character may be cut in two
            text = self.data[: len(self.data) - 4 * (self.size > BEGINNING)].decode("utf-8-sig")
        except UnicodeDecodeError:
            return False
        return not any(letter < " " and letter not in "\t\n\r\f" for letter in text[:4096])

    @cached_property
    def lines(self) -> list[str]:
        """The first lines of a text, whole ones, without their ends; empty for what is no text."""
        if self.kind != "text":
            return []
        lines = self.data.decode("utf-8-sig", "replace").splitlines()
        return lines[:-1] if self.size > BEGINNING and len(lines) > 1 else lines

    @property
    def first(self) -> str:
        """The first line of a text."""
        return self.lines[0] if self.lines else ""

    @cached_property
    def separator(self) -> str:
        """What stands between the columns of the first line; "" for blanks."""
        counts = {mark: self.first.count(mark) for mark in SEPARATORS}
        mark = max(counts, key=lambda mark: counts[mark])
        return mark if counts[mark] else ""

    @cached_property
    def columns(self) -> tuple[str, ...]:
        """The words of the first line of a text, without quotes."""
        return self.words(0)

    def words(self, line: int) -> tuple[str, ...]:
        """The words of a line, split as the first one is, without quotes and blanks around."""
        if line >= len(self.lines):
            return ()
        text = self.lines[line]
        words = text.split(self.separator) if self.separator else text.split()
        return tuple(word.strip().strip('"').strip() for word in words)

    def has_columns(self, *names: str) -> bool:
        """Whether the first line of a text names all of these columns."""
        return set(names) <= set(self.columns)

    @cached_property
    def keys(self) -> frozenset[bytes]:
        """The keys of the metadata of a Parquet file; empty for others."""
        if self.kind != "parquet":
            return frozenset()
        from agents.recordings.parquet_table import ParquetTable

        try:
            schema = ParquetTable(self.path, None, "a table").schema
        except InputError:  # its reader tells what is wrong with it
            return frozenset()
        return frozenset(schema.metadata or ())

    @cached_property
    def parts(self) -> frozenset[str]:
        """The names at the top of an HDF5 file, or the members of a zip file; empty for others."""
        from app.tracks.readers.stored_arrays import hdf5_names, zip_names

        if self.kind == "hdf5":
            return hdf5_names(self.path)
        return zip_names(self.path) if self.kind == "zip" else frozenset()
