"""viser's page as it is served here: with our own scripts, and the hashes of every script in it.

The page is one file. Its loader unpacks the client (base 88, then zstandard) and runs it as a
script of the page, so a policy that allows scripts by their hash must know the hash of that too.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
from dataclasses import dataclass
from functools import lru_cache
from html.parser import HTMLParser

import numpy as np
import viser
import zstandard

from app.front.viser_internals import PAGE
from app.package_files import STATIC
from worlds.input_error import InputError

ALPHABET = (
    "!#$%()*+,-./0123456789:;=?@ABCDEFGHIJKLMNOPQRSTUVWXYZ[\\]^_abcdefghijklmnopqrstuvwxyz{|}~"
)
"""The digits of base 88, the least first."""
DIGITS, BYTES = 5, 4
"""So many digits stand for so many bytes."""
SCRIPTS = (
    "own-address.js",
    "viser-client.js",
    "layout.js",
    "look.js",
    "connection.js",
    "keys.js",
    "dials.js",
    "plots.js",
    "labels.js",
    "accessible.js",
)
"""The scripts that run before viser's, in every page."""
STYLES = ("page.css", "gallery.css")
"""How every page looks from its first moment on."""
FACE, FONT = "Flockscope Sans", "flockscope-sans.woff2"
"""The face of all that is written in it, and the file of `static/` that has it."""


@dataclass(frozen=True)
class ClientPage:
    """A page ready to be sent."""

    html: bytes
    packed: bytes
    """The same by gzip."""
    hashes: tuple[str, ...]
    """Of all scripts that may run in it, as a Content-Security-Policy writes them."""


@lru_cache(maxsize=8)
def client_page(scripts: tuple[str, ...], styles: tuple[str, ...] = ()) -> ClientPage:
    """viser's page with these files of `static/`: styles, and scripts of its own that run first.

    They stand in the page itself: it can neither be had without them nor take them from elsewhere.
    Raises InputError if viser's page is not built as it was.
    """
    own = [(STATIC / name).read_text("utf-8") for name in (*SCRIPTS, *scripts)]
    html = viser_page()
    head, found, rest = html.partition("<head>")
    loaders = Scripts.of(html)
    if not found or len(loaders) != 1:
        raise unknown_page(f"{len(loaders)} scripts in it")
    attributes, loader = loaders[0]
    client = unpack_client(attributes)
    texts = [*(text.encode() for text in own), loader.encode(), client]
    style = font_face() + "".join((STATIC / name).read_text("utf-8") for name in (*STYLES, *styles))
    added = "".join((*(f"<script>{text}</script>" for text in own), f"<style>{style}</style>"))
    page = (head + found + added + rest).encode()
    return ClientPage(
        page, gzip.compress(page, mtime=0), tuple(script_hash(text) for text in texts)
    )


def font_face() -> str:
    """CSS that brings the page its face: in the page itself, which takes nothing from elsewhere."""
    data = base64.b64encode((STATIC / FONT).read_bytes()).decode()
    return (
        f'@font-face {{ font-family: "{FACE}"; font-weight: 400 700; '
        f'src: url(data:font/woff2;base64,{data}) format("woff2"); }}\n'
    )


def viser_page() -> str:
    """The page that viser would serve."""
    return PAGE.read_text("utf-8")


def script_hash(script: bytes) -> str:
    """The hash of a script, as a Content-Security-Policy writes it."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(script).digest()).decode()}'"


def unpack_client(attributes: dict[str, str]) -> bytes:
    """The client that the loader makes of its attributes. Raises InputError."""
    try:
        styles, code = int(attributes["data-ss"]), int(attributes["data-cs"])
        packed = from_base88(attributes["data-p"])
        plain = zstandard.ZstdDecompressor().decompress(packed, max_output_size=styles + code)
    except (KeyError, ValueError, zstandard.ZstdError) as error:
        raise unknown_page(f"its client cannot be unpacked: {error}") from None
    return plain[styles:]


def from_base88(text: str) -> bytes:
    """The bytes that a text in base 88 stands for, most significant digit first.

    Raises ValueError for other characters.
    """
    values = np.full(256, -1)
    values[[ord(character) for character in ALPHABET]] = np.arange(len(ALPHABET))
    digits = values[np.frombuffer(text.encode("latin-1"), np.uint8)]
    if digits.min(initial=0) < 0:
        raise ValueError("a character that is not of base 88")
    whole = len(digits) // DIGITS * DIGITS
    weights = len(ALPHABET) ** np.arange(DIGITS)[::-1]
    start = (digits[:whole].reshape(-1, DIGITS) @ weights).astype(">u4").tobytes()
    left = digits[whole:]
    if not len(left):
        return start
    last = int(left @ weights[-len(left) :])
    return start + last.to_bytes(BYTES, "big")[BYTES + 1 - len(left) :]


def unknown_page(why: str) -> InputError:
    """What is said of a page of viser's that is not built as it was."""
    return InputError(f"the page of viser {viser.__version__} is not one that can be served: {why}")


class Scripts(HTMLParser):
    """Finds the scripts of a page."""

    def __init__(self) -> None:
        super().__init__()
        self.found: list[tuple[dict[str, str], str]] = []
        self.inside = False

    @classmethod
    def of(cls, html: str) -> list[tuple[dict[str, str], str]]:
        """Attributes and text of each."""
        parser = cls()
        parser.feed(html)
        parser.close()
        return parser.found

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.inside = tag == "script"
        if self.inside:
            self.found.append(({name: value or "" for name, value in attrs}, ""))

    def handle_endtag(self, tag: str) -> None:
        self.inside = self.inside and tag != "script"

    def handle_data(self, data: str) -> None:
        if self.inside:
            attributes, text = self.found[-1]
            self.found[-1] = (attributes, text + data)
