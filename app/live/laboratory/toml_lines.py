"""On which line of a TOML file something stands: `tomllib` gives values without their lines."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Sequence
from typing import Any

Path = tuple[str, ...]


def line_of(text: str, keys: Sequence[str]) -> int | None:
    """The line (from 1) that sets a key, given the keys that lead to it.

    Where nothing sets it, the table that lacks it; None if that cannot be found either.

    >>> line_of("title = 'a'\\n[cars.red]\\naddress = 1", ["cars", "red", "address"])
    3
    >>> line_of("title = 'a'\\n[cars.red]\\nspeed = 1", ["cars", "red", "address"])
    2
    """
    best, found = 0, None
    for number, path in settings(text):
        if len(path) > best and tuple(keys[: len(path)]) == path:
            best, found = len(path), number
    return found


def settings(text: str) -> Iterator[tuple[int, Path]]:
    """What each line sets, as the keys that lead to it; tables within braces too."""
    table: Path = ()
    for number, line in enumerate(text.splitlines(), 1):
        if line.lstrip().startswith("["):
            paths = list(paths_of(parsed(line)))
            if paths:
                table = paths[-1]
                yield number, table
            continue
        key, equals, _ = line.partition("=")
        if equals:
            # a value that goes on in the next lines cannot be parsed by itself; its key can
            for path in paths_of(parsed(line) or parsed(f"{key} = 0")):
                yield number, (*table, *path)


def parsed(line: str) -> dict[str, Any]:
    """One line as TOML; empty if it is none by itself."""
    try:
        return tomllib.loads(line)
    except tomllib.TOMLDecodeError:
        return {}


def paths_of(values: dict[str, Any]) -> Iterator[Path]:
    """All keys of nested tables, the outer ones first."""
    for key, value in values.items():
        yield (key,)
        if isinstance(value, dict):
            for path in paths_of(value):
                yield (key, *path)
