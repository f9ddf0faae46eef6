"""Numbers and times in words."""

from __future__ import annotations

import signal


def counted(number: int, one: str, more: str = "") -> str:
    """A number with its noun, which takes an s, or `more`, unless it is 1.

    >>> counted(1, "obstacle"), counted(2, "obstacle"), counted(0, "box", "boxes")
    ('1 obstacle', '2 obstacles', '0 boxes')
    """
    return f"{number} {one if number == 1 else more or one + 's'}"


def duration(seconds: float) -> str:
    """Seconds for people.

    >>> duration(4.2), duration(95), duration(7300)
    ('4 s', '1 min 35 s', '2 h 1 min')
    """
    whole = max(0, round(seconds))
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"


def signal_name(number: int) -> str:
    """The name of a signal; the number of one without a name, as those of real time are.

    >>> signal_name(9), signal_name(40)
    ('SIGKILL', '40')
    """
    known = {one.value: one.name for one in signal.Signals}
    return known.get(number, str(number))
