"""From where connections come: how many there are of each address, and how soon more may come."""

from __future__ import annotations

import ipaddress
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

# So many at once, and so many a second.


class RateLimit:
    """Lets `most` pass at once and `rate` a second from then on; used by one thread.

    >>> limit = RateLimit(rate=1.0, most=2.0, clock=lambda: 5.0)
    >>> [limit.take() for _ in range(3)]
    [True, True, False]
    """

    def __init__(self, rate: float, most: float, clock: Callable[[], float] = time.monotonic):
        self.rate = rate
        self.most = most
        self.clock = clock
        self.left = most
        self.known = clock()

    def fill(self) -> float:
        """How much is left now; below 0 is owed."""
        now = self.clock()
        self.left = min(self.most, self.left + (now - self.known) * self.rate)
        self.known = now
        return self.left

    def take(self, cost: float = 1.0) -> bool:
        """Take so much if it is there; whether it was."""
        if self.fill() < cost:
            return False
        self.left -= cost
        return True

    def turn(self, longest: float, cost: float = 1.0) -> float | None:
        """Seconds until so much will be there, which is taken now; None if longer than `longest`.

        >>> limit = RateLimit(rate=2.0, most=1.0, clock=lambda: 5.0)
        >>> [limit.turn(longest=0.6) for _ in range(3)]
        [0.0, 0.5, None]
        """
        wait = max(0.0, (cost - self.fill()) / self.rate)
        if wait > longest:
            return None
        self.left -= cost
        return wait

    def give_back(self, cost: float) -> None:
        """Have so much back that was taken."""
        self.left = min(self.most, self.fill() + cost)

    def owe(self, cost: float, deepest: float) -> None:
        """Take so much whether it is there or not, but never owe more than `deepest`."""
        self.left = max(self.fill() - cost, -deepest)


TIMEOUT = 5.0
"""Seconds that a connection may have to wait for its turn."""
DEEPEST = 40.0
"""What an address owes at most, in pages."""
REMEMBERED = 4096
"""Addresses that are remembered."""


Rate = tuple[float, float]
"""A second, and at once."""


@dataclass(frozen=True)
class ConnectionLimits:
    """How many connections there may be, of all and of one address, and how soon more."""

    silent: int = 256
    """Lines on which nothing is asked; one more ends the one that has been silent longest."""
    open: int = 256
    """Requests that are being answered, of all: a page that is connected is one."""
    open_of_one: int = 128
    """The same of one address: a class behind one router has one."""
    requests: Rate = (50.0, 150.0)
    """Requests of one address: a page loads about ten files."""
    pages: Rate = (5.0, 40.0)
    """Pages of one address that connect."""
    messages: Rate = (1000.0, 2000.0)
    """Messages of one address, over all its connections."""
    price: float = 10.0
    """What a connection that was cut off costs its address, in pages."""


USUAL = ConnectionLimits()
BEHIND_A_FRONT = ConnectionLimits(
    open_of_one=USUAL.open,
    requests=(500.0, 1500.0),
    pages=(50.0, 200.0),
    messages=(20_000.0, 40_000.0),
    price=0.0,
)
"""Where all come through a front of our own, from one address: that bounds each of them itself."""


def address_of(peer: Any) -> str:
    """Where a connection comes from; of IPv6 the network of 64 bits, which one person has.

    >>> address_of(("::ffff:10.0.0.7", 80, 0, 0)), address_of(("2001:db8::1:2", 80, 0, 0))
    ('10.0.0.7', '2001:db8::/64')
    """
    try:
        found = ipaddress.ip_address(str(peer[0]).partition("%")[0])
    except (ValueError, TypeError, IndexError):
        return "elsewhere"
    if isinstance(found, ipaddress.IPv4Address):
        return str(found)
    if found.ipv4_mapped is not None:
        return str(found.ipv4_mapped)
    if found.is_loopback:
        return str(found)
    return str(ipaddress.ip_network((found, 64), strict=False))


class ClientAddress:
    """One address."""

    def __init__(self, clock: Callable[[], float], limits: ConnectionLimits = USUAL):
        self.open = 0
        self.requests = RateLimit(*limits.requests, clock)
        self.pages = RateLimit(*limits.pages, clock)
        self.messages = RateLimit(*limits.messages, clock)

    @property
    def forgettable(self) -> bool:
        """Whether it is as good as new."""
        return not self.open and all(
            limit.fill() >= limit.most for limit in (self.requests, self.pages, self.messages)
        )


class ClientAddresses:
    """All addresses; any thread may use it."""

    def __init__(
        self, clock: Callable[[], float] = time.monotonic, limits: ConnectionLimits = USUAL
    ):
        self.clock = clock
        self.limits = limits
        self.lock = threading.Lock()
        self.known: dict[str, ClientAddress] = {}
        self.open = 0

    def of(self, address: str) -> ClientAddress:
        """An address; those that have long been quiet are forgotten."""
        if address not in self.known and len(self.known) >= REMEMBERED:
            self.known = {one: kept for one, kept in self.known.items() if not kept.forgettable}
        return self.known.setdefault(address, ClientAddress(self.clock, self.limits))

    def enter(self, address: str) -> float | None:
        """Count a new request; seconds until its turn, or None if it cannot be taken."""
        with self.lock:
            visitor = self.of(address)
            if self.open >= self.limits.open or visitor.open >= self.limits.open_of_one:
                return None
            wait = visitor.requests.turn(TIMEOUT)
            if wait is not None:
                visitor.open += 1
                self.open += 1
            return wait

    def leave(self, address: str) -> None:
        """A request has been answered, or its connection is gone."""
        with self.lock:
            self.of(address).open -= 1
            self.open -= 1

    def page(self, address: str) -> float | None:
        """A page connects: seconds until its turn, or None if that would be too long."""
        with self.lock:
            return self.of(address).pages.turn(TIMEOUT)

    def cut(self, address: str) -> None:
        """A connection was cut off: its address has to wait for the next."""
        with self.lock:
            self.of(address).pages.owe(self.limits.price, DEEPEST)

    def messages(self, address: str) -> RateLimit:
        """The limit that all connections of an address have in common; for one thread."""
        with self.lock:
            return self.of(address).messages
