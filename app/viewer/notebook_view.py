"""The laboratory in a cell of a notebook, or in a window: of a copy of a flock, as it is.

The copy goes on from the flock's tick in a thread of this process; the flock itself stays as it is,
so that whoever has it need not ask what runs it meanwhile. What the laboratory has come to is taken
back as a flock of its own.
"""

from __future__ import annotations

import atexit
import ctypes
import html
import json
import os
import secrets
import sys
import weakref
import webbrowser
from collections.abc import Callable, Iterator
from concurrent.futures import Future
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from agents.flock import Flock
from agents.option import whole_number
from app.front.origin import (
    EVERYWHERE,
    LOOPBACK,
    PORTS,
    AllowedHost,
    local_address,
    parse_allowed_host,
)
from app.front.page_front import Front
from app.front.server import close_server, open_server
from app.viewer.lab.laboratory import Laboratory
from app.viewer.lab.scene_requests import SCRIPTS
from app.viewer.measuring.time_series import refuse_too_dense
from app.viewer.run.stored_flock import InMemoryFlock
from worlds.input_error import InputError, unknown

# Where a notebook is seen: whose pages may show a laboratory in a frame, and how they reach it.
#
# A browser on this machine reaches a port of this process. One that is elsewhere, as behind a hub,
# reaches nothing but the notebook's server, which passes on what is asked for below `proxy/PORT/`
# if it has jupyter-server-proxy.

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
        base = local_address(LOOPBACK[0], port) if self.proxy is None else f"{self.proxy}{port}"
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
        name = parse_allowed_host(parts.netloc)
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
        except (OSError, ValueError, KeyError, TypeError):
            continue  # half written, or of a server that listens on no port
        if is_running(found.pid):
            yield found


RUNS = 0x102
"""What Windows says of a process for which one would have to wait."""


def is_running(process: int) -> bool:
    """Whether there is a process of that number."""
    if os.name == "posix":
        try:
            os.kill(process, 0)
        except (OSError, OverflowError):
            return False
        return True
    # There os.kill(process, 0) is Ctrl-C to it.
    kernel: Any = getattr(ctypes, "windll").kernel32  # noqa: B009 - there is none to check here
    handle = kernel.OpenProcess(0x100000, False, process)
    is_there = bool(handle) and kernel.WaitForSingleObject(handle, 0) == RUNS
    if handle:
        kernel.CloseHandle(handle)
    return is_there


LEAST, MOST = 240, 4000
"""Height of a frame, pixels."""
TIMEOUT = 30.0
"""Time that the laboratory has to say how its flock is, s."""

open_views: list[NotebookView] = []
"""Those that are open, the oldest first."""


