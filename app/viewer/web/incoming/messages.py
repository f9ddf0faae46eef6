"""Which messages of one connection are let through, looked at before viser decodes them."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping

from app.viewer.web.incoming.kinds import (
    CAMERA,
    KINDS,
    KNOWN,
    LARGEST,
    RENDER,
    Kind,
    UnusableMessage,
    demand_shape,
    kind_of,
)
from app.viewer.web.incoming.rate_limit import RateLimit

ALL = (500.0, 1000.0)
"""Frames of any kind, a second and at once; more ends a connection."""
BYTES = (1024.0 * 1024, 2.0 * LARGEST)
"""Bytes, a second and at once; more ends a connection."""
DROPPED = (30.0, 300.0)
"""Messages that are dropped, a second and at once; more ends a connection."""
UNUSABLE = 5.0
"""As many dropped messages does one count that nobody can use."""
TOO_MUCH = "more messages than anybody can mean"


class Messages:
    """Judges the messages of one connection; used by viser's thread.

    `shared` is a limit that all connections of an address have in common; `log` gets a line for a
    message that nobody can use; `expected` knows the answers that were asked for; `kinds` are the
    kinds that may be passed on.
    """

    def __init__(
        self,
        shared: RateLimit,
        log: Callable[[str], None],
        clock: Callable[[], float] = time.monotonic,
        expected: Callable[[bytes], bool] = lambda _: False,
        kinds: Mapping[str, Kind] = KINDS,
    ):
        self.shared = shared
        self.expected = expected
        self.log = log
        self.frames = RateLimit(*ALL, clock)
        self.bytes = RateLimit(*BYTES, clock)
        self.dropped = RateLimit(*DROPPED, clock)
        self.kinds = {name: RateLimit(kind.rate, kind.most, clock) for name, kind in kinds.items()}
        self.introduced = False
        """Whether the browser has sent its camera."""
        self.verdict = ""
        """Why the connection is to be ended; empty: it is not."""

    def arrive(self, size: int) -> None:
        """Count a frame of so many bytes."""
        if not (self.frames.take() and self.bytes.take(size)):
            self.verdict = self.verdict or TOO_MUCH

    def pass_on(self, data: bytes | str) -> bool:
        """Whether viser may have a message."""
        if self.verdict:
            return False
        try:
            return self.judge(data)
        except UnusableMessage as why:
            self.log(str(why))
            self.drop(UNUSABLE)
            return False

    def judge(self, data: bytes | str) -> bool:
        """Whether a message is allowed now. Raises Unusable."""
        if isinstance(data, str):
            raise UnusableMessage("it is text")
        kind = kind_of(data)
        limit = self.kinds.get(kind)
        if limit is None:
            if kind not in KNOWN:
                raise UnusableMessage("it is of no kind that there is")
            return self.drop()
        if not (self.introduced or kind == CAMERA):
            return self.drop()
        if not (limit.take() and self.shared.take()):
            return self.drop()
        demand_shape(kind, data)
        if kind == RENDER:
            if not self.expected(data):
                return self.drop()
            self.bytes.give_back(len(data))  # we asked for them
        self.introduced = True
        return True

    def drop(self, cost: float = 1.0) -> bool:
        """Count a message that is not passed on; a connection that goes on so is to be ended."""
        if not self.dropped.take(cost):
            self.verdict = self.verdict or TOO_MUCH
        return False
