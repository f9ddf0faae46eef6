"""Where a notebook is seen: whose pages may show a laboratory in a frame, and how they reach it.

A browser on this machine reaches a port of this process. One that is elsewhere, as behind a hub,
reaches nothing but the notebook's server, which passes on what is asked for below `proxy/PORT/` if
it has jupyter-server-proxy.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from app.front.origin import EVERYWHERE, LOOPBACK, PORTS, AllowedHost, allowed, here
from worlds.input_error import InputError, unknown

AUTO, PORT, PROXY = "auto", "port", "proxy"
WAYS = (AUTO, PORT, PROXY)
"""How a page may reach the laboratory: as it has to, by its port, or through its own server."""
HUB = "JUPYTERHUB_SERVICE_PREFIX"
"""The environment's word for where a hub has a user's server, such as /user/ada/."""
STARTED_BY = "JPY_PARENT_PID"
"""The environment's word for the process that has started this kernel."""
OWN = "'self'"
"""How a policy writes the origin of the page itself: through the proxy it is the notebook's."""


@dataclass(frozen=True)
class NotebookAccess:
    """How the pages of a notebook come to what this process serves."""

    framed_by: tuple[str, ...] = ()
    """Origins of pages that may show it in a frame, as a policy writes them."""
    allow: tuple[AllowedHost, ...] = ()
    """Names that a proxy may have."""
    proxy: str | None = None
    """Below which path of its own the notebook's server passes on; None: it is asked directly."""

    def address(self, port: int, secret: str) -> str:
        """Where a page finds a port and a secret: in whole, or as a path of its own server."""
        base = here(LOOPBACK[0], port) if self.proxy is None else f"{self.proxy}{port}"
        return f"{base}/{secret}/"


@dataclass(frozen=True)
class Server:
    """A Jupyter server of this user that runs on this machine."""

    pid: int
    port: int
    host: str
    base: str
    """The path of its pages, with a slash at both ends."""
    secure: bool

    @property
    def is_local(self) -> bool:
        """Whether only browsers of this machine reach it."""
        return self.host in LOOPBACK

    @property
    def origins(self) -> tuple[str, ...]:
        """The origins of its pages; no policy can write a numeric address of IPv6."""
        named = ("localhost", "127.0.0.1", *(() if self.host in EVERYWHERE else (self.host,)))
        scheme = "https" if self.secure else "http"
        return tuple(f"{scheme}://{name}:{self.port}"
                     for name in dict.fromkeys(named) if ":" not in name)  # fmt: skip


def find_place(through: str = AUTO, origin: str | None = None) -> NotebookAccess:
    """Where this process's notebook is seen.

    `through`: `port`, `proxy`, or `auto`, the proxy on a hub and where the server can be reached
    from elsewhere. `origin`: of the page, such as https://hub.example.org, where it cannot be
    found out. Raises InputError.
    """
    if through not in WAYS:
        raise unknown("through", through, WAYS)
    given, allow = ((), ()) if origin is None else sound_origin(origin)
    servers = list(running_servers())
    own = next((one for one in servers if one.pid == started_by()), None)
    base = os.environ.get(HUB) or (own.base if own else "")
    if through == AUTO:
        elsewhere = HUB in os.environ or (own is not None and not own.is_local)
        through = PROXY if elsewhere else PORT
    if through == PROXY:
        if not base:
            raise InputError("through = 'proxy' is not allowed: no Jupyter server has started this")
        return NotebookAccess((OWN, *given), allow, f"{base}proxy/")
    found = [own] if own else servers
    return NotebookAccess(given or tuple(name for one in found for name in one.origins), allow)


def sound_origin(text: str) -> tuple[tuple[str, ...], tuple[AllowedHost, ...]]:
    """An origin as a policy writes it, and the name in it. Raises InputError.

    >>> sound_origin("https://hub.example.org")[0]
    ('https://hub.example.org',)
    """
    try:
        parts = urlsplit(text)
        name = allowed(parts.netloc)
        if parts.scheme not in PORTS or f"{parts.scheme}://{name}" != text or "[" in text:
            raise ValueError
    except ValueError:
        raise InputError(
            f"origin = {text!r} is not the beginning of an address, such as "
            "https://hub.example.org or http://localhost:8888"
        ) from None
    return (text,), (name,)


def started_by() -> int:
    """The process that has started this one, if it is a notebook's."""
    said = os.environ.get(STARTED_BY, "")
    return int(said) if said.isdecimal() else os.getppid()


def running_servers() -> Iterator[Server]:
    """The Jupyter servers of this user that run, from the files that they leave meanwhile.

    They are those of `jupyter server list`; a kernel need not have what lists them.
    """
    try:
        from jupyter_core.paths import jupyter_runtime_dir
    except ImportError:
        return
    for file in sorted(Path(jupyter_runtime_dir()).glob("jpserver-*.json")):
        try:
            said: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
            found = Server(
                int(said["pid"]),
                int(said["port"]),
                str(said["hostname"]),
                str(said["base_url"]),
                bool(said["secure"]),
            )
            os.kill(found.pid, 0)
        except (OSError, ValueError, KeyError, TypeError):
            continue  # half written, of a server that has ended, or of none that listens on a port
        yield found
