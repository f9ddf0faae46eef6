"""Write numbers and times as text."""

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
    total = max(0, round(seconds))
    if total < 60:
        return f"{total} s"
    if total < 3600:
        return f"{total // 60} min {total % 60} s"
    return f"{total // 3600} h {total % 3600 // 60} min"


def signal_name(number: int) -> str:
    """The name of a signal; the number of one without a name, as those of real time are.

    >>> signal_name(9), signal_name(40)
    ('SIGKILL', '40')
    """
    names = {member.value: member.name for member in signal.Signals}
    return names.get(number, str(number))
