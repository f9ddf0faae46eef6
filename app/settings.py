"""Settings given as text: `NAME=VALUE`, lists with commas."""

from __future__ import annotations

from typing import Any

from worlds.input_error import InputError, shorten

SWITCHES = {"true": True, "false": False, "on": True, "off": False}


def assignment(setting: str) -> tuple[str, Any]:
    """Name and value of `NAME=VALUE`. Raises InputError for anything else.

    >>> assignment("p1=0.1"), assignment("layers=instant"), assignment("eta = 1")
    (('p1', 0.1), ('layers', 'instant'), ('eta', 1))
    """
    name, equals, text = (part.strip() for part in setting.partition("="))
    if not equals or not name or not text:
        raise InputError(f"--set {setting} is not of the form NAME=VALUE")
    return name, value(text)


def value(text: str) -> Any:
    """A whole number, a number, a switch, or the text itself."""
    if text.lower() in SWITCHES:
        return SWITCHES[text.lower()]
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text


def names(text: str) -> list[str]:
    """The names of a list with commas.

    >>> names("vem, hwvem,")
    ['vem', 'hwvem']
    """
    return [part.strip() for part in text.split(",") if part.strip()]


def numbers(option: str, text: str) -> list[float]:
    """The numbers of a list with commas. Raises InputError naming the option."""
    try:
        values = [float(part) for part in names(text)]
    except ValueError:
        values = []
    if not values:
        raise InputError(f"{option} {text!r} is not a number, or numbers with commas")
    return values


def whole_numbers(option: str, text: str) -> list[int]:
    """The whole numbers of a list with commas. Raises InputError naming the option."""
    try:
        return [int(part) for part in names(text)]
    except ValueError:
        raise InputError(f"{option} {text!r} is not a whole number, or some with commas") from None


MOST = 10**15
"""The largest count, unless there is a reason for a smaller one."""


def check_whole_number(option: str, value: int | None, least: int, most: int = MOST) -> None:
    """Refuse a whole number outside [least, most]. Raises InputError naming the option."""
    if value is None:
        return
    if value < least:
        text = shorten(value)
        raise InputError(f"{option} {text} is not allowed: a whole number >= {least} is needed")
    if value > most:
        raise InputError(f"{option} {shorten(value)} is not allowed: the largest is {most}")
