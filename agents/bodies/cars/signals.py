"""What cars tell each other: the rows of a car's signals, from the body's first one on."""

from __future__ import annotations

FRESH, STEERING, PACE, WHEEL, THROTTLE, STUCK, STOPS = range(7)
"""1.0 until it has moved once; angle of its wheels, rad; speed, m/s; the command that it has, rad
and share of full throttle; the time (s) that it has not got on, below 0 while it backs out for
having been stuck; ticks in which something has stopped it."""
QUEUE = 7
"""The commands sent, the latest first: wheel, throttle, wheel, ..."""
LONGEST = 24
"""Commands kept; the longest way of one is a tick less."""
ROWS = QUEUE + 2 * LONGEST
SIGNALS = (
    "fresh",
    "steering",
    "pace",
    "wheel",
    "throttle",
    "stuck",
    "stops",
    *(f"{what} sent {ago}" for ago in range(1, LONGEST + 1) for what in ("wheel", "throttle")),
)
"""Their names; the commands sent, 1 for the latest, each a tick after the next."""
WORDS = {
    "fresh": "has not moved yet?",
    "steering": "front wheels turned",
    "pace": "speed it tells",
    "wheel": "wheels commanded",
    "throttle": "throttle commanded",
    "stuck": "stuck for",
    "stops": "ticks stopped",
    **{name: name for name in SIGNALS[QUEUE:]},
}
"""What people call them."""
