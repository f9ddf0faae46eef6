"""Bad input is refused with one line: the thing, the value, what is allowed, where it came from."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class Refusal(ValueError):
    """Something a user gave cannot be used; its text is the one line to show."""


def unknown(kind: str, name: object, known: Iterable[str], origin: str = "") -> Refusal:
    """A refusal of a name, with the nearest known one suggested.

    >>> str(unknown("model", "hwven", ["vem", "hwvem"]))
    "unknown model 'hwven': did you mean 'hwvem'? (known: vem, hwvem)"
    """
    known = list(known)
    near = difflib.get_close_matches(str(name), known, n=1, cutoff=0.5)
    hint = f"did you mean {near[0]!r}? " if near else ""
    where = f" ({origin})" if origin else ""
    return Refusal(f"unknown {kind} {name!r}: {hint}(known: {', '.join(known)}){where}")
