"""A viser server that keeps its port, its visitors and its values in hand.

viser takes the next free port when its own is busy, answers pages of any origin, opens a public
tunnel for any browser that asks, and believes what browsers send, however much it is. This one does
none of it.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import socket
import threading
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from http import HTTPStatus
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import rich
import viser
from websockets.http11 import Request, Response

from app.front.client_addresses import USUAL, ClientAddresses, ConnectionLimits
from app.front.connection import FAREWELL, Connection
from app.front.connection_acceptor import ConnectionAcceptor
from app.front.controls import guard
from app.front.kinds import KINDS, LARGEST, Kind
from app.front.log import Log, log_failures, logger
from app.front.page_front import BEGINNING, Front, is_websocket, text_response
from app.front.renders import Renders, accept_renders
from app.front.viser_internals import (
    PROTOCOL,
    drop_messages,
    event_loop,
    find_kinds_once,
    keep_icons_open,
    messages,
    protocol_factory,
    served_by,
    use_loop_events,
)
from app.front.waiting import BEGINS, Admission, MessageNotifier
from worlds.input_error import InputError

UNWANTED = (
    messages.ShareUrlRequest,
    messages.ShareUrlDisconnect,
    messages.FileTransferStartUpload,
    messages.FileTransferPart,
    messages.GuiFormSubmitMessage,
    messages.GuiFormDirtyMessage,
)
"""What browsers may send to viser but not to a laboratory."""
BACKLOG = 1024
"""Connections that the system keeps until the door takes them."""

starting = threading.Lock()


@dataclass
class ServerEntrance:
    """How browsers come to one server."""

    front: Front
    kinds: Mapping[str, Kind] = field(default_factory=lambda: KINDS)
    """Of which kinds of messages it hears at all."""
    visitors: ClientAddresses = field(default_factory=ClientAddresses)
    log: Log = field(default_factory=Log)
    renders: Renders = field(default_factory=Renders)
    heard: MessageNotifier = field(default_factory=MessageNotifier)


class ServedWebsockets(NamedTuple):
    """What viser serves, once its loop runs."""

    admission: Admission
    server: Any
    """The server of websockets, which takes no connections itself."""


@dataclass(kw_only=True)
class OpenEntrance(ServerEntrance):
    """An entrance whose server is there."""

    served: ServedWebsockets
    door: ConnectionAcceptor


entrances: WeakKeyDictionary[viser.ViserServer, OpenEntrance] = WeakKeyDictionary()
"""Of every server that is open."""


def open_server(
    host: str = "127.0.0.1",
    port: int = 8080,
    front: Front | None = None,
    kinds: Mapping[str, Kind] = KINDS,
    limits: ConnectionLimits = USUAL,
) -> viser.ViserServer:
    """A server on exactly this host and port; port 0 takes any free one.

    Its page can be loaded at once, but nothing that browsers say or ask for arrives before
    `admit_browsers`: whoever opens a server first makes whole what it serves.

    `front` answers what comes by HTTP; by default one with viser's page alone. `kinds`: of which
    kinds of messages it hears, and how often; all others are dropped before anybody decodes them.
    `limits`: how many connections there may be, of all and of one address, and how soon more.
    Raises InputError if the port is busy or the host is not this machine's.
    """
    use_loop_events()
    find_kinds_once()
    keep_icons_open()
    entrance = ServerEntrance(front or Front(), kinds, ClientAddresses(limits=limits))
    sock = listening(host, port)
    with starting, served_on(sock, entrance) as begun, quiet():
        server = viser.ViserServer(host=host, port=port, label="flockscope", verbose=False)
    drop_messages(server, UNWANTED)
    guard(server)
    accept_renders(server, entrance.renders)
    loop = event_loop(server)
    served = begun[-1]
    inside = partial(loop.connect_accepted_socket, protocol_factory(served.server))
    door = ConnectionAcceptor(sock, inside, loop, entrance.visitors, entrance.front.allow)
    entrances[server] = OpenEntrance(**vars(entrance), served=served, door=door)
    return server


def admit_browsers(server: viser.ViserServer) -> None:
    """Let browsers use what a server serves: the last step of whoever makes what it serves."""
    entrance = entrances[server]
    entrance.served.admission.decide(True)
    entrance.door.settled.set()


def front_of(server: viser.ViserServer) -> Front:
    """What answers for a server by HTTP."""
    return entrances[server].front


def renders_of(server: viser.ViserServer) -> Renders:
    """What asks a server's browsers for pictures."""
    return entrances[server].renders


