"""Which pages may talk to the laboratory: its own.

A browser sends the origin of the page that opens a connection, and the name by which it reached
the server. A foreign page shows a foreign origin; a page whose name was made to point here (DNS
rebinding) shows a foreign name.
"""

from __future__ import annotations

import ipaddress
import socket
from urllib.parse import SplitResult, urlsplit


def trusted(host: str | None, origin: str | None) -> bool:
    """Whether a request with these headers may be answered.

    No origin is a program, not a page: a program on this machine needs no browser to do harm.

    >>> trusted("localhost:8080", "http://127.0.0.1:8080")
    True
    >>> trusted("localhost:8080", "https://example.org")
    False
    """
    try:
        reached = urlsplit(f"//{host or ''}")
        if authority(host) is None or not is_ours(reached):
            return False
        if origin is None:
            return True
        page = urlsplit(origin)
        if page.scheme not in ("http", "https") or page.hostname is None:
            return False
        return port(page) == port(reached) and same_host(page, reached)
    except ValueError:
        return False


def authority(host: str | None) -> str | None:
    """A `Host` header as `name` or `name:port`; None if there is more or less in it.

    >>> authority("LOCALHOST:8080")
    'localhost:8080'
    >>> authority("localhost:8080/; script-src *")
    """
    try:
        reached = urlsplit(f"//{host or ''}")
        name, number = reached.hostname, reached.port
    except ValueError:
        return None
    if not name:
        return None
    whole = f"[{name}]" if ":" in name else name
    made = whole if number is None else f"{whole}:{number}"
    return made if made == (host or "").lower() else None


def is_ours(reached: SplitResult) -> bool:
    """Whether the server was reached by an address, or by a name that is this machine's."""
    name = reached.hostname or ""
    return is_address(name) or name in own_names()


def same_host(page: SplitResult, reached: SplitResult) -> bool:
    """Whether two names are the same host; all names of the loopback are."""
    return page.hostname == reached.hostname or (is_loopback(page) and is_loopback(reached))


def port(address: SplitResult) -> int:
    """The port, or the one that the scheme implies."""
    return address.port or (443 if address.scheme == "https" else 80)


def is_loopback(address: SplitResult) -> bool:
    """Whether the name is of the loopback."""
    name = address.hostname or ""
    return name == "localhost" or (is_address(name) and ipaddress.ip_address(name).is_loopback)


def is_address(name: str) -> bool:
    """Whether the name is a numeric address, which no foreign name server can answer for."""
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def own_names() -> set[str]:
    """Names of this machine."""
    name = socket.gethostname().lower()
    return {"localhost", name, f"{name}.local"}
