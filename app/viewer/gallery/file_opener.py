"""A file that is opened: a scene or a spec, a saved state or a recording, told apart by content."""

from __future__ import annotations

import os
import re
import stat
from pathlib import Path

from app.sandboxed_reader import read_in_sandbox, read_toml
from app.viewer.editing.layout_file import plain_name
from app.viewer.gallery.saved_scene import SavedScene, demand_scene_size, read_scene, scene_of
from app.viewer.run.stored_flock import PARQUET, REWRITE, StoredFlock, read_stored
from worlds.input_error import InputError
from worlds.text_file import read_text

ZIP = b"PK\x03\x04"
SHEET = re.compile(rb"\W*tick\W+id\W")
"""How a recording as CSV begins."""
ENDINGS = (".toml", ".parquet", ".pq")
HEAD = 64
"""Bytes by which a kind is told."""


def open_file(name: str, content: bytes) -> SavedScene | StoredFlock:
    """What a file from a browser is, whatever it is called. Raises InputError."""
    demand_kind(name, content[:HEAD])
    if content.startswith(PARQUET):
        return read_stored(name, read_in_sandbox(REWRITE, plain_name(name), content))
    demand_scene_size(name, content)
    return scene_of(read_toml(name, content), name)


def opened_file(name: str) -> SavedScene | StoredFlock:
    """What a file of this machine is. Raises InputError."""
    head = head_of(name)
    demand_kind(name, head)
    if head.startswith(PARQUET):
        return read_stored(name, path=Path(name))
    return read_scene(name, read_text(repr(name), name).encode())


def head_of(name: str) -> bytes:
    """How a file begins; nothing of what is no plain file. Raises InputError."""
    try:
        if not stat.S_ISREG(os.stat(name).st_mode):
            return b""
        with open(name, "rb") as file:
            return file.read(HEAD)
    except OSError as error:
        raise InputError(f"{name!r} cannot be read: {error.strerror or error}") from None
    except ValueError:
        raise InputError(f"{name!r} is no name that a file can have") from None


def demand_kind(name: str, head: bytes) -> None:
    """Raise InputError for what others of our files begin with that cannot be opened, and
    pictures."""
    if head.startswith(ZIP):
        raise InputError(f"{name} is a ZIP, as of two flocks side by side: open one of its files")
    if SHEET.match(head):
        raise InputError(
            f"{name} is a recording as CSV, which has no spec and no world: record it as Parquet "
            "(--record NAME.parquet)"
        )
    if head and any(byte < 9 for byte in head) and not head.startswith(PARQUET):
        raise InputError(
            f"{name} is no file that the laboratory opens: a scene or a spec (TOML), a saved state "
            "or a recording (Parquet)"
        )