def when_heard(server: viser.ViserServer, tell: Callable[[], None]) -> None:
    """Have something told of, on the server's loop, soon after browsers have sent messages."""
    entrances[server].heard.tell = tell


def stops(server: viser.ViserServer, stop: Callable[[str], None]) -> None:
    """Have emergency stops carried out, on the door's thread; `stop` is told by whom."""
    door = entrances[server].door
    door.stop = stop
    door.settled.set()


def close_server(server: viser.ViserServer) -> None:
    """Stop a server without a word on standard output."""
    entrance = entrances.pop(server, None)
    if entrance is not None:
        entrance.door.close()
        admission = entrance.served.admission
        admission.decide(False)
        with contextlib.suppress(RuntimeError):  # the loop is closed, and nobody is there
            admission.loop.call_soon_threadsafe(end_lines, entrance)
    with starting, quiet():
        server.stop()
    if entrance is not None:
        entrance.log.close()


def end_lines(entrance: OpenEntrance) -> None:
    """On viser's loop: let all have read what they are told last, then end their lines.

    websockets would wait until they go, and viser for that, 6 s in all: a client that keeps its
    line open, or says no more, would hold up whoever closes a page.
    """

    def end() -> None:
        for connection in list(entrance.served.server.handlers):
            connection.transport.abort()

    asyncio.get_running_loop().call_later(FAREWELL, end)


@contextlib.contextmanager
def quiet() -> Iterator[None]:
    """Within it viser says nothing, neither on standard output nor in a notebook's cell."""
    console = rich.get_console()
    before, console.quiet = console.quiet, True
    try:
        yield
    finally:
        console.quiet = before


def listening(host: str, port: int) -> socket.socket:
    """A socket that is bound already, so that nobody can take the port in between."""
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    try:
        return socket.create_server((host, port), family=family, backlog=BACKLOG)
    except (OSError, OverflowError) as error:
        number = getattr(error, "errno", None) or 0
        said = str(getattr(error, "strerror", error)).partition(" (while")[0]
        why = os.strerror(number) if number > 0 else said
        raise InputError(
            f"port {port} on {host} cannot be used: {why}; choose another with --port"
        ) from None


@contextlib.contextmanager
def served_on(sock: socket.socket, entrance: ServerEntrance) -> Iterator[list[ServedWebsockets]]:
    """Within it, viser serves on this socket what an entrance lets in.

    It takes no connections from the socket: they are brought in by the door. What is served is put
    into the list once viser's loop has begun it.
    """
    begun: list[ServedWebsockets] = []
    front, log = entrance.front, entrance.log
    own = {
        name: getattr(entrance, name) for name in ("kinds", "visitors", "log", "renders", "heard")
    }

    def serve_here(handler: Any, _host: str, _port: int, *, process_request: Any, **options: Any):
        admission = Admission(asyncio.get_running_loop())

        async def answer(connection: Any, request: Request) -> Response | None:
            early = front.loads_page(request.path) or is_websocket(request)
            if not (early or await admission.admits(connection, BEGINS)):
                return text_response(HTTPStatus.SERVICE_UNAVAILABLE, BEGINNING)
            return front.answer(
                request, lambda: process_request(connection, request), connection.method
            )

        def finish(connection: Any, _request: Request, response: Response) -> None:
            front.finish(response, connection.method)

        log_failures(asyncio.get_running_loop(), log)
        ours = {
            "sock": sock,
            "start_serving": False,
            "max_size": LARGEST,
            "create_connection": partial(Connection, **own, admission=admission),
            "process_request": answer,
            "process_response": finish,
            "logger": logger(log),
        }
        made = usual(partial(of_one_version, handler), **(options | ours))
        begun.append(ServedWebsockets(admission, made.server))
        made.server.is_serving = lambda: made.server.close_task is None
        return made

    with served_by(serve_here) as usual:
        yield begun


async def of_one_version(handler: Any, connection: Any) -> None:
    """Tell a page of another version so, as viser does, but without a line on standard output."""
    if connection.subprotocol == PROTOCOL:
        await handler(connection)
    else:
        await connection.close(1002, f"Version mismatch. Server: {viser.__version__}")
