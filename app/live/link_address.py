"""The text that names a link, taken apart: `kind:where?option=value&option=value`."""

from __future__ import annotations

from typing import NamedTuple

from worlds.input_error import InputError, unknown


class LinkAddress(NamedTuple):
    """Where a link leads and how."""

    text: str
    """All of it, for messages."""
    kind: str
    where: str
    """A port or an address, "" if there is none."""
    options: dict[str, str]

    def wants(self, what: str, example: str) -> str:
        """`where`. Raises InputError saying what is wanted there, with an example, if it is
        empty."""
        if not self.where:
            raise InputError(f"the link {self.text!r} does not say {what}: for example {example}")
        return self.where

    def whole(self, **ranges: tuple[int, int, int]) -> dict[str, int]:
        """The options, all whole numbers, each given as (default, least, most).

        Raises InputError for an option that is not known or a value that is not allowed.
        """
        values = {name: default for name, (default, _, _) in ranges.items()}
        for name, value in self.options.items():
            if name not in ranges:
                if not ranges:
                    raise InputError(
                        f"the link {self.text!r} has no options, but {name!r} is given"
                    )
                raise unknown("option", name, ranges, self.text)
            values[name] = self.number(name, value, ranges[name][1], ranges[name][2])
        return values

    def number(self, name: str, value: str, least: int, most: int) -> int:
        """A whole number within [least, most]; raises InputError if the value is not one."""
        if not (value.isascii() and value.isdigit() and len(value) < 20):
            raise InputError(f"{name} = {value!r} is no whole number (link {self.text!r})")
        if not least <= int(value) <= most:
            raise InputError(f"{name} = {value} is outside [{least}, {most}] (link {self.text!r})")
        return int(value)


def read_place(text: str) -> LinkAddress:
    """Take the text of a link apart. Raises InputError if an option is no `name=value`.

    >>> read_place("serial:/dev/ttyUSB0?baud=115200")[1:]
    ('serial', '/dev/ttyUSB0', {'baud': '115200'})
    """
    head, _, query = text.partition("?")
    kind, _, where = head.partition(":")
    options: dict[str, str] = {}
    for part in query.split("&") if query else ():
        name, equals, value = part.partition("=")
        if not name or not equals:
            raise InputError(f"{part!r} is no option=value (link {text!r})")
        if name in options:
            raise InputError(f"{name} is given twice (link {text!r})")
        options[name] = value
    return LinkAddress(text, kind, where, options)
