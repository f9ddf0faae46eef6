"""The laboratory of the example: two cars that follow an injected one, as in the reading."""

from __future__ import annotations

from pathlib import Path

from app.live.laboratory.lab_file import Lab, read_lab

FILE = Path(__file__).with_name("example.toml")
"""A file to begin from."""


def example() -> Lab:
    """The laboratory of that file."""
    return read_lab(FILE)
