"""Bad input is refused with one line: the thing, the value, what is allowed, where it came from."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Iterable, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pydantic import ValidationError

from pydantic import ValidationError


class Refusal(ValueError):
    """Something a user gave cannot be used; its text is the one line to show."""


class Refusals(Refusal):
    """Several things at once, one line each; the text is the first, and how many more there are."""

    def __init__(self, lines: Sequence[str]) -> None:
        super().__init__(f"{lines[0]} (and {len(lines) - 1} more)")
        self.lines = tuple(lines)


def refusal_of(lines: Sequence[str]) -> Refusal:
    """A refusal of one or more lines, repeated ones said once."""
    distinct = list(dict.fromkeys(lines))
    return Refusal(distinct[0]) if len(distinct) == 1 else Refusals(distinct)


def unknown(kind: str, name: object, known: Iterable[str], origin: str = "") -> Refusal:
    """A refusal of a name, with the nearest known one suggested.

    >>> str(unknown("model", "hwven", ["vem", "hwvem"]))
    "unknown model 'hwven': did you mean 'hwvem'? (known: vem, hwvem)"
    >>> str(unknown("source", "vicon", ["emulated cars"]))
    "unknown source 'vicon' (known: emulated cars)"
    """
    known = list(known)
    near = difflib.get_close_matches(str(name), known, n=1, cutoff=0.5)
    hint = f": did you mean {near[0]!r}?" if near else ""
    where = f" ({origin})" if origin else ""
    return Refusal(f"unknown {kind} {name!r}{hint} (known: {', '.join(known)}){where}")


def first_refusal(
    error: ValidationError, thing: str, origin: str = "", tags: Collection[str] = ()
) -> Refusal:
    """The first thing that pydantic found wrong, as a refusal: the thing, the key, the value.

    `tags` are discriminators, which pydantic puts before the keys of a tagged union.
    """
    first = error.errors()[0]
    keys = [str(key) for key in first["loc"] if key not in tags and "[" not in str(key)]
    where = f" ({origin})" if origin else ""
    message = first["msg"].removeprefix("Value error, ")
    message = message[:1].lower() + message[1:]
    key = ".".join(keys)
    if first["type"] == "missing":
        return Refusal(f"{thing} has no {key}{where}")
    if first["type"] == "extra_forbidden":
        return Refusal(f"{thing} has an unknown key {key!r}{where}")
    if first["type"] == "value_error" and not keys:
        return Refusal(f"{thing}: {message}{where}")
    return Refusal(f"{thing}: {key} = {first['input']!r} is not allowed: {message}{where}")
