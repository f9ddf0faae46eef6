"""A scene in an address: by its name, or whole, packed so that it fits."""

from __future__ import annotations

import base64
import binascii
import zlib

from app.viewer.gallery.saved_scene import SavedScene
from worlds.input_error import InputError

PACKED = "z."
"""Stands before a scene that is there whole."""
LONGEST = 6000
"""Letters of a packed scene: browsers and servers take addresses of 8 000."""
LARGEST = 100_000
"""Bytes that it may unpack to."""


def packed(scene: SavedScene) -> str:
    """A scene as a parameter of an address. Raises InputError for one that is too large.

    >>> from agents.spec import Spec
    >>> from app.viewer.run.run_preset import at_home
    >>> unpacked(packed(SavedScene("mine", at_home("vem", agents=30)))).title
    'mine'
    """
    text = zlib.compress(scene.in_short().encode(), 9)
    made = PACKED + base64.urlsafe_b64encode(text).decode().rstrip("=")
    if len(made) > LONGEST:
        raise InputError(
            f"the address would have {len(made)} letters, at most {LONGEST}: save the scene as a "
            "file instead"
        )
    return made


def unpacked(text: str) -> SavedScene:
    """The scene of such a parameter, from whomever it comes. Raises InputError."""
    if not text.startswith(PACKED) or len(text) > LONGEST:
        raise InputError("this address has no scene in it")
    letters = text.removeprefix(PACKED)
    try:
        data = base64.b64decode(letters + "=" * (-len(letters) % 4), altchars="-_", validate=True)
        unpacking = zlib.decompressobj()
        plain = unpacking.decompress(data, LARGEST)
        if unpacking.unconsumed_tail or not unpacking.eof:
            raise InputError(f"the scene of this address is broken, or has over {LARGEST} bytes")
        words = plain.decode()
    except (binascii.Error, zlib.error, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError("the scene of this address is broken") from None
    return SavedScene.from_toml(words, "the address")
