"""What one student's pages may send, however many they are."""

from __future__ import annotations

from app.front.client_addresses import RateLimit
from app.front.kinds import LARGEST

REQUESTS = (10.0, 60.0)
"""Requests by HTTP, a second and at once: a page loads ten files, its gallery twenty pictures."""
PAGES = (1.0, 8.0)
"""Pages that connect, a second and at once."""
MOST_PAGES = 4
"""Pages of one student at a time."""
MOST_STREAMS = 8
"""Lines of one student over which the class tells what has changed: pages that are loaded again
leave theirs behind for a while."""
MOST_AT_ONCE = 32
"""Requests of one student that are being answered: whoever reads no answer has it wait here."""
FRAMES = (200.0, 400.0)
"""Messages, a second and at once: a page that drags sends some 60."""
BYTES = (256.0 * 1024, 1.5 * LARGEST)
"""Bytes of messages, a second and at once: a file that is opened comes at once."""
WORDS = (1.0, 5.0)
"""Things that a student hands in, a second and at once."""
STRANGERS = (5.0, 60.0)
"""Wrong codes that are tried from one address, a second and at once. The right one is always taken:
a class comes through one router or one proxy, and nobody there may lock out the others."""
JOINS = (5.0, 250.0)
"""Students who come in, a second and at once: a whole class does within a minute."""


class StudentLimits:
    """Of one student, or of the teacher."""

    def __init__(self) -> None:
        self.requests = RateLimit(*REQUESTS)
        self.pages = RateLimit(*PAGES)
        self.frames = RateLimit(*FRAMES)
        self.bytes = RateLimit(*BYTES)
        self.words = RateLimit(*WORDS)
        self.streams = self.going = 0
        """Lines that tell of the class, and requests that are being answered."""
