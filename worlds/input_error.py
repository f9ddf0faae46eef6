"""An input error is one line: the thing, the value, what is allowed, where it came from."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pydantic import ValidationError


CONTROLS = (
    "\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f"
    "\u061c\u200e\u200f\u2028\u2029\u202a-\u202e\u2066-\u2069\ud800-\udfff"
)
"""What a terminal obeys, what begins a line, turns the order of others, or is half a character;
for a set of a regular expression. Newlines, tabs and returns are apart."""
BREAKS = re.compile(f"[{CONTROLS}\n\t\r]")


class InputError(ValueError):
    """Something a user gave cannot be used; its text is the one line to show."""


class InputErrors(InputError):
    """Several things at once, one line each; the text is the first, and how many more there are."""

    def __init__(self, lines: Sequence[str]) -> None:
        super().__init__(f"{lines[0]} (and {len(lines) - 1} more)")
        self.lines = tuple(lines)


def error_of_lines(lines: Sequence[str]) -> InputError:
    """A refusal of one or more lines, repeated ones once."""
    distinct = list(dict.fromkeys(lines))
    return InputError(distinct[0]) if len(distinct) == 1 else InputErrors(distinct)


def demand_line(text: str) -> str:
    """A text that is one line, such as a title. Raises ValueError for any other.

    >>> demand_line("a title")
    'a title'
    """
    if BREAKS.search(text):
        raise ValueError(f"{shorten(text)} is not allowed: one line of plain text is needed")
    return text


def unknown(
    kind: str, name: object, known: Iterable[str], origin: str = "", others: Iterable[str] = ()
) -> InputError:
    """A refusal of a name, with the nearest known one suggested.

    `others`: names of another kind that may stand in the same place; they are suggested too.

    >>> str(unknown("model", "hwven", ["vem", "hwvem"]))
    "unknown model 'hwven': did you mean 'hwvem'? (known: vem, hwvem)"
    >>> str(unknown("source", "vicon", ["emulated cars"]))
    "unknown source 'vicon' (known: emulated cars)"
    >>> str(unknown("kind", "robot", []))
    "unknown kind 'robot': there are none"
    """
    known = list(known)
    location = f" ({origin})" if origin else ""
    hint = suggestion(name, [*known, *others])
    names = f" (known: {', '.join(known)})" if known else "" if hint else ": there are none"
    return InputError(f"unknown {kind} {shorten(name)}{hint}{names}{location}")


def suggestion(name: object, known: Iterable[str]) -> str:
    """The nearest of the known names as a question, with the colon before it; "" if none is near.

    >>> suggestion("hwven", ["vem", "hwvem"]), suggestion("x", ["vem"])
    (": did you mean 'hwvem'?", '')
    >>> suggestion("agent", ["eta", "v0"]), suggestion("--ticks", ["--noise"])
    ('', '')
    """
    text = name if isinstance(name, str) else shorten(name)
    near = nearest(text, known)
    return f": did you mean {near!r}?" if near else ""


def nearest(text: str, known: Iterable[str]) -> str:
    """The known name that a text was most likely meant to be; "" if none is close.

    Close is what one slip makes of a name of up to four letters, and one more for each four more;
    or its beginning, of three letters or more, or it with one or two letters more. Dashes and
    capitals do not count.

    >>> nearest("rnu", ["lab", "run"]), nearest("emulatd", ["vicon", "emulated cars"])
    ('run', 'emulated cars')
    """
    letters = plain_letters(text[:LONGEST_NAME])
    candidates = [(count_slips(letters, plain_letters(name)), name) for name in known]
    near_names = [(count, near_name) for count, near_name in candidates if count is not None]
    return min(near_names, key=lambda pair: pair[0])[1] if near_names else ""


LONGEST_NAME = 60
"""Letters of a name that are compared."""


def plain_letters(text: str) -> str:
    """A name without what people mix up: capitals, and dashes, underlines and blanks."""
    return "".join(letter for letter in text.casefold() if letter not in "-_ ")


def count_slips(text: str, known: str) -> float | None:
    """How many slips make a text of a known name; None if it is not close to it."""
    if not text or not known:
        return None
    limit = 1 + (min(len(text), len(known)) - 1) // 4
    shorter = min(len(text), len(known))
    count = distance(text, known, limit)
    if count is not None and count < shorter + (text == known):
        return count
    if len(known) >= 3 and text.startswith(known) and len(text) <= len(known) + 2:
        return limit + 0.5
    beginning = distance(text, known[: len(text)], limit // 2)
    longer = beginning is not None and len(text) >= 3 and len(known) > len(text)
    return limit + (beginning or 0) + 0.01 * len(known) if longer else None


def distance(text: str, other: str, limit: int) -> int | None:
    """Letters put in, left out, changed, or swapped with the next; None if more than `limit`.

    >>> distance("rnu", "run", 2), distance("agent", "eta", 2)
    (1, None)
    """
    if abs(len(text) - len(other)) > limit:
        return None
    row_before_last: list[int] = []
    row = list(range(len(other) + 1))
    for i, letter in enumerate(text, 1):
        last, row_before_last, row = row_before_last, row, [i] + [0] * len(other)
        for j, other_letter in enumerate(other, 1):
            row[j] = min(
                row_before_last[j] + 1,
                row[j - 1] + 1,
                row_before_last[j - 1] + (letter != other_letter),
            )
            is_swap = i > 1 and j > 1 and letter == other[j - 2] and text[i - 2] == other_letter
            if is_swap:
                row[j] = min(row[j], last[j - 2] + 1)
    return row[-1] if row[-1] <= limit else None


NEEDED = {
    "bool_parsing": "true or false is needed",
    "bool_type": "true or false is needed",
    "dict_type": "a table is needed",
    "extra_forbidden": "there is no such key",
    "finite_number": "a finite number is needed",
    "float_parsing": "a number is needed",
    "float_type": "a number is needed",
    "frozen_instance": "it cannot be changed",
    "greater_than": "a number > {gt} is needed",
    "greater_than_equal": "a number >= {ge} is needed",
    "int_from_float": "a whole number is needed",
    "int_parsing": "a whole number is needed",
    "int_parsing_size": "it has too many digits",
    "int_type": "a whole number is needed",
    "is_instance_of": "a {class} is needed",
    "less_than": "a number < {lt} is needed",
    "less_than_equal": "a number <= {le} is needed",
    "list_type": "a list is needed",
    "literal_error": "{expected} is needed",
    "missing": "it is missing",
    "model_attributes_type": "a table is needed",
    "model_type": "a table is needed",
    "path_type": "the name of a file is needed",
    "string_pattern_mismatch": "it must match {pattern}",
    "string_too_long": "at most {max_length} characters are allowed",
    "string_too_short": "at least {min_length} characters are needed",
    "string_type": "a text is needed",
    "string_unicode": "a text is needed",
    "too_long": "at most {max_length} are allowed, not {actual_length}",
    "too_short": "at least {min_length} are needed, not {actual_length}",
    "tuple_type": "a list is needed",
    "union_tag_invalid": "{expected_tags} is needed",
    "union_tag_not_found": "{discriminator} is missing",
}
"""What is allowed where pydantic found a fault of a kind, in our words."""


def needed(fault: Mapping[str, Any]) -> str:
    """What is allowed instead of what pydantic found, from one of its faults.

    >>> needed({"type": "int_parsing", "msg": "Input should be a valid integer, unable to ..."})
    'a whole number is needed'
    >>> needed({"type": "less_than_equal", "msg": "...", "ctx": {"le": 3}})
    'a number <= 3 is needed'
    """
    context = {
        name: f"{value:g}" if isinstance(value, float) else value
        for name, value in (fault.get("ctx") or {}).items()
    }
    try:
        return NEEDED[fault["type"]].format_map(context)
    except KeyError:
        message = fault["msg"].removeprefix("Value error, ").removeprefix("Input ")
        return f"it {message}" if message.startswith("should") else lower_first(message)


def lower_first(message: str) -> str:
    """A message as the second half of a sentence."""
    return message[:1].lower() + message[1:]


def shorten(value: Any, most: int = 60) -> str:
    """A value as it is written, the middle left out of what is long.

    >>> shorten(3.5), shorten("x" * 100)
    ('3.5', "'xxxxxxxxxxxxxxxxxxxxxxxxxxx...xxxxxxxxxxxxxxxxxxxxxxxxxxx'")
    """
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # Python writes no number of more than 4300 digits
        return "a value too long to write"
    half = (most - 4) // 2
    return text if len(text) <= most else f"{text[:half]}...{text[-half:]}"


def first_input_error(
    error: ValidationError, thing: str, origin: str = "", tags: Collection[str] = ()
) -> InputError:
    """The first thing that pydantic found wrong, as a refusal: the thing, the key, the value.

    `tags` are discriminators, which pydantic puts before the keys of a tagged union.
    """
    first = error.errors()[0]
    keys = [str(key) for key in first["loc"] if key not in tags and "[" not in str(key)]
    location = f" ({origin})" if origin else ""
    key = ".".join(keys)
    if first["type"] == "missing":
        return InputError(f"{thing} has no {key}{location}")
    if first["type"] == "extra_forbidden":
        return InputError(f"{thing} has an unknown key {key!r}{location}")
    if first["type"] == "value_error" and not keys:
        return InputError(f"{thing}: {needed(first)}{location}")
    return InputError(
        f"{thing}: {key} = {shorten(first['input'])} is not allowed: {needed(first)}{location}"
    )
