"""TOML that somebody gave: read, or refused in one line."""

from __future__ import annotations

import tomllib
from typing import Any

from worlds.refusal import Refusal


def toml(text: str, origin: str) -> dict[str, Any]:
    """The tables of a TOML text. Raises Refusal naming the line that is wrong."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise Refusal(f"{origin} is not TOML: {error}") from None
    except RecursionError:
        raise Refusal(f"{origin} cannot be read: its values are nested too deep") from None
    except ValueError as error:  # a number of more digits than Python reads, a date that is none
        raise Refusal(f"{origin} is not TOML: {error}") from None
