"""How a text that somebody named is read: files and pipes, never a device, and not without end."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from worlds.refusal import Refusal

LARGEST = 64 * 2**20
"""Bytes of a text."""


def read_text(named: str, path: str | Path) -> str:
    """The text of a file in UTF-8; `named` is what a refusal calls it. Raises Refusal."""
    try:
        with open(path, "rb") as file:
            kind = os.fstat(file.fileno()).st_mode
            if stat.S_ISCHR(kind) or stat.S_ISBLK(kind):
                raise Refusal(f"{named} cannot be read: it is a device, not a file")
            data = file.read(LARGEST + 1)
    except OSError as error:
        raise Refusal(f"{named} cannot be read: {error.strerror or error}") from None
    except ValueError as error:
        if isinstance(error, Refusal):
            raise
        raise Refusal(f"{named} is no name that a file can have") from None
    if len(data) > LARGEST:
        raise Refusal(f"{named} cannot be read: it has more than {LARGEST >> 20} MiB")
    try:
        return data.decode("utf-8").replace("\r\n", "\n")
    except UnicodeDecodeError:
        raise Refusal(f"{named} is not a text file") from None
