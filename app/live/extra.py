"""Packages that only live runs need."""

from __future__ import annotations

from importlib.util import find_spec

from worlds.refusal import Refusal

INSTALL = 'install the extra live: `uv sync --extra live` or `pip install ".[live]"` in its folder'
"""What to do about a package that only live runs need; flockscope is on no package index."""


def demand(package: str, purpose: str) -> None:
    """Refuse with one line what needs a package that is not installed."""
    if find_spec(package) is None:
        raise Refusal(f"{purpose} needs the package {package}, which is not installed: {INSTALL}")