class NotebookView:
    """A laboratory that shows a copy of a flock. Raises InputError.

    It serves this machine alone, at an address with a secret in it, until it is closed, shown
    again from the same flock or the same cell, or Python ends.
    """

    def __init__(self, flock: Flock, place: NotebookAccess, height: int, running: bool):
        self.place, self.height = place, height
        self.title = flock.model.name
        self.secret = secrets.token_urlsafe(24)
        self.of = weakref.ref(flock)
        self.make: Callable[..., Flock] = type(flock).from_snapshot
        self.threads = flock.threads
        self.cell, self.shown = cell(), -1
        self.left: InMemoryFlock | None = None
        """How the flock was when it was closed."""
        now = InMemoryFlock(flock.spec, flock.snapshot())
        refuse_too_dense(now.flock(Flock))  # what it refuses is told here, not in the page
        front = Front(SCRIPTS, place.allow, self.secret, place.framed_by)
        server = open_server(port=0, front=front)
        try:
            self.laboratory = Laboratory(
                server=server, opened=now, running=running, threads=flock.threads
            )
        except BaseException:
            close_server(server)
            raise
        self.port = self.laboratory.port
        self.is_open = True
        open_views.append(self)
        atexit.register(self.end)  # before viser ends its server, which has registered by now

    @property
    def address(self) -> str:
        """Where it is: an address, or a path of the notebook's server that passes it on."""
        return self.place.address(self.port, self.secret)

    @property
    def flock(self) -> Flock:
        """A new flock, as that of the laboratory is now, or was when that was closed.

        It goes on as that one does, to the bit; from a preview that moves while the model is
        compiled, up to rounding. Raises InputError where there is none.
        """
        now = self.in_hand() if self.is_open else self.left
        if now is None:
            raise InputError("the laboratory is closed, and had no flock")
        return self.make(now.run, now.now, threads=self.threads)

    def in_hand(self) -> InMemoryFlock:
        """The flock of the laboratory as it is, between two ticks. Raises InputError."""
        simulation = self.laboratory.simulation

        def taken() -> InMemoryFlock:
            flock = simulation.require_run().flock
            return InMemoryFlock(flock.spec, flock.snapshot())

        answer: Future[InMemoryFlock] = simulation.tell(taken)
        try:
            return answer.result(TIMEOUT)
        except TimeoutError:
            raise InputError(f"the laboratory does not answer within {TIMEOUT:g} s") from None

    def close(self) -> None:
        """Stop it; its flock can still be taken from `flock`."""
        if not self.is_open:
            return
        try:
            self.left = self.in_hand()
        except InputError:
            self.left = None
        self.end()

    def end(self) -> None:
        """Stop it, whatever its flock has come to."""
        if self.is_open:
            self.is_open = False
            open_views.remove(self)
            atexit.unregister(self.end)
            self.laboratory.close()

    def __repr__(self) -> str:
        state = f"at {self.address}" if self.is_open else "closed"
        return f"<Laboratory of {self.title}, {state}>"

    def _ipython_display_(self) -> None:
        """As the value of a cell it is there once, also if that cell has just shown it."""
        kernel_shell = shell()
        if kernel_shell is None or kernel_shell.execution_count != self.shown:
            self.display()

    def display(self) -> None:
        """Put it into the cell that runs, or into a window of the browser where there is none."""
        kernel_shell = shell()
        if kernel_shell is None:
            print(f"flockscope is at {self.address}", file=sys.stderr)
            webbrowser.open(self.address)
            return
        from IPython.display import display

        self.shown = kernel_shell.execution_count
        display({"text/html": self.in_html(), "text/plain": repr(self)}, raw=True)

    def in_html(self) -> str:
        """The frame, with a link to the same in a window; without a known page the link alone."""
        if not self.is_open:
            return f"<p>{html.escape(repr(self))}</p>"
        address = html.escape(self.address)
        link = (
            f'<a href="{address}" target="_blank" rel="noopener noreferrer">flockscope in a window '
            "of its own</a>"
        )
        if not self.place.framed_by:
            return (
                f"<p>{link}: which page this notebook is on is not known; "
                "<code>show(origin=...)</code> says it.</p>"
            )
        return (
            f'<iframe src="{address}" title="flockscope: {html.escape(self.title)}" '
            f'style="display: block; width: 100%; height: {self.height}px; border: 0" '
            f'allow="fullscreen; clipboard-write" referrerpolicy="no-referrer"></iframe>'
            f'<p style="margin: 4px 0; font-size: 12px">{link}</p>'
        )


def show(
    flock: Flock,
    height: int = 640,
    *,
    running: bool = False,
    through: str = "auto",
    origin: str | None = None,
) -> NotebookView:
    """Show a copy of a flock, see `Flock.show`. Raises InputError."""
    whole_number("height", height, LEAST, MOST)
    place = find_place(through, origin)
    here = cell()
    before = [one for one in open_views if one.of() is flock or (here and one.cell == here)]
    view = NotebookView(flock, place, height, running)
    for one in before:
        one.close()
    view.display()
    return view


def shell() -> Any:
    """The shell of the notebook's kernel that runs here; None outside of notebooks."""
    module = sys.modules.get("IPython")
    found = None if module is None else module.get_ipython()
    return found if hasattr(found, "kernel") else None


def cell() -> str:
    """The cell that runs, as its notebook's page calls it; empty where it does not say."""
    kernel_shell = shell()
    if kernel_shell is None:
        return ""
    said = kernel_shell.kernel.get_parent().get("metadata", {})
    return str(said.get("cellId", ""))
