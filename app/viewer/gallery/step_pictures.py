"""Pictures of a lesson's steps: one of the gallery by its name, or one that the lesson carries."""

from __future__ import annotations

import base64
import binascii
import io
from functools import cache, lru_cache

from app.package_files import STATIC
from worlds.input_error import InputError, shorten

PICTURES = STATIC / "gallery"
MOVES = "-moves"
"""Behind the name of a picture: a loop of what comes after it."""
LONGEST_PICTURE = 100_000
"""Characters of a picture that a lesson carries."""
MOST_PIXELS = 2000
"""Along a side of such a picture: a small file may hold a huge one."""
KINDS = {"webp": "WEBP", "png": "PNG", "jpeg": "JPEG"}
"""What such a picture may be, by its name in an address, as Pillow calls it."""
ALLOWED = (
    "a picture of the gallery, or data:image/webp, png or jpeg;base64, of at most "
    f"{LONGEST_PICTURE:,} characters and {MOST_PIXELS} x {MOST_PIXELS} pixels"
)


@cache
def gallery_pictures() -> tuple[str, ...]:
    """The names by which a step can show pictures of the gallery; loops are none."""
    names = (path.stem for path in sorted(PICTURES.glob("*.webp")))
    return tuple(name for name in names if not name.endswith(MOVES))


@lru_cache(maxsize=64)
def picture_address(picture: str) -> str:
    """What a page shows of a step's picture, as a `data:` address, which needs no other file."""
    if picture.startswith("data:"):
        return picture
    content = (PICTURES / f"{picture}.webp").read_bytes()
    return f"data:image/webp;base64,{base64.b64encode(content).decode()}"


def demand_picture(picture: str, place: str) -> None:
    """Raise InputError for what is neither a picture of the gallery nor a sound one in itself."""
    if not picture or picture in gallery_pictures():
        return
    fault = find_fault(picture)
    if fault:
        raise InputError(
            f"picture = {shorten(picture)} is not allowed: {fault}; {ALLOWED} ({place})"
        )


@lru_cache(maxsize=64)
def find_fault(picture: str) -> str:
    """What is wrong with a picture that a lesson carries, a clause; empty: nothing."""
    if not picture.startswith("data:"):
        return "the gallery has no such picture"
    if len(picture) > LONGEST_PICTURE:
        return f"it has {len(picture):,} characters"
    head, _, text = picture.partition(",")
    kind = head.removeprefix("data:image/").removesuffix(";base64")
    if kind not in KINDS or head != f"data:image/{kind};base64":
        return "it is of another kind"
    try:
        content = base64.b64decode(text, validate=True)
    except (binascii.Error, ValueError):
        return "it is no base 64"
    return find_fault_of_content(content, KINDS[kind])


def find_fault_of_content(content: bytes, kind: str) -> str:
    """What is wrong with a picture in this format of Pillow's, a clause; empty: nothing."""
    from PIL import Image  # of scenes few carry a picture, and Pillow takes its time to load

    try:
        # No other format is tried, whatever the content says.
        with Image.open(io.BytesIO(content), formats=[kind]) as image:
            width, height = image.size  # from the head alone: nothing is decoded yet
            if max(width, height) > MOST_PIXELS:
                return f"it has {width} x {height} pixels"
            if getattr(image, "n_frames", 1) > 1:
                return "it moves"
            image.load()
    except Image.DecompressionBombError:
        return "it has too many pixels"
    except Exception:  # Pillow raises what its decoders raise, which it does not list
        return f"it cannot be read as {kind}"
    return ""
