"""The text that names a source: `kind:place?option=value&option=value`."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

from app.live.sources.axes import Axes
from worlds.input_error import InputError, unknown

AXES = ("up", "unit", "nose", "top")
"""The options that declare the axes of a tracking system."""


@dataclass(frozen=True, slots=True)
class Address:
    """A source as asked for."""

    kind: str
    place: str
    """A host or a path; empty where the kind needs none."""
    options: tuple[tuple[str, str], ...]
    text: str
    """As it was written, for what is said of it."""

    def known(self, names: Iterable[str], several: Iterable[str] = ()) -> None:
        """Refuse an option that is none of `names` or `several`, or one given twice."""
        names, several = list(names), list(several)
        given_names: set[str] = set()
        for name, _ in self.options:
            if name not in (*names, *several):
                raise unknown("option", name, [*names, *several], self.text)
            if name in given_names and name not in several:
                raise InputError(f"{name} is given twice ({self.text})")
            given_names.add(name)

    def word(self, name: str, default: str) -> str:
        """The value of an option."""
        return dict(self.options).get(name, default)

    def words(self, name: str) -> list[str]:
        """The values of an option that may be given several times."""
        return [value for option, value in self.options if option == name]

    def number(self, name: str, default: float, low: float, high: float) -> float:
        """The value of an option that is a number in [low, high]."""
        word = self.word(name, repr(default))
        try:
            number = float(word)
        except ValueError:
            number = math.nan
        if not low <= number <= high:
            raise InputError(f"{name} = {word} is outside [{low:g}, {high:g}] ({self.text})")
        return number

    def truth(self, name: str, default: bool) -> bool:
        """The value of an option that is yes or no."""
        word = self.word(name, "yes" if default else "no")
        if word not in ("yes", "no"):
            raise InputError(f"{name} = {word} is neither yes nor no ({self.text})")
        return word == "yes"

    def axes(self, up: str = "z", unit: str = "m") -> Axes:
        """The axes as declared, or those that this kind of source usually has."""
        try:
            return Axes(
                self.word("up", up),
                self.word("unit", unit),
                self.word("nose", "x"),
                self.word("top", ""),
            )
        except InputError as refused:
            raise InputError(f"{refused} ({self.text})") from None


def parse_address(text: str) -> Address:
    """The parts of a source's text.

    Raises InputError if it is not of the form `kind:place?option=value`.

    >>> parse_address("optitrack:192.168.1.5?up=y").options
    (('up', 'y'),)
    """
    head, question, tail = text.partition("?")
    kind, colon, place = head.partition(":")
    if not (kind and colon) or (question and not tail):
        raise InputError(f"source {text!r} is not of the form kind:place?option=value&option=value")
    pairs = []
    for part in tail.split("&") if tail else ():
        name, equals, value = part.partition("=")
        if not (name and equals):
            raise InputError(f"{part!r} is not of the form option=value ({text})")
        pairs.append((name, value))
    return Address(kind, place, tuple(pairs), text)
