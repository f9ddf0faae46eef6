"""Which pages may talk to the laboratory: its own.

A browser sends the origin of the page that opens a connection, and the name by which it reached
the server. A foreign page shows a foreign origin; a page whose name was made to point here (DNS
rebinding) shows a foreign name. Names that somebody else gives this machine, or a proxy before it,
are allowed one by one.
"""

from __future__ import annotations

import ipaddress
import re
import socket
from dataclasses import dataclass
from urllib.parse import SplitResult, urlsplit

from worlds.input_error import InputError

# Where browsers find a server: on this machine, and in the network.

EVERYWHERE = ("0.0.0.0", "::")
"""Hosts that mean every address of this machine."""
LOOPBACK = ("127.0.0.1", "localhost", "::1")
"""Hosts that nobody else in the network reaches."""


def local_address(host: str, port: int) -> str:
    """Where a browser on this machine finds a server that listens on `host`."""
    return page_address("localhost" if host in (*EVERYWHERE, "127.0.0.1") else host, port)


def network_addresses(host: str, port: int) -> list[str]:
    """Where browsers on other machines find it; nowhere if it listens on the loopback.

    On every address of this machine: those of its network interfaces, then its name, which is only
    of use where the network knows it.
    """
    if host in LOOPBACK:
        return []
    if host not in EVERYWHERE:
        return [page_address(host, port)]
    return [
        page_address(one, port)
        for one in (*interface_addresses(6 if host == "::" else 4), hostname())
    ]


def interface_addresses(version: int) -> list[str]:
    """Addresses of this machine's network interfaces, of IPv4 or IPv6, that others may reach."""
    import ifaddr

    found = []
    for adapter in ifaddr.get_adapters():
        for one in adapter.ips:
            address = ipaddress.ip_address(one.ip if isinstance(one.ip, str) else one.ip[0])
            if address.version != version or address.is_loopback or address.is_link_local:
                continue
            if str(address) not in found:
                found.append(str(address))
    return found


def hostname() -> str:
    """The name of this machine."""
    return socket.gethostname().lower()


def page_address(host: str, port: int) -> str:
    """The address of a page."""
    return f"http://{f'[{host}]' if ':' in host else host}:{port}"


LABEL = "[a-z0-9]([a-z0-9-]{0,61}[a-z0-9])?"
NAME = re.compile(rf"(?=.{{1,253}}$){LABEL}(\.{LABEL})*")
"""A host name, in small letters."""
PORTS = {"http": 80, "https": 443}


@dataclass(frozen=True)
class AllowedHost:
    """A name under which somebody reaches the laboratory, and its port if it is not the usual."""

    name: str
    port: int | None = None

    def __str__(self) -> str:
        whole = f"[{self.name}]" if ":" in self.name else self.name
        return whole if self.port is None else f"{whole}:{self.port}"

    def shows(self, page: SplitResult) -> bool:
        """Whether a page is of this name and port."""
        usual = PORTS[page.scheme]
        return page.hostname == self.name and (page.port or usual) == (self.port or usual)


def parse_allowed_host(text: str) -> AllowedHost:
    """A name as `--allow-host` gives it. Raises InputError for anything else than a name and a
    port.

    >>> parse_allowed_host("hub.example.org:8443")
    AllowedHost(name='hub.example.org', port=8443)
    """
    wrong = InputError(
        f"--allow-host {text!r} is not a host name with an optional port, "
        "such as hub.example.org or hub.example.org:8443"
    )
    try:
        parts = urlsplit(f"//{text}")
        given = AllowedHost(parts.hostname or "", parts.port)
        numeric = is_address(given.name)
        name = given.name if numeric else given.name.encode("idna").decode()
    except ValueError:
        raise wrong from None
    if given.port == 0 or str(given) != text.lower() or not (numeric or NAME.fullmatch(name)):
        raise wrong
    return AllowedHost(name, given.port)


def is_trusted(
    host: str | None, origin: str | None, allow: tuple[AllowedHost, ...] = (), invited: bool = False
) -> bool:
    """Whether a request with these headers may be answered.

    No origin is a program, not a page: a program on this machine needs no browser to do harm. A
    request that was `invited`, since it knows a secret, may come by any name, if the page that
    makes it has that name too; a port that is not said is then the usual one of the page, as there
    may be a proxy with TLS before us.

    >>> is_trusted("localhost:8080", "http://127.0.0.1:8080")
    True
    >>> is_trusted("localhost:8080", "https://example.org")
    False
    >>> is_trusted("example.org", "https://example.org", invited=True)
    True
    """
    try:
        reached = urlsplit(f"//{host or ''}")
        named = invited or is_ours(reached) or is_named(reached, allow)
        if authority(host) is None or not named:
            return False
        if origin is None:
            return True
        page = urlsplit(origin)
        if page.scheme not in PORTS or page.hostname is None:
            return False
        if any(one.shows(page) for one in allow):
            return True
        usual = PORTS[page.scheme if invited else "http"]
        return port_of(page) == (reached.port or usual) and same_host(page, reached)
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
        found = AllowedHost(reached.hostname or "", reached.port)
    except ValueError:
        return None
    return str(found) if found.name and str(found) == (host or "").lower() else None


def is_ours(reached: SplitResult) -> bool:
    """Whether the server was reached by an address, or by a name that is this machine's."""
    name = reached.hostname or ""
    return is_address(name) or name in own_names()


def is_named(reached: SplitResult, allow: tuple[AllowedHost, ...]) -> bool:
    """Whether the server was reached by an allowed name, at whatever port of it."""
    return any(reached.hostname == one.name for one in allow)


def same_host(page: SplitResult, reached: SplitResult) -> bool:
    """Whether two names are the same host; all names of the loopback are."""
    return page.hostname == reached.hostname or (is_loopback(page) and is_loopback(reached))


def port_of(page: SplitResult) -> int:
    """The port, or the one that the scheme implies."""
    return page.port or PORTS[page.scheme]


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
