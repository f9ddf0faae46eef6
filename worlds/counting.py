"""A number and its noun in words."""

from __future__ import annotations


def counted(number: int, one: str, more: str = "") -> str:
    """A number with its noun, which takes an s, or `more`, unless it is 1.

    >>> counted(1, "obstacle"), counted(2, "obstacle"), counted(0, "box", "boxes")
    ('1 obstacle', '2 obstacles', '0 boxes')
    """
    return f"{number} {one if number == 1 else more or one + 's'}"
