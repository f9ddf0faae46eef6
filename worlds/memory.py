"""Tell how much memory this machine has, so that what does not fit is refused at once."""

from __future__ import annotations

import functools
import os
from contextlib import suppress
from pathlib import Path

from worlds.input_error import InputError

LIMITS = (
    Path("/sys/fs/cgroup/memory.max"),
    Path("/sys/fs/cgroup/memory/memory.limit_in_bytes"),
)
"""Where a container says how much of the machine it has."""


@functools.cache
def memory_available() -> float:
    """Bytes of memory that this machine, or the container, has; infinity where it does not say."""
    limits = [float("inf")]
    with suppress(AttributeError, OSError, ValueError):
        limits.append(float(os.sysconf("SC_PHYS_PAGES")) * os.sysconf("SC_PAGE_SIZE"))
    for path in LIMITS:
        with suppress(OSError, ValueError):
            limits.append(float(path.read_text()))
    return min(limit for limit in limits if limit > 0.0)


def demand_memory(purpose: str, needed: float) -> None:
    """Refuse what needs more bytes than there are; `purpose` names it. Raises InputError."""
    available = memory_available()
    if needed > available:
        raise InputError(
            f"{purpose} is not allowed: about {format_bytes(needed)} of memory would be needed, "
            f"this machine has {format_bytes(available)}"
        )


def format_bytes(size: float) -> str:
    """Bytes for people.

    >>> format_bytes(25.3e9), format_bytes(2e11)
    ('25.3 GB', '200 GB')
    """
    return f"{size / 1e9:.3g} GB"
