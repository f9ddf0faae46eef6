"""Read a text file that somebody named, and TOML in it, or refuse it in one line.

Files and pipes are read, never a device, and not without end.
"""

from __future__ import annotations

import os
import re
import stat
import tomllib
from pathlib import Path
from typing import Any

from worlds.input_error import InputError

LARGEST = 64 * 2**20
"""Bytes of a text."""
DEEPEST = 50
"""Tables and lists within each other that are read."""
DOTTED = re.compile(rf"""(?<![\w"'-])(?:[\w"'-]++[ \t]*+\.[ \t]*+){{{DEEPEST}}}""")
"""A key of so many parts; the memory that `tomllib` needs for one grows with their square."""


def read_text(title: str, path: str | Path) -> str:
    """The text of a file in UTF-8; `title` is what a refusal calls it. Raises InputError."""
    try:
        with open(path, "rb") as file:
            kind = os.fstat(file.fileno()).st_mode
            if stat.S_ISCHR(kind) or stat.S_ISBLK(kind):
                raise InputError(f"{title} cannot be read: it is a device, not a file")
            data = file.read(LARGEST + 1)
    except OSError as error:
        raise InputError(f"{title} cannot be read: {error.strerror or error}") from None
    except ValueError as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"{title} is no name that a file can have") from None
    if len(data) > LARGEST:
        raise InputError(f"{title} cannot be read: it has more than {LARGEST >> 20} MiB")
    try:
        return data.decode("utf-8").replace("\r\n", "\n")
    except UnicodeDecodeError:
        raise InputError(f"{title} is not a text file") from None


def toml(text: str, origin: str) -> dict[str, Any]:
    """The tables of a TOML text. Raises InputError naming the line that is wrong."""
    if DOTTED.search(text):
        raise depth_error(origin)
    try:
        values = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{origin} is not TOML: {error}") from None
    except RecursionError:
        raise depth_error(origin) from None
    except ValueError:
        raise InputError(f"{origin} cannot be read: a number in it has too many digits") from None
    if is_deep(values):
        raise depth_error(origin)
    return values


def is_deep(values: Any) -> bool:
    """Whether tables and lists lie deeper within each other than is read."""
    level = [values]
    for _ in range(DEEPEST):
        level = [
            inner
            for item in level
            for inner in (item.values() if isinstance(item, dict) else item)
            if isinstance(inner, dict | list)
        ]
        if not level:
            return False
    return True


def depth_error(origin: str) -> InputError:
    """The refusal of what is nested too deep."""
    return InputError(
        f"{origin} cannot be read: tables or lists lie more than {DEEPEST} deep in each other"
    )
