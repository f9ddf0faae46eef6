"""TOML that somebody gave: read, or refused in one line."""

from __future__ import annotations

import re
import tomllib
from typing import Any

from worlds.refusal import Refusal

DEEPEST = 50
"""Tables and lists within each other that are read."""
DOTTED = re.compile(rf"""(?<![\w"'-])(?:[\w"'-]++[ \t]*+\.[ \t]*+){{{DEEPEST}}}""")
"""A key of so many parts; the memory that `tomllib` needs for one grows with their square."""


def toml(text: str, origin: str) -> dict[str, Any]:
    """The tables of a TOML text. Raises Refusal naming the line that is wrong."""
    if DOTTED.search(text):
        raise too_deep(origin)
    try:
        values = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise Refusal(f"{origin} is not TOML: {error}") from None
    except RecursionError:
        raise too_deep(origin) from None
    except ValueError:
        raise Refusal(f"{origin} cannot be read: a number in it has too many digits") from None
    if is_deep(values):
        raise too_deep(origin)
    return values


def is_deep(values: Any) -> bool:
    """Whether tables and lists lie deeper within each other than is read."""
    level = [values]
    for _ in range(DEEPEST):
        level = [
            inner
            for one in level
            for inner in (one.values() if isinstance(one, dict) else one)
            if isinstance(inner, dict | list)
        ]
        if not level:
            return False
    return True


def too_deep(origin: str) -> Refusal:
    """The refusal of what is nested too deep."""
    return Refusal(
        f"{origin} cannot be read: tables or lists lie more than {DEEPEST} deep in each other"
    )
