"""viser's icons from an archive that is opened once.

viser opens it for every icon, and reads the names of all the thousands in it: half a second for the
buttons of a page.
"""

from __future__ import annotations

import functools
import zipfile
from types import SimpleNamespace

from viser import _icons


class IconArchive(zipfile.ZipFile):
    """An archive that stays open."""

    def __exit__(self, *_: object) -> None:
        """Stay open for the next icon."""


def keep_icons_open() -> None:
    """Have viser read its icons so."""
    _icons.zipfile = SimpleNamespace(ZipFile=functools.cache(IconArchive))  # type: ignore[assignment]
