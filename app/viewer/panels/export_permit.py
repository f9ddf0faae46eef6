"""Which files may be made for browsers, and when: many pages may ask one machine for them."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext

from app.viewer.run.allowance import Allowance
from app.viewer.web.incoming.rate_limit import RateLimit
from worlds.input_error import InputError

AT_ONCE = 2.0
"""Files of one page at once; then they come at the rate that is allowed."""
in_turn = threading.Lock()
"""Held while a file is made, by all pages of this process that have an allowance."""


class ExportPermit:
    """What one page may have made; everything, without an allowance."""

    def __init__(self, allowance: Allowance | None = None):
        self.allowance = allowance
        self.limit = None if allowance is None else RateLimit(allowance.files, AT_ONCE)

    def demand_file(self) -> None:
        """Raise InputError if too many pictures and files have been asked for of late."""
        if self.allowance is not None and self.limit is not None and not self.limit.take():
            raise InputError(
                f"a class makes a picture or a file of a plot every {1 / self.allowance.files:g} s "
                "for each student: try again soon"
            )

    def demand_film(self) -> None:
        """Raise InputError where there are no films."""
        if self.allowance is not None and not self.allowance.films:
            raise InputError("a class makes no films: `flockscope lab` on your own machine does")

    @contextmanager
    def turn(self) -> Iterator[None]:
        """Within it a file is made: with an allowance one after the other, of all pages."""
        with nullcontext() if self.allowance is None else in_turn:
            yield
