"""Where browsers find a server: on this machine, and in the network."""

from __future__ import annotations

import ipaddress
import socket

EVERYWHERE = ("0.0.0.0", "::")
"""Hosts that mean every address of this machine."""
LOOPBACK = ("127.0.0.1", "localhost", "::1")
"""Hosts that nobody else in the network reaches."""


def here(host: str, port: int) -> str:
    """Where a browser on this machine finds a server that listens on `host`."""
    return at("localhost" if host in (*EVERYWHERE, "127.0.0.1") else host, port)


def elsewhere(host: str, port: int) -> list[str]:
    """Where browsers on other machines find it; nowhere if it listens on the loopback.

    On every address of this machine: those of its network interfaces, then its name, which is only
    of use where the network knows it.
    """
    if host in LOOPBACK:
        return []
    if host not in EVERYWHERE:
        return [at(host, port)]
    return [at(one, port) for one in (*interface_addresses(6 if host == "::" else 4), hostname())]


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


def at(host: str, port: int) -> str:
    """The address of a page."""
    return f"http://{f'[{host}]' if ':' in host else host}:{port}"
